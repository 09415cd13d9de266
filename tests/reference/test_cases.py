"""Each scenario cases/... is what its title says, by closed forms and by what its run shows."""

import json
import math
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest

from hydroservo import load_scenario, simulate
from hydroservo.core.block import value_at
from hydroservo.linear.operating_point import operating_point
from hydroservo.linear.system import opened_variants
from hydroservo.scenario import scenarios
from tests.support.tiers import mostly

DOCS = Path(__file__).parents[2] / "docs"
FOUND = json.loads((DOCS / "cases.json").read_text("utf-8"))
REMEDIES = {  # and the most that is left of PI's error on the nominal machine
    "limits": ("pi, anti-windup", 0.7),
    "soft-axis": ("pi, pressure feedback", 0.6),
    "load-step": ("lq", 0.5),
    "dead-band": ("industrial, compensated", 0.7),
}


def test_each_case_has_its_laws() -> None:
    assert set(FOUND) == {name.removeprefix("cases/") for name in scenarios() if name.startswith("cases/")}


@pytest.mark.parametrize("case", FOUND)
def test_the_laws_of_a_case_are_complete_and_its_pi_is_that_of_its_file(case: str) -> None:
    loop = load_scenario(f"cases/{case}")
    assert all(value_at(loop, path) == value for path, value in FOUND[case]["pi"].items())
    for changes in FOUND[case].values():
        load_scenario(f"cases/{case}", changes)


@pytest.mark.parametrize("case", FOUND)
def test_the_page_has_a_row_for_each_law_of_a_case(case: str) -> None:
    page = (DOCS / "cases.md").read_text("utf-8")
    shown = page.partition(f"<!-- {case}: begin -->")[2].partition(f"<!-- {case}: end -->")[0]
    rows = [line.strip("| ").split(" | ") for line in shown.strip().splitlines()[2:]]
    assert sorted(row[0] for row in rows) == sorted(FOUND[case])


@pytest.mark.nightly  # forty runs
@pytest.mark.parametrize("law", ["pi", "industrial"])
def test_a_row_is_what_the_script_makes_of_what_it_found(law: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scripts = DOCS.parent / "scripts"
    monkeypatch.syspath_prepend(scripts)
    row = run_path(str(scripts / "cases"))["row"]("dead-band", law, FOUND["dead-band"][law])
    assert f"| {' | '.join(row)} |\n" in (DOCS / "cases.md").read_text("utf-8")


@pytest.mark.slow  # two laws each
@pytest.mark.parametrize("case", mostly(pytest.mark.nightly, REMEDIES, [*REMEDIES][:2]))
def test_a_remedy_is_worth_its_name(case: str) -> None:
    remedy, left = REMEDIES[case]
    changes = [FOUND[case][law] | {"uncertainty.scale": 0} for law in ("pi", remedy)]
    pi, other = (simulate(load_scenario(f"cases/{case}", one), record=[]) for one in changes)
    assert float(other["rms_error"]) < left * float(pi["rms_error"])


def test_the_demand_is_beyond_the_command_s_limit() -> None:
    """A valve fully open to a piston without load moves it at Cd w x sqrt(p_s/rho)/A."""
    loop = load_scenario("cases/limits", {"uncertainty.scale": 0})
    valve, orifice = loop.valve, loop.valve.orifice
    area = orifice.discharge_coefficient * orifice.area_gradient * valve.gain * loop.controller.limit
    reached = area * math.sqrt(loop.supply.supply_pressure / orifice.density) / loop.plant.piston_area
    assert 0.8 < reached / loop.reference.amplitude < 0.9
    run = simulate(load_scenario("cases/limits"))
    limited = np.abs(run["controller.u"].values) > 0.999 * loop.controller.limit
    assert 0.1 < limited.mean() < 0.5


def test_the_soft_axis_swings_slowly_and_long() -> None:
    loop = load_scenario("cases/soft-axis")
    found = opened_variants(operating_point(loop, 0.0)).loop
    rates = np.log(np.linalg.eigvals(found.a).astype(complex)) / found.period
    (pole,) = rates[rates.imag > 1.0]
    plant = loop.plant
    stiffness = 4.0 * plant.bulk_modulus * plant.piston_area**2 / plant.total_volume
    assert abs(pole) == pytest.approx(math.sqrt(stiffness / plant.mass), rel=1e-3)
    assert 10.0 < abs(pole) / (2.0 * math.pi) < 30.0
    assert -pole.real / abs(pole) < 0.05
    assert 1.0 / loop.valve.time_constant > 2.0 * math.pi * 100.0


def test_stiction_holds_the_piston_while_the_demand_goes_on() -> None:
    run = simulate(load_scenario("cases/stick-slip"))
    friction = load_scenario("cases/stick-slip").plant.friction
    asked = np.abs(run["reference.value"].values) > 1e-3
    stuck = np.abs(run["plant.velocity"].values) < 1e-4
    assert 0.01 < (asked & stuck).mean() < 0.5
    deflection = np.abs(run["plant.friction.deflection"].values).max()
    assert friction.coulomb < friction.bristle_stiffness * deflection <= friction.breakaway


def test_the_load_has_nothing_to_do_with_the_demand() -> None:
    loop = load_scenario("cases/load-step")
    run = simulate(loop)
    load = run["load.force"].values
    assert set(np.abs(load)) == {400.0}
    assert np.count_nonzero(np.diff(load)) == math.floor(2.0 * loop.simulation.duration / loop.load.period)
    assert abs(np.corrcoef(load, run["reference.value"].values)[0, 1]) < 0.2


def test_a_command_within_the_dead_band_moves_nothing() -> None:
    """Half a volt is the overlap: 0.4 V leave leakage alone, and would be half the speed of 0.8 V."""
    law = {"type": "OpenLoop"}
    moved = []
    for command in (0.4, 0.8):
        changes = {
            "controller": law,
            "controls": {"type": "Command"},
            "reference": {"type": "Step", "initial": "0 V", "final": f"{command} V", "time": "0.1 s"},
        }
        run = simulate(load_scenario("cases/dead-band", changes))
        moved.append(abs(float(run["plant.position"][-1] - run["plant.position"][0])))
    assert moved[0] < 0.2 * moved[1]


def test_the_accumulator_empties_and_halves_the_valve_s_gain() -> None:
    run = simulate(load_scenario("cases/drift"))
    pressure = run["supply.pressure"].values
    assert pressure[0] == pytest.approx(40e5, rel=0.01)
    assert np.sqrt(pressure[-1] / pressure[0]) < 0.5
    slow = pressure.reshape(-1)[::200]  # a demand's period apart
    assert (np.diff(slow) < 0.0).all()


def test_the_encoder_shows_whole_counts_and_nothing_else() -> None:
    loop = load_scenario("cases/encoder")
    assert {"hydraulic_force", "pressure_a", "pressure_b"} <= set(loop.sensors.missing())
    counts = simulate(loop)["sensors.position.value"].values / 20e-6
    assert np.allclose(counts, np.rint(counts), atol=1e-6)
