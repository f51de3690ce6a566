"""Monte Carlo in space with heyoka: orbits averaged over the satellite's revolution, in the eccentricity vector e and the angular momentum
vector h = sqrt(1 - e^2) times the orbit's normal (Rosengren & Scheeres 2013, 2014; Tremaine, Touma & Namouni 2009):

    e' = n_sun (e x dH/dh + h x dH/de)      h' = n_sun (h x dH/dh + e x dH/de)

The Hamiltonian H of docs/models.md is written once, and heyoka differentiates it. Axes are equatorial, s is the direction to the Sun, p the
Earth's pole and k that of the ecliptic; time is in years, n_sun = 2 pi / yr.
"""

import argparse
import sys

import numpy as np

from phasecloud.kit import SAMPLES, serve

try:
    import heyoka as hy
except ImportError:
    sys.exit("this example needs heyoka: pip install -r examples/python/requirements-heyoka.txt")

LANES = hy.recommended_simd_size()
N_SUN = 2.0 * np.pi
LEAST_H_SQUARED = 1e-6  # an orbit that comes nearer to e = 1 than 5e-7 is a line, for which the model does not hold
KEPT = 1e-9  # to which every orbit keeps e^2 + h^2 = 1

# The parameters of the integrator. The radiation parameter may differ from orbit to orbit.
PARAMETERS = ("radiation", "oblateness", "sun", "moon", "obliquity", "sun_longitude")


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def integrator():
    """Moves LANES orbits at once; it stops where an orbit comes to e = 1."""
    e, h = hy.make_vars("e1", "e2", "e3"), hy.make_vars("h1", "h2", "h3")
    radiation, oblateness, sun, moon, obliquity, sun_longitude = (hy.par[k] for k in range(len(PARAMETERS)))
    longitude = N_SUN * hy.time + sun_longitude
    s = [hy.cos(longitude), hy.sin(longitude) * hy.cos(obliquity), hy.sin(longitude) * hy.sin(obliquity)]
    k = [hy.expression(0.0), -hy.sin(obliquity), hy.cos(obliquity)]
    e2, h2 = dot(e, e), dot(h, h)
    hamiltonian = (
        radiation * dot(e, s)
        + oblateness / 6.0 * (3.0 * h[2] ** 2 * h2**-2.5 - h2**-1.5)
        + sun * (5.0 * dot(e, s) ** 2 - dot(h, s) ** 2 - 2.0 * e2)
        + moon * (0.5 * e2 - 2.5 * dot(e, k) ** 2 - 0.5 * h2 + 0.5 * dot(h, k) ** 2)
    )
    by_e, by_h = ([hy.diff(hamiltonian, x) for x in vector] for vector in (e, h))
    e_rate = [N_SUN * (a + b) for a, b in zip(cross(e, by_h), cross(h, by_e))]
    h_rate = [N_SUN * (a + b) for a, b in zip(cross(h, by_h), cross(e, by_e))]
    line = hy.t_event_batch(h2 - LEAST_H_SQUARED)
    rates = list(zip([*e, *h], e_rate + h_rate))
    return hy.taylor_adaptive_batch(rates, np.ones((6, LANES)), tol=1e-15, t_events=[line])


def advance(taylor, states, radiation, start, end):
    """Moves states (6, samples) in place from one time to another [yr]."""
    for first in range(0, states.shape[1], LANES):
        block = states[:, first : first + LANES]
        width = block.shape[1]
        taylor.set_time(start)
        taylor.state[:] = block[:, :1]  # lanes without an orbit repeat the first
        taylor.state[:, :width] = block
        taylor.pars[0, :] = radiation[first]
        taylor.pars[0, :width] = radiation[first : first + width]
        taylor.propagate_until(end)
        block[:] = taylor.state[:, :width]
        is_kept = np.abs((block**2).sum(axis=0) - 1.0) < KEPT
        if not is_kept.all() or any(result[0] != hy.taylor_outcome.time_limit for result in taylor.propagate_res):
            raise ArithmeticError(f"an orbit came to e = 1 between t = {start} and {end} yr")


def vectors(phi, e, inclination, node, sun_longitude):
    """The vectors e and h at t = 0 as (6, samples). phi = node + argument of pericentre - longitude of the Sun."""
    argument = phi + sun_longitude - node
    cos_n, sin_n, cos_w, sin_w, cos_i, sin_i = (
        f(angle) for angle in (node, argument, inclination) for f in (np.cos, np.sin)
    )
    pericentre = [cos_n * cos_w - sin_n * sin_w * cos_i, sin_n * cos_w + cos_n * sin_w * cos_i, sin_w * sin_i]
    normal = [sin_n * sin_i, -cos_n * sin_i, cos_i]
    return np.concatenate([e * np.array(pericentre), np.sqrt(1.0 - e**2) * np.array(normal)])


def elements(states, longitude):
    """Solar angle, eccentricity, inclination and node at a longitude of the Sun."""
    e, h = states[:3], states[3:]
    node = np.arctan2(h[0], -h[1])
    inclination = np.arctan2(np.hypot(h[0], h[1]), h[2])
    along = e[0] * np.cos(node) + e[1] * np.sin(node)
    across = (e[1] * np.cos(node) - e[0] * np.sin(node)) * np.cos(inclination) + e[2] * np.sin(inclination)
    turn = 2.0 * np.pi
    return (node + np.arctan2(across, along) - longitude) % turn, np.sqrt(dot(e, e)), inclination, node % turn


def draw(problem, samples, seed):
    """The initial Gaussian, cut to 0 < e < 1 and C > 0 by drawing again, as (variables, samples). An inclination below 0 is one above it, with the
    node on the other side: nothing is cut there."""
    random = np.random.default_rng(seed)
    positive = [k for k, variable in enumerate(problem.variables) if variable.symbol in ("e", "C")]
    orbits = random.multivariate_normal(problem.mean, problem.covariance, samples).T
    while (outside := (orbits[positive] <= 0.0).any(axis=0) | (orbits[1] >= 1.0)).any():
        orbits[:, outside] = random.multivariate_normal(problem.mean, problem.covariance, outside.sum()).T
    return orbits


def monte_carlo(taylor, problem, run, samples, seed):
    problem.require("vectorial")
    longitude_at_start = problem.parameters["sun_longitude"]
    for k, name in enumerate(PARAMETERS):
        taylor.pars[k, :] = problem.parameters[name]
    rows = run.share(samples)
    orbits = draw(problem, samples, seed)[:, rows.start : rows.stop]
    radiation = np.full(len(rows), problem.parameters["radiation"])
    if len(problem.variables) == 5:
        radiation = np.exp(orbits[4]) if problem.variables[4].symbol == "ln_C" else orbits[4]
    states, now = vectors(*orbits[:4], longitude_at_start), 0.0
    for time in problem.times:
        if time > now:
            advance(taylor, states, radiation, now, time)
            now = time
        with run.snapshot(SAMPLES, rows=len(rows)) as columns:
            columns[:4] = elements(states, longitude_at_start + N_SUN * time)
            columns[4:] = orbits[4:]


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--samples", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    settings = vars(parser.parse_args())
    taylor = integrator()  # compiled once, before the run starts
    serve(lambda problem, run: monte_carlo(taylor, problem, run, **settings))
