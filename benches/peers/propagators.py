"""Programs that propagate orbits. States are arrays (2, samples); results (4 snapshots, 2, samples)."""
import subprocess
import threading
from functools import cache

import heyoka
import numba
import numpy as np
from scipy.integrate import solve_ivp
from scipy.integrate._ivp import dop853_coefficients

from compare import SUN, WORK, C, W, median

TIMES = SUN * np.array([0.0, 0.5, 1.0, 1.5, 2.0])
BATCH = 16
# SciPy takes minutes for all samples: it propagates this number, and its time is scaled.
SCIPY_SAMPLES = 200


def reference(start):
    return heyoka_states([integrator(1e-16)], start)


def peers(start, reference, level, repeats):
    """For every program: its name and (largest error, seconds on one thread, seconds on two)."""
    for name, peer in (("C, gcc", c_peer), ("heyoka, batches of 16", heyoka_peer), ("numba, Runge-Kutta 8", numba_peer)):
        found = peer(start, reference, level, repeats)
        if found:
            yield name, found
    yield f"SciPy DOP853 ({SCIPY_SAMPLES} samples, scaled)", scipy_peer(start, reference, level)


def loosest(ladder, run, reference, level):
    """The first setting of the series whose largest error is within the level, and this error."""
    for rung in ladder:
        error = np.abs(run(rung) - reference).max()
        if error <= level:
            return rung, error
    raise RuntimeError(f"nothing on the ladder reaches {level}")


def tolerances(level, factors=(300, 100, 30, 10, 3, 1, 0.3, 0.1, 0.03, 0.01, 0.003)):
    return [level * factor for factor in factors]


# heyoka


def integrator(tolerance):
    x1, x2, s = heyoka.make_vars("x1", "x2", "s")
    g = W * s**-4.0 - 1.0
    system = [(x1, C * s + x2 * g), (x2, -x1 * g), (s, -C * x1)]
    return heyoka.taylor_adaptive_batch(system, np.zeros((3, BATCH)), tol=tolerance, fast_math=True)


def heyoka_states(integrators, start):
    samples = start.shape[1]
    states = np.vstack([start, np.sqrt(1 - (start**2).sum(0))])
    times = np.repeat(TIMES[:, None], BATCH, 1)
    out = np.empty((5, 3, samples))

    def run(integrator, first, last):
        for i in range(first, last, BATCH):
            integrator.set_time(0.0)
            integrator.state[:] = states[:, i : i + BATCH]
            out[:, :, i : i + BATCH] = integrator.propagate_grid(times)[1]

    share = samples // len(integrators) // BATCH * BATCH
    ends = [*(share * k for k in range(len(integrators))), samples]
    workers = [threading.Thread(target=run, args=work) for work in zip(integrators, ends, ends[1:])]
    [worker.start() for worker in workers]
    [worker.join() for worker in workers]
    return out[1:, :2]


def heyoka_peer(start, reference, level, repeats):
    tolerance, error = loosest(tolerances(level), lambda t: heyoka_states([integrator(t)], start), reference, level)
    two = [integrator(tolerance), integrator(tolerance)]
    seconds = [median(lambda: heyoka_states(two[:n], start), repeats, n) for n in (1, 2)]
    return error, *seconds


# numba


