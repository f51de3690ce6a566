//! `phasecloud echo`: the messages of a topic, field by field.
//!
//! A thread of its own takes the messages, so that a slow terminal delays nobody; messages that it cannot keep up with
//! are counted.

use std::io::Write;
use std::process::ExitCode;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use clap::Args;
use messages::describe::{Field, FieldKind, Value};
use messages::domain::Place;
use messages::payload::{Item, Shape};
use messages::port::{Message, PortError};
use messages::topic::{Topic, Visitor};
use serde_json::{Map, json};

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

/// A message taken apart.
struct Shown {
    topic: &'static str,
    header: Vec<(String, Field, Value)>,
    items: usize,
    shape: Shape,
    rows: Vec<Vec<Value>>,
    /// Number of messages before this one that could not be printed in time.
    missed: usize,
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
fn take<T: Topic>(place: &Place, most: usize, sender: SyncSender<Option<Shown>>) -> Result<End, PortError> {
    use std::sync::mpsc::TrySendError::{Disconnected, Full};
    let mut missed = 0;
    follow::<T>(place, "echo", |message| {
        let shown = message.map(|message| take_apart(&message, most, missed));
        let is_message = shown.is_some();
        match sender.try_send(shown) {
            Ok(()) => missed = if is_message { 0 } else { missed },
            Err(Full(_)) => missed += usize::from(is_message),
            Err(Disconnected(_)) => return false,
        }
        true
    })
}

fn take_apart<T: Topic>(message: &Message<T>, most: usize, missed: usize) -> Shown {
    let header = T::values(message.header());
    let (shape, items) = (T::shape(message.header()), message.items());
    let rows = if T::Item::FIELDS.is_empty() {
        number_rows(bytemuck::cast_slice(bytemuck::cast_slice::<_, u8>(items)), &shape, most)
    } else {
        let fields =
            |item: &T::Item| T::Item::FIELDS.iter().filter_map(|field| field.value(bytemuck::bytes_of(item))).collect();
        items.iter().take(most).map(fields).collect()
    };
    Shown { topic: T::NAME, header, items: items.len(), shape, rows, missed }
}

/// The numbers before the table of a payload, if it has any, as a row of their own, and the first rows of the table.
fn number_rows(numbers: &[f64], shape: &Shape, most: usize) -> Vec<Vec<Value>> {
    let (head, numbers) = numbers.split_at(shape.head.min(numbers.len()));
    let head = (!head.is_empty()).then(|| head.iter().map(|&x| Value::Real(vec![x])).collect());
    let columns = shape.columns.len().max(1);
    let count = numbers.len().div_ceil(columns);
    let at = |row: usize, column: usize| if shape.by_column { column * count + row } else { row * columns + column };
    let row =
        |row| (0..columns).filter_map(|column| numbers.get(at(row, column))).map(|&x| Value::Real(vec![x])).collect();
    head.into_iter().chain((0..count.min(most)).map(row)).collect()
}

/// Prints what comes; returns why it ended, if it ended before the messages did.
fn print_all(arguments: &EchoArguments, receiver: &Receiver<Option<Shown>>) -> Option<End> {
    let mut left = arguments.count.unwrap_or(usize::MAX);
    let mut out = std::io::stdout().lock();
    while left > 0 {
        let Ok(shown) = receiver.recv() else { return None };
        let Some(shown) = shown else { continue };
        if shown.missed > 0 {
            remark!("{} messages were not shown, they came too fast", shown.missed);
        }
        let text = if arguments.json { json_line(&shown) } else { block(&shown) };
        if !output::note(writeln!(out, "{text}").and_then(|()| out.flush())) {
            return Some(End::Stopped);
        }
        left -= 1;
    }
    Some(End::Over)
}

/// A message as text: one line per field, then rows of the payload.
fn block(shown: &Shown) -> String {
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

/// Whether a field is the number of a run. Runs are named in hexadecimal digits everywhere; all other numbers are
/// decimal.
fn is_run(field: &Field) -> bool {
    field.kind == FieldKind::U64 && field.name == "run_id"
}

fn words(field: &Field, value: &Value) -> String {
    match value {
        Value::Whole(number) if is_run(field) => format!("{number:012x}"),
        other => plain(other),
    }
}

fn plain(value: &Value) -> String {
    match value {
        Value::Whole(number) => number.to_string(),
        Value::Real(numbers) => numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" "),
        Value::Text(text) => text.clone(),
    }
}

fn code(field: &Field, value: &Value) -> String {
    let name = match value {
        Value::Whole(number) => field.codes.and_then(|codes| codes.name_of(*number)),
        _ => None,
    };
    name.map_or(String::new(), |name| format!(" ({name})"))
}

/// A message as one JSON object.
fn json_line(shown: &Shown) -> String {
    let value = |value: &Value| match value {
        Value::Whole(number) => json!(number),
        Value::Real(numbers) if numbers.len() == 1 => json!(numbers[0]),
        Value::Real(numbers) => json!(numbers),
        Value::Text(text) => json!(text),
    };
    let field = |(name, field, field_value): &(String, Field, Value)| {
        let shown = if is_run(field) { json!(words(field, field_value)) } else { value(field_value) };
        (name.clone(), shown)
    };
    let header: Map<_, _> = shown.header.iter().map(field).collect();
    let rows: Vec<Vec<_>> = shown.rows.iter().map(|row| row.iter().map(value).collect()).collect();
    let payload = json!({"items": shown.items, "columns": shown.shape.columns, "rows": rows});
    json!({"topic": shown.topic, "header": header, "payload": payload}).to_string()
}

#[cfg(test)]
mod tests {
    use messages::content::Characteristics;
    use messages::layout::{PassageHeader, SnapshotHeader};
    use messages::topic::{Passage, Snapshot};

    use super::*;

    fn shown<T: Topic>(header: &T::Header) -> Shown {
        let header = T::values(header);
        let shape = Shape { head: 0, columns: Vec::new(), by_column: false };
        Shown { topic: "x", header, items: 0, shape, rows: Vec::new(), missed: 0 }
    }

    #[test]
    fn runs_are_shown_in_hexadecimal_digits_and_numbers_in_decimal_ones() {
        let snapshot = shown::<Snapshot>(&SnapshotHeader { run_id: 255, total: 100_000, ..SnapshotHeader::default() });
        let text = block(&snapshot);
        assert!(text.contains("0000000000ff\n") && text.contains(" 100000\n"), "{text}");
        let json: serde_json::Value = serde_json::from_str(&json_line(&snapshot)).unwrap();
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
        let json: serde_json::Value = serde_json::from_str(&json_line(&snapshot)).unwrap();
        assert_eq!(json["header"]["resolution"], json!(500));
    }
}
