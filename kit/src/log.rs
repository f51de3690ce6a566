//! One log of a whole run: every process writes lines of the same form, each with its node and its run.
//!
//! `docs/reliability.md` says what each level means. A process logs to stderr; a launcher collects the lines of its
//! processes.

use std::collections::BTreeMap;
use std::fmt;
use std::io::Write;
use std::str::FromStr;

use messages::report;
use messages::text::printable;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use tracing::field::{Field, Visit};
use tracing::level_filters::LevelFilter;
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::layer::{Context, Layer, SubscriberExt};

use crate::clock;
use crate::failure::Failure;

/// Environment variable that holds the level: `error`, `warn`, `info`, `debug` or `trace`.
pub const LEVEL_VARIABLE: &str = "PHASECLOUD_LOG";
/// Environment variable that holds the format: `compact` or `json`.
pub const FORMAT_VARIABLE: &str = "PHASECLOUD_LOG_FORMAT";

/// Libraries that log as well.
const FOREIGN: [&str; 2] = ["zenoh", "rustls"];

/// A line of the log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Time at which the line was written, in UTC.
    pub time: String,
    /// `ERROR`, `WARN`, `INFO`, `DEBUG` or `TRACE`.
    pub level: String,
    /// The run.
    pub run: String,
    /// The process that wrote it: a propagator's label or the name of another process.
    pub node: String,
    /// The message.
    pub message: String,
    /// Further values, by name.
    #[serde(flatten)]
    pub fields: BTreeMap<String, Value>,
}

impl Line {
    /// A line without a message, at the present time.
    pub fn now(level: tracing::Level, run: &str, node: &str) -> Self {
        Self {
            time: clock::millis(),
            level: level.to_string(),
            run: run.into(),
            node: node.into(),
            message: String::new(),
            fields: BTreeMap::new(),
        }
    }

    /// The line as text, without a line break; nothing in it can command a terminal.
    pub fn to_text(&self, format: Format) -> String {
        match format {
            Format::Json => json_escaped(&serde_json::to_string(self).unwrap_or_default()),
            Format::Compact => self.to_string(),
        }
    }
}

/// JSON in which also those control characters are escaped that JSON itself allows.
fn json_escaped(json: &str) -> String {
    let mut escaped = String::with_capacity(json.len());
    for character in json.chars() {
        match character {
            c if c.is_control() => escaped += &format!("\\u{:04x}", u32::from(c)),
            c => escaped.push(c),
        }
    }
    escaped
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { time, level, run, node, message, fields } = self;
        let [time, level, run, node] = [time, level, run, node].map(|text| printable(text));
        write!(f, "{time} {level:5} {run} {node}: {}", printable(message))?;
        fields.iter().try_for_each(|(name, value)| write!(f, " {}={}", printable(name), printable(&value.to_string())))
    }
}

impl Visit for Line {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        match field.name() {
            "message" => self.message = format!("{value:?}"),
            name => drop(self.fields.insert(name.into(), format!("{value:?}").into())),
        }
    }

    fn record_str(&mut self, field: &Field, value: &str) {
        self.fields.insert(field.name().into(), value.into());
    }

    fn record_u64(&mut self, field: &Field, value: u64) {
        self.fields.insert(field.name().into(), value.into());
    }
}

/// How a line is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Format {
    /// For people.
    #[default]
    Compact,
    /// One JSON object per line.
    Json,
}

impl FromStr for Format {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "compact" => Ok(Self::Compact),
            "json" => Ok(Self::Json),
            other => Err(format!("\"{other}\" is not a format; there are compact and json")),
        }
    }
}

/// Turns events into lines of the log, and gives these to `emit`.
struct Stream<F> {
    run: String,
    node: String,
    emit: F,
}

impl<S: Subscriber, F: Fn(Line) + 'static> Layer<S> for Stream<F> {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let (level, target) = (*event.metadata().level(), event.metadata().target());
        let is_foreign = FOREIGN.iter().any(|library| target.starts_with(library));
        if is_foreign && level > Level::WARN {
            return;
        }
        // An error in a library is only a warning here, since the process that uses the library goes on.
        let level = if is_foreign { Level::WARN } else { level };
        let mut line = Line::now(level, &self.run, &self.node);
        event.record(&mut line);
        (self.emit)(line);
    }
}

/// Logs this process's events up to `level` with `emit`, from now on; does nothing if it logs already.
pub fn start(node: &str, run_id: u64, level: LevelFilter, emit: impl Fn(Line) + Send + Sync + 'static) {
    let stream = Stream { run: format!("{run_id:012x}"), node: node.into(), emit };
    let _ = tracing::subscriber::set_global_default(tracing_subscriber::registry().with(level).with(stream));
}

/// Logs to stderr as the environment says: by default warnings and errors, in the compact format.
pub fn start_from_environment(node: &str, run_id: u64) {
    let format = variable(FORMAT_VARIABLE).unwrap_or_default();
    // A reader of stderr that has ended is no reason to fail.
    let emit = move |line: Line| drop(writeln!(std::io::stderr(), "{}", line.to_text(format)));
    start(node, run_id, variable(LEVEL_VARIABLE).unwrap_or(LevelFilter::WARN), emit);
}

fn variable<T: FromStr>(name: &str) -> Option<T> {
    std::env::var(name).ok()?.parse().ok()
}

/// Logs why the process ends, also where no log has been started.
pub fn end(failure: &Failure) {
    if tracing::dispatcher::has_been_set() {
        tracing::error!("{failure}");
    } else {
        let _ = writeln!(std::io::stderr(), "error: {failure}");
    }
}

/// Logs a report to the launcher.
pub(crate) fn report(scenario: u32, event: &report::Event) {
    match event {
        report::Event::Ready => tracing::info!("ready"),
        report::Event::Accepted { name, .. } => tracing::debug!(scenario, "has published {name}"),
        report::Event::Refused { name, why, .. } => tracing::warn!(scenario, "refuses {name}: {why}"),
        report::Event::Progress { done, of } => tracing::debug!(scenario, "{done} of {of} done"),
        report::Event::WaitsFor { case, what, .. } => tracing::debug!(scenario, "waits for {case}: {what}"),
        report::Event::Done => tracing::info!(scenario, "done"),
        report::Event::Failed { of, why } => tracing::warn!(scenario, subject = of.to_string(), "failed: {why}"),
        report::Event::Joined { host } => tracing::info!("host {host} has joined"),
        report::Event::Total => tracing::info!("{scenario} scenarios in all"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_survives_json_and_cannot_command_a_terminal() {
        let mut line = Line::now(tracing::Level::INFO, "7", "mc");
        line.message = "bad \u{1b}[2J".into();
        line.fields.insert("scenario".into(), 3.into());
        let json = line.to_text(Format::Json);
        assert_eq!(serde_json::from_str::<Line>(&json).unwrap(), line);
        assert!(line.to_string().ends_with("INFO  7 mc: bad \\u{1b}[2J scenario=3"), "{line}");
        for code in ["\u{1b}[2J", "\u{1b}]0;x\u{7}", "\u{9b}2J", "\u{9d}0;x\u{9c}", "\r", "\u{8}", "\u{7f}"] {
            line.message = code.into();
            line.node = format!("mc@{code}");
            line.fields.insert(code.into(), format!("a{code}").into());
            let json = line.to_text(Format::Json);
            assert_eq!(serde_json::from_str::<Line>(&json).unwrap(), line);
            assert!(!json.chars().chain(line.to_string().chars()).any(char::is_control), "{code:?}");
        }
    }
}
