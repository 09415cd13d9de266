"""Verdicts on right and wrong models of machines that the package did not simulate itself."""

from typing import NamedTuple

import numpy as np
import pytest

import hydroservo as hs
from hydroservo.limits.command import Playback
from tests.support.independent_machines import (
    PERIOD,
    SPANS,
    excitation,
    measured,
    numbers_of,
    scenario,
    simulated,
)
from tests.support.tiers import mostly

WIDE = "-40%..+70%"
LOGS, SECONDS = 2, 1.2
AGREEMENT = 1e-5  # of a signal's span: a fiftieth of the least noise
FAR = 2.0  # half-widths of a 95 % interval: one truth in ten thousand lies beyond


class Case(NamedTuple):
    """A machine, what is measured and sought of it, and what a wrong model of it leaves out.

    Attributes:
        machine: its scenario.
        signals: that are measured.
        sought: numbers of the right model and of the wrong one.
        effect: the number of the effect that the wrong model lacks.
        name: of the effect, as it must be named first or among those alike.
    """

    machine: str
    signals: tuple[str, ...]
    sought: tuple[str, ...]
    effect: str
    name: str


POSITION = ("position", "pressure_a", "pressure_b")
OIL = "plant.oil.liquid_bulk_modulus"
CASES = [
    Case(
        "overlap",
        POSITION,
        ("plant.mechanism.mass", "valve.time_constant", "valve.gain", "plant.internal_leakage"),
        "valve.orifice.lap",
        "valve overlap",
    ),
    Case(
        "hysteresis",
        ("velocity", "hydraulic_force"),
        ("plant.mechanism.mass", "plant.mechanism.stiffness", OIL, "valve.natural_frequency"),
        "valve.hysteresis",
        "valve hysteresis",
    ),
    Case(
        "pump",
        POSITION,
        ("plant.mechanism.mass", OIL, "plant.friction.coefficient", "drive.inertia"),
        "drive.leakage",
        "leakage",
    ),
]


@pytest.mark.parametrize("machine", ["overlap", "hysteresis", "pump", "friction"])
def test_the_engine_agrees_with_equations_solved_apart(machine: str) -> None:
    samples = 200
    exact = simulated(numbers_of(machine, {}), excitation(1, samples * PERIOD, np.random.default_rng(1)))
    loop = hs.load_scenario(scenario(machine), {"simulation.duration": (samples - 1) * PERIOD})
    run = hs.simulate(loop._replace(controller=Playback(np.ascontiguousarray(exact["command"][:, 0]))))
    for name in SPANS.keys() & {"position", "velocity", "pressure_a", "pressure_b"}:
        np.testing.assert_allclose(run[f"plant.{name}"], exact[name][:, 0], atol=AGREEMENT * SPANS[name])


@pytest.mark.slow
@pytest.mark.parametrize(
    "case", mostly(pytest.mark.nightly, CASES, CASES[:2]), ids=[case.machine for case in CASES]
)
def test_right_models_fit_and_wrong_ones_do_not(case: Case) -> None:
    truth = numbers_of(case.machine, {})
    for log in measured(case.machine, case.signals, LOGS, SECONDS, seed=1):
        right = hs.identify(
            scenario(case.machine), log, dict.fromkeys((*case.sought, case.effect), WIDE), threads=1
        )
        assert right.fits
        told = {path: one for path, one in right.parameters.items() if one.identifiable}
        assert told
        for path, one in told.items():
            assert abs(truth[path] - one.value) < 0.5 * FAR * (one.high - one.low)
        wrong = hs.identify(
            scenario(case.machine),
            log,
            dict.fromkeys(case.sought, WIDE),
            changes={case.effect: 0.0},
            threads=1,
        )
        assert not wrong.fits
        assert case.name in [one.name for one in wrong.effects if one.alike or one is wrong.effects[0]]


@pytest.mark.slow
def test_right_models_fit_logs_in_motion_and_with_gaps() -> None:
    (log,) = measured("overlap", POSITION, 1, SECONDS, seed=2, skipped=0.7)
    kept = np.ones(log["time"].size, dtype=bool)
    kept[800:830] = False
    broken = {name: values[kept] for name, values in log.items()}
    ranges = dict.fromkeys((*CASES[0].sought, CASES[0].effect), WIDE)
    for one in (log, broken):
        assert hs.identify(scenario("overlap"), one, ranges, threads=1).fits


@pytest.mark.slow
def test_a_number_at_an_end_of_its_range_is_not_told() -> None:
    path = "plant.mechanism.mass"
    (log,) = measured("overlap", POSITION, 1, SECONDS, seed=2)
    free = hs.identify(scenario("overlap"), log, {path: "150..250 kg"}, threads=1).parameters[path]
    assert free.identifiable
    most = 0.5 * (free.low + free.value)
    found = hs.identify(scenario("overlap"), log, {path: (150.0, most)}, threads=1)
    assert found.fits
    assert found.parameters[path].at_end
    assert not found.parameters[path].identifiable
    found = hs.identify(scenario("overlap"), log, {path: "150..180 kg"}, threads=1)
    assert f"{path} beyond its range" in [one.name for one in found.effects]
