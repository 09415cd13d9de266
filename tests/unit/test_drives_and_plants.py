"""Which drives go with which plants."""

import pytest

from hydroservo import Loop, ParameterError
from hydroservo.control.wiring import wired
from hydroservo.core.block import Block
from hydroservo.machine.drives import (
    Counterbalance,
    Hoses,
    LoadSensing,
    PressureCompensator,
    PumpDrive,
    ValveOnSupply,
)
from hydroservo.machine.plants import Cylinder, LoadPressurePlant
from hydroservo.machine.valves import NoValve
from hydroservo.testing.examples import example

SENSING = [example(cls) for cls in (Counterbalance, LoadSensing, PressureCompensator)]


@pytest.mark.parametrize(
    "drive", [*SENSING, example(Hoses, drive=SENSING[1])], ids=lambda one: type(one).__name__
)
def test_a_drive_that_goes_by_chambers_is_refused_where_there_are_none(drive: Block) -> None:
    loop = example(Loop, drive=drive)
    assert isinstance(loop.plant, LoadPressurePlant)
    said = f"drive = '{type(drive).__name__}': works from the pressures of two chambers, and the plant LoadP"
    with pytest.raises(ParameterError, match=said):
        wired(loop)
    wired(loop._replace(plant=example(Cylinder)))


@pytest.mark.parametrize("drive", [ValveOnSupply(), example(Hoses)])
def test_a_drive_that_does_not_goes_with_any_plant(drive: Block) -> None:
    wired(example(Loop, drive=drive))
    wired(example(Loop, drive=drive, plant=example(Cylinder)))


def test_a_pump_goes_with_any_plant() -> None:
    wired(example(Loop, valve=NoValve(), drive=example(PumpDrive)))
