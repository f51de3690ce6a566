"""Scenarios from files, keywords and dictionaries, and their errors."""

import numpy as np
import phasecloud as pc
import pytest
from conftest import SCENARIOS

TABLES = {
    "orbit": {"altitude": 9567, "area_to_mass": 12.0, "reflectivity": 1.3},
    "initial": {"phi": "126 deg", "e": 0.145, "delta_phi": 0.39, "delta_e": 0.05},
    "times": {"end": 2.0, "step": 0.5},
    "disposal": {"critical_e": 0.6},
}


def test_keywords_a_dictionary_and_a_text_state_the_same_scenario():
    scenario = pc.Scenario("mine", **TABLES)
    assert (scenario.name, scenario.critical, scenario.model) == ("mine", 0.6, "planar")
    assert np.array_equal(scenario.times, [0.0, 0.5, 1.0, 1.5, 2.0])
    assert scenario.mean[0] == pytest.approx(np.radians(126)) and scenario.covariance[1, 1] == pytest.approx(0.025**2)
    assert [variable.symbol for variable in scenario.variables] == ["phi", "e"]
    assert scenario.variables[0].unit == "rad" and scenario.variables[0].bounds is None
    for other in (pc.Scenario.from_dict({"name": "mine", **TABLES}), pc.Scenario.from_toml(scenario.to_toml())):
        assert other.parameters == scenario.parameters and np.array_equal(other.mean, scenario.mean)
    assert scenario.to_dict()["orbit"]["area_to_mass"] == 12.0


def test_numbers_of_numpy_are_numbers():
    tables = {**TABLES, "times": {"at": np.linspace(0, 2, 5)}, "disposal": {"critical_e": np.float64(0.6)}}
    assert len(pc.Scenario("mine", **tables).times) == 5


def test_a_value_can_be_changed_by_its_key():
    scenario = pc.Scenario("mine", **TABLES)
    stronger = scenario.changed({"orbit.area_to_mass": 24.0})
    assert stronger.parameters["radiation"] == pytest.approx(2 * scenario.parameters["radiation"])
    assert scenario.to_dict()["orbit"]["area_to_mass"] == 12.0
    with pytest.raises(pc.InputError, match="name is no table"):
        scenario.changed({"name.x": 1})


def test_an_error_in_a_file_names_file_line_and_key(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text((SCENARIOS / "scenario-1.toml").read_text() + "critcal_e = 0.6\n")
    with pytest.raises(pc.InputError) as error:
        pc.Scenario.from_file(file)
    line = len(file.read_text().splitlines())
    assert (error.value.file, error.value.line, error.value.key) == (str(file), line, "disposal.critcal_e")
    assert str(error.value).startswith(f"{file}:{line}: disposal.critcal_e: is unknown, did you mean `critical_e`?")
    with pytest.raises(pc.InputError, match="cannot be read"):
        pc.Scenario.from_file(tmp_path / "none.toml")


def test_an_error_in_keywords_names_the_key_and_no_line():
    with pytest.raises(pc.InputError) as error:
        pc.Scenario("mine", **{**TABLES, "disposal": {"critical_e": 1.5}})
    assert error.value.line is None and str(error.value).startswith("scenario: disposal.critical_e: 1.5 is not allowed")
    with pytest.raises(TypeError, match="is not allowed in a file"):
        pc.Scenario("mine", **{**TABLES, "disposal": {"critical_e": object()}})
    with pytest.raises(ValueError):
        pc.Scenario("mine", **{**TABLES, "disposal": {"critical_e": float("nan")}})


def test_the_package_says_what_it_has():
    assert pc.__version__.count(".") == 2
    assert all(callable(getattr(pc, name)) for name in pc.__all__) and "exact" in dir(pc)
    with pytest.raises(AttributeError, match="no attribute 'exakt'"):
        pc.exakt  # noqa: B018
