//! The headers in `examples/python/phasecloud_layout.py` are those of `layout.rs`, byte for byte.
#![allow(missing_docs)]

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use messages::layout::{
    PASSAGE_COLUMNS, PASSAGE_TIMES, PassageHeader, SCENARIO_COLUMNS, ScenarioHeader, SnapshotHeader, StatusHeader,
    columns, event, kind, treatment,
};

/// Set to 1 to fail where Python is missing, instead of skipping.
const REQUIRE: &str = "PHASECLOUD_REQUIRE_PYTHON";

/// Prints what the Python file says, in the form of [`rust_says`].
const PYTHON_SAYS: &str = r#"
import ctypes, phasecloud_layout as layout
names = {ctypes.c_uint64: "u64", ctypes.c_double: "f64", ctypes.c_uint32: "u32", ctypes.c_uint8: "u8"}
def rust_name(kind):
    return names[kind] if kind in names else f"[{names[kind._type_]}; {kind._length_}]"
for header in (layout.ScenarioHeader, layout.SnapshotHeader, layout.PassageHeader, layout.StatusHeader):
    print(header.type_name(), ctypes.sizeof(header), ctypes.alignment(header))
    for name, kind in header._fields_:
        print(name, rust_name(kind), getattr(header, name).offset)
for name in ("SAMPLES", "CHARACTERISTICS", "MIXTURE"):
    print(name, getattr(layout, name), layout.COLUMNS[getattr(layout, name)])
for name in ("CARRIED_MESH", "HULL_MESH", "READY", "PROGRESS", "DONE", "FAILED",
             "SCENARIO_COLUMNS", "PASSAGE_COLUMNS", "PASSAGE_TIMES"):
    print(name, getattr(layout, name))
"#;

/// Writes a header and all its fields; does not compile if one is forgotten.
macro_rules! describe {
    ($lines:ident, $header:ident { $($field:ident),* $(,)? }) => {{
        let $header { $($field),* } = $header::default();
        let (size, alignment) = (size_of::<$header>(), align_of::<$header>());
        writeln!($lines, "{} {size} {alignment}", type_name(stringify!($header))).unwrap();
        $(
            let kind = std::any::type_name_of_val(&$field);
            writeln!($lines, "{} {kind} {}", stringify!($field), std::mem::offset_of!($header, $field)).unwrap();
        )*
    }};
}

/// The type name that stands above a header in `layout.rs`.
fn type_name(header: &str) -> &'static str {
    let source = include_str!("../src/layout.rs");
    let before = source.split(&format!("pub struct {header} ")).next().unwrap();
    before.rsplit("#[type_name(\"").next().unwrap().split('"').next().unwrap()
}

fn rust_says() -> String {
    let mut lines = String::new();
    describe!(
        lines,
        ScenarioHeader {
            run_id,
            radiation,
            oblateness,
            mean_phi,
            mean_e,
            sigma_phi,
            sigma_e,
            critical_e,
            scenario,
            scenarios,
            snapshots,
            reserved,
            phi_bins,
            e_bins,
            name,
        }
    );
    describe!(
        lines,
        SnapshotHeader {
            run_id,
            time,
            seconds,
            disagreement,
            total,
            scenario,
            index,
            count,
            kind,
            rows,
            columns,
            treatment,
            resolution,
            lattice,
            degree,
            replicates,
            attempt,
            shard,
            shards,
            most_rows,
            reserved,
            label,
        }
    );
    describe!(lines, PassageHeader { run_id, seconds, samples, scenario, rows, shard, shards, label, reason });
    describe!(lines, StatusHeader { run_id, event, scenario, node, subject, text });
    lines
}

#[test]
fn python_has_the_same_headers_and_codes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/python");
    let python = Command::new("python3").args(["-B", "-c", PYTHON_SAYS]).env("PYTHONPATH", folder).output();
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

fn codes() -> String {
    let mut text = String::new();
    let kinds = [("SAMPLES", kind::SAMPLES), ("CHARACTERISTICS", kind::CHARACTERISTICS), ("MIXTURE", kind::MIXTURE)];
    for (name, kind) in kinds {
        writeln!(text, "{name} {kind} {}", columns(kind).unwrap()).unwrap();
    }
    let codes = [
        ("CARRIED_MESH", treatment::CARRIED_MESH as usize),
        ("HULL_MESH", treatment::HULL_MESH as usize),
        ("READY", event::READY as usize),
        ("PROGRESS", event::PROGRESS as usize),
        ("DONE", event::DONE as usize),
        ("FAILED", event::FAILED as usize),
        ("SCENARIO_COLUMNS", SCENARIO_COLUMNS),
        ("PASSAGE_COLUMNS", PASSAGE_COLUMNS),
        ("PASSAGE_TIMES", PASSAGE_TIMES),
    ];
    for (name, value) in codes {
        writeln!(text, "{name} {value}").unwrap();
    }
    text
}
