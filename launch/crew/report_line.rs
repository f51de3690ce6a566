//! A report of a node as a line of text.

use messages::report::{Event, Report};

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
