//! Writes `docs/messages.md` from the layouts themselves: `cargo run -p phasecloud-messages --example messages_doc`.
//!
//! What cannot be read off a layout, such as who waits for whom and why, is in `messages_doc.md` beside this file.

use std::fmt::Write;

use messages::content::{self, DENSITY_HEAD, KINDS, KindTable, kind};
use messages::describe::{Codes, Described, Entries, Field, FieldKind, plain};
use messages::domain::MOST_HELD;
use messages::domain::PATIENCE;
use messages::layout::{
    ALL_CODES, DISTANCE_COLUMNS, EFFORT_COLUMNS, ERROR_COLUMNS, GIVEN_COLUMNS, PASSAGE_COLUMNS, PASSAGE_TIMES,
    RosterEntry,
};
use messages::payload::{self, Item};
use messages::port::{JOINED, OBSERVER, READER, SENT};
use messages::scenario::{MOST_SNAPSHOTS, ScenarioHeader};
use messages::topic::{Capacity, Status, Topic, Visitor, for_each};

/// A run without propagators.
const ANY_CAPACITY: Capacity = Capacity { propagators: 0, cases: 0, snapshots: 1, hosts: 0 };

fn main() {
    print!("{}", document());
}

/// The whole document.
pub fn document() -> String {
    let onlookers = ANY_CAPACITY.nodes();
    let words = [
        ("{SENT}", SENT.as_value().to_string()),
        ("{JOINED}", JOINED.as_value().to_string()),
        ("{PATIENCE}", PATIENCE.as_secs().to_string()),
        ("{OBSERVER}", OBSERVER.to_owned()),
        ("{READER}", READER.to_owned()),
        ("{MOST_HELD}", MOST_HELD.to_string()),
        ("{MOST_SNAPSHOTS}", MOST_SNAPSHOTS.to_string()),
        ("{ONLOOKERS}", onlookers.to_string()),
        ("{STATUS_DEPTH}", Status::depth(&ANY_CAPACITY).to_string()),
        ("{topics}", topics()),
        ("{headers}", headers()),
        ("{details}", KINDS.iter().map(details).collect()),
        ("{codes}", ALL_CODES.map(codes).concat()),
        ("{payloads}", payloads()),
        ("`PASSAGE_COLUMNS`", PASSAGE_COLUMNS.to_string()),
        ("`GIVEN_COLUMNS`", GIVEN_COLUMNS.to_string()),
        ("`ERROR_COLUMNS`", ERROR_COLUMNS.to_string()),
        ("`DISTANCE_COLUMNS`", DISTANCE_COLUMNS.to_string()),
        ("`EFFORT_COLUMNS`", EFFORT_COLUMNS.to_string()),
        ("`DENSITY_HEAD`", DENSITY_HEAD.to_string()),
    ];
    let text = include_str!("messages_doc.md").to_owned();
    words.iter().fold(text, |text, (word, value)| text.replace(word, value.trim_end()))
}

fn topics() -> String {
    struct Row;
    impl Visitor for Row {
        type Out = String;
        fn visit<T: Topic>(&mut self) -> String {
            let reader = if T::LATCHED { "latched" } else { "kept" };
            let depth = T::DEPTH.replace("capacity.", "");
            format!("| `{}` | {} | {depth} | {reader} |\n", T::NAME, plain(T::DOC))
        }
    }
    format!("| topic | what | depth | |\n|---|---|---|---|\n{}", for_each(&mut Row).concat())
}

fn headers() -> String {
    struct Section;
    impl Visitor for Section {
        type Out = String;
        fn visit<T: Topic>(&mut self) -> String {
            layout::<T::Header>(&format!("`{}`, items `{}`", T::NAME, T::Item::NAME))
        }
    }
    let lists = ScenarioHeader::FIELDS.iter().filter_map(|field| match field.kind {
        FieldKind::Entries(entries) => Some(entry(field.name, entries)),
        _ => None,
    });
    for_each(&mut Section).concat()
        + &lists.collect::<String>()
        + &layout::<RosterEntry>("an item of `phasecloud/roster`")
}

/// One of the structures in a list of a scenario's header.
fn entry(list: &str, Entries { name, size, doc, fields: said, .. }: Entries) -> String {
    format!("### {name}\n\nOne of the `{list}` of a scenario, {size} bytes. {}\n\n", plain(doc)) + &fields(said)
}

fn layout<T: Described>(of: &str) -> String {
    format!("### {}\n\n{of}, {} bytes. {}\n\n", T::TYPE_NAME, size_of::<T>(), plain(T::DOC)) + &fields(T::FIELDS)
}

/// The details of a kind of snapshot.
fn details(table: &KindTable) -> String {
    let name = kind::CODES.name_of(table.kind.code().into()).unwrap_or_default();
    format!("### Details of kind `{name}`\n\n{}\n\n", plain(table.details_doc)) + &fields(table.details)
}

fn fields(fields: &[Field]) -> String {
    let mut text = String::new();
    text += "| offset | field | type | unit | meaning |\n|---|---|---|---|---|\n";
    for Field { name, kind, offset, unit, doc, .. } in fields {
        let _ = writeln!(text, "| {offset} | `{name}` | {kind} | {unit} | {} |", plain(doc));
    }
    text + "\n"
}

fn codes(codes: &Codes) -> String {
    let mut text =
        format!("### `{}`\n\n{}\n\n| code | name | meaning |\n|---|---|---|\n", codes.name, plain(codes.doc));
    let mut sorted = codes.codes.to_vec();
    sorted.sort_by_key(|code| code.value);
    for code in sorted {
        let _ = writeln!(text, "| {} | `{}` | {} |", code.value, code.name, plain(code.doc));
    }
    text + "\n"
}

fn payloads() -> String {
    let mut text = String::from("| payload | order | columns |\n|---|---|---|\n");
    let mut row = |name: &str, order: &str, columns: &[&str]| {
        let _ = writeln!(text, "| {name} | {order} | {} |", columns.join(", "));
    };
    let gaussian = "mean and upper triangle of the covariance of the initial Gaussian, then rows";
    let row_of_scenario = ["time [yr]", "lowest and highest value of every axis of every projection"];
    row("scenario", &format!("{gaussian}, one per snapshot"), &row_of_scenario);
    row("request", &format!("{gaussian}, one per snapshot"), &row_of_scenario[..1]);
    for code in kind::CODES.codes {
        let columns = content::table(code.value).map_or(&[][..], |kind| kind.columns);
        row(&format!("snapshot of kind `{}`", code.name), "column after column", columns);
    }
    row("passage", &format!("one row per time, {PASSAGE_TIMES} times"), &payload::PASSAGE);
    row("passage whose `given` is 1", "each row goes on with", &payload::GIVEN);
    row("density", "first variable outermost", &["quantities, their standard errors, the density on each projection"]);
    row("comparison of moments", "one row per quantity", &payload::ERRORS);
    row(
        "comparison of densities",
        "one row per projection, then the probability that each density is short of 1",
        &payload::DISTANCES,
    );
    row("comparison of effort", "one row", &payload::EFFORT);
    row("status", "one row", &payload::STATUS);
    let _ = writeln!(text, "\nA snapshot of kind `DENSITY` has {DENSITY_HEAD} numbers before its joint density.");
    text += "\nIn a first-passage curve `0 <= low <= probability <= high <= 1`, and probabilities do not fall; without an interval both ends are NaN. A \
        probability that is NaN between two ends is withheld: the truth lies between them.\n";
    text
}
