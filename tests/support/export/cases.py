"""What is exported for the tools of its users: parts of built-in scenarios, in both precisions."""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import CModule, Part, Precision
from hydroservo.export.vectors import Vectors, make_vectors
from hydroservo.scenario import load_scenario
from tools.targets.boards import BOARDS
from tools.targets.sources import Rows, width

COMPILERS = ("gcc", "clang")


class Case(NamedTuple):
    """What is exported."""

    scenario: str
    part: Part = Part.CONTROLLER
    precision: Precision = Precision.DOUBLE
    inlined: bool = False


CASES = (
    Case("paper/sine-pi"),
    Case("paper/sine-backstepping"),
    Case("paper/sine-tsmc"),
    Case("paper/sine-tsmc", precision=Precision.SINGLE),
    Case("paper/sine-tsmc", inlined=True),
    Case("paper/sine-tsmc", Part.LOOP),
    Case("rig/noisy-1khz-tsmc-sine"),
    Case("rig/noisy-1khz-tsmc-sine", Part.MACHINE),
    Case("rig/excavator-link"),
    Case("rig/excavator-link", precision=Precision.SINGLE),
    Case("rig/excavator-link", Part.MACHINE),
    Case("rig/excavator-link", Part.EQUATIONS),
    Case("rig/excavator-link", Part.LOOP, inlined=True),
)
SINGLE = [case for case in CASES if case.precision is Precision.SINGLE]
CONTROLLERS = [case for case in CASES if case.part is Part.CONTROLLER]


def named(case: Case) -> str:
    return f"{case.scenario}-{case.part}-{case.precision}{'-inlined' if case.inlined else ''}"


each_case = pytest.mark.parametrize("case", CASES, ids=named)
each_board = pytest.mark.parametrize("board", BOARDS, ids=[board.name for board in BOARDS])
each_controller = pytest.mark.parametrize("case", CONTROLLERS, ids=named)


@cache
def unit_of(case: Case) -> CModule:
    loop = load_scenario(case.scenario)
    return exported_unit(
        loop, case.part, prefix="unit", title=case.scenario, precision=case.precision, inlined=case.inlined
    )


@cache
def vectors_of(case: Case) -> Vectors:
    return make_vectors(load_scenario(case.scenario), case.part, unit_of(case))


def rows_of(unit: CModule, count: int = 1000) -> Rows:
    """Ordinary numbers, as small as velocities are."""
    return np.random.default_rng(0).normal(0.0, 0.02, (count, width(unit)))


def limit_of(unit: CModule) -> float:
    """The largest command [V]: of all limits that it goes through the least."""
    return min(signal.value for signal in unit.parameters if signal.path.endswith("saturation.limit"))
