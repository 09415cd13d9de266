"""A workbench for servo-hydraulic axes: ``import hydroservo as hs``.

What it offers is imported when it is first asked for, so that the package itself is there at once.
"""

import sys

_HOMES = {  # what is offered, and the module that it comes from; none for a package of blocks
    "AUTO": "loop",
    "Aim": "runs.aims",
    "Field": "field",
    "HydroservoError": "errors",
    "HydroservoWarning": "errors",
    "Loop": "loop",
    "LoopError": "errors",
    "ParameterError": "errors",
    "ScenarioError": "errors",
    "Simulation": "loop",
    "__version__": "_version",
    "audit": "audits.audited",
    "bode": "linear.bode",
    "controlled": "",
    "controllers": "",
    "differences": "runs.conditions",
    "draws": "scenario.sampling",
    "drives": "",
    "export_c": "export.products",
    "export_fmu": "export.products",
    "holds": "",
    "identify": "identification.identified",
    "integrators": "",
    "load_scenario": "scenario",
    "limit": "limits",
    "linear": "",
    "linearize": "linear.linearize",
    "loads": "",
    "map_logs": "identification.maps",
    "mechanics": "",
    "metrics_of": "runs.results",
    "monitors": "",
    "observers": "",
    "oils": "",
    "ops": "",
    "plants": "",
    "plot": "plotting",
    "pulls": "",
    "references": "",
    "relative": "scenario.ranges",
    "replace": "block",
    "run_of": "scenario.sampling",
    "save": "runs.results",
    "scenarios": "scenario",
    "sensors": "",
    "simulate": "runs.run",
    "simulate_batch": "runs.batch",
    "starts": "",
    "study": "studies.running",
    "supplies": "",
    "tune": "scenario.tuning",
    "valves": "",
    "winners": "runs.conditions",
}
__all__ = list(_HOMES)

TYPE_CHECKING = False  # as typing has it, which takes longer to import than all the rest here
if TYPE_CHECKING:  # the same once more, for those who read types; a test compares the two
    from hydroservo import controlled as controlled
    from hydroservo import controllers as controllers
    from hydroservo import drives as drives
    from hydroservo import holds as holds
    from hydroservo import integrators as integrators
    from hydroservo import linear as linear
    from hydroservo import loads as loads
    from hydroservo import mechanics as mechanics
    from hydroservo import monitors as monitors
    from hydroservo import observers as observers
    from hydroservo import oils as oils
    from hydroservo import ops as ops
    from hydroservo import plants as plants
    from hydroservo import pulls as pulls
    from hydroservo import references as references
    from hydroservo import sensors as sensors
    from hydroservo import starts as starts
    from hydroservo import supplies as supplies
    from hydroservo import valves as valves
    from hydroservo._version import __version__ as __version__
    from hydroservo.audits.audited import audit as audit
    from hydroservo.block import replace as replace
    from hydroservo.errors import HydroservoError as HydroservoError
    from hydroservo.errors import HydroservoWarning as HydroservoWarning
    from hydroservo.errors import LoopError as LoopError
    from hydroservo.errors import ParameterError as ParameterError
    from hydroservo.errors import ScenarioError as ScenarioError
    from hydroservo.export.products import export_c as export_c
    from hydroservo.export.products import export_fmu as export_fmu
    from hydroservo.field import Field as Field
    from hydroservo.identification.identified import identify as identify
    from hydroservo.identification.maps import map_logs as map_logs
    from hydroservo.limits import limit as limit
    from hydroservo.linear.bode import bode as bode
    from hydroservo.linear.linearize import linearize as linearize
    from hydroservo.loop import AUTO as AUTO
    from hydroservo.loop import Loop as Loop
    from hydroservo.loop import Simulation as Simulation
    from hydroservo.plotting import plot as plot
    from hydroservo.runs.aims import Aim as Aim
    from hydroservo.runs.batch import simulate_batch as simulate_batch
    from hydroservo.runs.conditions import differences as differences
    from hydroservo.runs.conditions import winners as winners
    from hydroservo.runs.results import metrics_of as metrics_of
    from hydroservo.runs.results import save as save
    from hydroservo.runs.run import simulate as simulate
    from hydroservo.scenario import load_scenario as load_scenario
    from hydroservo.scenario import scenarios as scenarios
    from hydroservo.scenario.ranges import relative as relative
    from hydroservo.scenario.sampling import draws as draws
    from hydroservo.scenario.sampling import run_of as run_of
    from hydroservo.scenario.tuning import tune as tune
    from hydroservo.studies.running import study as study


def __getattr__(name: str) -> object:
    """What the package offers, imported when it is first asked for."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    home = _HOMES[name]
    return getattr(import_module(f"{__name__}.{home}"), name) if home else import_module(f"{__name__}.{name}")


def __dir__() -> list[str]:
    return __all__


def _show_in_notebooks() -> None:
    """Where IPython runs, results are shown there as ``hydroservo.notebook`` has them."""
    from importlib import import_module

    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    if shell is not None:
        import_module(f"{__name__}.notebook.display").show_results_in(shell)


_show_in_notebooks()
