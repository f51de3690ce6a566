//! `phasecloud graph`: who sends what to whom in a launch file, as a Mermaid flowchart.

use std::path::Path;
use std::process::ExitCode;

use crate::exit::BAD_INPUT;
use crate::plan::cases::{Case, LAUNCHER, Runs};
use crate::plan::launch_file::Launch;
use messages::service::Service;
use messages::topic::{Comparison, Density, Passage, Roster, Scenario, Snapshot, Status, Topic};

/// Prints the graph of a launch file.
pub fn run(launch_file: Option<&Path>) -> ExitCode {
    match Launch::load(launch_file, None) {
        Ok(launch) => {
            say!("{}", mermaid(&launch).trim_end());
            ExitCode::SUCCESS
        }
        Err(error) => {
            remark!("error: {error}");
            ExitCode::from(BAD_INPUT)
        }
    }
}

/// Boxes are processes, arrows topics.
fn mermaid(launch: &Launch) -> String {
    let [publisher, estimator, comparator, recorder] =
        [Service::Scenario, Service::Estimator, Service::Comparator, Service::Recorder].map(Service::name);
    let scenarios: Vec<&str> = launch.scenarios.iter().map(|s| s.content.name()).collect();
    let mut text = format!("flowchart LR\n  {publisher}[\"{publisher}<br>{}\"]\n", scenarios.join(", "));
    for (number, case) in launch.cases.iter().enumerate() {
        text += &format!("  case{number}[\"{}\"]\n", title(case, launch));
        text += &arrow::<Scenario>(publisher, &format!("case{number}"));
        text += &arrow::<Snapshot>(&format!("case{number}"), estimator);
        text += &arrow::<Passage>(&format!("case{number}"), recorder);
    }
    let of_services = [
        arrow::<Scenario>(publisher, estimator),
        arrow::<Scenario>(publisher, comparator),
        arrow::<Scenario>(publisher, recorder),
        arrow::<Density>(estimator, comparator),
        arrow::<Density>(estimator, recorder),
        arrow::<Comparison>(comparator, recorder),
        arrow::<Roster>(LAUNCHER, comparator),
        arrow::<Roster>(LAUNCHER, recorder),
        arrow::<Status>("everyone([every process])", LAUNCHER),
        arrow::<Status>(recorder, publisher),
    ];
    text + &of_services.concat()
}

/// What a process sends to another one on a topic.
fn arrow<T: Topic>(from: &str, to: &str) -> String {
    let topic = T::NAME.rsplit('/').next().unwrap_or(T::NAME);
    format!("  {from} -- {topic} --> {to}\n")
}

/// Label of a case, what runs in it, the number of its shards if there are several, and whether it is a reference.
fn title(case: &Case, launch: &Launch) -> String {
    let runs = match &case.runs {
        Runs::BuiltIn { node, .. } => node.clone(),
        Runs::Command(words) => words.join(" "),
        Runs::Recorded(file) => file.display().to_string(),
    };
    let shards = if case.shards > 1 { format!("<br>{} shards", case.shards) } else { String::new() };
    let reference = match launch.references.iter().position(|label| *label == case.label) {
        None => String::new(),
        Some(0) => "<br>reference".to_owned(),
        Some(place) => format!("<br>reference {}", place + 1),
    };
    let escaped = runs.replace('&', "#amp;").replace('"', "#quot;").replace('<', "#lt;").replace('>', "#gt;");
    format!("{}<br>{escaped}{shards}{reference}", case.label)
}
