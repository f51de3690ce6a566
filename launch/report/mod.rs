//! What a run prints at its end: its results, with the paper's Table 3 and Table 4 beside them if they are the paper's.

mod disposal;
mod effort;
mod given;
mod moments;
mod notes;
mod printed;
mod side_by_side;
mod verdicts;

use std::collections::BTreeMap;
use std::path::Path;

use comfy_table::Table;
use results::rows::{EffortRow, GivenRow, NoteRow, PassageRow, VerdictRow, of_scenario};
use results::{files, table};

use crate::plan::launch_file::Launch;

pub use printed::new_table;

/// Prints the results in `folder`.
pub fn print(launch: &Launch, folder: &Path) {
    let rows = results::moments::read(&folder.join(files::MOMENTS)).unwrap_or_default();
    let effort_rows: Vec<EffortRow> = table::read(&folder.join(files::EFFORT)).unwrap_or_default();
    let papers = Launch::load(None, None).ok().and_then(|launch| launch.scenarios.into_iter().next());
    let papers = papers.as_ref().and_then(|papers| papers.content.in_plane()).map(|papers| &papers.problem);
    let passages: Vec<PassageRow> = table::read(&folder.join(files::FIRST_PASSAGE)).unwrap_or_default();
    let given: Vec<GivenRow> = table::read_if_there(&folder.join(files::GIVEN_RE_ENTRY)).unwrap_or_default();
    let verdicts: Vec<VerdictRow> = table::read(&folder.join(files::VERDICTS)).unwrap_or_default();
    let notes = notes_in(folder);
    for scenario in &launch.scenarios {
        let (name, in_plane) = (scenario.content.name(), scenario.content.in_plane());
        let is_papers = papers.is_some() && papers == in_plane.map(|scenario| &scenario.problem);
        let rows = of_scenario(&rows, name);
        notes::print_fallbacks(name, &notes);
        if is_papers && side_by_side::applies(launch) {
            side_by_side::print(launch, &rows);
        } else {
            moments::print(name, &rows, is_papers);
        }
        if let Some(critical_e) = scenario.content.critical_e() {
            disposal::print(name, critical_e, &rows, &of_scenario(&passages, name));
        }
        given::print(name, &of_scenario(&given, name));
        effort::print(name, &of_scenario(&effort_rows, name), launch.baseline.as_deref(), is_papers);
        verdicts::print(name, launch.tolerance, &of_scenario(&verdicts, name));
    }
    notes::print(&notes);
}

/// The errors in the results in `folder`: where methods that know their errors contradict one another, and what else
/// cannot be right.
pub fn errors(folder: &Path) -> Vec<String> {
    notes::errors(&notes_in(folder))
}

/// The first error of each case, by the label of the case.
pub fn errors_by_case(folder: &Path) -> BTreeMap<String, String> {
    notes::errors_by_case(&notes_in(folder))
}

/// Means and deviations of a scenario in the table `moments.csv` at `path`, whatever the variables of its model.
pub fn moments_at(path: &Path, scenario: &str) -> Table {
    let rows = results::moments::read(path).unwrap_or_default();
    moments::table(&of_scenario(&rows, scenario), false)
}

fn notes_in(folder: &Path) -> Vec<NoteRow> {
    table::read(&folder.join(files::NOTES)).unwrap_or_default()
}
