"""A results folder, as `phasecloud run` writes it."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from . import tables
from .density import Density
from .evolution import FirstPassage
from .program import command

#: The tables of a results folder, each a CSV file.
TABLES = ("moments", "errors", "distances", "first_passage", "given_re_entry", "effort", "diagnostics", "notes", "verdicts")


class Results:
    """The results in a folder. Tables are read when they are asked for.

    ``results.moments``, ``.errors``, ``.distances``, ``.first_passage``, ``.given_re_entry``, ``.effort``, ``.diagnostics``, ``.notes`` and ``.verdicts`` are the
    CSV files of those names (docs/results.md) as tables of pandas, else of polars, else as dictionaries of arrays.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)
        if not (self.folder / "manifest.json").is_file():
            raise FileNotFoundError(f"{self.folder}: not a results folder; name one that `phasecloud run` wrote")

    def table(self, name: str) -> Any:
        """A table by its name."""
        return tables.shown(self.columns(name))

    def columns(self, name: str) -> tables.Columns:
        """The same as a dictionary of arrays, whatever is installed."""
        if name not in TABLES:
            raise KeyError(f"there is no table {name!r}; there are {', '.join(TABLES)}")
        return tables.read_csv(self.folder / f"{name}.csv")

    def __getattr__(self, name: str) -> Any:
        if name in TABLES:
            return self.table(name)
        raise AttributeError(f"results have no {name!r}; the tables are {', '.join(TABLES)}")

    def to_parquet(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Writes every table as a Parquet file into a new folder, by the command `phasecloud export`.

        Returns the files. The metadata of each has what the manifest says of the run. A folder that exists already, or lies in the results folder, whose
        files are sealed, is a `ValueError`.
        """
        folder = Path(folder)
        written = subprocess.run([command(), "export", str(self.folder), str(folder)], capture_output=True, text=True)
        if written.returncode != 0:
            raise ValueError(written.stderr.strip())
        return sorted(folder.glob("*.parquet"))

    @cached_property
    def manifest(self) -> dict[str, Any]:
        """What was run, and how every process ended."""
        return json.loads((self.folder / "manifest.json").read_text(encoding="utf-8"))

    @cached_property
    def descriptions(self) -> dict[str, dict[str, Any]]:
        """By scenario: its model, parameters, variables, quantities and projections."""
        lines = (self.folder / "scenarios.jsonl").read_text(encoding="utf-8").splitlines()
        return {said["name"]: said for said in map(json.loads, lines)}

    @property
    def scenarios(self) -> list[str]:
        """Names of the scenarios, in order."""
        return list(self.descriptions)

    @property
    def methods(self) -> list[str]:
        """Labels of the cases that have results, in order."""
        return list(dict.fromkeys(self.columns("moments")["method"]))

    @property
    def is_complete(self) -> bool:
        """Whether everything that was asked for has been done or has failed by name."""
        return bool(self.manifest["complete"])

    def times(self, scenario: str | None = None) -> np.ndarray:
        """Snapshot times [yr] of a scenario, the first unless named."""
        return np.array(self.descriptions[self._scenario(scenario)]["times"])

    @cached_property
    def arrays(self) -> Any:
        """The arrays of densities.npz, by their names SCENARIO/METHOD/INDEX/NAME."""
        return np.load(self.folder / "densities.npz")

    def density(self, method: str, index: int, name: str | None = None, scenario: str | None = None) -> Density:
        """The density of a case at snapshot `index`: the joint one unless `name` is that of another ("marginal_phi")."""
        scenario = self._scenario(scenario)
        said = self.descriptions[scenario]
        projections = {projection["density"]: projection["variables"] for projection in said["projections"]}
        name = next(iter(projections)) if name is None else name
        if name not in projections:
            raise KeyError(f"there is no density {name!r}; there are {', '.join(projections)}")
        index = range(len(said["times"]))[index]
        place = f"{scenario}/{self._method(method, scenario)}/{index}"
        variables = [said["variables"][k] for k in projections[name]]
        dims = tuple(variable["symbol"] for variable in variables)
        edges = {symbol: self.arrays[f"{place}/{symbol}_edges"] for symbol in dims}
        units = {variable["symbol"]: variable["unit"] for variable in variables}
        attrs = {"scenario": scenario, "method": method, "time": said["times"][index]}
        return Density(self.arrays[f"{place}/{name}"], dims, edges, units, attrs)

    def passage(self, method: str, scenario: str | None = None) -> FirstPassage:
        """The first-passage curve of a case."""
        scenario = self._scenario(scenario)
        rows = tables.chosen(self.columns("first_passage"), scenario=scenario, method=self._method(method, scenario))
        if not len(rows["t_yr"]):
            raise KeyError(f"{method} has no first-passage curve in {scenario}; `notes` says why")
        times, probability, low, high = (
            rows[name].astype(float) for name in ("t_yr", "prob_reached_critical_e", "low", "high")
        )
        return FirstPassage(times, probability, low, high, tuple(map(str, rows["interval"])))

    def plot_density(self, method: str, index: int | None = None, name: str | None = None, scenario: str | None = None) -> Any:
        """Draws the density of a case at a snapshot, or at all of them; returns the figure."""
        from .plots import draw_densities

        snapshots = range(len(self.times(scenario))) if index is None else [index]
        return draw_densities([self.density(method, k, name, scenario) for k in snapshots])

    def plot_difference(self, method: str, reference: str, index: int, scenario: str | None = None, ax: Any = None) -> Any:
        """Draws the joint density of a case minus that of another at a snapshot; returns the axes."""
        from .plots import draw_difference

        mine, theirs = (self.density(label, index, None, scenario) for label in (method, reference))
        return draw_difference(mine, theirs, ax)

    def plot_first_passage(self, methods: list[str] | None = None, scenario: str | None = None, ax: Any = None) -> Any:
        """Draws the first-passage curves of some cases, or of all that have one, with their intervals; returns the axes."""
        from .plots import draw_passages

        return draw_passages(self._curves(methods, scenario), ax)

    def plot_moment(self, quantity: str, methods: list[str] | None = None, scenario: str | None = None, ax: Any = None) -> Any:
        """Draws a column of moments.csv over time, with two standard errors where there are any; returns the axes."""
        from .plots import draw_lines

        scenario, columns = self._scenario(scenario), self.columns("moments")
        if quantity not in columns:
            raise KeyError(f"there is no column {quantity!r} in moments.csv; there are {', '.join(columns)}")
        rows = [(label, tables.chosen(columns, scenario=scenario, method=label)) for label in methods or self.methods]
        none = np.full(len(columns[quantity]), np.nan)
        lines = [(label, of["t_yr"], of[quantity], of.get(f"se_{quantity}", none[: len(of["t_yr"])])) for label, of in rows]
        return draw_lines(lines, quantity, ax)

    def _curves(self, methods: list[str] | None, scenario: str | None) -> Iterator[tuple[str, FirstPassage]]:
        there = set(tables.chosen(self.columns("first_passage"), scenario=self._scenario(scenario))["method"])
        for label in methods or [label for label in self.methods if label in there]:
            yield label, self.passage(label, scenario)

    def _scenario(self, name: str | None) -> str:
        if name is None:
            return self.scenarios[0]
        if name not in self.descriptions:
            raise KeyError(f"there is no scenario {name!r}; there are {', '.join(self.scenarios)}")
        return name

    def _method(self, label: str, scenario: str) -> str:
        there = tables.chosen(self.columns("moments"), scenario=scenario)["method"]
        if label not in there:
            raise KeyError(f"there is no case {label!r} in {scenario}; there are {', '.join(dict.fromkeys(there))}")
        return label

    def __repr__(self) -> str:
        return f"<Results {str(self.folder)!r}: {', '.join(self.scenarios)} by {', '.join(self.methods)}>"
