//! `phasecloud submit`: asks a running service to work on scenarios, and waits until they are done.

use std::process::ExitCode;
use std::time::{Duration, Instant};

use kit::assignment::Assignment;
use messages::domain::{Domain, Place};
use messages::port::{Inlet, Outlet, PortError};
use messages::report::{Event, Report};
use messages::text::printable;
use messages::topic::{Request, Status};
use messages::wait::Signals;
use nodes::files::scenario_file::{self, AnyScenario};
use nodes::services::request::request;
use results::manifest::{self, Manifest};

use crate::command::serve::folder_name;
use crate::domain::attach::{self, LiveRun, Target};
use crate::domain::{self};
use crate::exit::{BAD_INPUT, INTERRUPTED};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `phasecloud submit`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  phasecloud submit launch/scenarios/scenario-1.toml my-scenario.toml\n\n\
    Returns when the results folders are there, whole.\n\n\
    Exit codes: 0 all cases compared; 1 a scenario was refused or a case failed, it is named; 2 bad input, or no service that \
    does anything; 130 stopped on request.")]
pub struct SubmitArguments {
    /// Scenario files
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    #[command(flatten)]
    pub target: Target,
}

/// Wait between two looks at whether the service is still there.
const LOOK: Duration = Duration::from_millis(500);
/// Wait between two looks at whether a results folder is there, once it is recorded.
const LOOK_FOR_FOLDER: Duration = Duration::from_millis(20);
/// A service that has not accepted a request after this time works on another one, and the user is told so.
const WHILE: Duration = Duration::from_secs(60);

/// Why no more requests can be made.
enum Trouble {
    Interrupted,
    /// The service has ended.
    Ended,
    /// There is no service, or it cannot be reached.
    NoService(String),
}

impl From<PortError> for Trouble {
    fn from(error: PortError) -> Self {
        Self::NoService(error.to_string())
    }
}

/// What has become of the requests so far.
#[derive(Default)]
struct Tally {
    /// How many results folders there are.
    done: usize,
    /// How many scenarios were refused.
    refused: usize,
    /// How many cases failed in the scenarios that were done.
    failed: usize,
}

/// Submits scenario files one after the other.
pub fn run(arguments: &SubmitArguments) -> ExitCode {
    let loaded: Result<Vec<_>, _> =
        arguments.files.iter().map(|file: &PathBuf| scenario_file::load_cloud(file)).collect();
    let scenarios = match loaded {
        Ok(scenarios) => scenarios,
        Err(error) => {
            remark!("error: {error}");
            return ExitCode::from(BAD_INPUT);
        }
    };
    let mut tally = Tally::default();
    match submit(&scenarios, &arguments.target, &mut tally) {
        Ok(()) if tally.failed + tally.refused == 0 => ExitCode::SUCCESS,
        Ok(()) => ExitCode::FAILURE,
        Err(Trouble::Interrupted) => ExitCode::from(INTERRUPTED),
        Err(trouble) => {
            let missing = scenarios.iter().skip(tally.done + tally.refused).map(AnyScenario::name);
            let problem = match trouble {
                Trouble::NoService(problem) => problem,
                _ => format!("{}: the service has ended, there are no results", missing.collect::<Vec<_>>().join(", ")),
            };
            remark!("error: {problem}");
            ExitCode::from(if tally.done + tally.refused == 0 { BAD_INPUT } else { 1 })
        }
    }
}

/// Asks for all scenarios, one after the other, as long as there is a service that does them.
fn submit(scenarios: &[AnyScenario], target: &Target, tally: &mut Tally) -> Result<(), Trouble> {
    let LiveRun { place, notice } = attach::find_service(target).map_err(Trouble::NoService)?;
    let asked = ask(scenarios, &place, notice.map(|notice| notice.results), tally);
    if domain::is_live(&place) {
        return asked;
    }
    // Files that this process had open may have outlived the domain.
    domain::remove_remains(&place);
    match asked {
        // The topics of a service that has ended cannot be reached either.
        Err(Trouble::NoService(_)) => Err(Trouble::Ended),
        other => other,
    }
}

