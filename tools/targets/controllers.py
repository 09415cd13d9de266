"""The controllers whose cost is shown: every law, and those of built-in scenarios, each combination once."""

from hydroservo import Loop, Simulation
from hydroservo.scenario import load_scenario, scenarios
from hydroservo.testing.examples import example
from hydroservo.testing.loops import signal_for
from tools.targets.laws import LAWS, types_in

PERIOD = 1e-4  # s, of the laws' loops


def controllers() -> dict[str, Loop]:
    """Loops by the names of their laws, then by those of their scenarios."""
    short = Simulation(period=PERIOD)
    laws = {
        name: example(Loop, short, controller=law, controls=signal_for(law)) for name, law in LAWS.items()
    }
    found: dict[tuple[type, ...], tuple[str, Loop]] = {}
    for name in sorted(scenarios(), key=lambda name: name.startswith(("cases/", "laws/"))):  # last
        loop = load_scenario(name)
        found.setdefault(tuple(types_in(loop.controller)), (name, loop))
    return laws | dict(found.values())
