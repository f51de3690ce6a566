"""Hand-tuned C programs that are no part of this project: `FOLDER/taylor.c` and `FOLDER/raster.c`, built with gcc for this machine.

    taylor THREADS REPEATS TOLERANCE     order P at compile time; reads ic_x.bin and ref.bin, rows of x1, x2
    raster 4 SAMPLES POINTS THREADS REPEATS 1     reads pts..._4.bin, rows of phi, e, n, and tri..._4.bin

Both print JSON with `cpu_med` and `wall_med`, taylor also the largest error as `max`.
"""
import json
import subprocess

import numpy as np

from compare import WORK, W

ROOM = WORK / "yardsticks"
ORDERS = {1e-6: 11, 1e-9: 12, 1e-12: 18}


def propagate(folder, start, reference, level, repeats):
    """Largest error, seconds on one thread, seconds on two."""
    program = build(folder / "taylor.c", "-DU=2", f"-DP={ORDERS[level]}")
    start.T.copy().tofile(ROOM / "ic_x.bin")
    reference.transpose(0, 2, 1).copy().tofile(ROOM / "ref.bin")
    for factor in (3, 2, 1.4, 1, 0.7, 0.5, 0.35, 0.2, 0.1, 0.05, 0.02):
        if run(program, 1, 1, factor * level)["max"] <= level:
            break
    one, two = (run(program, threads, repeats, factor * level) for threads in (1, 2))
    return one["max"], one["cpu_med"], two["wall_med"]


def rasterise(folder, repeats):
    """Seconds on one thread and on two, for as many grid points as ours, spread over the cloud's own extent."""
    program = build(folder / "raster.c", "-ffast-math")
    cloud = np.fromfile(WORK / "cloud.f64").reshape(3, -1)
    samples = cloud.shape[1]
    cloud.T.copy().tofile(ROOM / f"pts{samples}_4.bin")
    np.fromfile(WORK / "triangles.u32", np.uint32).tofile(ROOM / f"tri{samples}_4.bin")
    (ROOM / "results").mkdir(exist_ok=True)
    one, two = (run(program, 4, samples, 5000, threads, repeats, 1) for threads in (1, 2))
    return one["cpu_med"], two["wall_med"]


def build(source, *options):
    """Builds a copy with our oblateness parameter, which the original has rounded."""
    ROOM.mkdir(exist_ok=True)
    copy, program = ROOM / source.name, ROOM / source.stem
    copy.write_text(source.read_text().replace("W=0.409", f"W={W}"))
    subprocess.run(["gcc", "-O3", "-march=native", "-fopenmp", *options, copy, "-o", program, "-lm"], check=True)
    return program


def run(program, *arguments):
    output = subprocess.run([program, *map(str, arguments)], cwd=ROOM, check=True, capture_output=True, text=True).stdout
    return json.loads(output)
