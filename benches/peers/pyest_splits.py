"""The splitting criteria of PyEst beside ours, on the planar scenarios of the paper.

    python3 -m venv target/peers/pyest && target/peers/pyest/bin/pip install pyest==0.7.2
    cargo run --release -p phasecloud-experiments --bin splitting_criteria -- plane target/splits.json
    target/peers/pyest/bin/python benches/peers/pyest_splits.py target/splits.json

Three tables. The first has the directions: of PyEst as released, of PyEst with the whitening that its documentation states, and ours. The second has the same
components: PyEst splits along our direction with our library, moves every component by its unscented transform on orbits of SciPy (DOP853, 1e-12), and the
components are set beside ours. The third has PyEst's own run, its direction with its library, on our grid against our exact density.

PyEst whitens by solving with the transpose of the lower triangular factor of the predicted covariance, where its documentation has the norm of its inverse.
"With its whitening right" replaces the factor by one with which the same solution is that norm. PyEst splits a component that is above a tolerance; here the
tolerance is below zero and the depth is one, so that the one Gaussian is split once. It has no cut at e = 0, and its criteria know no angle that turns: the flow
given to it returns angles on the branch of the component's centre.
"""

import json
import sys
import warnings

import numpy as np
from scipy.integrate import solve_ivp

warnings.filterwarnings("ignore", category=FutureWarning)
from pyest.filters.sigma_points import SigmaPointOptions, unscented_transform  # noqa: E402
from pyest.gm import GaussianMixture  # noqa: E402
from pyest.gm import split as pyest  # noqa: E402
from pyest.gm.gm import GaussSplitOptions  # noqa: E402

C, W, SUN = 0.15, 0.40921, 2 * np.pi
INITIAL = {  # mean phi, mean e, two standard deviations of each: Table 1
    1: (2.2069, 0.145, np.pi / 8, 0.05),
    2: (0.5419, 0.095, np.pi / 40, 0.01),
    3: (0.3004, 0.23, np.pi / 32, 0.02),
}
POINTS = SigmaPointOptions(alpha=1, beta=0, kappa=1)  # n + zeta = n + 1, central covariance weight as that of the mean
STEP = 0.02  # standard deviations over which derivatives are taken
MOST_OF_ITS_OWN = 15  # components of a library of PyEst; its optimiser was ended before it had one of 39
SUBDIVISIONS = 6  # of a bin along each axis
BEHIND = np.array([[0.0, 1.0], [1.0, 0.0]])


def flow(points, years):
    """Variables of many points (2, n) after so many years; angles in (-pi, pi]."""
    phi, e = points
    start = np.concatenate([e * np.sin(phi), e * np.cos(phi)])

    def rate(_, state):
        x1, x2 = state.reshape(2, -1)
        s = np.sqrt(1 - x1**2 - x2**2)
        g = W * s**-4 - 1
        return SUN * np.concatenate([C * s + x2 * g, -x1 * g])

    x1, x2 = solve_ivp(rate, (0, years), start, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1].reshape(2, -1)
    return np.array([np.arctan2(x1, x2), np.hypot(x1, x2)])


def near(values, centre):
    """The same with angles on the branch of a centre."""
    turns = np.round((values[0] - centre[0]) / (2 * np.pi))
    return np.array([values[0] - 2 * np.pi * turns, values[1]])


class Local:
    """What a criterion asks of the flow about a mean."""

    def __init__(self, mean, deviations, years):
        self.years, self.centre = years, flow(mean[:, None], years)[:, 0]
        steps = STEP * np.diag(deviations)
        at = [mean, *(mean + sign * step for step in steps for sign in (1, -1))]
        at += [mean + sign * (steps[0] + steps[1]) for sign in (1, -1)]
        y = near(flow(np.array(at).T, years), self.centre).T
        d = STEP * deviations
        self.slopes = np.array([(y[1 + 2 * k] - y[2 + 2 * k]) / (2 * d[k]) for k in (0, 1)]).T
        bends = [y[1 + 2 * k] + y[2 + 2 * k] - 2 * y[0] for k in (0, 1, 2)]
        twist = 0.5 * (bends[2] - bends[0] - bends[1]) / (d[0] * d[1])
        a, b = bends[0] / d[0] ** 2, bends[1] / d[1] ** 2
        self.bends = np.array([[[a[v], twist[v]], [twist[v], b[v]]] for v in (0, 1)])

    def map(self, point):
        return near(flow(point[:, None], self.years), self.centre[:, None])[:, 0]

    def direction(self, name, gaussian):
        jacobian, bends = (lambda *_: self.slopes), (lambda *_: self.bends)
        arguments = {
            "variance": (), "fos": (jacobian,), "safos": (jacobian,), "usfos": (jacobian,),
            "sos": (bends, jacobian), "wussos": (bends, jacobian), "wussolc": (bends, jacobian), "wsasos": (bends, jacobian),
            "solc": (bends,), "ussolc": (bends,), "sasos": (bends,),
            "alodt": (self.map, POINTS), "sadl": (jacobian, self.map, POINTS), "wussadl": (jacobian, self.map, POINTS),
        }  # fmt: skip
        _, directions = getattr(pyest, f"id_{name}")(gaussian, *arguments[name], -1.0)
        return directions[0]


