//! `phasecloud topics`: the live runs, and who takes part in each topic.

use std::process::ExitCode;

use messages::describe::Described;
use messages::observe::{Census, Observer};
use messages::payload::Item;
use messages::port::PortError;
use messages::topic::{Topic, Visitor, for_each};

use crate::domain::attach::{self, LiveRun, Target};
use crate::report::new_table;

/// Prints the topics of one run, or of all.
pub fn run(target: &Target) -> ExitCode {
    let runs = if target.run.is_some() || target.domain.is_some() {
        match attach::find(target) {
            Ok(run) => vec![run],
            Err(problem) => return super::fail(&problem, crate::exit::BAD_INPUT),
        }
    } else {
        attach::live_runs()
    };
    if runs.is_empty() {
        say!("There is no live run; start one with `phasecloud run`.");
    }
    for run in &runs {
        if let Err(error) = print(run) {
            return super::fail(&format!("{}: {error}", run.title()), 1);
        }
    }
    ExitCode::SUCCESS
}

fn print(run: &LiveRun) -> Result<(), PortError> {
    let observer = Observer::enter(&run.place, "topics")?;
    say!("{}\n  --domain {}:{}", run.title(), run.place.root.display(), run.place.prefix);
    if let Some(notice) = &run.notice {
        say!("  results: {}", notice.results.display());
    }
    let heads = ["topic", "header", "items", "publishers", "readers", "observers"];
    let mut table = new_table(heads.map(str::to_owned).to_vec(), 3);
    for row in for_each(&mut Rows(&observer)) {
        table.add_row(row?);
    }
    say!("{table}\n");
    Ok(())
}

/// Makes one row per topic.
struct Rows<'a>(&'a Observer);

impl Visitor for Rows<'_> {
    type Out = Result<Vec<String>, PortError>;

    fn visit<T: Topic>(&mut self) -> Self::Out {
        let Census { publishers, readers, observers } = self.0.census::<T>()?;
        let names = [T::NAME, T::Header::TYPE_NAME, T::Item::NAME].map(str::to_owned);
        Ok(names.into_iter().chain([publishers, readers, observers].map(|count| count.to_string())).collect())
    }
}
