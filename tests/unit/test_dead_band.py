"""Compensation of a valve's overlap: through a valve that overlaps the law has the gain it has without."""

from typing import Annotated, NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo import Field
from hydroservo.control.controllers import DeadBandCompensation, DeadBandJump
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.valves import FourEdges
from hydroservo.testing.examples import example

LAP, OPENING_GAIN = 2e-5, 1e-4  # [m], [m/V]
OVERLAP = LAP / OPENING_GAIN
EDGES = example(FourEdges, clearance=0.0)


class AskingState(NamedTuple):
    u: Annotated[float, Field("V", "command")]


class Asking(NamedTuple):
    """A law that asks for what the demand says."""

    def init(self) -> AskingState:
        return AskingState(0.0)

    def step(self, s: AskingState, y: Measurement, r: Demand, dt: float) -> AskingState:
        return AskingState(r.value)


def put_out(law: DeadBandCompensation | DeadBandJump, asked: float) -> float:
    rest = Measurement(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    u: float = law.step(law.init(), rest, Demand(asked, 0.0, 0.0), 1e-3).u
    return u


def flow(lap: float, u: float) -> float:
    return EDGES._replace(lap=lap).flow(OPENING_GAIN * u, 70e5, 10e5)


beyond = st.floats(0.05, 9.0).flatmap(lambda u: st.sampled_from([u, -u]))


@given(beyond)
def test_beyond_the_threshold_the_flow_is_that_without_overlap(asked: float) -> None:
    for kind in (DeadBandCompensation, DeadBandJump):
        law = kind(Asking(), OVERLAP, OVERLAP, 0.0499)
        assert flow(LAP, put_out(law, asked)) == pytest.approx(flow(0.0, asked), rel=1e-9)
        assert flow(LAP, asked) != pytest.approx(flow(0.0, asked), rel=1e-2)


@given(st.floats(-0.05, 0.05))
def test_within_it_a_continuous_one_has_a_finite_gain_and_a_jump_is_at_rest(asked: float) -> None:
    overlap = 0.4 if asked > 0.0 else 0.3
    smooth, jump = (kind(Asking(), 0.4, 0.3, 0.05) for kind in (DeadBandCompensation, DeadBandJump))
    assert put_out(smooth, asked) == pytest.approx(asked * (1.0 + overlap / 0.05), abs=1e-15)
    assert put_out(jump, asked) == 0.0


@pytest.mark.parametrize("kind", [DeadBandCompensation, DeadBandJump])
def test_each_direction_has_its_own_overlap_and_both_the_command_s_limit(kind: type) -> None:
    law = kind(Asking(), 0.4, 0.3, 0.05)
    assert [put_out(law, u) for u in (1.0, -1.0, 9.9, -20.0)] == [1.4, -1.3, 10.0, -10.0]
