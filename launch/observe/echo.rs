//! `phasecloud echo`: the messages of a topic, field by field.
//!
//! A thread of its own takes the messages, so that a slow terminal delays nobody; messages that it cannot keep up with
//! are counted.

use std::io::Write;
use std::process::ExitCode;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use clap::Args;
use messages::describe::{Field, Value};
use messages::domain::Place;
use messages::port::PortError;
use messages::topic::{Topic, Visitor};

use super::taken::{Taken, plain, words};
use super::{End, follow, with_topic};
use crate::domain::attach::{self, Target};
use crate::output;

/// Rows of a payload that are shown.
const FEW_ROWS: usize = 3;
/// Messages that may wait to be printed.
const WAITING: usize = 64;

/// Arguments of `phasecloud echo`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  phasecloud echo status\n  phasecloud echo snapshot --count 1 --json --full")]
pub struct EchoArguments {
    /// The topic: scenario, snapshot, passage, density, comparison, status or roster
    pub topic: String,
    #[command(flatten)]
    pub target: Target,
    /// Show payloads whole instead of their first rows
    #[arg(long)]
    pub full: bool,
    /// Print one JSON object per line
    #[arg(long)]
    pub json: bool,
    /// End after this number of messages
    #[arg(long, value_name = "N")]
    pub count: Option<usize>,
}

/// Prints the messages of a topic until the run ends.
pub fn run(arguments: &EchoArguments) -> ExitCode {
    let target = attach::find(&arguments.target);
    super::exit(target.and_then(|run| with_topic(&arguments.topic, Echo { place: run.place, arguments })))
}

struct Echo<'a> {
    place: Place,
    arguments: &'a EchoArguments,
}

impl Visitor for Echo<'_> {
    type Out = Result<End, PortError>;

    fn visit<T: Topic>(&mut self) -> Self::Out {
        let most = if self.arguments.full { usize::MAX } else { FEW_ROWS };
        let (sender, receiver) = sync_channel(WAITING);
        let place = self.place.clone();
        std::thread::scope(|scope| {
            let reader = std::thread::Builder::new().spawn_scoped(scope, move || take::<T>(&place, most, sender));
            let reader = reader.map_err(|e| PortError::new("start a thread for", T::NAME, &e))?;
            let stopped = print_all(self.arguments, &receiver);
            drop(receiver);
            let end = reader.join().unwrap_or(Ok(End::Stopped))?;
            Ok(stopped.unwrap_or(end))
        })
    }
}

/// Takes messages and passes them on.
fn take<T: Topic>(place: &Place, most: usize, sender: SyncSender<Option<Taken>>) -> Result<End, PortError> {
    use std::sync::mpsc::TrySendError::{Disconnected, Full};
    let mut missed = 0;
    follow::<T>(place, "echo", |message| {
        let shown = message.map(|message| Taken { missed, ..Taken::of::<T>(message.header(), message.items(), most) });
        let is_message = shown.is_some();
        match sender.try_send(shown) {
            Ok(()) => missed = if is_message { 0 } else { missed },
            Err(Full(_)) => missed += usize::from(is_message),
            Err(Disconnected(_)) => return false,
        }
        true
    })
}

/// Prints what comes; returns why it ended, if it ended before the messages did.
fn print_all(arguments: &EchoArguments, receiver: &Receiver<Option<Taken>>) -> Option<End> {
    let mut left = arguments.count.unwrap_or(usize::MAX);
    let mut out = std::io::stdout().lock();
    while left > 0 {
        let Ok(shown) = receiver.recv() else { return None };
        let Some(shown) = shown else { continue };
        if shown.missed > 0 {
            remark!("{} messages were not shown, they came too fast", shown.missed);
        }
        let text = if arguments.json { shown.json().to_string() } else { block(&shown) };
        if !output::note(writeln!(out, "{text}").and_then(|()| out.flush())) {
            return Some(End::Stopped);
        }
        left -= 1;
    }
    Some(End::Over)
}

/// A message as text: one line per field, then rows of the payload.
fn block(shown: &Taken) -> String {
    let mut text = format!("{}\n", shown.topic);
    for (name, field, value) in &shown.header {
        let unit = if field.unit.is_empty() { String::new() } else { format!(" {}", field.unit) };
        text += &format!("  {name:20} {}{unit}{}\n", words(field, value), code(field, value));
    }
    text += &format!("  payload              {} items", shown.items);
    if !shown.shape.columns.is_empty() {
        text += &format!(": {}", shown.shape.columns.join(", "));
    }
    for row in &shown.rows {
        let cells: Vec<String> = row.iter().map(plain).collect();
        text += &format!("\n    {}", cells.join("  "));
    }
    text
}

fn code(field: &Field, value: &Value) -> String {
    let name = match value {
        Value::Whole(number) => field.codes.and_then(|codes| codes.name_of(*number)),
        _ => None,
    };
    name.map_or(String::new(), |name| format!(" ({name})"))
}

#[cfg(test)]
mod tests {
    use messages::content::Characteristics;
    use messages::layout::{PassageHeader, SnapshotHeader};
    use messages::topic::{Passage, Snapshot};

    use super::*;
    use messages::payload::Shape;
    use serde_json::json;

    fn shown<T: Topic>(header: &T::Header) -> Taken {
        let header = T::values(header);
        let shape = Shape { head: 0, columns: Vec::new(), by_column: false };
        Taken { topic: "x", header, items: 0, shape, rows: Vec::new(), missed: 0 }
    }

    #[test]
    fn runs_are_shown_in_hexadecimal_digits_and_numbers_in_decimal_ones() {
        let snapshot = shown::<Snapshot>(&SnapshotHeader { run_id: 255, total: 100_000, ..SnapshotHeader::default() });
        let text = block(&snapshot);
        assert!(text.contains("0000000000ff\n") && text.contains(" 100000\n"), "{text}");
        let json: serde_json::Value = snapshot.json();
        assert_eq!((&json["header"]["run_id"], &json["header"]["total"]), (&json!("0000000000ff"), &json!(100_000)));
        let text = block(&shown::<Passage>(&PassageHeader { samples: 4096, ..PassageHeader::default() }));
        assert!(text.contains(" 4096\n"), "{text}");
    }

    #[test]
    fn the_fields_that_only_one_kind_of_snapshot_has_are_shown_by_name_with_their_codes() {
        let hull = Characteristics::HullMesh { resolution: 500, as_printed: true };
        let snapshot = shown::<Snapshot>(&SnapshotHeader::default().with(hull));
        let text = block(&snapshot);
        let line = |name: &str| text.lines().find(|line| line.trim_start().starts_with(name)).unwrap_or_default();
        assert!(
            line("treatment").ends_with("2 (HULL_MESH_AS_PRINTED)") && line("resolution").ends_with(" 500"),
            "{text}"
        );
        assert!(line("replicates").is_empty() && line("details").is_empty(), "{text}");
        let json: serde_json::Value = snapshot.json();
        assert_eq!(json["header"]["resolution"], json!(500));
    }
}
