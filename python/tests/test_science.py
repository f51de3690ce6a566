"""The methods in this process: their numbers, what they take and return, and what they refuse."""

import math
import signal
import threading
import time

import numpy as np
import phasecloud as pc
import pytest
from conftest import SCENARIOS
from scipy.integrate import solve_ivp

#: Means and deviations of Sun et al. (2022), Table 3, Monte Carlo with 1e5 samples: t [yr], mean phi, std phi, mean e, std e.
TABLE_3 = [
    (0.0, 2.20780, 0.19671, 0.14499, 0.02500),
    (0.5, 0.95229, 0.07561, 0.54399, 0.02460),
    (1.0, 3.57337, 0.58152, 0.78955, 0.01501),
    (1.5, 5.26674, 0.14873, 0.49021, 0.04534),
    (2.0, 3.32611, 0.86184, 0.14285, 0.04342),
]


@pytest.fixture(scope="module")
def scenario():
    return pc.Scenario.from_file(SCENARIOS / "scenario-1.toml")


@pytest.fixture(scope="module")
def exact(scenario):
    return pc.exact(scenario)


def test_the_exact_moments_are_those_of_the_paper_within_its_sampling_error(exact):
    names = ["mean_phi_rad", "std_phi_rad", "mean_e", "std_e"]
    for k, (t, *printed) in enumerate(TABLE_3):
        assert exact.times[k] == t
        sigma = {name[-5:]: exact.quantities[name][k] for name in ("std_phi_rad", "std_e")}
        for name, value in zip(names, printed):
            of = exact.quantities["std_phi_rad" if "phi" in name else "std_e"][k]
            assert abs(exact.quantities[name][k] - value) < 5.0 * of / math.sqrt(1e5), (t, name, sigma)


def test_monte_carlo_lies_within_its_standard_errors_of_the_exact_answer(scenario, exact):
    cloud = pc.monte_carlo(scenario, samples=20_000, seed=3)
    for name in ["mean_phi_rad", "std_phi_rad", "mean_e", "std_e", "cov_phi_e"]:
        error = cloud.standard_errors[name]
        assert (error > 0).all() and (abs(cloud.quantities[name] - exact.quantities[name]) < 5.0 * error).all(), name
    assert cloud.snapshots[2].rows.shape == (2, 20_000) and cloud.snapshots[2].kind == "samples"
    assert cloud.quantities["mean_e"][2] == pytest.approx(cloud.snapshots[2].rows[1].mean(), abs=1e-12)
    assert abs(cloud.first_passage.at(2.0) - exact.first_passage.at(2.0)) < 1e-3
    assert pc.monte_carlo(scenario, samples=100, keep_samples=False).snapshots[0].rows is None


@pytest.mark.parametrize("method, settings", [(pc.dee, {"samples": 961}), (pc.gmm_ut, {})])
def test_densities_of_the_other_methods_are_those_of_the_exact_answer(scenario, exact, method, settings):
    other = method(scenario, **settings)
    for mine, theirs in zip(other.snapshots, exact.snapshots):
        cell = np.prod([np.diff(edges)[0] for edges in theirs.joint.edges.values()])
        assert np.abs(mine.joint.values - theirs.joint.values).sum() * cell < 0.01
    assert other.diagnostics and other.snapshots[0].trajectories > 0


def test_a_density_has_named_axes_units_and_its_mass(exact):
    joint = exact.snapshots[1].joint
    assert joint.dims == ("phi", "e") and joint.shape == (100, 100) and joint.unit == "1/rad"
    assert joint.mass == pytest.approx(exact.snapshots[1].mass_on_grid, abs=1e-12) and joint.mass > 0.999
    assert np.asarray(joint).shape == joint.coords["phi"].shape + joint.coords["e"].shape
    xarray = pytest.importorskip("xarray")
    array = joint.to_xarray()
    assert isinstance(array, xarray.DataArray) and array.dims == ("phi", "e") and array.phi.attrs["units"] == "rad"
    assert float(array.integrate(("phi", "e"))) == pytest.approx(1.0, abs=2e-3)


