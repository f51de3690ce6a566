//! The headers in `python/phasecloud/kit/layout.py` are those of `layout.rs`, byte for byte.
#![allow(missing_docs)]

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use messages::content::{
    Characteristics, DETAIL_WORDS, KINDS, Kind, KindTable, Mixture, Samples, SnapshotKind, kind, treatment,
};
use messages::describe::{Described, Entries, Field, FieldKind};
use messages::layout::{PASSAGE_COLUMNS, PASSAGE_TIMES, PassageHeader, SnapshotHeader, StatusHeader, event, role};
use messages::scenario::{ParameterEntry, ProjectionEntry, ScenarioHeader, VariableEntry, range};

/// Set to 1 to fail where Python is missing, instead of skipping.
const REQUIRE: &str = "PHASECLOUD_REQUIRE_PYTHON";

/// Prints the layouts of the Python file in the form of [`rust_says`], and the kinds of snapshots whose names are its
/// arguments.
const PYTHON_SAYS: &str = r#"
import ctypes, layout, sys
names = {ctypes.c_uint64: "u64", ctypes.c_double: "f64", ctypes.c_uint32: "u32", ctypes.c_uint8: "u8"}
def rust_name(kind):
    if kind in names:
        return names[kind]
    item = names[kind._type_] if kind._type_ in names else kind._type_.type_name()
    return f"[{item}; {kind._length_}]"
for header in (layout.VariableEntry, layout.ParameterEntry, layout.ProjectionEntry, layout.ScenarioHeader, layout.SnapshotHeader, layout.SamplesDetails, layout.CharacteristicsDetails,
               layout.MixtureDetails, layout.PassageHeader, layout.StatusHeader):
    print(header.type_name(), ctypes.sizeof(header), ctypes.alignment(header))
    for name, kind in header._fields_:
        print(name, rust_name(kind), getattr(header, name).offset)
for name in sys.argv[1:]:
    kind = getattr(layout, name)
    print(name, kind, layout.COLUMNS[kind], layout.DETAILS[kind].type_name())
for name in ("CARRIED_MESH", "HULL_MESH", "READY", "PROGRESS", "DONE", "FAILED", "CASE", "SHARD",
             "DETAIL_WORDS", "CIRCLE", "INTERVAL", "PASSAGE_COLUMNS", "PASSAGE_TIMES"):
    print(name, getattr(layout, name))
"#;

/// Writes a header and all its fields.
fn describe<T: Described>(lines: &mut String) {
    writeln!(lines, "{} {} {}", T::TYPE_NAME, size_of::<T>(), align_of::<T>()).unwrap();
    for Field { name, kind, offset, .. } in T::FIELDS {
        let kind = match kind {
            FieldKind::U64 => "u64".into(),
            FieldKind::U32 => "u32".into(),
            FieldKind::F64 => "f64".into(),
            FieldKind::F64s(count) => format!("[f64; {count}]"),
            FieldKind::Text(bytes) => format!("[u8; {bytes}]"),
            FieldKind::Words(count) => format!("[u64; {count}]"),
            FieldKind::Entries(Entries { name, count, .. }) => format!("[{name}; {count}]"),
        };
        writeln!(lines, "{name} {kind} {offset}").unwrap();
    }
}

fn rust_says() -> String {
    let mut lines = String::new();
    describe::<VariableEntry>(&mut lines);
    describe::<ParameterEntry>(&mut lines);
    describe::<ProjectionEntry>(&mut lines);
    describe::<ScenarioHeader>(&mut lines);
    describe::<SnapshotHeader>(&mut lines);
    describe::<<Samples as Kind>::Details>(&mut lines);
    describe::<<Characteristics as Kind>::Details>(&mut lines);
    describe::<<Mixture as Kind>::Details>(&mut lines);
    describe::<PassageHeader>(&mut lines);
    describe::<StatusHeader>(&mut lines);
    lines
}

#[test]
fn python_has_the_same_headers_and_codes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../python/phasecloud/kit");
    let kinds = sent_from_python().map(name);
    let python = Command::new("python3").args(["-B", "-c", PYTHON_SAYS]).args(kinds).env("PYTHONPATH", folder).output();
    let output = match python {
        Ok(output) => output,
        Err(error) => {
            assert!(std::env::var_os(REQUIRE).is_none_or(|value| value != "1"), "python3: {error}");
            println!("skipped: python3 cannot be started: {error}");
            return;
        }
    };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(String::from_utf8_lossy(&output.stdout), rust_says() + &codes());
}

/// The kinds of snapshots that a propagator in Python may send.
fn sent_from_python() -> impl Iterator<Item = &'static KindTable> {
    KINDS.iter().filter(|table| match table.kind {
        SnapshotKind::Samples | SnapshotKind::Characteristics | SnapshotKind::Mixture => true,
        SnapshotKind::Density | SnapshotKind::Reduced => false,
    })
}

/// The name of a kind's code.
fn name(table: &KindTable) -> &'static str {
    kind::CODES.name_of(table.kind.code().into()).unwrap()
}

fn codes() -> String {
    let mut text = String::new();
    for table in sent_from_python() {
        writeln!(text, "{} {} {} {}", name(table), table.kind.code(), table.columns.len(), table.details_name).unwrap();
    }
    let codes = [
        ("CARRIED_MESH", treatment::CARRIED_MESH as usize),
        ("HULL_MESH", treatment::HULL_MESH as usize),
        ("READY", event::READY as usize),
        ("PROGRESS", event::PROGRESS as usize),
        ("DONE", event::DONE as usize),
        ("FAILED", event::FAILED as usize),
        ("CASE", role::CASE as usize),
        ("SHARD", role::SHARD as usize),
        ("DETAIL_WORDS", DETAIL_WORDS),
        ("CIRCLE", range::CIRCLE as usize),
        ("INTERVAL", range::INTERVAL as usize),
        ("PASSAGE_COLUMNS", PASSAGE_COLUMNS),
        ("PASSAGE_TIMES", PASSAGE_TIMES),
    ];
    for (name, value) in codes {
        writeln!(text, "{name} {value}").unwrap();
    }
    text
}
