# %% [markdown]
# # The paper in ten minutes
#
# Sun, Colombo, Trisolini & Li (2022) ask how the uncertainty of a satellite's orbit evolves under solar radiation pressure and Earth's
# oblateness. The orbit is two numbers: the solar angle φ, between perigee and the direction away from the Sun, and the eccentricity e. They compare
# Monte Carlo, the density evolution equation along characteristics (DEE), and a Gaussian mixture moved by the unscented transform (GMM-UT).
#
# Here the same scenario is solved exactly, then by the methods as the paper printed them and as they are corrected.

# %%
import numpy as np
import phasecloud as pc
from phasecloud.plots import COLOURS, show_or_save

# Scenario 1 (Table 1): a satellite at 2.5 Earth radii with a large area-to-mass ratio; re-entry at e = 0.6.
scenario = pc.Scenario(
    "scenario-1",
    orbit={"radiation": 0.15, "oblateness": 0.40921},  # C and W of Eq. 1
    initial={"phi": 2.2069, "e": 0.145, "delta_phi": 0.3927, "delta_e": 0.05},  # two standard deviations each
    times={"at": [0.0, 0.5, 1.0, 1.5, 2.0]},  # years
    disposal={"critical_e": 0.6},
)

# %% [markdown]
# ## The exact answer
#
# The flow preserves a known measure, so the density at any time is the initial one, looked up along orbits that run backwards. Moments are
# integrals of it by quadrature, and the error of each is known.

# %%
exact = pc.exact(scenario)
for k, t in enumerate(exact.times):
    mean, deviation = exact.quantities["mean_e"][k], exact.quantities["std_e"][k]
    print(f"t = {t:g} yr: e = {mean:.5f} ± {deviation:.5f}; moments known to {exact.diagnostics['moment_error_sigmas'][k]:.0e} sigma")

# %% [markdown]
# ## The paper's methods, as printed and corrected
#
# As printed, DEE leaves out the Jacobian of the coordinates and meshes the final points; GMM-UT splits along e alone. DEE here has 961
# characteristics, as the paper's smaller case.

# %%
methods = {
    "Monte Carlo": pc.monte_carlo(scenario, samples=100_000, seed=1),
    "DEE-961 as printed": pc.dee(scenario, samples=961, mode="as-printed", resolution=1000),
    "DEE-961 corrected": pc.dee(scenario, samples=961),
    "GMM-UT as printed": pc.gmm_ut(scenario, mode="as-printed"),
    "GMM-UT corrected": pc.gmm_ut(scenario),
}
for name, method in methods.items():
    error = np.abs(method.quantities["std_e"] / exact.quantities["std_e"] - 1.0)
    print(f"{name}: the deviation of e is off by up to {100 * error.max():.2g} %")

# %% [markdown]
# ## Where the cloud goes
#
# Above, the exact density at each time: the cloud swings up past the critical eccentricity within a year. Below, how far each method's
# density is off, as the probability that lies in the wrong place (total variation).

# %%
import matplotlib.pyplot as plt

figure, axes = plt.subplot_mosaic([["0", "1", "2", "3", "4"], ["errors"] * 5], figsize=(15, 7), layout="constrained")
for k, snapshot in enumerate(exact.snapshots):
    snapshot.joint.plot(axes[str(k)])
for number, (name, method) in enumerate(methods.items()):
    wrong = [
        0.5 * np.abs(mine.joint.values - theirs.joint.values).sum() / theirs.joint.values.sum()
        for mine, theirs in zip(method.snapshots, exact.snapshots)
    ]
    axes["errors"].semilogy(exact.times, wrong, "o-", color=COLOURS[number], label=name)
axes["errors"].set(xlabel="time t [yr]", ylabel="probability in the wrong place")
axes["errors"].legend(ncols=3)
show_or_save(figure, "paper.png")