fn ask(scenarios: &[AnyScenario], place: &Place, results: Option<PathBuf>, tally: &mut Tally) -> Result<(), Trouble> {
    let signals = Signals::catch(&[]).map_err(|e| Trouble::NoService(format!("cannot catch signals: {e}")))?;
    let domain = Domain::enter(place, &format!("submit-{}", std::process::id()))?;
    let longest = scenarios.iter().map(|scenario| scenario.times().len()).max().unwrap_or(1);
    let longest = Assignment::numbers(longest);
    let (reports, requests) = (domain.inlet()?, domain.outlet(longest)?);
    let client = Client { signals, place, results, reports, requests };
    while client.reports.receive()?.is_some() {}
    for scenario in scenarios {
        match client.have_done(scenario)? {
            Ok(position) => client.conclude(position, scenario.name(), tally)?,
            Err(why) => {
                remark!("error: {}: {why}", scenario.name());
                tally.refused += 1;
            }
        }
    }
    Ok(())
}

struct Client<'a> {
    signals: Signals,
    place: &'a Place,
    /// Where the service puts its results folders; not known for a domain that was made by hand.
    results: Option<PathBuf>,
    reports: Inlet<Status>,
    requests: Outlet<Request>,
}

impl Client<'_> {
    /// Asks for a scenario and waits until it is recorded; returns its position, or why it was refused.
    fn have_done(&self, scenario: &AnyScenario) -> Result<Result<u32, String>, Trouble> {
        let number = number_of_a_request();
        let (header, items) = match request(scenario, number) {
            Ok(parts) => parts,
            Err(why) => return Ok(Err(why.to_string())),
        };
        self.requests.send_items(header, &items)?;
        let asked = Instant::now();
        let (mut position, mut told) = (None, false);
        loop {
            // Checked before the reports are read, so that a report sent just before the end is not missed.
            let has_ended = !domain::is_live(self.place);
            while let Some(report) = self.reports.receive()? {
                let Ok(report) = Report::from_parts(report.header(), report.items()) else { continue };
                if position.is_some_and(|position| report.is_end_of(position)) {
                    return Ok(Ok(report.scenario));
                }
                match report.event {
                    Event::Refused { request, why, .. } if request == Some(number) => return Ok(Err(why)),
                    Event::Accepted { request, .. } if request == Some(number) => position = Some(report.scenario),
                    _ => {}
                }
            }
            if has_ended {
                return Err(Trouble::Ended);
            }
            if position.is_none() && !told && asked.elapsed() > WHILE {
                remark!("{}: not taken yet; the service works on what it was asked for before", scenario.name());
                told = true;
            }
            self.wait(LOOK)?;
        }
    }

    /// Waits until the results folder of a recorded scenario is there and sealed, and prints how its cases went.
    fn conclude(&self, position: u32, name: &str, tally: &mut Tally) -> Result<(), Trouble> {
        let Some(results) = &self.results else {
            say!("{name}: recorded as number {position}");
            tally.done += 1;
            return Ok(());
        };
        let folder = results.join(folder_name(position, name));
        let failures = loop {
            // Checked before looking for the folder, which may be the last one that the service publishes.
            let has_ended = !domain::is_live(self.place);
            // The folder gets this name only when it is whole.
            if let Ok(manifest) = manifest::read::<Manifest>(&folder) {
                break manifest.failures;
            }
            if has_ended {
                return Err(Trouble::Ended);
            }
            self.wait(LOOK_FOR_FOLDER)?;
        };
        say!("{name}: recorded as {}", folder_name(position, name));
        for (case, why) in &failures {
            remark!("error: {name}, {case}: {}", printable(why));
        }
        tally.done += 1;
        tally.failed += failures.len();
        Ok(())
    }

    fn wait(&self, longest: Duration) -> Result<(), Trouble> {
        self.signals.wait(&[&self.reports, &self.requests], longest)?;
        if self.signals.stop_requested() { Err(Trouble::Interrupted) } else { Ok(()) }
    }
}

/// A number by which the answer to a request is recognised, also when others request scenarios of the same name; never
/// 0.
fn number_of_a_request() -> u32 {
    (domain::fresh_run_id() as u32).max(1)
}
