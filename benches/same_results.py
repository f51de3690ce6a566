#!/usr/bin/env python3
"""Compares the numbers of two results folders: every CSV and NPZ file, except for times and effort.

    benches/same_results.py BEFORE AFTER

BEFORE and AFTER are folders that `phasecloud run` wrote, or folders of such folders. Prints what differs, one line per file, and how far numbers
are apart; the exit code is 0 if nothing differs, 1 if something differs, 2 if there is nothing to compare. Needs numpy.
"""

import csv
import sys
from pathlib import Path

import numpy as np

#: Columns and files that say how long something took, or when.
TIMES = {"t_prop_s", "t_int_s", "t_cal_s", "ratio_to_baseline", "seconds"}
EFFORT = {"effort.csv"}


def files(folder):
    """The tables and arrays below a folder, by their paths in it."""
    found = (path for kind in ("*.csv", "*.npz") for path in folder.rglob(kind))
    return {path.relative_to(folder): path for path in found if path.name not in EFFORT}


def as_number(text):
    try:
        return float(text)
    except ValueError:
        return None


def apart(before, after):
    """How far two cells are apart: 0 if they are the same, infinity if they are not both numbers."""
    if before == after:
        return 0.0
    numbers = as_number(before), as_number(after)
    if None in numbers:
        return float("inf")
    return 0.0 if all(np.isnan(numbers)) else abs(numbers[0] - numbers[1])


def compare_tables(before, after):
    with before.open(newline="") as a, after.open(newline="") as b:
        rows = list(csv.DictReader(a)), list(csv.DictReader(b))
    if len(rows[0]) != len(rows[1]):
        return f"{len(rows[0])} rows, then {len(rows[1])}"
    worst = {}
    for one, other in zip(*rows):
        if one.keys() != other.keys():
            return f"columns {', '.join(one)}, then {', '.join(other)}"
        for column in one.keys() - TIMES:
            distance = apart(one[column], other[column])
            if distance > 0:
                worst[column] = max(worst.get(column, 0.0), distance)
    return ", ".join(f"{column} by {distance:.1e}" for column, distance in sorted(worst.items()))


def compare_arrays(before, after):
    a, b = np.load(before), np.load(after)
    if set(a.files) != set(b.files):
        return f"other arrays: {', '.join(sorted(set(a.files) ^ set(b.files)))}"
    differ = [name for name in a.files if not np.array_equal(a[name], b[name], equal_nan=True)]
    return ", ".join(differ[:5]) + (f" and {len(differ) - 5} more" if len(differ) > 5 else "")


def main(before, after):
    before_files, after_files = files(Path(before)), files(Path(after))
    if not before_files or not after_files:
        print(f"{before if not before_files else after}: no tables and no arrays below it")
        return 2
    differences = 0
    for name in sorted(before_files.keys() | after_files.keys()):
        if name not in before_files or name not in after_files:
            what = f"only in {before if name in before_files else after}"
        else:
            compare = compare_tables if name.suffix == ".csv" else compare_arrays
            what = compare(before_files[name], after_files[name])
        if what:
            differences += 1
            print(f"{name}: {what}")
    print(f"{len(before_files.keys() & after_files.keys())} files compared, {differences} differ")
    return 1 if differences else 0


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
