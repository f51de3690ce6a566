"""Schemas, completions of editors, and the formats of other programs."""

import json
import subprocess

import numpy as np
import phasecloud as pc
import pytest
from conftest import ROOT, SCENARIOS
from phasecloud import _native

jsonschema = pytest.importorskip("jsonschema")

#: The folder of maps has the scenarios that they vary, too.
IS_MAP = {file: "[quantity]" in file.read_text() for file in ROOT.glob("launch/maps/*.toml")}
FILES = {
    "scenario": [*SCENARIOS.glob("*.toml"), *ROOT.glob("launch/models/*.toml"), *(file for file, is_map in IS_MAP.items() if not is_map)],
    "launch": [*ROOT.glob("launch/*.toml"), ROOT / "examples/python/launch.toml"],
    "map": [file for file, is_map in IS_MAP.items() if is_map],
}


def validator(kind):
    said = subprocess.run([pc.command(), "schema", kind], capture_output=True, text=True, check=True).stdout
    return jsonschema.Draft7Validator(json.loads(said))


def table(text):
    return json.loads(_native.json_from_toml(text))


def examples(page):
    """The TOML examples of a page that are whole files."""
    blocks = (ROOT / "docs" / page).read_text().split("```toml\n")[1:]
    return [block.split("```")[0] for block in blocks if block.startswith(("name", "scenario"))]


@pytest.mark.parametrize("kind", FILES)
def test_every_file_of_the_project_fits_its_schema_and_a_misspelt_key_does_not(kind):
    schema = validator(kind)
    assert len(FILES[kind]) >= 3
    for file in FILES[kind]:
        content = table(file.read_text())
        assert not [error.message for error in schema.iter_errors(content)], file
        for place in [content, *(part for part in content.values() if isinstance(part, dict) and part is not content.get("vary"))]:
            place["misspelt"] = 1
            assert not schema.is_valid(content), (file, place)
            del place["misspelt"]


def test_the_examples_of_the_pages_fit_the_schemas():
    for page, kind in [("scenario-files.md", "scenario"), ("launch-files.md", "launch"), ("maps.md", "map")]:
        schema, there = validator(kind), [text for text in examples(page) if "[vary]" not in text or kind == "map"]
        assert there, page
        for text in there:
            assert not [error.message for error in schema.iter_errors(table(text))], text


@pytest.mark.parametrize(
    "change",
    [
        {"label": "mc", "node": "mc", "sampels": 10},
        {"label": "mc", "node": "mc", "samples": 0.5},
        {"label": "mc", "node": "mc", "draws": "random"},
        {"label": "mc", "node": "mcc"},
        {"label": "mc", "command": ["x"], "samples": 10},
        {"label": "mc", "node": "mc", "accuracy": 1e-7},
        {"node": "mc"},
    ],
)
def test_a_case_that_cannot_be_is_found(change):
    launch = {"name": "x", "scenarios": ["s.toml"], "reference": "mc", "propagator": [{"label": "mc", "node": "mc"}]}
    schema = validator("launch")
    assert schema.is_valid(launch)
    launch["propagator"] = [change]
    assert not schema.is_valid(launch)


def test_keys_are_described_and_words_are_listed():
    scenario = json.dumps(validator("scenario").schema)
    assert "solar radiation pressure against the Sun" in scenario and "log-normal" in scenario and "osculating" in scenario
    launch = json.dumps(validator("launch").schema)
    assert "low-discrepancy" in launch and "what methods are judged against" in launch


def test_the_schemas_in_the_project_are_those_of_the_program():
    for kind in FILES:
        assert json.loads((ROOT / f"docs/schema/{kind}.json").read_text()) == validator(kind).schema, f"phasecloud schema {kind}"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recorded")
    launch = folder / "launch.toml"
    scenario = SCENARIOS / "scenario-1.toml"
    cases = '[[propagator]]\nlabel = "mc"\nnode = "mc"\nsamples = 500\n[[propagator]]\nlabel = "gmm"\nnode = "gmm-ut"\n'
    launch.write_text(f'name = "x"\nscenarios = ["{scenario}"]\nreference = "mc"\nbins = [20, 20]\n{cases}')
    words = ["run", str(launch), "--record", "run.tape", "--out", "out", "--no-report"]
    subprocess.run([pc.command(), *words], cwd=folder, check=True, capture_output=True)
    return folder


