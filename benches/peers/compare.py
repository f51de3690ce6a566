#!/usr/bin/env python3
"""Our kernels beside the programs that one would otherwise take, on the same samples and at the same largest error.

    python3 benches/peers/compare.py [--repeats 5] [--quick] [--yardsticks FOLDER]

makes a virtual environment in target/peers, builds and runs `experiments/src/bin/for_peers.rs`, and prints tables in Markdown.
Each peer runs with the loosest tolerance (or the smallest number of steps) of a series with which no coordinate of any sample at any
snapshot differs from the reference by more than the level; the reference is heyoka at 1e-16. Figures are medians: CPU time on one
thread, wall time on two; the last column is the first over the second, which has a meaning only on an idle machine. `taylor.c`
shows what plain C can do; it is left out where there is no gcc. FOLDER may hold further yardsticks, see `yardsticks.py`.
"""
import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WORK = ROOT / "target" / "peers"
PACKAGES = ["numpy", "scipy", "numba", "heyoka", "fast-histogram"]
C, W, SUN = 0.15, 0.40921, 6.283185307179586
LEVELS = {"1e-6": 1e-6, "1e-9": 1e-9, "1e-12": 1e-12}


def enter_environment():
    """Restarts this script in its own virtual environment."""
    python = WORK / "venv" / "bin" / "python"
    if Path(sys.prefix) != WORK / "venv":
        if not python.exists():
            subprocess.run([sys.executable, "-m", "venv", WORK / "venv"], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
        os.execv(python, [python, __file__, *sys.argv[1:]])


def median(work, repeats, threads=1):
    """Median seconds of `work()`: CPU time on one thread, wall time on more."""
    clock = time.process_time if threads == 1 else time.perf_counter
    seconds = []
    for _ in range(repeats):
        start = clock()
        work()
        seconds.append(clock() - start)
    return sorted(seconds)[len(seconds) // 2]


def run_ours(repeats):
    command = ["cargo", "run", "--release", "--quiet", "-p", "phasecloud-experiments", "--bin", "for_peers", "--"]
    lines = subprocess.run([*command, WORK, str(repeats)], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    rows = [line.split(",") for line in lines.splitlines()]
    return {(stage, level, int(threads)): float(seconds) for stage, level, threads, seconds in rows}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--quick", action="store_true", help="leave out what takes minutes: interpolation by SciPy")
    parser.add_argument("--yardsticks", type=Path, help="a folder with C programs that are no part of this one")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    enter_environment()
    import numpy as np

    import meshes
    import propagators
    import yardsticks

    ours = run_ours(options.repeats)
    start = np.fromfile(WORK / "start.f64").reshape(2, -1)
    reference = propagators.reference(start)
    print("\n## Propagation: 1e5 samples, 2 yr, 4 snapshots\n")
    rows = []
    for name, level in LEVELS.items():
        error = abs(np.fromfile(WORK / f"ours-{name}.f64").reshape(4, 2, -1) - reference).max()
        rows.append(("ours", name, error, ours["propagate", name, 1], ours["propagate", name, 2]))
        if options.yardsticks:
            rows.append(("yardstick in C", name, *yardsticks.propagate(options.yardsticks, start, reference, level, options.repeats)))
        rows += [(peer, name, *found) for peer, found in propagators.peers(start, reference, level, options.repeats)]
    table(rows)
    print("\n## From 1e5 samples at 2 yr to a density\n")
    rows = list(meshes.rows(WORK, ours, options.repeats, options.quick))
    if options.yardsticks:
        rows.append(("yardstick in C", "interpolate", None, *yardsticks.rasterise(options.yardsticks, options.repeats)))
    table(rows)
    print("\n" + ", ".join(versions()))


def table(rows):
    """Prints rows of (who, what, largest error, seconds on 1 thread, on 2 threads) with ratios to ours, the first of each `what`."""
    print("| program | what | largest error | 1 thread, s | 2 threads, s | times ours (1) | times ours (2) | 1 over 2 threads |")
    print("|---|---|---|---|---|---|---|---|")
    best = {}
    for who, what, error, one, two in rows:
        base = best.setdefault(what, (one, two))
        number = lambda x, form: "-" if x is None else format(x, form)
        ratio = lambda x, y: "-" if x is None or y is None else f"{x / y:.2f}"
        cells = [who, what, number(error, ".1e"), number(one, ".4g"), number(two, ".4g"), ratio(one, base[0]), ratio(two, base[1]), ratio(one, two)]
        print("| " + " | ".join(cells) + " |", flush=True)


def versions():
    from importlib.metadata import version

    yield f"Python {sys.version.split()[0]}"
    for package in PACKAGES:
        yield f"{package} {version(package)}"


if __name__ == "__main__":
    main()
