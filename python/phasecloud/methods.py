"""The built-in methods, each computed in this process as its node computes it in a run.

Settings are those of a launch file (docs/launch-files.md), with the same defaults and the same refusals; the numbers are those of a run with the
same settings. What a method cannot do raises Refused with the reason.
"""

from __future__ import annotations

from typing import Any

from . import _native
from .errors import InputError
from .evolution import Evolution, FirstPassage, from_native, passage_from_native
from .scenario import Scenario, to_toml

#: Bins of the comparison grid in solar angle and eccentricity, as in a launch file.
BINS = (100, 100)


def exact(scenario: Scenario, *, bins: tuple[int, int] = BINS, **settings: Any) -> Evolution:
    """The exact density of a planar scenario by quadrature, without samples; what it cannot bound it withholds (NaN).

    Settings: moment_error, joint_error, most_orbits, largest_moment_error, largest_probability_error, largest_joint_error, accuracy.
    """
    return _computed(scenario, "exact", bins, True, settings)


def monte_carlo(
    scenario: Scenario, *, bins: tuple[int, int] = BINS, keep_samples: bool = True, **settings: Any
) -> Evolution:
    """Monte Carlo in any model: `samples` orbits (100,000), drawn by `seed` (1) and propagated each on its own.

    ``snapshots[k].rows`` has the samples, shape (variables, samples), unless `keep_samples` is False.
    Settings: samples, seed, draws, replicates, through, map_error, accuracy, model, forces.
    """
    return _computed(scenario, "mc", bins, keep_samples, settings)


def quasi_monte_carlo(
    scenario: Scenario, *, bins: tuple[int, int] = BINS, keep_samples: bool = True, **settings: Any
) -> Evolution:
    """Randomised quasi-Monte Carlo in any model: the reference where there is no exact density.

    ``snapshots[k].rows`` has the samples, shape (variables, samples), unless `keep_samples` is False.
    Settings: samples, seed, replicates, accuracy, model, forces.
    """
    return _computed(scenario, "qmc", bins, keep_samples, settings)


def dee(scenario: Scenario, *, bins: tuple[int, int] = BINS, keep_rows: bool = True, **settings: Any) -> Evolution:
    """The density evolution equation along characteristics, for planar scenarios and the model "vectorial".

    ``snapshots[k].rows`` has solar angle [rad], eccentricity and density [1/rad] of each, shape (3, characteristics).
    Settings: samples, placement, seed, mesh, degree, resolution, mode, accuracy.
    """
    return _computed(scenario, "dee", bins, keep_rows, settings)


def gmm_ut(scenario: Scenario, *, bins: tuple[int, int] = BINS, keep_rows: bool = True, **settings: Any) -> Evolution:
    """A Gaussian mixture moved by the unscented transform, for planar scenarios and the model "vectorial". It has no first-passage curve.

    ``snapshots[k].rows`` has weight, means and covariances of each component, shape (6, components) in the plane.
    Settings: split, sigma_points, components, across, keep_variance, merge_to, mode, accuracy.
    """
    return _computed(scenario, "gmm-ut", bins, keep_rows, settings)


def first_passage(scenario: Scenario, method: str = "exact", **settings: Any) -> FirstPassage:
    """The probability that the eccentricity has ever reached its critical value, by one of the methods "exact", "mc", "qmc", "dee".

    Faster than the whole evolution: no densities are computed. Settings are those of the method.
    """
    try:
        return passage_from_native(_native.first_passage(scenario._native, method, _settings(settings)))
    except InputError as error:
        raise error.without_line() from None


def _computed(
    scenario: Scenario, method: str, bins: tuple[int, int], keep_rows: bool, settings: dict[str, Any]
) -> Evolution:
    try:
        told = _native.compute(scenario._native, method, _settings(settings), (bins[0], bins[1]), keep_rows)
    except InputError as error:
        raise error.without_line() from None
    return from_native(scenario, method, settings, told)


def _settings(settings: dict[str, Any]) -> str:
    return to_toml({key: value for key, value in settings.items() if value is not None})
