"""What a method says of a scenario: a density and moments at each snapshot, and the first-passage curve."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import tables
from .density import Density
from .scenario import Scenario


@dataclass(frozen=True)
class FirstPassage:
    """The probability that the eccentricity has ever reached its critical value by a time. All arrays have the shape (times,)."""

    times: np.ndarray  #: [yr]
    probability: np.ndarray  #: NaN where the method withholds it
    low: np.ndarray  #: lower end of the interval; NaN where there is none
    high: np.ndarray  #: upper end of the interval
    interval: tuple[str, ...]  #: what the interval is: "95 %", "error estimate", "bounds", or empty

    def at(self, time: float) -> float:
        """The probability by a time [yr] within the curve, interpolated linearly."""
        if not self.times[0] <= time <= self.times[-1]:
            raise ValueError(f"time: {time} is not allowed, the curve reaches from {self.times[0]:g} to {self.times[-1]:g} yr")
        return float(np.interp(time, self.times, self.probability))

    def plot(self, ax: Any = None, label: str = "") -> Any:
        """Draws the curve with its interval and returns the axes."""
        from .plots import draw_passages

        return draw_passages([(label, self)], ax)


@dataclass(frozen=True)
class Snapshot:
    """A cloud at one time."""

    time: float  #: [yr]
    kind: str  #: what the rows are: "samples", "characteristics", "mixture", or "density" where there are none
    #: samples: a row for each variable; characteristics: phi, e, density; mixture: weight, means, covariances row by row of the upper triangle.
    #: Shape (columns of the kind, number of samples, characteristics or components); None if they were not kept
    rows: np.ndarray | None
    densities: dict[str, Density]  #: "joint", "marginal_phi", ...
    mass_on_grid: float  #: probability on the grid of the joint density
    trajectories: int  #: orbits that were followed for it
    seconds: tuple[float, float]  #: CPU time of propagation and of estimation [s]

    @property
    def joint(self) -> Density:
        """The first of the densities: in solar angle and eccentricity."""
        return next(iter(self.densities.values()))


@dataclass(frozen=True)
class Evolution:
    """What a method says of a scenario.

    `quantities` and `standard_errors` have, by the name of the column in moments.csv (``mean_phi_rad``, ``std_e``,
    ``prob_above_critical_e``), an array of shape (snapshots,). NaN stands for a quantity that the method withholds, or for a method without
    standard errors. `diagnostics` are what the method says of its own reliability, by the names in diagnostics.csv.
    """

    scenario: Scenario
    method: str
    settings: Mapping[str, Any]
    times: np.ndarray
    quantities: dict[str, np.ndarray]
    standard_errors: dict[str, np.ndarray]
    diagnostics: dict[str, np.ndarray]
    snapshots: tuple[Snapshot, ...]
    first_passage: FirstPassage | None  #: None if the method has no curve
    no_first_passage: str | None  #: why it has none

    def moments(self) -> Any:
        """The quantities as a table with a row for each snapshot: pandas, else polars, else a dictionary of arrays."""
        return tables.shown({"t_yr": self.times, **self.quantities})

    def plot_density(self, index: int | None = None, name: str | None = None) -> Any:
        """Draws the density `name`, the joint one unless another is named, of snapshot `index` or of all; returns the figure."""
        from .plots import draw_densities

        chosen = self.snapshots if index is None else [self.snapshots[index]]
        return draw_densities([snapshot.joint if name is None else snapshot.densities[name] for snapshot in chosen])

    def plot_difference(self, other: Evolution, index: int, ax: Any = None) -> Any:
        """Draws the joint density minus that of another method at snapshot `index`; returns the axes."""
        from .plots import draw_difference

        return draw_difference(self.snapshots[index].joint, other.snapshots[index].joint, ax)

    def plot_first_passage(self, ax: Any = None) -> Any:
        """Draws the first-passage curve; returns the axes. A method without one refuses in words."""
        from .errors import Refused

        if self.first_passage is None:
            raise Refused(f"{self.method}: {self.no_first_passage}")
        return self.first_passage.plot(ax, self.method)

    def __repr__(self) -> str:
        return f"<Evolution of {self.scenario.name!r} by {self.method}: {len(self.times)} snapshots>"


def from_native(scenario: Scenario, method: str, settings: Mapping[str, Any], told: dict[str, Any]) -> Evolution:
    """An evolution from what the native part returns."""
    times, snapshots = scenario.times, told["snapshots"]
    variables = scenario.variables
    symbols = [variable.symbol for variable in variables]
    units = {variable.symbol: variable.unit for variable in variables}

    def density(said: tuple[str, list[int]], numbers: tuple[np.ndarray, list[np.ndarray]], time: float) -> Density:
        dims = tuple(symbols[variable] for variable in said[1])
        attrs = {"scenario": scenario.name, "method": method, "time": time}
        return Density(numbers[0], dims, dict(zip(dims, numbers[1])), {symbol: units[symbol] for symbol in dims}, attrs)

    def snapshot(time: float, said: dict[str, Any]) -> Snapshot:
        densities = {
            kind[0]: density(kind, numbers, time) for kind, numbers in zip(told["densities"], said["densities"])
        }
        seconds = tuple(said["seconds"])
        return Snapshot(
            time, said["kind"], said.get("rows"), densities, said["mass_on_grid"], said["trajectories"], seconds
        )

    def columns(key: str) -> dict[str, np.ndarray]:
        rows = np.array([said[key] for said in snapshots])
        return {name: rows[:, k] for k, name in enumerate(told["quantities"])}

    names = snapshots[0]["diagnostics"] if snapshots else {}
    return Evolution(
        scenario,
        method,
        dict(settings),
        times,
        columns("values"),
        columns("errors"),
        {name: np.array([said["diagnostics"][name] for said in snapshots]) for name in names},
        tuple(snapshot(float(time), said) for time, said in zip(times, snapshots)),
        passage_from_native(told["passage"]) if "passage" in told else None,
        told.get("no_passage"),
    )


def passage_from_native(told: dict[str, Any]) -> FirstPassage:
    """A curve from what the native part returns."""
    return FirstPassage(told["times"], told["probability"], told["low"], told["high"], tuple(told["interval"]))