def test_a_first_passage_curve_is_the_same_alone_and_beside_the_densities(scenario, exact):
    alone = pc.first_passage(scenario)
    assert np.array_equal(alone.probability, exact.first_passage.probability) and len(alone.times) == 65
    assert set(alone.interval) == {"error estimate"}
    counted = pc.first_passage(scenario, "mc", samples=2000)
    assert set(counted.interval) == {"95 %"} and (np.diff(counted.probability) >= 0).all()
    with pytest.raises(pc.Refused, match="a mixture says where orbits are at a time"):
        pc.first_passage(scenario, "gmm-ut")
    mixture = pc.gmm_ut(scenario)
    assert mixture.first_passage is None and "mixture" in mixture.no_first_passage
    with pytest.raises(pc.Refused, match="gmm-ut: a mixture"):
        mixture.plot_first_passage()


def rate(_time, state, radiation, oblateness):
    """Sun et al. (2022), Eq. 1, in x1 = e sin(phi), x2 = e cos(phi)."""
    x1, x2 = state
    s = math.sqrt(1.0 - x1 * x1 - x2 * x2)
    g = oblateness / s**4 - 1.0
    return 2.0 * np.pi * np.array([radiation * s + x2 * g, -x1 * g])


def test_orbits_are_those_of_an_integrator_of_scipy(scenario):
    starts = np.array([[2.2, 1.0, 4.0], [0.145, 0.02, 0.3]])
    moved = pc.propagate(scenario, starts, [0.3, 1.7])
    assert moved.shape == (2, 2, 3)
    arguments = (scenario.parameters["radiation"], scenario.parameters["oblateness"])
    for k, (phi, e) in enumerate(starts.T):
        begin = [e * np.sin(phi), e * np.cos(phi)]
        solution = solve_ivp(rate, (0, 1.7), begin, "DOP853", [0.3, 1.7], rtol=1e-12, atol=1e-13, args=arguments)
        x1, x2 = moved[:, 1, k] * np.sin(moved[:, 0, k]), moved[:, 1, k] * np.cos(moved[:, 0, k])
        assert np.allclose([x1, x2], solution.y, atol=1e-9)
    single = pc.propagate(scenario, starts[:, 0], [0.3, 1.7])
    assert single.shape == (2, 2) and np.array_equal(single, moved[:, :, 0])
    # An array whose rows do not lie together in memory is the same orbits.
    assert np.array_equal(pc.propagate(scenario, np.asfortranarray(starts), [0.3, 1.7]), moved)


@pytest.mark.parametrize("file", ["scenarios/three-dimensional.toml", "scenarios/unaveraged.toml", "models/vectorial.toml"])
def test_orbits_in_every_model_come_back_at_time_zero(file):
    scenario = pc.Scenario.from_file(SCENARIOS.parent / file)
    start = {"phi": 2.0, "e": 0.1, "i": 0.4, "node": 1.0, "M": 0.5, "a": 2.5, "C": 0.1}
    symbols = [variable.symbol for variable in scenario.orbit_variables]
    starts = np.array([start.get(symbol, 0.4) for symbol in symbols])
    moved = pc.propagate(scenario, starts, [0.0, 0.1])
    assert moved.shape == (2, len(symbols)) and np.allclose(moved[0], starts, atol=1e-9), symbols
    assert abs(moved[1] - starts).max() > 1e-4


