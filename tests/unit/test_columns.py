"""A block's check is asked about each run, where what differs between them is what it looks at."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from hydroservo import ParameterError
from hydroservo.core.block import is_block, values
from hydroservo.runs.columns import check_runs, fields_checked

ASKED: list[Any] = []


class Limits(NamedTuple):
    low: float = 0.0
    high: float = 1.0
    name: float = 3.0

    @property
    def width(self) -> float:
        return self.high - self.low

    def least(self) -> float:
        return self.low

    def check(self) -> None:
        ASKED.append(self)
        if self.low > self.high:
            raise ParameterError("low", self.low, "must be at most high")


class ByProperty(Limits):
    def check(self) -> None:
        self.width  # noqa: B018


class ByMethod(Limits):
    def check(self) -> None:
        self.least()


class ByPlace(Limits):
    def check(self) -> None:
        self[0]


class Whole(Limits):
    def check(self) -> None:
        self._replace(low=1.0)


class Faulty(Limits):
    def check(self) -> None:
        raise ParameterError("name", self.name, "must be another")


class ByKind(Limits):
    def check(self) -> None:
        if is_block(self):
            values(self)


class ByPresence(Limits):
    def check(self) -> None:
        if hasattr(self, "width"):
            raise ParameterError("low", self.low, "must be another")


ALL = {"low", "high", "name"}


@pytest.mark.parametrize(
    ("kind", "fields"),
    [
        (Limits, {"low", "high"}),
        (ByMethod, {"low"}),
        (ByPlace, ALL),
        (Whole, ALL),
        (Faulty, ALL),
        (ByProperty, ALL),
        (ByKind, ALL),
        (ByPresence, ALL),
    ],
)
def test_what_a_check_looks_at(kind: Callable[[], Any], fields: set[str]) -> None:
    assert set(fields_checked(kind())) == fields


def test_each_run_is_asked_about_what_the_check_looks_at() -> None:
    with pytest.raises(ParameterError, match=r"^low = 2\.0: must be at most high, in run 7$"):
        check_runs(Limits(), {"low": np.array([0.0, 0.5, 2.0])}, first=5)


def test_no_run_is_asked_about_another_field() -> None:
    ASKED.clear()
    check_runs(Limits(), {"name": np.arange(1000.0)}, first=0)
    assert len(ASKED) == 1
