"""Exported loops of all blocks give the bits of plain Python."""

from pathlib import Path
from typing import get_type_hints

import numpy as np
import pytest

from hydroservo import Loop, Simulation, replace
from hydroservo.control.holds import DelayedHold
from hydroservo.control.wiring import with_model
from hydroservo.core.block import Block
from hydroservo.core.group import nested
from hydroservo.core.roles import ControlledSignal, Integrator, Monitor, Start
from hydroservo.machine.plants import DesignModel
from hydroservo.machine.starts import AsBuilt
from hydroservo.scenario.role_checks import ROLES
from hydroservo.testing.examples import example
from hydroservo.testing.loops import signal_for, with_its_machine
from tests.support.export.agreement import assert_same_run
from tests.support.roles import NOTHING, blocks, role_of
from tests.support.strategies import choices, going_together
from tests.support.tiers import mostly
from tools.targets.laws import LAWS, types_in

PERIOD = 1e-4
PERIODS = 200
LOOPS = 2 * len(LAWS)  # of different blocks


def picked(cls: type, draw: np.random.Generator) -> Block:
    """The default block of a class with a random choice for each role in it."""
    hints = get_type_hints(cls)
    inner = {}
    for name in cls._fields:
        if hints[name] in ROLES:
            found = choices(cls, hints[name])
            inner[name] = picked(found[draw.integers(len(found))], draw)
    return going_together(example(cls), inner)


def loop_of_choices(i: int) -> Loop:
    """A loop of random blocks, with each of the laws in turn."""
    simulation = Simulation(PERIODS * PERIOD, PERIOD, 2, PERIOD)
    law = with_model(list(LAWS.values())[i % len(LAWS)], example(DesignModel))  # a pump has none
    own = {"simulation": simulation, "controller": law, "controls": signal_for(law)}
    made = replace(picked(Loop, np.random.default_rng(i)), own)
    loop = with_its_machine(made)
    return replace(loop, {"hold.delay": 0.5 * PERIOD}) if isinstance(loop.hold, DelayedHold) else loop


@pytest.mark.slow
@pytest.mark.parametrize("i", mostly(pytest.mark.nightly, range(LOOPS), range(3)))
def test_loops_of_all_blocks(i: int, tmp_path: Path) -> None:
    assert_same_run(loop_of_choices(i), tmp_path, compiled=False)


@pytest.mark.slow
def test_a_loop_that_starts_with_given_states(tmp_path: Path) -> None:
    given = nested({"plant.velocity": 0.01, "controller.integral": 0.25})
    simulation = Simulation(PERIODS * PERIOD, PERIOD, 2, PERIOD)
    loop = example(Loop, simulation, controller=LAWS["PI"], start=AsBuilt(given))
    assert_same_run(loop, tmp_path, compiled=False)


def test_every_block_is_in_a_loop() -> None:
    found = {cls for i in range(LOOPS) for cls in types_in(loop_of_choices(i))}
    other = (Integrator, Monitor)  # which no C computes
    other += (ControlledSignal, Start)  # of which the loops here have one each
    assert {cls for cls in blocks() if cls.__name__ not in NOTHING and role_of(cls) not in other} <= found