@cache
def runge_kutta():
    """Dormand and Prince's method of order 8 with fixed steps, written out for blocks of samples."""
    a, b = dop853_coefficients.A[:12, :12], dop853_coefficients.B
    block = 64
    lines = ["def block(start, out, first, steps, h):", f"  x = np.empty({block}); y = np.empty({block})"]
    lines += [f"  kx{s} = np.empty({block}); ky{s} = np.empty({block})" for s in range(12)]
    each = f"for l in range({block}):"
    lines += [f"  {each}", "    x[l] = start[0, first + l]; y[l] = start[1, first + l]"]
    lines += ["  for snapshot in range(4):", "    for step in range(steps):"]
    total = lambda row, c: "".join(f" + {float(w)!r} * k{c}{j}[l]" for j, w in enumerate(row) if w != 0)
    for s in range(12):
        lines += [f"      {each}"] + [f"        {c}s = {c}[l]{total(a[s, :s], c)}" for c in "xy"]
        lines += ["        q = 1.0 - xs * xs - ys * ys", f"        g = h * ({W} / (q * q) - 1.0)"]
        lines += [f"        kx{s}[l] = h * {C} * np.sqrt(q) + ys * g", f"        ky{s}[l] = -xs * g"]
    lines += [f"      {each}"] + [f"        {c}[l] = {c}[l]{total(b, c)}" for c in "xy"]
    lines += [f"    {each}", "      out[snapshot, 0, first + l] = x[l]; out[snapshot, 1, first + l] = y[l]"]
    names = {"np": np}
    exec("\n".join(lines), names)
    options = {"fastmath": True, "error_model": "numpy"}
    one_block = numba.njit(names["block"], **options)

    @numba.njit(parallel=True, **options)
    def all_blocks(start, out, steps, h):
        samples = start.shape[1]
        for k in numba.prange((samples + block - 1) // block):
            one_block(start, out, min(k * block, samples - block), steps, h)

    return all_blocks


def numba_peer(start, reference, level, repeats):
    def run(steps):
        out = np.empty((4, 2, start.shape[1]))
        runge_kutta()(start, out, steps, SUN / 2 / steps)
        return out

    ladder = [int(10 * 1.1**k) for k in range(30)]
    steps, error = loosest(ladder, run, reference, level)
    seconds = []
    for threads in (1, 2):
        numba.set_num_threads(min(threads, numba.config.NUMBA_NUM_THREADS))
        seconds.append(median(lambda: run(steps), repeats, threads))
    return error, *seconds


# SciPy


def scipy_peer(start, reference, level):
    def rate(_, state):
        x1, x2 = state
        q = 1 - x1 * x1 - x2 * x2
        g = W / (q * q) - 1
        return C * abs(q) ** 0.5 + x2 * g, -x1 * g

    def run(tolerance):
        options = {"method": "DOP853", "rtol": max(tolerance, 3e-14), "atol": 0.1 * tolerance, "t_eval": TIMES[1:]}
        orbits = start[:, :SCIPY_SAMPLES].T
        return np.stack([solve_ivp(rate, (0, TIMES[-1]), orbit, **options).y.T for orbit in orbits], axis=-1)

    tolerance, error = loosest(tolerances(level), run, reference[:, :, :SCIPY_SAMPLES], level)
    return error, median(lambda: run(tolerance), 1) * start.shape[1] / SCIPY_SAMPLES, None


# C


def c_peer(start, reference, level, repeats):
    source, program, states = (str(path) for path in (WORK.parents[1] / "benches/peers/taylor.c", WORK / "taylor", WORK / "c.f64"))
    order = {1e-6: 11, 1e-9: 14, 1e-12: 18}[level]
    flags = ["-O3", "-march=native", "-ffast-math", "-fopenmp", f"-DORDER={order}"]
    try:
        subprocess.run(["gcc", *flags, source, "-o", program, "-lm"], check=True)
    except FileNotFoundError:
        return None

    def run(tolerance, repeats=1):
        arguments = [WORK / "start.f64", states, start.shape[1], repeats, tolerance, C, W]
        return subprocess.run([program, *map(str, arguments)], check=True, capture_output=True, text=True).stdout

    def states_of(tolerance):
        run(tolerance)
        return np.fromfile(states).reshape(4, 2, -1)

    ladder = [level * factor for factor in (0.2, 0.14, 0.1, 0.07, 0.05, 0.03, 0.02, 0.01)]
    tolerance, error = loosest(ladder, states_of, reference, level)
    one, two = (float(line.split(",")[1]) for line in run(tolerance, repeats).splitlines())
    return error, one, two