def right_factor(root):
    """A lower triangular L with L^T L = root root^T."""
    upper = BEHIND @ np.linalg.cholesky(BEHIND @ root @ root.T @ BEHIND) @ BEHIND
    return upper.T


def with_right_whitening(work):
    released, pyest.triangularize = pyest.triangularize, right_factor
    try:
        return work()
    finally:
        pyest.triangularize = released


def split(gaussian, direction, library, count):
    """PyEst's split along a direction, with a library given or its own."""
    own = pyest.split_1d_standard_gaussian
    if library:
        one = np.array(library["means"])[:, None]
        root = np.full((count, 1, 1), library["sigma"])
        pyest.split_1d_standard_gaussian = lambda *_, **__: GaussianMixture(np.array(library["weights"]), one, root, "cholesky")
    try:
        options = GaussSplitOptions(L=count, lam=1e-3, variance_preserving=True)
        return pyest.split_gaussian(1.0, gaussian.m[0], gaussian.P[0], options, direction=direction.copy())
    finally:
        pyest.split_1d_standard_gaussian = own


def carried(mixture, years, axes=None):
    """Weights, means and covariances of PyEst's components after so many years. PyEst places sigma points on the columns of the Cholesky factor;
    with axes given it is asked for the transform of a standard normal in these axes, which places them there."""
    means, covariances = [], []
    for start, covariance in zip(mixture.m, mixture.P, strict=True):
        centre = flow(start[:, None], years)
        if axes is None:
            step = np.linalg.cholesky(covariance)
        else:
            step = axes
            assert np.allclose(axes @ axes.T, covariance, rtol=1e-6), "the axes are a square root of the component's covariance"
        mapped = lambda z, start=start, step=step, centre=centre: near(flow((start + step @ z)[:, None], years), centre)[:, 0]  # noqa: E731
        mean, covariance, *_ = unscented_transform(np.zeros(2), np.eye(2), mapped, POINTS)
        means.append(mean)
        covariances.append(covariance)
    return np.array(mixture.w), np.array(means), np.array(covariances)


def l1(case, weights, means, covariances):
    """L1 distance of a mixture from the exact density, with what either has outside the grid."""
    ends, exact = (case["phi"], case["e"]), np.array(case["exact"])
    fine = [low + (high - low) * (np.arange(bins * SUBDIVISIONS) + 0.5) / (bins * SUBDIVISIONS) for low, high, bins in ends]
    phi, e = np.meshgrid(*fine, indexing="ij")
    density = np.zeros_like(phi)
    middle = 0.5 * (case["phi"][0] + case["phi"][1])
    for w, (m_phi, m_e), p in zip(weights, means, covariances, strict=True):
        m_phi -= 2 * np.pi * np.round((m_phi - middle) / (2 * np.pi))
        q = np.linalg.inv(p)
        u, v = phi - m_phi, e - m_e
        density += w / (2 * np.pi * np.sqrt(np.linalg.det(p))) * np.exp(-0.5 * (q[0, 0] * u * u + 2 * q[0, 1] * u * v + q[1, 1] * v * v))
    bins = [bins for *_, bins in ends]
    average = density.reshape(bins[0], SUBDIVISIONS, bins[1], SUBDIVISIONS).mean((1, 3)).ravel()
    area = np.prod([(high - low) / bins for low, high, bins in ends])
    return area * np.abs(average - exact).sum() + abs(area * (average.sum() - exact.sum()))


def prepared(case):
    phi, e, delta_phi, delta_e = INITIAL[case["scenario"]]
    deviations = np.array([delta_phi, delta_e]) / 2
    gaussian = GaussianMixture(np.array([1.0]), np.array([[phi, e]]), np.diag(deviations**2)[None])
    return gaussian, deviations, Local(gaussian.m[0], deviations, case["time"])


def row(*cells):
    print("|", " | ".join(str(cell) for cell in cells), "|")


