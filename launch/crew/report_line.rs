//! A report of a node as a line of text.

use messages::report::{Event, Report};

/// A report in words.
pub fn describe(Report { from, scenario, event }: &Report) -> String {
    match event {
        Event::Ready => format!("{from}: ready"),
        Event::Accepted { name, .. } => format!("{from}: scenario {scenario} is {name}"),
        Event::Refused { name, why, .. } => format!("{from}: {name} is refused: {why}"),
        Event::Progress { done, of: 0 } => format!("{from}: scenario {scenario}, {done} done"),
        Event::Progress { done, of } => format!("{from}: scenario {scenario}, {done} of {of}"),
        Event::WaitsFor { case, what, .. } => format!("{from}: scenario {scenario} waits for {case}: {what}"),
        Event::Done => format!("{from}: scenario {scenario} done"),
        Event::Failed { of, why } => format!("{from}: {of} failed: {why}"),
        Event::Joined { host } => format!("{from}: host {host} has joined"),
        Event::Total => format!("{from}: {scenario} scenarios in all"),
    }
}
