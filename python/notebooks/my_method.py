# %% [markdown]
# # My method against theirs
#
# A propagator of your own takes part in a run beside the built-in ones: the same scenario, the same grids, the same verdicts. Here it is linear
# covariance analysis, in some twenty lines: the mean moves along its orbit, and the covariance with the Jacobian of the flow.
#
# It needs `pip install '.[kit,plots]'` in the checkout of phasecloud.

# %%
import sys
import tempfile
from pathlib import Path

import numpy as np
import phasecloud as pc
from phasecloud.plots import COLOURS, show_or_save

PROPAGATOR = '''
import numpy as np
import phasecloud as pc
from phasecloud.kit import MIXTURE, serve

STEP = 1e-5  # of the central differences


def linear_covariance(problem, run):
    problem.require("planar")
    scenario = pc.Scenario(
        "mean",
        orbit=problem.parameters,
        initial={"phi": problem.mean[0], "e": problem.mean[1], "sigma_phi": 0.1, "sigma_e": 0.01},
        times={"at": problem.times},
        disposal={"critical_e": problem.critical},
    )
    starts = problem.mean[:, None] + STEP * np.array([[0, 1, -1, 0, 0], [0, 0, 0, 1, -1]])
    for phi, e in pc.propagate(scenario, starts):
        moved = np.stack([np.unwrap([phi[0], *phi])[1:], e])
        jacobian = (moved[:, 1::2] - moved[:, 2::2]) / (2 * STEP)
        covariance = jacobian @ problem.covariance @ jacobian.T
        with run.snapshot(MIXTURE, rows=1, disagreement=float("nan")) as row:
            row[:, 0] = 1.0, phi[0], e[0], covariance[0, 0], covariance[0, 1], covariance[1, 1]


serve(linear_covariance)
'''

# %% [markdown]
# ## The run
#
# A launch file as a dictionary: the exact answer is the reference, `gmm-ut` the neighbour to beat, and `mine` a command.

# %%
folder = Path(tempfile.mkdtemp(prefix="my-method-"))
(folder / "propagator.py").write_text(PROPAGATOR)
scenario = pc.Scenario(
    "scenario-1",
    orbit={"radiation": 0.15, "oblateness": 0.40921},
    initial={"phi": 2.2069, "e": 0.145, "delta_phi": 0.3927, "delta_e": 0.05},
    times={"at": [0.0, 0.5, 1.0, 1.5, 2.0]},
    disposal={"critical_e": 0.6},
)
results = pc.run(
    {
        "name": "my-method",
        "scenarios": [scenario],
        "reference": "exact",
        "propagator": [
            {"label": "exact", "node": "exact"},
            {"label": "gmm-ut", "node": "gmm-ut"},
            {"label": "mine", "command": [sys.executable, str(folder / "propagator.py")]},
        ],
    },
    out=folder / "results",
)

# %% [markdown]
# ## What each is good for
#
# Verdicts in words, against a tolerance of 1 %; then the worst error of the mean of e.

# %%
verdicts = results.columns("verdicts")
for method, verdict in zip(verdicts["method"], verdicts["verdict"]):
    print(f"{method}: {verdict}")
errors = results.columns("errors")
for method in ("gmm-ut", "mine"):
    of = (errors["method"] == method) & (errors["quantity"] == "mean_e")
    print(f"{method}: the mean of e is off by up to {np.abs(errors['abs_error'][of]).max():.1e}")

# %% [markdown]
# ## Picture
#
# A single Gaussian cannot bend: after a year the cloud does, and `mine` misplaces what the exact density shows.

# %%
import matplotlib.pyplot as plt

figure, axes = plt.subplots(1, 4, figsize=(16, 3.8), layout="constrained")
results.density("exact", 2).plot(axes[0])
results.density("mine", 2).plot(axes[1])
results.plot_difference("mine", "exact", 2, ax=axes[2])
distances = results.columns("distances")
for number, method in enumerate(("gmm-ut", "mine")):
    of = (distances["method"] == method) & (distances["density"] == "joint") & (distances["measure"] == "total_variation")
    axes[3].semilogy(distances["t_yr"][of], distances["value"][of], "o-", color=COLOURS[number + 1], label=method)
axes[3].set(xlabel="time t [yr]", ylabel="total variation from exact")
axes[3].legend()
show_or_save(figure, "my_method.png")
