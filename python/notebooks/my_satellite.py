# %% [markdown]
# # My satellite
#
# When does it re-enter, how sure is that, and how large a sail would it take? Write down your satellite and run the cells.

# %%
import numpy as np
import phasecloud as pc
from phasecloud.plots import COLOURS, show_or_save

satellite = pc.Scenario(
    "my-satellite",
    orbit={"altitude": 9567, "area_to_mass": 12.0, "reflectivity": 1.3},  # km; m²/kg, with the sail
    initial={"phi": "126 deg", "e": 0.145, "sigma_phi": "11 deg", "sigma_e": 0.025},
    times={"end": 3.0, "step": 0.5},  # yr
    disposal={"altitude": 120},  # km: the perigee at which it counts as re-entered
)
print(f"C = {satellite.parameters['radiation']:.4f}, W = {satellite.parameters['oblateness']:.4f}")
print(f"It re-enters at e = {satellite.critical:.4f}")

# %% [markdown]
# ## By when it has re-entered
#
# The exact first-passage curve, with an error estimate; no samples are involved. Monte Carlo on the same scenario is an independent check.

# %%
exact = pc.first_passage(satellite)
sampled = pc.first_passage(satellite, "mc", samples=20_000)
for year in (1.0, 2.0, 3.0):
    k = int(np.argmin(np.abs(exact.times - year)))
    print(f"by {exact.times[k]:.2f} yr: {exact.probability[k]:.4f}; sampled {sampled.low[k]:.4f} to {sampled.high[k]:.4f} (95 %)")
assert ((sampled.low - 0.01 <= exact.probability) & (exact.probability <= sampled.high + 0.01)).all()

# %% [markdown]
# ## How large a sail
#
# The same satellite with other area-to-mass ratios.

# %%
ratios = [8.0, 10.0, 12.0, 14.0, 16.0]
curves = {ratio: pc.first_passage(satellite.changed({"orbit.area_to_mass": ratio})) for ratio in ratios}
for ratio, curve in curves.items():
    print(f"{ratio:4.0f} m²/kg: {curve.probability[-1]:.4f} by {curve.times[-1]:g} yr")

# %% [markdown]
# ## Picture
#
# Left, probability of re-entry against time for each sail; right, where the satellite may be after a year.

# %%
import matplotlib.pyplot as plt

figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
for number, (ratio, curve) in enumerate(curves.items()):
    left.plot(curve.times, curve.probability, color=COLOURS[number], label=f"{ratio:g} m²/kg")
    left.fill_between(curve.times, curve.low, curve.high, color=COLOURS[number], alpha=0.2)
left.set(xlabel="time t [yr]", ylabel="probability of re-entry", ylim=(-0.02, 1.02))
left.legend(title="area to mass")
pc.exact(satellite).snapshots[2].joint.plot(right)
right.axhline(satellite.critical, color="black", linestyle="--", linewidth=1)
show_or_save(figure, "my_satellite.png")
