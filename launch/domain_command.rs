//! `phasecloud domain`: a domain under a name, for runs whose nodes are started by hand.
//!
//! It does what else the launcher does: it holds the topics open, tells comparator and recorder who takes part and who has
//! failed, prints what the nodes report, and removes the domain at the end.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use messages::domain::{HeldDomain, PREFIX_VARIABLE, ROOT_VARIABLE};
use messages::layout::{RosterEntry, RosterHeader};
use messages::port::{Outlet, PortError};
use messages::report::{Event, Report};
use messages::text::pack;
use messages::topic::{Capacity, Roster, Status};
use messages::wait::Signals;
use nodes::scenario_file;
use nodes::session::RUN_VARIABLE;
use nodes::shard::label_of_member;

use crate::BAD_INPUT;
use crate::cli::{DomainArguments, HandCase};
use crate::domains::{self, OwnDomain};

/// Number of a run by hand, as `phasecloud node` has it without `--run-id`.
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
    let snapshots = |file: &PathBuf| scenario_file::load(file).map(|scenario| scenario.problem.times.len());
    let snapshots: Vec<usize> =
        arguments.scenarios.iter().map(snapshots).collect::<Result<_, _>>().map_err(|e| e.to_string())?;
    let propagators = arguments.labels.iter().map(|case| case.shards as usize).sum();
    let snapshots = snapshots.into_iter().max().unwrap_or(1);
    let capacity = Capacity { propagators, cases: labels.len(), snapshots, hosts: 0 };
    domains::sweep();
    Ok((OwnDomain::claim_named(&arguments.name)?, capacity))
}

/// The cases that all are compared with: the first that states a quantity.
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
            remark!("{}", describe(&report));
            let is_recorded = report.is_end_of(scenario);
            if is_recorded {
                // The next scenario is a new chance.
                (scenario, fallen) = (scenario + 1, BTreeMap::new());
            }
            let mut has_failed = false;
            if let Event::Failed { case, why } = report.event {
                let label = label_of_member(&case).to_owned();
                has_failed = !fallen.contains_key(&label);
                fallen.entry(label).or_insert(why);
            }
            if is_recorded || has_failed {
                publish(&roster, arguments, scenario, &fallen).map_err(failed)?;
            }
        }
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
    let entry = |HandCase { label, shards }: &HandCase| RosterEntry {
        label: pack(label),
        failed: u32::from(fallen.contains_key(label)),
        reason: fallen.get(label).map_or([0; 384], |why| pack(why)),
        shards: *shards,
        reference: references.iter().position(|reference| reference == label).map_or(0, |place| place as u32 + 1),
        reserved: 0,
    };
    roster.send_items(header, &arguments.labels.iter().map(entry).collect::<Vec<_>>())
}

/// A report in words.
pub fn describe(Report { node, scenario, event }: &Report) -> String {
    match event {
        Event::Ready => format!("{node}: ready"),
        Event::Accepted { name, .. } => format!("{node}: scenario {scenario} is {name}"),
        Event::Refused { name, why, .. } => format!("{node}: {name} is refused: {why}"),
        Event::Progress { done, of: 0 } => format!("{node}: scenario {scenario}, {done} done"),
        Event::Progress { done, of } => format!("{node}: scenario {scenario}, {done} of {of}"),
        Event::WaitsFor { case, what, .. } => format!("{node}: scenario {scenario} waits for {case}: {what}"),
        Event::Done => format!("{node}: scenario {scenario} done"),
        Event::Failed { case, why } => format!("{node}: {case} failed: {why}"),
        Event::Joined { host } => format!("{node}: host {host} has joined"),
        Event::Total => format!("{node}: {scenario} scenarios in all"),
    }
}
