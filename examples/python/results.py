# %% [markdown]
# # A results folder with numpy and matplotlib
#
# Reads what `phasecloud run` wrote and redraws one figure of its report: the joint density of a case at every snapshot.
# Open it as a notebook (the cells are marked with `# %%`), or run it:
#
# ```sh
# venv/bin/python examples/python/results.py results/scenario-1-...
# ```

# %%
import csv
import json
import pathlib
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")  # drop this line in a notebook
import matplotlib.pyplot as plt

# The folder, the case and the picture to write; by default the newest folder, its reference and a file in the current folder:
# the results are sealed, and `phasecloud verify` would report an additional file in their folder.
newest = max(pathlib.Path("results").glob("*/densities.npz"), default=None, key=lambda path: path.stat().st_mtime)
folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else newest and newest.parent
if folder is None or not (folder / "manifest.json").is_file():
    sys.exit(f"{folder}: not a results folder; name one that `phasecloud run` wrote")
manifest = json.loads((folder / "manifest.json").read_text())
scenario = next(iter(manifest["scenarios"]))
method = sys.argv[2] if len(sys.argv) > 2 else manifest["reference"]
picture = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else pathlib.Path(f"{folder.resolve().name}-{method}.png")
sealed = [parent for parent in picture.resolve().parents if (parent / "manifest.json").is_file()]
if sealed:
    sys.exit(f"{picture}: that is in the results folder {sealed[0]}, whose files are sealed; name another place as third argument")

# %% [markdown]
# ## Tables
#
# Every table is a CSV file with full precision; `nan` stands where a method has no such number, or withholds it.

# %%
with open(folder / "moments.csv", newline="") as file:
    moments = [row for row in csv.DictReader(file) if (row["scenario"], row["method"]) == (scenario, method)]
if not moments:
    sys.exit(f"{folder}: no case {method} in {scenario}; there are {', '.join(manifest['cases'])}")
for row in moments:
    numbers = (float(row[name]) for name in ("t_yr", "mean_phi_rad", "std_phi_rad", "mean_e", "std_e"))
    print("t = {:g} yr: phi = {:.5f} ± {:.5f} rad, e = {:.5f} ± {:.5f}".format(*numbers))

# %% [markdown]
# ## Densities
#
# `densities.npz` has `SCENARIO/METHOD/INDEX/joint` and the edges of its bins. Each snapshot's `phi_edges` are on the
# branch that keeps its cloud whole, so the pictures need no wrapping.

# %%
densities = np.load(folder / "densities.npz")
figure, axes = plt.subplots(1, len(moments), figsize=(3.2 * len(moments), 3.0), layout="constrained")
for index, (row, axis) in enumerate(zip(moments, np.atleast_1d(axes))):
    joint, phi, e = (densities[f"{scenario}/{method}/{index}/{name}"] for name in ("joint", "phi_edges", "e_edges"))
    if np.isnan(joint).all():
        print(f"t = {row['t_yr']} yr: {method} withholds its density")
        axis.set(title=f"{method}, t = {row['t_yr']} yr: withheld")
        continue
    mass = joint.sum() * (phi[1] - phi[0]) * (e[1] - e[0])
    print(f"t = {row['t_yr']} yr: {mass:.4f} of the probability lies on the grid")
    shown = np.ma.masked_less(joint, 1e-3 * joint.max())
    mesh = axis.pcolormesh(phi, e, shown.T, cmap="viridis", rasterized=True)
    axis.set(title=f"{method}, t = {row['t_yr']} yr", xlabel="solar angle φ [rad]", ylabel="eccentricity e")
    figure.colorbar(mesh, ax=axis, label="joint density [1/rad]")
figure.savefig(picture, dpi=150)
print(f"Picture: {picture}")
