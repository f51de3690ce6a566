//! `phasecloud domain`: a domain under a name, for runs whose nodes are started by hand.
//!
//! It takes the place of the launcher: it holds the topics open, tells the comparator and the recorder which cases take
//! part and which have failed, prints what the nodes report, and removes the domain at the end.

use std::collections::{BTreeMap, BTreeSet};
use std::process::ExitCode;
use std::time::Duration;

use kit::environment::RUN_VARIABLE;
use messages::domain::{HeldDomain, PREFIX_VARIABLE, ROOT_VARIABLE};
use messages::layout::{RosterEntry, RosterHeader};
use messages::port::{Outlet, PortError};
use messages::report::{Event, Report};
use messages::text::pack;
use messages::topic::{Capacity, Roster, Status};
use messages::wait::Signals;
use nodes::files::scenario_file;

use crate::crew::report_line;
use crate::domain::{self, OwnDomain};
use crate::exit::BAD_INPUT;
use crate::plan::baseline;
use clap::Args;
use kit::shard::MOST_SHARDS;
use nodes::files::input::{PLAIN_NAME, is_plain_name};
use std::path::PathBuf;
use std::str::FromStr;

/// Arguments of `phasecloud domain`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  phasecloud domain demo exact mc --scenario launch/scenarios/scenario-1.toml\n\n\
    Then start every node in a terminal of its own: phasecloud node estimator --domain demo, and so on.")]
pub struct DomainArguments {
    /// Name of the domain: letters and digits
    pub name: String,
    /// Labels of the cases that will take part; LABEL/N if N processes share a case's work
    #[arg(required = true, value_name = "LABEL")]
    pub labels: Vec<HandCase>,
    /// Label of the reference, the case with which all are compared [default: the first label]; may be repeated: a
    /// later reference stands in where the earlier ones withhold a figure
    #[arg(long = "reference", value_name = "LABEL")]
    pub references: Vec<String>,
    /// Scenario files that the scenario node will publish
    #[arg(long = "scenario", value_name = "FILE", required = true)]
    pub scenarios: Vec<PathBuf>,
}

/// A case of a run by hand.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HandCase {
    /// Its label.
    pub label: String,
    /// How many processes share its work.
    pub shards: u32,
}

impl FromStr for HandCase {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (label, shards) = match text.split_once('/') {
            Some((label, shards)) => (label, shards.parse().ok().filter(|n| (1..=MOST_SHARDS).contains(n))),
            None => (text, Some(1)),
        };
        match shards {
            Some(shards) if is_plain_name(label) => Ok(Self { label: label.into(), shards }),
            Some(_) => Err(format!("the label \"{label}\" is not allowed, {PLAIN_NAME}")),
            None => Err(format!("{text} is not allowed, a case has 1 to {MOST_SHARDS} shards")),
        }
    }
}

/// Number of a run that is started by hand; `phasecloud node` has the same default for `--run-id`.
const RUN_ID: u64 = 0;
/// Longest sleep.
const TICK: Duration = Duration::from_secs(1);

/// Creates the domain and holds it until asked to stop.
pub fn run(arguments: &DomainArguments) -> ExitCode {
    let prepared = prepare(arguments);
    let (own, capacity) = match prepared {
        Ok(prepared) => prepared,
        Err(problem) => {
            remark!("error: phasecloud domain: {problem}");
            return ExitCode::from(BAD_INPUT);
        }
    };
    match hold(arguments, &own, &capacity) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            remark!("error: phasecloud domain: {problem}");
            ExitCode::FAILURE
        }
    }
}

