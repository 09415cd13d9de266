"""Rates and demands asked for from outside of a run: compiled, with the bits of plain Python."""

from typing import NamedTuple

import numpy as np
import pytest

from hydroservo import load_scenario
from hydroservo.control.references import Ramp
from hydroservo.core.block import values
from hydroservo.core.roles import Reference, role
from hydroservo.core.signals import Demand
from hydroservo.core.states import filled
from hydroservo.runs.evaluation import FIRST, demand_values, machine_rates, row_function
from hydroservo.runs.run import runnable_loop

MACHINES = ("paper/sine-tsmc", "axis/position", "axis/pump-controlled")


class Given(NamedTuple):
    x: float


class Answer(NamedTuple):
    y: float


class Guarded(NamedTuple):
    """It raises below zero."""

    factor: float

    def row(self, given: Given) -> Answer:
        if given.x < 0.0:
            raise ValueError("below zero")
        return Answer(self.factor * given.x)


class Printing(NamedTuple):
    """It does what compiled code cannot."""

    def row(self, given: Given) -> Answer:
        return Answer(float(f"{given.x}"))


@role(Reference)
class Late(NamedTuple):
    """A demand that raises after a second."""

    def at(self, t: float) -> Demand:
        if t > 1.0:
            raise ArithmeticError
        return Demand(t, 1.0, 0.0)


@pytest.mark.parametrize("name", MACHINES)
def test_rates_are_those_of_plain_python(name: str) -> None:
    loop = runnable_loop(load_scenario(name))
    start = loop.machine(loop.init())
    move = machine_rates([loop], start)
    size = np.maximum(np.abs(values(start)), 1e-3)
    states = np.array(values(start)) + size * np.random.default_rng(1).normal(size=(20, size.size))
    found = move(states[np.newaxis], np.array([[0.7, 300.0]]), FIRST)[0]
    assert found.shape == states.shape
    for state, row in zip(states, found, strict=True):
        assert values(loop.rates(filled(start, iter(state.tolist())), 0.7, 300.0)) == row.tolist()


def test_one_machine_has_one_kernel_whatever_its_law(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("HYDROSERVO_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr("hydroservo.engine.native.READY", {})
    for name in ("paper/sine-tsmc", "paper/sine-pi"):
        loop = runnable_loop(load_scenario(name))
        machine_rates([loop], loop.machine(loop.init()))
    assert len([*tmp_path.glob("*")]) == 1


def test_a_row_of_which_a_block_raises_is_nan() -> None:
    ask = row_function([Guarded(2.0)], Given(0.0), Answer(0.0))
    assert ask(np.array([[[1.0], [3.0]]]), FIRST).tolist() == [[[2.0], [6.0]]]
    found = ask(np.array([[[1.0], [-1.0], [3.0]]]), FIRST)
    assert np.array_equal(found, [[[2.0], [np.nan], [6.0]]], equal_nan=True)


def test_blocks_answer_to_rows_of_their_own() -> None:
    ask = row_function([Guarded(factor) for factor in (2.0, 3.0, 5.0)], Given(0.0), Answer(0.0))
    rows = np.array([[[1.0], [3.0]], [[-1.0], [2.0]], [[4.0], [1.0]]])
    assert np.array_equal(ask(rows, np.arange(3)).ravel(), [2.0, 6.0, np.nan, 6.0, 20.0, 5.0], equal_nan=True)
    assert ask(rows[[2, 0]], np.array([1, 2])).ravel().tolist() == [12.0, 3.0, 5.0, 15.0]


def test_what_cannot_be_compiled_is_interpreted() -> None:
    ask = row_function([Printing()], Given(0.0), Answer(0.0))
    assert ask(np.array([[[1.5], [2.5]]]), FIRST).tolist() == [[[1.5], [2.5]]]


def test_demands_are_those_of_plain_python() -> None:
    times = np.linspace(0.0, 3.0, 50)
    reference = Ramp(initial=0.05, final=0.25, rate=0.15, time=0.2)
    assert demand_values(reference, times).tolist() == [reference.at(t).value for t in times.tolist()]
    assert np.array_equal(demand_values(Late(), np.array([0.5, 2.0])), [0.5, np.nan], equal_nan=True)
