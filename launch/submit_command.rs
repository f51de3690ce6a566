//! `phasecloud submit`: asks a running service to work on scenarios, and waits until it has.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use messages::domain::Domain;
use messages::layout::{MOST_SNAPSHOTS, StatusHeader, phase};
use messages::port::{Inlet, Outlet, PortError};
use messages::text::unpack;
use messages::topic::{Request, Status};
use messages::wait::Signals;
use nodes::assignment::request;
use nodes::scenario::RECORDER;
use nodes::scenario_file::{self, ScenarioFile};

use crate::BAD_INPUT;
use crate::attach::{self, Target};
use crate::cli::SubmitArguments;
use crate::commands::SCENARIO_NODE;
use crate::run_command::INTERRUPTED;

/// Wait between two looks at whether the service is still there.
const LOOK: Duration = Duration::from_secs(1);
/// Longest that a service may take to say that it has a request.
const PATIENCE: Duration = Duration::from_secs(60);

/// Why a request was not done.
enum Trouble {
    Interrupted,
    Refused(String),
}

impl From<PortError> for Trouble {
    fn from(error: PortError) -> Self {
        Self::Refused(error.to_string())
    }
}

/// Submits scenario files one after the other.
pub fn run(arguments: &SubmitArguments) -> ExitCode {
    let loaded: Result<Vec<_>, _> = arguments.files.iter().map(|file: &PathBuf| scenario_file::load(file)).collect();
    let scenarios = match loaded {
        Ok(scenarios) => scenarios,
        Err(error) => {
            remark!("error: {error}");
            return ExitCode::from(BAD_INPUT);
        }
    };
    match submit(&scenarios, &arguments.target) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(Trouble::Interrupted) => ExitCode::from(INTERRUPTED),
        Err(Trouble::Refused(problem)) => {
            remark!("error: {problem}");
            ExitCode::FAILURE
        }
    }
}

/// Whether all scenarios have been recorded.
fn submit(scenarios: &[ScenarioFile], target: &Target) -> Result<bool, Trouble> {
    let signals = Signals::catch(&[]).map_err(|e| Trouble::Refused(format!("cannot catch signals: {e}")))?;
    let place = attach::find(target).map_err(Trouble::Refused)?.place;
    let domain = Domain::enter(&place, &format!("submit-{}", std::process::id()))?;
    let office = Office { signals, reports: domain.inlet()?, requests: domain.outlet(MOST_SNAPSHOTS)? };
    while office.reports.receive()?.is_some() {}
    let mut all = true;
    for scenario in scenarios {
        match office.have_done(scenario)? {
            Ok(position) => say!("{}: recorded as {position:06}-{0}", scenario.name),
            Err(why) => {
                remark!("error: {}: {why}", scenario.name);
                all = false;
            }
        }
    }
    Ok(all)
}

struct Office {
    signals: Signals,
    reports: Inlet<Status>,
    requests: Outlet<Request>,
}

impl Office {
    /// Asks for a scenario and waits for its position, or why it was refused.
    fn have_done(&self, scenario: &ScenarioFile) -> Result<Result<u32, String>, Trouble> {
        let (header, times) = request(scenario);
        self.requests.send_items(header, &times)?;
        let asked = Instant::now();
        let mut position = None;
        loop {
            while let Some(report) = self.reports.receive()? {
                let header = report.header();
                if is_about(header, &scenario.name) && header.phase == phase::FAILED {
                    return Ok(Err(unpack(&header.text)));
                }
                if is_about(header, &scenario.name) && header.phase == phase::WORKING {
                    position = Some(header.scenario);
                }
                if header.phase == phase::DONE && unpack(&header.node) == RECORDER && position == Some(header.scenario)
                {
                    return Ok(Ok(header.scenario));
                }
            }
            if position.is_none() && asked.elapsed() > PATIENCE {
                return Ok(Err(format!("the service has not taken it within {} s", PATIENCE.as_secs())));
            }
            self.signals.wait(&[&self.reports, &self.requests], LOOK)?;
            if self.signals.stop_requested() {
                return Err(Trouble::Interrupted);
            }
        }
    }
}

/// Whether the scenario node reports about the request called `name`.
fn is_about(report: &StatusHeader, name: &str) -> bool {
    unpack(&report.node) == SCENARIO_NODE && unpack(&report.subject) == name
}