fn prepare(arguments: &DomainArguments) -> Result<(OwnDomain, Capacity), String> {
    let labels: Vec<&str> = arguments.labels.iter().map(|case| case.label.as_str()).collect();
    if labels.iter().collect::<BTreeSet<_>>().len() < labels.len() {
        return Err("two cases have the same label; labels must differ".into());
    }
    if let Some(unknown) = references(arguments).into_iter().find(|reference| !labels.contains(reference)) {
        return Err(format!("no case has the label \"{unknown}\"; there are {}", labels.join(", ")));
    }
    let snapshots = |file: &PathBuf| scenario_file::load_cloud(file).map(|scenario| scenario.times().len());
    let snapshots: Vec<usize> =
        arguments.scenarios.iter().map(snapshots).collect::<Result<_, _>>().map_err(|e| e.to_string())?;
    let propagators = arguments.labels.iter().map(|case| case.shards as usize).sum();
    let snapshots = snapshots.into_iter().max().unwrap_or(1);
    let capacity = Capacity { propagators, cases: labels.len(), snapshots, hosts: 0 };
    domain::sweep();
    Ok((OwnDomain::claim_named(&arguments.name)?, capacity))
}

/// The labels of the references: every case is compared with the first of them that states the quantity.
fn references(arguments: &DomainArguments) -> Vec<&str> {
    match &arguments.references[..] {
        [] => vec![&arguments.labels[0].label],
        named => named.iter().map(String::as_str).collect(),
    }
}

fn hold(arguments: &DomainArguments, own: &OwnDomain, capacity: &Capacity) -> Result<(), String> {
    let failed = |error: PortError| error.to_string();
    let signals = Signals::catch(&[]).map_err(|e| format!("cannot catch signals: {e}"))?;
    let held = HeldDomain::create(&own.place, capacity).map_err(failed)?;
    own.keep();
    let reports = held.domain.inlet::<Status>().map_err(failed)?;
    let roster = held.domain.outlet::<Roster>(arguments.labels.len()).map_err(failed)?;
    let mut fallen: BTreeMap<String, String> = BTreeMap::new();
    let mut scenario = 0;
    publish(&roster, arguments, scenario, &fallen).map_err(failed)?;
    let (root, prefix) = (own.place.root.display(), &own.place.prefix);
    say!("export {ROOT_VARIABLE}={root} {PREFIX_VARIABLE}={prefix} {RUN_VARIABLE}={RUN_ID}");
    remark!("domain {}: held until Ctrl-C", arguments.name);
    while !signals.stop_requested() {
        signals.wait(&[&reports, &roster], TICK).map_err(failed)?;
        while let Some(report) = reports.receive().map_err(failed)? {
            let Ok(report) = Report::from_parts(report.header(), report.items()) else { continue };
            remark!("{}", report_line::describe(&report));
            let is_recorded = report.is_end_of(scenario);
            if is_recorded {
                // A case that has failed takes part again in the next scenario.
                (scenario, fallen) = (scenario + 1, BTreeMap::new());
            }
            let mut has_failed = false;
            if let Event::Failed { of, why } = report.event {
                let label = of.label().to_owned();
                has_failed = !fallen.contains_key(&label);
                fallen.entry(label).or_insert(why);
            }
            if is_recorded || has_failed {
                publish(&roster, arguments, scenario, &fallen).map_err(failed)?;
            }
        }
        // What the dead have reported is read by now.
        held.domain.clean_up_after_the_dead();
    }
    Ok(())
}

fn publish(
    roster: &Outlet<Roster>,
    arguments: &DomainArguments,
    scenario: u32,
    fallen: &BTreeMap<String, String>,
) -> Result<(), PortError> {
    let header = RosterHeader { run_id: RUN_ID, scenario, reserved: 0 };
    let references = references(arguments);
    let baseline = baseline::among(arguments.labels.iter().map(|case| case.label.as_str()));
    let entry = |HandCase { label, shards }: &HandCase| RosterEntry {
        label: pack(label),
        failed: u32::from(fallen.contains_key(label)),
        reason: fallen.get(label).map_or([0; 1024], |why| pack(why)),
        shards: *shards,
        reference: references.iter().position(|reference| reference == label).map_or(0, |place| place as u32 + 1),
        baseline: u32::from(baseline == Some(label.as_str())),
    };
    roster.send_items(header, &arguments.labels.iter().map(entry).collect::<Vec<_>>())
}
