//! `phasecloud graph`: who sends what to whom in a launch file, as a Mermaid flowchart.

use std::path::Path;
use std::process::ExitCode;

use crate::exit::BAD_INPUT;
use crate::plan::cases::{Case, Runs};
use crate::plan::launch_file::Launch;
use messages::service::Service;

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
    let scenarios: Vec<&str> = launch.scenarios.iter().map(|s| s.content.name()).collect();
    let mut text = format!("flowchart LR\n  scenario[\"scenario<br>{}\"]\n", scenarios.join(", "));
    for (number, case) in launch.cases.iter().enumerate() {
        text += &format!("  case{number}[\"{}\"]\n", title(case, launch));
        text += &format!("  scenario -- scenario --> case{number}\n");
        text += &format!("  case{number} -- snapshot --> estimator\n");
        text += &format!("  case{number} -- passage --> recorder\n");
    }
    for service in [Service::Estimator, Service::Comparator, Service::Recorder].map(Service::name) {
        text += &format!("  scenario -- scenario --> {service}\n");
    }
    text += "  estimator -- density --> comparator\n  estimator -- density --> recorder\n";
    text += "  comparator -- comparison --> recorder\n";
    text += "  launcher -- roster --> comparator\n  launcher -- roster --> recorder\n";
    text += "  everyone([every process]) -- status --> launcher\n  recorder -- status --> scenario\n";
    text
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
