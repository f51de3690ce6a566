"""Runs of the command, and their results folders."""

import signal
import subprocess
import threading
from pathlib import Path

import numpy as np
import phasecloud as pc
import pytest
from conftest import SCENARIOS
from phasecloud import tables

SETTINGS = {"mc": {"samples": 3000, "seed": 7}, "dee": {"samples": 961}, "gmm-ut": {}, "exact": {}}
METHODS = {"mc": pc.monte_carlo, "dee": pc.dee, "gmm-ut": pc.gmm_ut, "exact": pc.exact}


def launch(scenario):
    cases = [{"label": node, "node": node, **settings} for node, settings in SETTINGS.items()]
    return {"name": "four", "scenarios": [scenario], "reference": "exact", "bins": [40, 40], "propagator": cases}


@pytest.fixture(scope="module")
def scenario():
    return pc.Scenario.from_file(SCENARIOS / "scenario-1.toml")


@pytest.fixture(scope="module")
def results(scenario, tmp_path_factory):
    return pc.run(launch(scenario), out=tmp_path_factory.mktemp("run") / "out")


def test_the_command_is_the_program_and_says_its_version():
    said = subprocess.run([pc.command(), "--version"], capture_output=True, text=True, check=True).stdout
    assert said.startswith(f"phasecloud {pc.__version__}")
    with open(pc.command(), "rb") as file:
        assert file.read(4) == b"\x7fELF"


@pytest.mark.parametrize("node", SETTINGS)
def test_a_method_in_this_process_has_the_numbers_of_its_node_in_a_run(scenario, results, node):
    mine = METHODS[node](scenario, bins=(40, 40), **SETTINGS[node])
    rows = tables.chosen(results.columns("moments"), method=node)
    for name, values in mine.quantities.items():
        if name in rows:
            assert np.array_equal(rows[name], values, equal_nan=True), name
    for index, snapshot in enumerate(mine.snapshots):
        for name, density in snapshot.densities.items():
            theirs = results.density(node, index, name)
            assert np.array_equal(theirs.values, density.values, equal_nan=True)
            assert all(np.array_equal(theirs.edges[symbol], density.edges[symbol]) for symbol in density.dims)
    if mine.first_passage is not None:
        assert np.array_equal(results.passage(node).probability, mine.first_passage.probability)
        assert results.passage(node).interval == mine.first_passage.interval


def test_results_have_tables_and_say_what_there_is(results):
    assert results.scenarios == ["scenario-1"] and sorted(results.methods) == sorted(SETTINGS)
    assert results.is_complete and np.array_equal(results.times(), [0, 0.5, 1, 1.5, 2])
    pandas = pytest.importorskip("pandas")
    assert isinstance(results.moments, pandas.DataFrame) and len(results.moments) == 20
    assert "verdict" in results.verdicts.columns
    with pytest.raises(KeyError, match="there is no case 'none' in scenario-1; there are"):
        results.density("none", 0)
    with pytest.raises(KeyError, match="there are joint, marginal_phi, marginal_e"):
        results.density("mc", 0, "marginal_x")
    with pytest.raises(KeyError, match="has no first-passage curve"):
        results.passage("gmm-ut")
    with pytest.raises(AttributeError, match="the tables are moments"):
        results.moment
    with pytest.raises(FileNotFoundError, match="not a results folder"):
        pc.Results(results.folder.parent)


def test_pictures_are_drawn(results, tmp_path):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    drawn = [
        results.plot_density("mc"),
        results.plot_density("exact", 1, "marginal_e"),
        results.plot_difference("mc", "exact", 2).figure,
        results.plot_first_passage().figure,
        results.plot_moment("std_e").figure,
    ]
    for number, figure in enumerate(drawn):
        path = tmp_path / f"{number}.png"
        figure.savefig(path)
        assert path.stat().st_size > 5000
    with pytest.raises(KeyError, match="there is no column 'mean'"):
        results.plot_moment("mean")


def test_a_launch_file_is_refused_before_anything_starts(scenario, tmp_path):
    file = tmp_path / "launch.toml"
    file.write_text('name = "x"\nscenarios = ["none.toml"]\nreference = "mc"\n[[propagator]]\nlabel = "mc"\nnode = "mc"\n')
    with pytest.raises(pc.InputError) as error:
        pc.run(file, out=tmp_path / "out")
    assert (error.value.line, error.value.key) == (2, "scenarios") and not (tmp_path / "out").exists()
    with pytest.raises(pc.InputError, match="did you mean `reference`"):
        pc.run({**launch(scenario), "referense": "mc"}, out=tmp_path / "out")
    (tmp_path / "full").mkdir()
    (tmp_path / "full/file").write_text("mine")
    with pytest.raises(pc.RunFailed) as failed:
        pc.run(launch(scenario), out=tmp_path / "full")
    assert failed.value.code == 2 and "full" in failed.value.said


def test_ctrl_c_ends_a_run_keeps_what_is_done_and_leaves_nothing_in_shared_memory(scenario, tmp_path):
    long = scenario.changed({"name": "long", "times": {"end": 400.0, "step": 1.0}})
    case = {"label": "mc", "node": "mc", "samples": 200_000}
    table = {"name": "two", "scenarios": [scenario, long], "reference": "mc", "propagator": [case]}
    interrupt = threading.Timer(8.0, signal.raise_signal, [signal.SIGINT])
    interrupt.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            pc.run(table, out=tmp_path / "out")
    finally:
        interrupt.cancel()
        interrupt.join()
    kept = pc.Results(tmp_path / "out")
    assert not kept.is_complete and "long" in kept.manifest["incomplete_because"]
    assert len(kept.columns("moments")["t_yr"]) == 5
    assert not list(Path("/dev/shm").glob(f"*{kept.manifest['run_id']}*"))
