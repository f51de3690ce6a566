use std::path::Path;

use super::*;

const LAUNCH: &str = "name = \"l\"\nscenarios = [\"s.toml\"]\nreference = \"mc\"\n[[propagator]]\nlabel = \"mc\"\n";
const SCENARIO: &str = "name = \"s\"\n[orbit]\nradiation = 1\n[initial]\ne = 0.1\n";
const SWEEP: &str = "scenario = \"s.toml\"\n[vary]\n\"initial.e\" = [0.1]\n";

fn file(text: &str) -> InputFile {
    InputFile::from_text(Path::new("x.toml"), text)
}

#[test]
fn a_file_is_what_most_of_its_keys_say() {
    for (text, kind) in [
        (LAUNCH, Some(FileKind::Launch)),
        (SCENARIO, Some(FileKind::Scenario)),
        (SWEEP, Some(FileKind::Sweep)),
        ("name = \"x\"\n", None),
        ("scenario = \"s.toml\"\n[orbit]\n", None),
        ("not toml", None),
    ] {
        assert_eq!(file(text).kind(), kind, "{text}");
    }
}

#[test]
fn every_other_kind_is_recognised_with_what_to_do() {
    for (expected, text, words) in [
        (
            FileKind::Launch,
            SCENARIO,
            "x.toml:2: orbit: this is a scenario file, but a launch file belongs here; `phasecloud run --scenario x.toml`",
        ),
        (
            FileKind::Launch,
            SWEEP,
            "x.toml:1: scenario: this is a sweep file, but a launch file belongs here; `phasecloud serve LAUNCH_FILE --sweep x.toml`",
        ),
        (
            FileKind::Scenario,
            LAUNCH,
            "x.toml:2: scenarios: this is a launch file, but a scenario file belongs here; `phasecloud run x.toml`",
        ),
        (FileKind::Scenario, SWEEP, "`phasecloud serve LAUNCH_FILE --sweep x.toml`"),
        (FileKind::Sweep, LAUNCH, "`phasecloud serve x.toml --sweep SWEEP_FILE`"),
        (FileKind::Sweep, SCENARIO, "names it as scenario"),
    ] {
        let error = file(text).expect(expected).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    assert!(file(LAUNCH).expect(FileKind::Launch).is_ok() && file("x = [").expect(FileKind::Launch).is_ok());
}