def main():
    np.random.seed(1)  # PyEst searches the longest bend from random starts
    given = json.loads(open(sys.argv[1]).read())
    cases = given["cases"]
    ready = [prepared(case) for case in cases]
    titles = [f"{case['scenario']}, {case['time']:g} yr" for case in cases]
    released, found = directions(given, ready, titles)
    same_components(given, ready, titles)
    own_runs(given, ready, titles, released)
    off = max(abs((found[key] - split["angle"] + np.pi / 2) % np.pi - np.pi / 2) for key, split in found_splits(given).items())
    print(f"\nwith its whitening right no direction of PyEst is further from ours than {np.degrees(off):.1e} degrees")


def found_splits(given):
    return {(split["case"], split["criterion"]): split for split in given["splits"]}


def directions(given, ready, titles):
    print("\ndirections, from phi towards e in standard deviations: as released, with its whitening right, ours\n")
    row("criterion", *titles)
    row(*["---"] * (1 + len(titles)))
    released, right = {}, {}
    for name in dict.fromkeys(split["criterion"] for split in given["splits"]):
        cells = []
        for index, (gaussian, deviations, local) in enumerate(ready):
            find = lambda: local.direction(name, gaussian)  # noqa: B023, E731
            as_released = find()
            both = [as_released, with_right_whitening(find) if name.startswith("w") else as_released]
            angles = [np.arctan2(*(x / deviations)[::-1]) % np.pi for x in both]
            released[index, name], right[index, name] = both[0], angles[1]
            angles.append(found_splits(given)[index, name]["angle"])
            cells.append(", ".join(f"{np.degrees(angle):.1f}" for angle in angles))
        row(name, *cells)
    return released, right


def same_components(given, ready, titles):
    print("\nthe same components of `wussolc`, sigma points on the axes of the split: largest differences of weights, of means in deviations, of")
    print("covariances relative to variances; L1 ours, by PyEst, and by PyEst with sigma points where it places them itself\n")
    row("case", "components", "weights", "means", "covariances", "L1 ours", "L1 by PyEst", "on its own axes")
    row(*["---"] * 8)
    for index, (gaussian, deviations, _) in enumerate(ready):
        case, ours = given["cases"][index], found_splits(given)[index, "wussolc"]
        cos, sin = np.cos(ours["angle"]), np.sin(ours["angle"])
        for library, there in zip(given["libraries"], ours["splits"], strict=True):
            start = split(gaussian, deviations * [cos, sin], library, there["count"])
            axes = deviations[:, None] * np.array([[cos * library["sigma"], -sin], [sin * library["sigma"], cos]])
            found = carried(start, case["time"], axes)
            errors = [there["l1"], l1(case, *found), l1(case, *carried(start, case["time"]))]
            off = differences(found, np.array(there["components"]))
            row(titles[index], there["count"], *(f"{part:.0e}" for part in off), *(f"{error:.4f}" for error in errors))


def differences(found, components):
    """The largest differences of weights, means and covariances."""
    weights, means, covariances = found
    right = components[:, [3, 4, 4, 5]].reshape(-1, 2, 2)
    sigma = np.sqrt(np.diagonal(right, axis1=1, axis2=2))
    means_apart = near(means.T, components[:, 1:3].T).T - components[:, 1:3]
    covariances_apart = (covariances - right) / (sigma[:, :, None] * sigma[:, None, :])
    return [np.abs(part).max() for part in (weights - components[:, 0], means_apart / sigma, covariances_apart)]


def own_runs(given, ready, titles, released):
    counts = [there["count"] for there in given["splits"][0]["splits"] if there["count"] <= MOST_OF_ITS_OWN]
    widths = [f"{pyest.split_1d_standard_gaussian(count, 1e-3).P[0, 0, 0] ** 0.5:.2f}" for count in counts]
    print(f"\nPyEst's own run (its directions as released, its library with lam = 1e-3): L1 with {', '.join(map(str, counts))} components,")
    print(f"which are {', '.join(widths)} deviations wide\n")
    row("criterion", *titles)
    row(*["---"] * (1 + len(titles)))
    for name in dict.fromkeys(split["criterion"] for split in given["splits"]):
        cells = []
        for index, (gaussian, _, _) in enumerate(ready):
            case = given["cases"][index]
            moved = [carried(split(gaussian, released[index, name], None, count), case["time"]) for count in counts]
            cells.append(", ".join(f"{l1(case, *mixture):.3f}" for mixture in moved))
        row(name, *cells)


if __name__ == "__main__":
    main()
