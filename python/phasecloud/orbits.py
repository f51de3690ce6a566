"""Orbits that the caller gives."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from .scenario import Scenario


def propagate(
    scenario: Scenario, starts: ArrayLike, times: ArrayLike | None = None, *, accuracy: float = 1e-12
) -> np.ndarray:
    """Moves orbits in the scenario's model from `t = 0` to each of `times` [yr], the scenario's snapshots unless given.

    `starts` has a row for each of `scenario.orbit_variables` and a column for each orbit, shape (variables, orbits); so has the result
    for each time, shape (times, variables, orbits). A single orbit may be given as shape (variables,), and the result then has the shape
    (times, variables). Rows of float64 that lie together in memory are read without a copy. `accuracy`, 1e-6, 1e-9 or 1e-12, is the largest
    error of an orbit after two years in the paper's scenarios.

    Raises ValueError for a start that is no orbit, LostOrbit for an orbit that leaves the domain of the equations of motion.
    """
    starts = np.asarray(starts, dtype=np.float64)
    times = scenario.times if times is None else np.atleast_1d(np.asarray(times, dtype=np.float64))
    if starts.ndim not in (1, 2):
        raise ValueError(f"starts: they have {starts.ndim} dimensions, it must be a row for each variable and a column for each orbit")
    moved = _native.propagate(scenario._native, np.atleast_2d(starts.T).T, times, accuracy)
    return moved[:, :, 0] if starts.ndim == 1 else moved


class FlowMap:
    """The flow of a planar scenario, interpolated from some thousand orbits: ``map(starts, index)`` moves orbits to a snapshot.

    Starts outside the cloud, or where the map has no cell, are propagated one by one.
    """

    def __init__(self, scenario: Scenario, error: float = 1e-9, *, most_orbits: int = 300_000, accuracy: float = 1e-12) -> None:
        self._native = _native.FlowMap(scenario._native, error, most_orbits, accuracy)
        self.scenario = scenario

    def __call__(self, starts: ArrayLike, index: int) -> np.ndarray:
        """Where orbits that start at `starts`, shape (2, orbits), are at snapshot `index`; the result has the same shape."""
        starts = np.asarray(starts, dtype=np.float64)
        index = range(len(self.times))[index]
        return self._native.at(np.atleast_2d(starts.T).T, index).reshape(starts.shape)

    @property
    def times(self) -> np.ndarray:
        """Snapshot times [yr]."""
        return self._native.times

    @property
    def orbits(self) -> int:
        """Orbits from which the map is made."""
        return self._native.orbits

    @property
    def cells(self) -> int:
        """Cells of the map."""
        return self._native.cells

    @property
    def error(self) -> float:
        """Estimate of the largest error of ``e sin(phi)`` or ``e cos(phi)`` at any snapshot."""
        return self._native.error

    @property
    def mapped(self) -> float:
        """Probability of the starts that the map moves."""
        return self._native.mapped

    def __repr__(self) -> str:
        return f"<FlowMap of {self.scenario.name!r}: {self.orbits} orbits, {self.cells} cells, error {self.error:.1e}>"


def flow_map(scenario: Scenario, error: float = 1e-9, **options: Any) -> FlowMap:
    """The map of the flow of a planar scenario whose coordinates are off by no more than `error`, by its own estimate.

    Options: most_orbits (300,000), accuracy (1e-12) of orbits that are propagated one by one. Raises Refused where the flow bends too much.
    """
    return FlowMap(scenario, error, **options)
