"""phasecloud: how the uncertainty of a satellite's orbit evolves over years.

    import phasecloud as pc

    scenario = pc.Scenario.from_file("my-satellite.toml")
    exact = pc.exact(scenario)                     # moments, densities and the first-passage curve, each with its error
    cloud = pc.monte_carlo(scenario, samples=100_000)
    results = pc.run("launch.toml")                # a run of the command, with a process for each case
    results.plot_density("mc", 2)

Times are in years, angles in radians, probability densities in the inverse of the product of the units of their variables. An array of orbits
has one row for each variable of the scenario's model and one column for each orbit.

Modules: `phasecloud.kit`, to write a propagator that takes part in runs; everything else is in this namespace.
"""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .density import Density
    from .errors import InputError, LostOrbit, Refused, RunFailed
    from .evolution import Evolution, FirstPassage, Snapshot
    from .methods import dee, exact, first_passage, gmm_ut, monte_carlo, quasi_monte_carlo
    from .orbits import FlowMap, flow_map, propagate
    from .program import command
    from .results import Results
    from .runs import run
    from .scenario import Scenario, Variable

# Everything is imported when it is first used: a propagator that needs the kit alone does not wait for the rest.
_HOMES = {
    "density": ["Density"],
    "errors": ["InputError", "LostOrbit", "Refused", "RunFailed"],
    "evolution": ["Evolution", "FirstPassage", "Snapshot"],
    "methods": ["dee", "exact", "first_passage", "gmm_ut", "monte_carlo", "quasi_monte_carlo"],
    "orbits": ["FlowMap", "flow_map", "propagate"],
    "program": ["command"],
    "results": ["Results"],
    "runs": ["run"],
    "scenario": ["Scenario", "Variable"],
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = sorted(_HOME_OF)


def __getattr__(name):
    if name == "__version__":
        from importlib.metadata import version

        return version("phasecloud")
    if name in _HOME_OF:
        return getattr(_import_module(f".{_HOME_OF[name]}", __name__), name)
    raise AttributeError(f"module 'phasecloud' has no attribute {name!r}")


def __dir__():
    return [*globals(), *__all__, "__version__"]
