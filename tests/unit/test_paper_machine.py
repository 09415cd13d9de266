"""The paper's numbers in Python are those of its scenarios."""

import pytest

from hydroservo import Loop, Simulation
from hydroservo.core.block import replace, value_at
from hydroservo.papers.tsmc_eha_2021 import machine
from hydroservo.runs.provenance import canonical_toml
from hydroservo.scenario import load_scenario

LAWS = {"pi": machine.PROPORTIONAL_INTEGRAL, "backstepping": machine.BACKSTEPPING, "tsmc": machine.TERMINAL}


def loop_of(demand: str, law: str) -> Loop:
    return Loop(
        simulation=Simulation(duration=machine.DURATION),
        plant=machine.PLANT,
        valve=machine.VALVE,
        supply=machine.SUPPLY,
        load=machine.LOADS[demand],
        reference=machine.REFERENCES[demand],
        controller=LAWS[law],
    )


@pytest.mark.parametrize("demand", ["sine", "square"])
@pytest.mark.parametrize("law", LAWS)
def test_the_scenarios_are_the_machine_its_demands_and_its_laws(demand: str, law: str) -> None:
    nominal = load_scenario(f"paper/{demand}-{law}", {"uncertainty.scale": 0.0})
    assert canonical_toml(nominal) == canonical_toml(loop_of(demand, law))


@pytest.mark.parametrize("scale", [-1.0, 1.0])
def test_the_scenarios_have_its_uncertainty(scale: float) -> None:
    nominal = loop_of("sine", "tsmc")
    moved = {
        path: value_at(nominal, path) * (1.0 + scale * delta) for path, delta in machine.UNCERTAINTY.items()
    }
    loaded = load_scenario("paper/sine-tsmc", {"uncertainty.scale": scale})
    assert canonical_toml(loaded) == canonical_toml(replace(nominal, moved))