def test_a_recording_is_read_by_the_mcap_package(recorded):
    reader = pytest.importorskip("mcap.reader")
    subprocess.run([pc.command(), "export", "run.tape", "run.mcap"], cwd=recorded, check=True, capture_output=True)
    with open(recorded / "run.mcap", "rb") as file:
        messages = list(reader.make_reader(file, validate_crcs=True).iter_messages())
    for schema, _, message in messages:
        jsonschema.Draft7Validator(json.loads(schema.data)).validate(json.loads(message.data))
    densities = [(schema, json.loads(message.data)) for schema, channel, message in messages if channel.topic == "phasecloud/density"]
    assert len(densities) == 10
    for schema, message in densities:
        assert schema.encoding == "jsonschema"
    results = pc.Results(recorded / "out").columns("moments")
    mine = [message for _, message in densities if message["header"]["label"] == "mc"]
    assert [message["header"]["time"] for message in mine] == [0.0, 0.5, 1.0, 1.5, 2.0]
    assert mine[2]["header"]["mass_on_grid"] == pytest.approx(results["mass_on_grid"][(results["method"] == "mc")][2])
    samples = [json.loads(message.data) for _, channel, message in messages if channel.topic == "phasecloud/snapshot"]
    assert any(len(message["payload"]["rows"]) == 500 for message in samples)
    times = [message.log_time for _, _, message in messages]
    assert sorted(times) == [1_000_000 * k for k in range(len(times))]
    again = subprocess.run([pc.command(), "export", "run.tape", "run.mcap"], cwd=recorded, capture_output=True, text=True)
    assert again.returncode == 2 and "exists already" in again.stderr
    damaged = subprocess.run([pc.command(), "export", "launch.toml", "x.mcap"], cwd=recorded, capture_output=True, text=True)
    assert damaged.returncode == 2 and not (recorded / "x.mcap").exists()


def test_tables_are_written_as_parquet(recorded, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    results = pc.Results(recorded / "out")
    files = results.to_parquet(tmp_path / "tables")
    assert len(files) == 9
    table = parquet.read_table(tmp_path / "tables/moments.parquet")
    assert table.column_names == list(results.columns("moments")) and table.num_rows == 10
    assert table.column("mean_e").to_pylist() == results.columns("moments")["mean_e"].tolist()
    assert set(table.column("method").to_pylist()) == {"mc", "gmm"}
    about = json.loads(parquet.read_metadata(files[0]).metadata[b"phasecloud"])
    assert about["run_id"] == results.manifest["run_id"]
    with pytest.raises(ValueError, match="whose files are sealed"):
        results.to_parquet(recorded / "out/tables")
    with pytest.raises(ValueError, match="does not exist yet"):
        results.to_parquet(tmp_path / "tables")


def test_a_run_writes_its_tables_as_parquet_too(recorded):
    parquet = pytest.importorskip("pyarrow.parquet")
    run = [pc.command(), "run", "launch.toml", "--out", "columns", "--no-report", "--quiet", "--export", "parquet"]
    subprocess.run(run, cwd=recorded, check=True, capture_output=True)
    subprocess.run([pc.command(), "verify", "columns"], cwd=recorded, check=True, capture_output=True)
    for name in ("moments", "first_passage", "notes"):
        rows = parquet.read_table(recorded / f"columns/{name}.parquet").to_pylist()
        written = pc.Results(recorded / "columns").columns(name)
        assert len(rows) == len(written["method"]) and list(rows[0] if rows else written) == list(written)


def test_an_ephemeris_is_read_by_the_oem_package(tmp_path):
    oem = pytest.importorskip("oem")
    scenario = (ROOT / "launch/models/osculating.toml").read_text()
    (tmp_path / "mine.toml").write_text(scenario.replace("[epoch]\n", "[epoch]\ndate = 2027-03-01\n"))
    command = [pc.command(), "orbit", "--oem", "--step", "0.25", "mine.toml"]
    printed = subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True).stdout
    (tmp_path / "mine.oem").write_text(printed)
    message = oem.OrbitEphemerisMessage.open(tmp_path / "mine.oem")
    segment = message.segments[0]
    assert segment.metadata["OBJECT_NAME"] == "osculating" and segment.metadata["TIME_SYSTEM"] == "TT"
    states = list(segment.states)
    assert len(states) == 9
    assert 2.5 * 6378.137 * 0.85 < np.linalg.norm(states[0].position) < 2.5 * 6378.137 * 1.15
    assert (states[-1].epoch - states[0].epoch).to_value("s") == pytest.approx(2 * 365.256363 * 86400, abs=1e-4)
