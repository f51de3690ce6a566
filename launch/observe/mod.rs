//! Looking into a live run: `phasecloud topics`, `echo`, `hz` and `watch`.
//!
//! All attach as observers. No publisher of ours waits for an observer, so they cannot hold up a run, even when they
//! are stopped or killed.

pub mod echo;
pub mod hz;
pub(crate) mod taken;
pub mod topics;
pub mod watch;
mod web;

use std::process::ExitCode;
use std::time::Duration;

use clap::Args;
use messages::domain::Place;
use messages::observe::Observer;
use messages::port::{Inlet, Message, PortError};
use messages::topic::{Topic, Visitor, for_each};
use messages::wait::Signals;

use crate::domain;
use crate::domain::attach::Target;
use crate::exit::{BAD_INPUT, INTERRUPTED};

/// Longest time between two checks whether the run still lives.
const TICK: Duration = Duration::from_millis(500);

/// Arguments of `phasecloud hz`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  phasecloud hz snapshot\n  phasecloud hz status --run 4f2a")]
pub struct HzArguments {
    /// The topic: scenario, snapshot, passage, density, comparison, status or roster
    pub topic: String,
    #[command(flatten)]
    pub target: Target,
}

/// Why an observer ends.
#[derive(Debug)]
enum End {
    /// The run has ended.
    Over,
    /// The user asked to stop, or nobody reads what is printed.
    Stopped,
}

/// Hands every message of a topic to `each` until the run ends, the user stops it, or `each` returns false. In between
/// `each` is called with `None`, at least twice a second.
fn follow<T: Topic>(
    place: &Place,
    what: &str,
    mut each: impl FnMut(Option<Message<T>>) -> bool,
) -> Result<End, PortError> {
    let signals = Signals::catch(&[]).map_err(|e| PortError::new("catch", "signals", &e))?;
    let observer = Observer::enter(place, what)?;
    let inlet: Inlet<T> = observer.inlet()?;
    loop {
        // Checked before the messages are read, so that a message sent just before the end is not missed.
        let over = !domain::is_live(place);
        while let Some(message) = inlet.receive()? {
            if !each(Some(message)) {
                return Ok(End::Stopped);
            }
        }
        if signals.stop_requested() || !each(None) {
            return Ok(End::Stopped);
        }
        if over {
            drop((inlet, observer));
            domain::remove_remains(place);
            return Ok(End::Over);
        }
        signals.wait(&[&inlet], TICK)?;
    }
}

/// Lets `visitor` visit the topic of this name, with or without `phasecloud/` before it.
fn with_topic<V: Visitor>(name: &str, visitor: V) -> Result<V::Out, String> {
    struct Named<'a, V>(&'a str, Option<V>);
    impl<V: Visitor> Visitor for Named<'_, V> {
        type Out = Result<V::Out, &'static str>;
        fn visit<T: Topic>(&mut self) -> Self::Out {
            let wanted = T::NAME == self.0 || T::NAME.rsplit('/').next() == Some(self.0);
            match self.1.take_if(|_| wanted) {
                Some(mut visitor) => Ok(visitor.visit::<T>()),
                None => Err(T::NAME),
            }
        }
    }
    let outcomes = for_each(&mut Named(name, Some(visitor)));
    let names: Vec<&str> = outcomes.iter().filter_map(|outcome| outcome.as_ref().err().copied()).collect();
    let names = names.join(", ");
    outcomes.into_iter().find_map(Result::ok).ok_or_else(|| format!("there is no topic \"{name}\"; there are {names}"))
}

/// The exit code of a command that has observed a run.
fn exit(outcome: Result<Result<End, PortError>, String>) -> ExitCode {
    match outcome {
        Ok(Ok(End::Over)) => ExitCode::SUCCESS,
        Ok(Ok(End::Stopped)) => ExitCode::from(INTERRUPTED),
        Ok(Err(error)) => fail(&error.to_string(), 1),
        Err(problem) => fail(&problem, BAD_INPUT),
    }
}

fn fail(problem: &str, code: u8) -> ExitCode {
    remark!("error: {problem}");
    ExitCode::from(code)
}
