"""A law with the inverse of a measured table has the bits of Python in C and in Structured Text."""

from pathlib import Path

import numpy as np
import pytest

import hydroservo as hs
from hydroservo import Loop, Simulation
from hydroservo.control.controllers import PID, CharacteristicCompensation
from hydroservo.core.curve import Curve
from hydroservo.export import vectors
from hydroservo.testing.examples import example
from hydroservo.testing.loops import signal_for
from tests.support.characteristic_logs import stairs
from tests.support.export.agreement import same_bits
from tests.support.export.structured_text import differences, unit_of
from tests.support.needs import needs
from tools.targets.host import library


@pytest.mark.slow
def test_a_measured_table_replays_bit_for_bit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    needs("gcc")
    monkeypatch.setattr(vectors, "STRETCHES", 4)
    monkeypatch.setattr(vectors, "IN_A_ROW", 20)
    table = hs.map_logs("characteristic", stairs(0)).characteristic
    assert table is not None
    measured = Curve.from_samples(table["command"].values, table["speed"].values)
    law = CharacteristicCompensation.from_speed(example(PID), measured, 10.0, 0.1)
    loop = example(Loop, Simulation(period=1e-3, duration=1.0), controller=law, controls=signal_for(law))
    unit = unit_of(loop)
    assert differences(unit) == []
    states = library(unit.c, tmp_path).run(np.asarray(unit.vectors.inputs))
    assert same_bits(np.asarray(unit.vectors.expected), states).all()
