"""Monte Carlo with SciPy: draws from the initial Gaussian, each propagated by DOP853 (Hairer, Norsett & Wanner 1993).

In x1 = e sin(phi), x2 = e cos(phi) the averaged equations of motion (Sun et al. 2022, Eq. 1; Krivov & Getino 1997) are
regular at e = 0:

    x1' =  n_sun (C s + x2 g)      s = sqrt(1 - e^2)
    x2' = -n_sun x1 g              g = W / s^4 - 1

with time in years and n_sun = 2 pi / yr.
"""

import argparse

import numpy as np
from scipy.integrate import solve_ivp

from phasecloud.kit import SAMPLES, serve

BLOCK = 4000  # orbits that share a step size: their numbers stay in the cache
RELATIVE, ABSOLUTE = 1e-11, 1e-13  # the Hamiltonian of 1e5 orbits then drifts by 8e-11 at most in two years
DRIFT = 1e-6  # of an orbit that can be followed


def rate(_time, state, radiation, oblateness):
    x1, x2 = state.reshape(2, -1)
    s_squared = 1.0 - x1 * x1 - x2 * x2
    g = oblateness / (s_squared * s_squared) - 1.0
    return 2.0 * np.pi * np.concatenate([radiation * np.sqrt(s_squared) + x2 * g, -x1 * g])


def hamiltonian(states, radiation, oblateness):
    """Constant along every orbit; beyond e = 1 there is none (below Eq. 3)."""
    s = np.sqrt(1.0 - states[0] ** 2 - states[1] ** 2)
    return s + radiation * states[1] + oblateness / (3.0 * s**3)


def advance(problem, states, start, end):
    """Moves states (2, samples) in place from one time to another [yr]."""
    arguments = (problem.parameters["radiation"], problem.parameters["oblateness"])
    for block in np.array_split(states, range(BLOCK, states.shape[1], BLOCK), axis=1):
        before = hamiltonian(block, *arguments)
        solution = solve_ivp(
            rate, (start, end), block.ravel(), "DOP853", [end], rtol=RELATIVE, atol=ABSOLUTE, args=arguments
        )
        block[:] = solution.y.reshape(2, -1)
        # An orbit that the integrator has taken over e = 1 and back again has another Hamiltonian, or none.
        kept = np.abs(hamiltonian(block, *arguments) - before) <= DRIFT
        if not solution.success or not kept.all():
            raise ArithmeticError(f"an orbit left the domain e < 1 before t = {end} yr: {solution.message}")


def draw(problem, samples, seed):
    """The initial Gaussian, cut to 0 < e < 1 by drawing again."""
    random = np.random.default_rng(seed)
    phi, e = random.multivariate_normal(problem.mean, problem.covariance, samples).T
    while (outside := (e <= 0.0) | (e >= 1.0)).any():
        again = random.multivariate_normal(problem.mean, problem.covariance, outside.sum())
        phi[outside], e[outside] = again.T
    return np.stack([e * np.sin(phi), e * np.cos(phi)])


def monte_carlo(problem, run, samples, seed):
    problem.require("planar")
    # All of them, or this shard's part. Blocks share step sizes: shards agree within the tolerances, not to the last bit.
    rows = run.share(samples)
    states, now = draw(problem, samples, seed)[:, rows.start : rows.stop].copy(), 0.0
    for time in problem.times:
        if time > now:
            advance(problem, states, now, time)
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
    serve(lambda problem, run: monte_carlo(problem, run, **settings))
