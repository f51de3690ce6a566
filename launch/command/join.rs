//! `phasecloud join`: a worker host does its share of a run that another host conducts, or computes parts of a map.

use std::process::ExitCode;
use std::time::{Duration, Instant};

use bridge::endpoint::{Access, End, Fault, Part, Tls};
use bridge::greeting::{Hello, greet};
use bridge::plan::{HOME, HostPlan, MapPlan, Program, Work};
use bridge::zenoh::Session;
use messages::wait::Signals;
use nodes::files::input::{PLAIN_NAME, is_plain_name};

use crate::command::cli::JoinArguments;
use crate::crew::share::{self, Ending};
use crate::domain;
use crate::exit::{BAD_INPUT, INTERRUPTED};
use crate::map::contributing::{Contribution, contribute};
use crate::shown::Shown;

/// Pause between two attempts to reach a home that does not answer yet.
const PAUSE: Duration = Duration::from_millis(300);
/// After this time without an answer it is said what may be the reason.
const HINT: Duration = Duration::from_secs(10);

/// Joins, works, and ends with the run or the map.
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
        Ok(Ended::Over(told)) => {
            tell(arguments, &told);
            ExitCode::SUCCESS
        }
        Ok(Ended::Interrupted(told)) => {
            remark!("interrupted: {told}");
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
    access.check(End::Connects).map_err(|Fault { part, why }| format!("{}: {why}", option(part)))?;
    Ok((access, name(arguments.name.as_deref())?))
}

/// The option that gives a part of the way to home.
fn option(part: Part) -> &'static str {
    match part {
        Part::Endpoint => "--connect",
        Part::Authority => "--authority",
        Part::Certificate => "--certificate",
        Part::Key => "--key",
    }
}

/// The name of this host, which must be one that home may know.
fn name(given: Option<&str>) -> Result<String, String> {
    let own = || rustix::system::uname().nodename().to_string_lossy().into_owned();
    let (name, advice) = match given {
        Some(name) => (name.to_owned(), ""),
        None => (own(), "; that is this machine's host name, give another one with --name"),
    };
    match () {
        () if !is_plain_name(&name) => Err(format!("--name: {name:?} is not allowed, {PLAIN_NAME}{advice}")),
        () if name == HOME => {
            Err(format!("--name: \"{HOME}\" is the host to which this one connects; take another name{advice}"))
        }
        () => Ok(name),
    }
}

fn tell(arguments: &JoinArguments, line: &str) {
    if !arguments.quiet {
        remark!("{line}");
    }
}

/// How a host's work has ended, in words.
enum Ended {
    /// By itself.
    Over(String),
    /// The user asked to stop.
    Interrupted(String),
}

fn work(arguments: &JoinArguments, access: &Access, host: &str) -> Result<Ended, String> {
    let signals =
        Signals::outlive_terminal(&[signal_hook::consts::SIGCHLD]).map_err(|e| format!("cannot catch signals: {e}"))?;
    let hello = Hello::of(host, domain::fresh_run_id());
    let zenoh = bridge::session::open(access, End::Connects).map_err(|e| e.to_string())?;
    match await_work(arguments, (access, &zenoh), &hello, &signals)? {
        None => Ok(Ended::Interrupted(format!("{host} has not joined"))),
        Some(Work::Map(plan)) => on_map(arguments, (&plan, &zenoh), &hello, &signals),
        Some(Work::Run(plan)) => {
            // The bridge has a session of its own.
            drop(zenoh);
            in_run(arguments, (&plan, access), &hello, &signals)
        }
    }
}

fn on_map(
    arguments: &JoinArguments,
    (plan, zenoh): (&MapPlan, &Session),
    hello: &Hello,
    signals: &Signals,
) -> Result<Ended, String> {
    let (host, file) = (&hello.host, plan.file.display());
    tell(arguments, &format!("joined the map {file} as {host}"));
    let Contribution { is_complete, parts } = contribute(zenoh, plan, hello, signals)?;
    Ok(match is_complete {
        true => Ended::Over(format!("the map at home is complete; {parts} of its parts were computed here")),
        false => Ended::Interrupted(format!("{host} has left the map; {parts} of its parts were computed here")),
    })
}

fn in_run(
    arguments: &JoinArguments,
    (plan, access): (&HostPlan, &Access),
    hello: &Hello,
    signals: &Signals,
) -> Result<Ended, String> {
    let host = &hello.host;
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
    Ok(match share::work(plan, access, hello, signals, (shown, arguments.logged))? {
        Ending::Over => Ended::Over("the run at home has ended".into()),
        Ending::Interrupted => Ended::Interrupted(format!("{host} has left the run")),
    })
}

/// Asks home what there is to do until home answers; `None` if the user asked to stop before that.
fn await_work(
    arguments: &JoinArguments,
    (access, zenoh): (&Access, &Session),
    hello: &Hello,
    signals: &Signals,
) -> Result<Option<Work>, String> {
    let (start, mut is_told, mut is_hinted) = (Instant::now(), false, false);
    while !signals.stop_requested() {
        if let Some(work) = greet(zenoh, hello).map_err(|e| e.to_string())? {
            return Ok(Some(work));
        }
        if !std::mem::replace(&mut is_told, true) {
            tell(arguments, &format!("waiting for a run or a map at {}", access.endpoint));
        }
        if start.elapsed() >= HINT && !std::mem::replace(&mut is_hinted, true) {
            tell(arguments, &hint(access));
        }
        signals.wait(&[], PAUSE).map_err(|e| e.to_string())?;
    }
    Ok(None)
}

/// What may be the reason that home does not answer, as far as this side can know.
fn hint(access: &Access) -> String {
    format!(
        "nothing has answered at {} for {} s: either the home host has not started, or it refuses this host (its certificate, or tcp/ in place of tls/)",
        access.endpoint,
        HINT.as_secs()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_home_cannot_know_is_refused_here() {
        assert_eq!(name(Some("worker-a")), Ok("worker-a".into()));
        for bad in ["a b", "", "-a", "home"] {
            assert!(name(Some(bad)).unwrap_err().starts_with("--name: "), "{bad}");
        }
    }
}
