//! `phasecloud join`: a worker host does its share of a run that another host conducts.

use std::process::ExitCode;
use std::time::Duration;

use bridge::endpoint::{Access, End, Tls};
use bridge::greeting::{Hello, greet};
use bridge::plan::{HostPlan, Program};
use messages::wait::Signals;

use crate::command::cli::JoinArguments;
use crate::crew::share::{self, Ending};
use crate::domain;
use crate::exit::{BAD_INPUT, INTERRUPTED};
use crate::shown::Shown;

/// Pause between two attempts to reach a home that does not answer yet.
const PAUSE: Duration = Duration::from_millis(300);

/// Joins, works, and ends with the run.
pub fn run(arguments: &JoinArguments) -> ExitCode {
    let prepared = prepare(arguments);
    let (access, host) = match prepared {
        Ok(prepared) => prepared,
        Err(problem) => {
            remark!("error: phasecloud join: {problem}");
            return ExitCode::from(BAD_INPUT);
        }
    };
    match work(arguments, &access, &host) {
        Ok(Ending::Over) => {
            tell(arguments, "the run at home has ended");
            ExitCode::SUCCESS
        }
        Ok(Ending::Interrupted) => {
            remark!("interrupted: {host} has left the run");
            ExitCode::from(INTERRUPTED)
        }
        Err(problem) => {
            remark!("error: phasecloud join: {problem}");
            ExitCode::FAILURE
        }
    }
}

fn prepare(arguments: &JoinArguments) -> Result<(Access, String), String> {
    let access = Access {
        endpoint: arguments.connect.clone(),
        tls: Tls {
            authority: arguments.authority.clone(),
            certificate: arguments.certificate.clone(),
            key: arguments.key.clone(),
        },
        insecure: arguments.insecure,
    };
    access.check(End::Connects)?;
    let host = match &arguments.name {
        Some(name) => name.clone(),
        None => rustix::system::uname().nodename().to_string_lossy().into_owned(),
    };
    Ok((access, host))
}

fn tell(arguments: &JoinArguments, line: &str) {
    if !arguments.quiet {
        remark!("{line}");
    }
}

fn work(arguments: &JoinArguments, access: &Access, host: &str) -> Result<Ending, String> {
    let signals =
        Signals::outlive_terminal(&[signal_hook::consts::SIGCHLD]).map_err(|e| format!("cannot catch signals: {e}"))?;
    let hello = Hello::of(host, domain::fresh_run_id());
    let Some(plan) = await_plan(arguments, access, &hello, &signals)? else { return Ok(Ending::Interrupted) };
    let commands = plan.members.iter().find(|share| matches!(share.program, Program::Command(_)));
    if let Some(share) = commands.filter(|_| !arguments.allow_commands) {
        return Err(format!(
            "{} is a program of home's choice, {:?}; --allow-commands lets home start such here",
            share.name, share.program
        ));
    }
    let names: Vec<&str> = plan.members.iter().map(|share| share.name.as_str()).collect();
    tell(arguments, &format!("joined run {:012x} ({}) as {host}: {}", plan.run_id, plan.name, names.join(", ")));
    let shown = Shown { quiet: arguments.quiet, json: false };
    share::work(&plan, access, &hello, &signals, (shown, arguments.logged))
}

/// Asks home for its plan until home answers; `None` if the user asked to stop before that.
fn await_plan(
    arguments: &JoinArguments,
    access: &Access,
    hello: &Hello,
    signals: &Signals,
) -> Result<Option<HostPlan>, String> {
    let zenoh = bridge::session::open(access, End::Connects).map_err(|e| e.to_string())?;
    let mut is_told = false;
    while !signals.stop_requested() {
        if let Some(plan) = greet(&zenoh, hello).map_err(|e| e.to_string())? {
            return Ok(Some(plan));
        }
        if !std::mem::replace(&mut is_told, true) {
            tell(arguments, &format!("waiting for a run at {}", access.endpoint));
        }
        signals.wait(&[], PAUSE).map_err(|e| e.to_string())?;
    }
    Ok(None)
}