def test_starts_that_are_no_orbits_are_refused_by_number_and_variable(scenario):
    with pytest.raises(ValueError, match=r"starts: orbit 1 has e = 1.2, it must be at least 0 and below 1"):
        pc.propagate(scenario, [[0.0, 0.0], [0.1, 1.2]])
    with pytest.raises(ValueError, match=r"starts: orbit 0 has phi = NaN"):
        pc.propagate(scenario, [[math.nan], [0.1]])
    with pytest.raises(ValueError, match=r"3 rows, the model has 2 variables, a row each: phi, e"):
        pc.propagate(scenario, np.zeros((3, 4)))
    with pytest.raises(ValueError, match="times: they must be finite numbers of years"):
        pc.propagate(scenario, [[0.0], [0.1]], [1.0, 0.5])
    with pytest.raises(ValueError, match="accuracy: 1e-7 is not allowed, it must be 1e-6, 1e-9 or 1e-12"):
        pc.propagate(scenario, [[0.0], [0.1]], accuracy=1e-7)
    strong = scenario.changed({"orbit.radiation": 3.0, "orbit.oblateness": 0.0})
    with pytest.raises(pc.LostOrbit, match="sample 0, which started at phi = 0"):
        pc.propagate(strong, [[0.0], [0.6]], [2.0])
    assert pc.propagate(scenario, np.empty((2, 0)), [1.0]).shape == (1, 2, 0)


def test_a_flow_map_moves_orbits_to_where_they_are_propagated(scenario):
    flow = pc.flow_map(scenario)
    assert flow.orbits < 50_000 and 0 < flow.error <= 1e-9 and flow.mapped > 0.999
    random = np.random.default_rng(5)
    starts = random.multivariate_normal(scenario.mean, scenario.covariance, 2000).T
    starts[:, 0] = [0.3, 0.6]  # far from the cloud: propagated
    truth = pc.propagate(scenario, starts)
    for index in range(len(flow.times)):
        phi, e = flow(starts, index)
        x = [e * np.sin(phi) - truth[index, 1] * np.sin(truth[index, 0]), e * np.cos(phi) - truth[index, 1] * np.cos(truth[index, 0])]
        assert np.abs(x).max() < 1e-8
    with pytest.raises(IndexError):
        flow(starts, 7)
    with pytest.raises(pc.Refused, match="a flow map is for planar scenarios"):
        pc.flow_map(pc.Scenario.from_file(SCENARIOS / "three-dimensional.toml"))
    with pytest.raises(ValueError, match="between 1e-11 and 1e-3"):
        pc.flow_map(scenario, 1.0)


def test_what_a_method_cannot_do_is_refused_in_words(scenario):
    in_space = pc.Scenario.from_file(SCENARIOS / "three-dimensional.toml")
    with pytest.raises(pc.Refused, match='the scenario\'s model is "vectorial", this is for models in the plane alone'):
        pc.exact(in_space, bins=(10, 10))
    with pytest.raises(pc.InputError) as error:
        pc.monte_carlo(scenario, sampels=10)
    assert error.value.key == "sampels" and "did you mean `samples`" in error.value.problem and error.value.line is None
    with pytest.raises(pc.InputError, match="settings of mc: samples: 1 is not enough"):
        pc.monte_carlo(scenario, samples=1)
    with pytest.raises(pc.InputError, match="settings of gmm-ut: components: has no effect"):
        pc.gmm_ut(scenario, components=39)
    with pytest.raises(ValueError, match="bins: "):
        pc.exact(scenario, bins=(0, 10))


def test_clouds_in_space_have_their_variables_and_densities():
    cloud = pc.monte_carlo(pc.Scenario.from_file(SCENARIOS / "three-dimensional.toml"), samples=500, bins=(20, 20))
    snapshot = cloud.snapshots[-1]
    assert snapshot.rows.shape == (len(cloud.scenario.variables), 500)
    assert snapshot.joint.dims == ("phi", "e") and len(snapshot.densities) == 6


def test_the_lock_is_released_and_ctrl_c_ends_a_computation(scenario):
    long = scenario.changed({"times": {"end": 40.0, "step": 0.25}})
    ticks = []
    done = threading.Event()

    def tick():
        while not done.wait(0.01):
            ticks.append(time.monotonic())

    def interrupt():
        time.sleep(1.0)
        signal.raise_signal(signal.SIGINT)

    threads = [threading.Thread(target=tick), threading.Thread(target=interrupt)]
    for thread in threads:
        thread.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            pc.monte_carlo(long, samples=2_000_000, keep_samples=False)
    finally:
        done.set()
        for thread in threads:
            thread.join()
    assert len(ticks) > 20, "another thread ran meanwhile"
