"""Tables as the packages have them that are installed: pandas, else polars, else a dictionary of arrays."""

from __future__ import annotations

import csv
import os
from typing import Any

import numpy as np

#: Columns of texts, whatever a text looks like: a case may be called "1".
TEXTS = {
    "scenario",
    "method",
    "reference",
    "quantity",
    "density",
    "measure",
    "diagnostic",
    "note",
    "interval",
    "given",
    "errors",
    "verdict",
    "moments_quantity",
    "moments_judged_by",
    "density_judged_by",
}

Columns = dict[str, np.ndarray]


def shown(columns: Columns) -> Any:
    """A pandas.DataFrame; without pandas a polars.DataFrame; without either the columns as they are."""
    try:
        import pandas

        return pandas.DataFrame(columns)
    except ImportError:
        pass
    try:
        import polars

        return polars.DataFrame(columns)
    except ImportError:
        return columns


def read_csv(path: str | os.PathLike[str]) -> Columns:
    """The columns of a CSV file: numbers where a column has nothing else, NaN among them, and texts."""
    with open(path, newline="", encoding="utf-8") as file:
        reader = csv.reader(file)
        names = next(reader)
        rows = list(reader)
    return {name: _column(name, [row[k] for row in rows]) for k, name in enumerate(names)}


def _column(name: str, texts: list[str]) -> np.ndarray:
    try:
        if name not in TEXTS:
            return np.array([float(text) for text in texts])
    except ValueError:
        pass
    return np.array(texts, dtype=object)


def chosen(columns: Columns, **values: Any) -> Columns:
    """The rows in which the columns have these values."""
    count = len(next(iter(columns.values()))) if columns else 0
    rows = np.ones(count, dtype=bool)
    for name, value in values.items():
        rows &= columns[name] == value
    return {name: column[rows] for name, column in columns.items()}
