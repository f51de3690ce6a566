"""Pictures with matplotlib, which is imported only here."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from .density import Density
    from .evolution import FirstPassage

#: Densities below this share of the largest are left white.
FAINTEST = 1e-3
#: Colours of Okabe and Ito, as in the figures of a report.
COLOURS = ["#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"]
NAMES = {"phi": "solar angle φ", "e": "eccentricity e", "i": "inclination i", "node": "node Ω"}


def axes_of(ax: Any) -> Any:
    """The axes that were given, or new ones."""
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    return plt.subplots(layout="constrained")[1]


def label_of(symbol: str, unit: str) -> str:
    """The label of an axis."""
    name = NAMES.get(symbol, symbol)
    return f"{name} [{unit}]" if unit else name


def draw_density(density: Density, ax: Any = None, **options: Any) -> Any:
    """Draws a density in one or two variables."""
    ax = axes_of(ax)
    said = density.attrs
    title = ", ".join(str(said[key]) for key in ("scenario", "method") if key in said)
    if "time" in said:
        title += f", t = {said['time']:g} yr"
    labels = [label_of(symbol, density.units.get(symbol, "")) for symbol in density.dims]
    if density.is_withheld:
        ax.set(title=f"{title}: withheld", xlabel=labels[0])
        return ax
    if len(density.dims) == 1:
        ax.stairs(density.values, density.edges[density.dims[0]], **options)
        ax.set(title=title, xlabel=labels[0], ylabel=f"density [{density.unit or '1'}]")
        return ax
    shown = np.ma.masked_less(density.values, FAINTEST * density.values.max())
    first, second = density.dims
    options = {"cmap": "viridis", "rasterized": True, **options}
    mesh = ax.pcolormesh(density.edges[first], density.edges[second], shown.T, **options)
    ax.set(title=title, xlabel=labels[0], ylabel=labels[1])
    ax.figure.colorbar(mesh, ax=ax, label=f"joint density [{density.unit or '1'}]")
    return ax


def draw_difference(one: Density, other: Density, ax: Any = None, **options: Any) -> Any:
    """Draws one density minus another on the same grid."""
    if one.dims != other.dims or any(not np.array_equal(one.edges[symbol], other.edges[symbol]) for symbol in one.dims):
        raise ValueError("the densities are not on the same grid")
    ax = axes_of(ax)
    largest = float(np.nanmax(np.abs(one.values - other.values), initial=0.0)) or 1.0
    first, second = one.dims
    options = {"cmap": "PuOr", "vmin": -largest, "vmax": largest, "rasterized": True, **options}
    mesh = ax.pcolormesh(one.edges[first], one.edges[second], (one.values - other.values).T, **options)
    names = [str(density.attrs.get("method", "?")) for density in (one, other)]
    time = f", t = {one.attrs['time']:g} yr" if "time" in one.attrs else ""
    labels = [label_of(symbol, one.units.get(symbol, "")) for symbol in one.dims]
    ax.set(title=f"{names[0]} minus {names[1]}{time}", xlabel=labels[0], ylabel=labels[1])
    ax.figure.colorbar(mesh, ax=ax, label=f"difference [{one.unit or '1'}]")
    return ax


def draw_densities(densities: Sequence[Density]) -> Any:
    """Draws densities side by side and returns the figure."""
    import matplotlib.pyplot as plt

    count = len(densities)
    figure, axes = plt.subplots(1, count, figsize=(3.4 * count, 3.2), layout="constrained", squeeze=False)
    for density, ax in zip(densities, axes[0]):
        draw_density(density, ax)
    return figure


def draw_passages(curves: Iterable[tuple[str, FirstPassage]], ax: Any = None) -> Any:
    """Draws first-passage curves, each with its interval."""
    ax = axes_of(ax)
    for number, (name, curve) in enumerate(curves):
        colour = COLOURS[number % len(COLOURS)]
        ax.plot(curve.times, curve.probability, color=colour, label=name)
        ax.fill_between(curve.times, curve.low, curve.high, color=colour, alpha=0.2, linewidth=0)
    ax.set(xlabel="time t [yr]", ylabel="probability of having reached the critical e", ylim=(-0.02, 1.02))
    ax.legend()
    return ax


def draw_lines(lines: Iterable[tuple[str, np.ndarray, np.ndarray, np.ndarray]], label: str, ax: Any = None) -> Any:
    """Draws lines over time: for each its name, times, values and standard errors."""
    ax = axes_of(ax)
    for number, (name, times, values, errors) in enumerate(lines):
        colour = COLOURS[number % len(COLOURS)]
        ax.errorbar(times, values, np.nan_to_num(2.0 * errors), color=colour, label=name, marker="o", markersize=3, capsize=2)
    ax.set(xlabel="time t [yr]", ylabel=label)
    ax.legend()
    return ax


def show_or_save(figure: Any, path: str) -> None:
    """Shows a figure in a notebook or an interactive session; elsewhere writes it to `path` and says so."""
    import sys

    import matplotlib.pyplot as plt

    if hasattr(sys, "ps1") or "IPython" in sys.modules:
        plt.show()
        return
    figure.savefig(path, dpi=150)
    print(f"Picture: {path}")
