"""A probability density on a grid, with named axes and units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Density:
    """A density on the bins of a grid, in one or two variables, as an xarray has it.

    NaN stands for a density that the method withholds.
    """

    values: np.ndarray  #: density of each bin, shape: bins of each variable in the order of `dims`
    dims: tuple[str, ...]  #: symbols of the variables, such as ("phi", "e")
    edges: dict[str, np.ndarray]  #: by symbol, edges of the bins, one more than there are bins
    units: Mapping[str, str] = field(default_factory=dict)  #: by symbol, unit; empty for a pure number
    attrs: Mapping[str, Any] = field(default_factory=dict)  #: what it is of: scenario, method, time [yr]

    @property
    def shape(self) -> tuple[int, ...]:
        """Bins of each variable."""
        return self.values.shape

    @property
    def coords(self) -> dict[str, np.ndarray]:
        """By symbol, middles of the bins."""
        return {symbol: 0.5 * (edges[1:] + edges[:-1]) for symbol, edges in self.edges.items()}

    @property
    def unit(self) -> str:
        """Unit of the density, such as "1/rad"."""
        units = [self.units.get(symbol, "") for symbol in self.dims]
        return " ".join(f"1/{unit}" for unit in units if unit)

    @property
    def mass(self) -> float:
        """Probability on the grid."""
        cells = np.ones_like(self.values)
        for axis, symbol in enumerate(self.dims):
            widths = np.diff(self.edges[symbol])
            cells *= widths.reshape([-1 if k == axis else 1 for k in range(len(self.dims))])
        return float((self.values * cells).sum())

    @property
    def is_withheld(self) -> bool:
        """Whether the method gives no density."""
        return bool(np.isnan(self.values).all())

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        array = self.values if dtype is None else self.values.astype(dtype)
        return array.copy() if copy else array

    def to_xarray(self) -> Any:
        """The same as an xarray.DataArray, with the middles of the bins as coordinates; needs the package xarray."""
        import xarray

        coords = {symbol: (symbol, middle, {"units": self.units.get(symbol, "")}) for symbol, middle in self.coords.items()}
        return xarray.DataArray(self.values, coords, self.dims, "density", {**self.attrs, "units": self.unit})

    def plot(self, ax: Any = None, **options: Any) -> Any:
        """Draws it with matplotlib, into `ax` if that is given, and returns the axes. `options` go to pcolormesh or stairs."""
        from .plots import draw_density

        return draw_density(self, ax, **options)
