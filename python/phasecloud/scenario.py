"""Scenarios: an orbit, how well it is known at first, when the density is wanted, and when the satellite re-enters."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _native
from .errors import InputError, Refused

#: Where values come from that do not stand in a file, as errors say it.
_KEYWORDS = "scenario"


@dataclass(frozen=True)
class Variable:
    """A variable of a model."""

    name: str  #: "solar angle"
    symbol: str  #: "phi"
    unit: str  #: "rad"; empty for a pure number
    bounds: tuple[float, float] | None  #: lowest and highest value; None for an angle on the full circle


class Scenario:
    """A scenario that has been checked.

    ``Scenario("my-satellite", orbit={...}, initial={...}, times={...}, disposal={...})`` has the keys of a scenario file
    (docs/scenario-files.md), a table for each keyword; a value with a unit of its own is a text: ``"126 deg"``.

    Raises InputError, with the key, for whatever a scenario file may not say.
    """

    def __init__(
        self,
        name: str,
        *,
        orbit: Mapping[str, Any],
        initial: Mapping[str, Any],
        times: Mapping[str, Any],
        disposal: Mapping[str, Any] | None = None,
        model: Mapping[str, Any] | None = None,
        epoch: Mapping[str, Any] | None = None,
    ) -> None:
        given = dict(name=name, model=model, epoch=epoch, orbit=orbit, initial=initial, times=times, disposal=disposal)
        self._native = _checked({key: value for key, value in given.items() if value is not None})

    @classmethod
    def from_file(cls, path: str | os.PathLike[str]) -> Scenario:
        """The scenario of a file. Errors name the file, the line and the key."""
        return cls._of(_native.Scenario.load(os.fspath(path)))

    @classmethod
    def from_dict(cls, table: Mapping[str, Any]) -> Scenario:
        """The scenario of a dictionary with the keys of a scenario file."""
        return cls._of(_checked(table))

    @classmethod
    def from_toml(cls, text: str, file: str = _KEYWORDS) -> Scenario:
        """The scenario of the text of a scenario file; errors call it `file`."""
        return cls._of(_native.Scenario.parse(text, file))

    @classmethod
    def _of(cls, native: _native.Scenario) -> Scenario:
        scenario = cls.__new__(cls)
        scenario._native = native
        return scenario

    def to_toml(self) -> str:
        """The text of a scenario file that states this scenario."""
        return self._native.text

    def to_dict(self) -> dict[str, Any]:
        """The keys of that file."""
        return json.loads(_native.json_from_toml(self._native.text))

    def changed(self, values: Mapping[str, Any]) -> Scenario:
        """The scenario with other values, by their keys: ``scenario.changed({"orbit.area_to_mass": 14.0})``."""
        table = self.to_dict()
        for key, value in values.items():
            place, *path = table, *key.split(".")
            for name in path[:-1]:
                place = place.setdefault(name, {})
                if not isinstance(place, dict):
                    raise InputError(f"{_KEYWORDS}: {key}: {name} is no table", _KEYWORDS, None, key, f"{name} is no table")
            place[path[-1]] = value
        return Scenario.from_dict(table)

    @property
    def name(self) -> str:
        """Its name."""
        return self._native.name

    @property
    def times(self) -> np.ndarray:
        """Snapshot times [yr], shape (snapshots,)."""
        return self._native.times

    @property
    def critical(self) -> float | None:
        """Eccentricity at which the satellite re-enters; None if the scenario does not say it."""
        return self._native.critical

    @property
    def model(self) -> str:
        """Name of the model of the orbit's motion."""
        return self._cloud["model"]

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters of the model by name."""
        return self._cloud["parameters"]

    @property
    def variables(self) -> list[Variable]:
        """Variables of the cloud, in the order of `mean` and `covariance`."""
        return [Variable(*said) for said in self._cloud["variables"]]

    @property
    def orbit_variables(self) -> list[Variable]:
        """Variables of a single orbit, in the order of the rows that `propagate` takes and returns."""
        return [Variable(*said) for said in self._native.orbit_variables]

    @property
    def mean(self) -> np.ndarray:
        """Mean of the initial Gaussian, shape (variables,)."""
        return self._cloud["mean"]

    @property
    def covariance(self) -> np.ndarray:
        """Covariance of the initial Gaussian, shape (variables, variables)."""
        said = self._cloud
        count = len(said["mean"])
        upper = np.zeros((count, count))
        upper[np.triu_indices(count)] = said["upper_covariance"]
        return upper + np.triu(upper, 1).T

    @property
    def _cloud(self) -> dict[str, Any]:
        described = self._native.described()
        if described is None:
            raise Refused(f"{self.name} describes an orbit without a cloud about it")
        return described

    def __repr__(self) -> str:
        return f"<Scenario {self.name!r}: {len(self.times)} snapshots to {self.times[-1]:g} yr>"


def _checked(table: Mapping[str, Any]) -> _native.Scenario:
    try:
        return _native.Scenario.parse(to_toml(table), _KEYWORDS)
    except InputError as error:
        raise error.without_line() from None


def to_toml(table: Mapping[str, Any]) -> str:
    """A dictionary as the text of a TOML file; numpy's numbers and arrays are numbers and lists."""
    return _native.toml_from_json(json.dumps(table, default=_plain, allow_nan=False))


def _plain(value: Any) -> Any:
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{value!r} is not allowed in a file: it must be a number, text, true or false, a list or a table")
