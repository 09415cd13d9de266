"""Sustained oscillation of loops whose limit cycle is known in closed form, and of loops that settle."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from hydroservo import load_scenario, ops, simulate, simulate_batch
from hydroservo.control.loop import Loop
from hydroservo.control.references import Step
from hydroservo.core.block import Block, replace
from hydroservo.linear import bode
from hydroservo.machine.loads import Constant
from tests.support.brink import at_the_brink

AXIS = "examples/axis.toml"
LEVEL = 1.0  # [V]


class RelayState(NamedTuple):
    u: float


class Relay(NamedTuple):
    """u = LEVEL sign(r - y)."""

    def init(self) -> RelayState:
        return RelayState(0.0)

    def step(self, s: RelayState, y: Block, r: Block, dt: float) -> RelayState:
        return RelayState(LEVEL * ops.sign(r.value - y.velocity))


def relay_loop() -> Loop:
    """A relay on the velocity of an axis, sampled fast enough to be taken for continuous."""
    damped = {"plant.internal_leakage": 1e-11, "plant.friction.coefficient": 0.0}
    loop = replace(load_scenario(AXIS), damped)
    simulation = loop.simulation._replace(period=1e-4, duration=1.0, record_period=1e-4)
    loop = loop._replace(load=Constant(0.0))
    return loop._replace(simulation=simulation, reference=Step(initial=0.0, final=1e-5), controller=Relay())


def test_a_relay_loop_oscillates_as_its_describing_function_says() -> None:
    """Gelb, Vander Velde, 1968: where the machine's phase is -180 degrees, with 4 LEVEL/pi of its gain."""
    loop = relay_loop()
    pi = loop._replace(controller=load_scenario(AXIS).controller)
    curve = bode(pi, measure=False, band=(20.0, 200.0))["machine"]
    crossing = int(np.argmin(np.abs(curve.values / np.abs(curve.values) + 1.0)))
    frequency, gain = float(curve["frequency"][crossing]), float(np.abs(curve.values[crossing]))
    run = simulate(loop)
    assert float(run["oscillation_frequency"]) == pytest.approx(frequency, rel=0.02)
    assert float(run["oscillation_command"]) == pytest.approx(math.sqrt(2.0) * LEVEL, rel=0.05)
    assert float(run["oscillation_amplitude"]) == pytest.approx(4.0 * LEVEL / math.pi * gain, rel=0.1)


@pytest.mark.parametrize("name", ["cases/soft-axis", "rig/1khz-pi-sine", "cases/encoder", "cases/dead-band"])
def test_loops_that_settle_do_not_oscillate(name: str) -> None:
    assert float(simulate(load_scenario(name))["oscillation_command"]) == 0.0


def test_the_crane_hunts() -> None:
    """By a run of 40 s: the command's line at 8.6 Hz has 99.9 % of the power beside demand and load."""
    run = simulate(at_the_brink("axis/crane"))
    assert float(run["oscillation_frequency"]) == pytest.approx(8.625, rel=0.02)
    assert float(run["oscillation_command"]) == pytest.approx(0.559, rel=0.02)


@pytest.mark.slow  # some ten seconds
def test_batches_and_single_runs_have_the_same_numbers() -> None:
    loop = at_the_brink("axis/crane")
    payloads = np.array([0.0, 5.0, 10.0])
    batch = simulate_batch(loop, {"plant.mechanism.payload": payloads})
    for i, payload in enumerate(payloads.tolist()):
        run = simulate(replace(loop, {"plant.mechanism.payload": payload}))
        for metric in ("oscillation_amplitude", "oscillation_command", "oscillation_frequency"):
            np.testing.assert_allclose(batch[metric].values[i], run[metric].values, rtol=1e-9)
