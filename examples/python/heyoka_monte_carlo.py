"""Monte Carlo with heyoka: draws from the initial Gaussian, each propagated by adaptive Taylor series of high order, several at
a time in the lanes of the processor (Biscani & Izzo, MNRAS 504, 2021).

The equations of motion are those of monte_carlo.py, written as expressions, which heyoka differentiates and compiles.
"""

import argparse
import sys

import numpy as np

from monte_carlo import DRIFT, draw, hamiltonian
from phasecloud.kit import SAMPLES, serve

try:
    import heyoka as hy
except ImportError:
    sys.exit("this example needs heyoka: pip install -r examples/python/requirements-heyoka.txt")

LANES = hy.recommended_simd_size()


def integrator():
    """Moves LANES orbits at once; radiation and oblateness are its parameters."""
    x1, x2 = hy.make_vars("x1", "x2")
    radiation, oblateness, n_sun = hy.par[0], hy.par[1], 2.0 * np.pi
    s_squared = 1.0 - x1 * x1 - x2 * x2
    g = oblateness / (s_squared * s_squared) - 1.0
    rates = [(x1, n_sun * (radiation * hy.sqrt(s_squared) + x2 * g)), (x2, -n_sun * x1 * g)]
    return hy.taylor_adaptive_batch(rates, np.zeros((2, LANES)), tol=1e-15)


def advance(taylor, states, start, end):
    """Moves states (2, samples) in place from one time to another [yr]."""
    for first in range(0, states.shape[1], LANES):
        block = states[:, first : first + LANES]
        before = hamiltonian(block, *taylor.pars[:, 0])
        taylor.set_time(start)
        taylor.state[:] = 0.0  # lanes without an orbit hold the circular one
        taylor.state[:, : block.shape[1]] = block
        taylor.propagate_until(end)
        block[:] = taylor.state[:, : block.shape[1]]
        # A step may lead over e = 1 and back again: such an orbit has another Hamiltonian.
        kept = np.abs(hamiltonian(block, *taylor.pars[:, 0]) - before) <= DRIFT
        if not kept.all() or any(result[0] != hy.taylor_outcome.time_limit for result in taylor.propagate_res):
            raise ArithmeticError(f"an orbit left the domain e < 1 between t = {start} and {end} yr")


def monte_carlo(taylor, problem, run, samples, seed):
    problem.require("planar")
    taylor.pars[0], taylor.pars[1] = problem.parameters["radiation"], problem.parameters["oblateness"]
    rows = run.share(samples)
    states, now = draw(problem, samples, seed)[:, rows.start : rows.stop].copy(), 0.0
    for time in problem.times:
        if time > now:
            advance(taylor, states, now, time)
            now = time
        with run.snapshot(SAMPLES, rows=len(rows)) as (phi, e):
            np.arctan2(states[0], states[1], out=phi)
            phi %= 2.0 * np.pi
            np.hypot(states[0], states[1], out=e)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--samples", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    settings = vars(parser.parse_args())
    taylor = integrator()  # compiled once, before the run starts
    serve(lambda problem, run: monte_carlo(taylor, problem, run, **settings))
