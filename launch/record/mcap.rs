//! A recording as an MCAP file: a channel for each topic, messages as JSON, with schemas that Foxglove and other
//! readers of MCAP know.
//!
//! A recording has no times of day: the log time of a message is its place in the recording, a millisecond each. The
//! time in years of what a message is about is in its header.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};
use messages::describe::{Described, Field, FieldKind};
use messages::payload::Item;
use messages::recording::{Entry, Recording};
use messages::topic::{Topic, Visitor, for_each};
use serde_json::{Map, Value, json};

use crate::observe::taken::Taken;

/// Time between two messages in the log \[ns\].
const TICK: u64 = 1_000_000;

/// Writes a recording as an MCAP file, which must not exist yet, and returns the number of messages.
///
/// # Errors
/// What cannot be read or written.
pub fn export(recording: &Path, out: &Path) -> Result<usize, String> {
    let recording = Recording::open(recording).map_err(|error| error.to_string())?;
    if out.exists() {
        return Err(format!("{} exists already; name a new file", out.display()));
    }
    let draft = Draft(out.with_extension("mcap.partial"));
    let failed = |problem: &dyn std::fmt::Display| format!("{}: {problem}", out.display());
    let count = write(&recording, &draft.0).map_err(|error| failed(&error))?;
    std::fs::rename(&draft.0, out).map_err(|error| failed(&error))?;
    Ok(count)
}

/// A file that is removed unless it has got its final name.
struct Draft(PathBuf);

impl Drop for Draft {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn write(recording: &Recording, path: &Path) -> Result<usize, String> {
    let file = BufWriter::new(File::create(path).map_err(|e| e.to_string())?);
    let options = WriteOptions::new().compression(None).library("phasecloud");
    let mut writer = options.create(file).map_err(|e| e.to_string())?;
    // All topics say where their messages stand; then the messages are written in that order.
    let listed = for_each(&mut List { recording, writer: &mut writer });
    let mut places: Vec<(u64, u16, usize)> = Vec::new();
    for (topic, listed) in listed.into_iter().enumerate() {
        let (channel, positions) = listed?;
        places.extend(positions.into_iter().map(|position| (position, channel, topic)));
    }
    places.sort_unstable();
    let order: BTreeMap<u64, u64> = (0..).zip(&places).map(|(number, (position, ..))| (*position, number)).collect();
    let channels: Vec<u16> = {
        let mut channels = vec![0; 8];
        places.iter().for_each(|&(_, channel, topic)| channels[topic] = channel);
        channels
    };
    let mut topic = 0;
    let mut write = Write { recording, writer: &mut writer, order: &order, channels: &channels, topic: &mut topic };
    for written in for_each(&mut write) {
        written?;
    }
    writer.finish().map_err(|e| e.to_string())?;
    Ok(places.len())
}

type Mcap = Writer<BufWriter<File>>;

/// Adds the channel of each topic.
struct List<'a> {
    recording: &'a Recording,
    writer: &'a mut Mcap,
}

impl Visitor for List<'_> {
    type Out = Result<(u16, Vec<u64>), String>;

    fn visit<T: Topic>(&mut self) -> Self::Out {
        let schema = schema::<T>().to_string();
        let schema = self.writer.add_schema(T::Header::TYPE_NAME, "jsonschema", schema.as_bytes());
        let schema = schema.map_err(|e| e.to_string())?;
        let channel = self.writer.add_channel(schema, T::NAME, "json", &BTreeMap::new()).map_err(|e| e.to_string())?;
        Ok((channel, self.recording.messages::<T>().map(|(_, entry)| entry.position()).collect()))
    }
}

/// Writes the messages of each topic.
struct Write<'a> {
    recording: &'a Recording,
    writer: &'a mut Mcap,
    order: &'a BTreeMap<u64, u64>,
    channels: &'a [u16],
    topic: &'a mut usize,
}

impl Visitor for Write<'_> {
    type Out = Result<(), String>;

    fn visit<T: Topic>(&mut self) -> Self::Out {
        let channel_id = self.channels[*self.topic];
        *self.topic += 1;
        for (sequence, (header, entry)) in (0..).zip(self.recording.messages::<T>()) {
            let log_time = TICK * self.order.get(&entry.position()).copied().unwrap_or_default();
            let message = taken::<T>(self.recording, &header, entry)?.json().to_string();
            let place = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
            self.writer.write_to_known_channel(&place, message.as_bytes()).map_err(|e| e.to_string())?;
        }
        Ok(())
    }
}

fn taken<T: Topic>(recording: &Recording, header: &T::Header, entry: &Entry) -> Result<Taken, String> {
    let mut items = vec![bytemuck::Zeroable::zeroed(); entry.items::<T>()];
    recording.read::<T>(entry, &mut items).map_err(|error| error.to_string())?;
    Ok(Taken::of::<T>(header, &items, usize::MAX))
}

/// The JSON Schema of the messages of a topic.
fn schema<T: Topic>() -> Value {
    let property = |field: &Field| {
        // A number that is withheld is null.
        let number = json!({ "type": ["number", "null"] });
        let mut said = match field.kind {
            FieldKind::U64 if field.name == "run_id" => json!({ "type": "string" }),
            FieldKind::U64 | FieldKind::U32 => json!({ "type": "integer" }),
            FieldKind::F64 => number,
            FieldKind::F64s(_) => json!({ "type": "array", "items": number }),
            FieldKind::Text(_) => json!({ "type": "string" }),
            FieldKind::Words(_) | FieldKind::Entries(_) => return None,
        };
        let unit = if field.unit.is_empty() { String::new() } else { format!(" [{}]", field.unit) };
        said["description"] = format!("{}{unit}", field.doc.join(" ").trim()).into();
        Some((field.name.to_owned(), said))
    };
    let header: Map<String, Value> = T::Header::FIELDS.iter().filter_map(property).collect();
    let cell = if T::Item::FIELDS.is_empty() { json!({ "type": ["number", "null"] }) } else { json!({}) };
    let rows = json!({ "type": "array", "items": { "type": "array", "items": cell } });
    let columns = json!({ "type": "array", "items": { "type": "string" } });
    json!({
        "type": "object",
        "properties": {
            "topic": { "type": "string" },
            "header": { "type": "object", "properties": header },
            "payload": {
                "type": "object",
                "properties": { "items": { "type": "integer" }, "columns": columns, "rows": rows }
            }
        }
    })
}
