"""Exports that several files of tests share: FMUs of the small units, and the paper's PI in C."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from hydroservo.control.loop import Loop
from hydroservo.export.fmu import FmiVersion
from hydroservo.export.unit import CModule, Precision
from hydroservo.export.vectors import Vectors
from tests.support.export.fmus import Instance, mass, unpacked
from tests.support.export.projects import scenario, unit
from tests.support.export.toy import toy


@pytest.fixture(scope="module", params=FmiVersion, ids=lambda version: version.name)
def version(request: pytest.FixtureRequest) -> FmiVersion:
    return request.param


@pytest.fixture(scope="module")
def pi(version: FmiVersion, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return unpacked(toy(), version, tmp_path_factory.mktemp("pi"))


@pytest.fixture(scope="module")
def machine(version: FmiVersion, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return unpacked(mass(), version, tmp_path_factory.mktemp("mass"))


@pytest.fixture
def one(pi: Path) -> Iterator[Instance]:
    with Instance(pi) as instance:
        yield instance


@pytest.fixture(scope="module")
def loop() -> Loop:
    return scenario()


@pytest.fixture(scope="module")
def law(loop: Loop) -> tuple[CModule, Vectors]:
    return unit(loop)


@pytest.fixture(scope="module")
def single(loop: Loop) -> tuple[CModule, Vectors]:
    return unit(loop, precision=Precision.SINGLE)
