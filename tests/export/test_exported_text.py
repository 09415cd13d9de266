"""The C that is written: what is left out, names, units, sources, and how it can be varied."""

import math
from pathlib import Path

import numpy as np
import pytest

from hydroservo import Loop, Simulation
from hydroservo.control.controllers import PI, TSMC, Saturation
from hydroservo.core.errors import LoopError, ParameterError
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.texts import WIDTH, comment
from hydroservo.export.unit import CModule, Part, Precision
from hydroservo.language.names import identifier, is_identifier, snake
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example
from tests.support.export.small_laws import NAMED, law
from tests.support.needs import needs
from tools.targets.host import library


def run(unit: CModule, rows: np.ndarray, folder: Path) -> np.ndarray:
    """The states after each row, by a library of its own: one that is loaded must not be written again."""
    own = folder / f"{unit.real}{unit.inlined}"
    own.mkdir()
    return library(unit, own).run(rows)


def test_what_nobody_reads_is_left_out(tmp_path: Path) -> None:
    loop = law(tmp_path, "spare = r.second_rate * y.position\nreturn LawState(self.gain * y.velocity, 0.0)")
    unit = exported_unit(loop, Part.CONTROLLER, **NAMED)
    assert [one.path for one in unit.parameters] == ["controller.gain", "simulation.period"]
    assert [one.path for argument in unit.arguments for one in argument.signals] == ["measurement.velocity"]
    assert [one.path for one in unit.states] == ["controller.u", "controller.beside"]
    for name in ("unused", "spare", "second_rate", "position"):
        assert name not in unit.source.partition("*/")[2]


def test_names_units_and_sources_are_there() -> None:
    unit = exported_unit(
        load_scenario("paper/sine-tsmc"), Part.CONTROLLER, prefix="tsmc", title="the paper's law"
    )
    for text in (unit.header, unit.source):
        assert text.startswith("/*\n * the paper's law\n")
        assert f"scenario with hash {unit.hash}" in text
        assert f"hydroservo {unit.version}" in text
        assert max(map(len, text.splitlines())) <= WIDTH
    assert "double linear_gain_1; /* [1/s] gain mu_1 */" in " ".join(unit.header.split())
    assert ".linear_gain_1 = 10000.0, /* [1/s] */" in unit.source
    assert "eqs. (19)-(22) of doi:10.1007/s42401-021-00087-w" in unit.source
    for name in ("xi2", "acceleration", "drift"):
        assert f"const double {name} = " in " ".join(unit.source.split())


def test_tunable_and_fixed_parameters() -> None:
    unit = exported_unit(
        load_scenario("rig/excavator-link"), Part.MACHINE, prefix="machine", title="a machine"
    )
    fixed = {one.path: one.fixed for one in unit.parameters}
    assert fixed["plant.start_position"]
    assert fixed["simulation.period"]
    assert not fixed["plant.area_a"]
    assert "simulation.seed" in fixed
    assert not any(path.startswith(("controller", "nominal", "reference")) for path in fixed)
    ranges = {one.path: (one.least, one.most) for one in unit.parameters}
    assert ranges["simulation.seed"] == (0.0, math.nextafter(2.0**53, 0.0))
    assert ranges["plant.area_a"] == (math.nextafter(0.0, 1.0), math.inf)


def test_parameters_can_be_part_of_the_source(tmp_path: Path) -> None:
    needs("gcc")
    loop = example(Loop, Simulation(1.0, 1e-3, record_period=1e-3), controller=example(PI))
    rows = np.array([[0.1, 1.0, 0.3], [0.2, 0.5, -0.4]])
    units = [exported_unit(loop, Part.CONTROLLER, **NAMED, inlined=inlined) for inlined in (False, True)]
    found = [
        library(unit, tmp_path).run(rows[:, : sum(len(a.signals) for a in unit.arguments)]) for unit in units
    ]
    assert np.array_equal(*found)
    assert "parameters" not in units[1].header
    assert units[1].inlined


def test_single_precision_is_near(tmp_path: Path) -> None:
    needs("gcc")
    loop = load_scenario("paper/sine-tsmc")
    draw = np.random.default_rng(0)
    units = {p: exported_unit(loop, Part.CONTROLLER, **NAMED, precision=p) for p in Precision}
    assert "double" not in units[Precision.SINGLE].source.partition("*/")[2].replace("double-", "")
    names = [one.path for argument in units[Precision.SINGLE].arguments for one in argument.signals]
    size = {"measurement.velocity": 1e-5, "measurement.hydraulic_force": 100.0, "measurement.command": 0.5}
    rows = draw.normal(size=(50, len(names))) * [size.get(name, 1e-5) for name in names]
    found = {p: run(unit, rows, tmp_path) for p, unit in units.items()}
    single, double = found[Precision.SINGLE], found[Precision.DOUBLE]
    assert single.dtype == np.float32
    assert np.allclose(single, double, rtol=1e-3, atol=1e-3 * np.nanmax(np.abs(double), axis=0))
    assert not np.array_equal(single, double)


@pytest.mark.parametrize("part", [Part.MACHINE, Part.LOOP])
def test_single_precision_is_for_controllers(part: Part) -> None:
    with pytest.raises(LoopError, match="in double precision only"):
        exported_unit(example(Loop), part, **NAMED, precision=Precision.SINGLE)


def test_a_number_beyond_single_precision_is_refused() -> None:
    loop = example(
        Loop, Simulation(1.0, 1e-3, record_period=1e-3), controller=example(PI, saturation=Saturation(1e300))
    )
    with pytest.raises(LoopError, match="1e\\+300 is out of the range of single precision"):
        exported_unit(loop, Part.CONTROLLER, **NAMED, precision=Precision.SINGLE)


@pytest.mark.parametrize("prefix", ["", "2law", "a-law", "double", "a law", "größe", "law;"])
def test_a_prefix_is_a_name_of_c(prefix: str) -> None:
    assert not is_identifier(prefix)
    with pytest.raises(ParameterError, match="prefix"):
        exported_unit(example(Loop), Part.CONTROLLER, prefix=prefix, title="")


@pytest.mark.slow
@pytest.mark.parametrize("prefix", ["pi", "tsmc", "ops", "loop", "state", "saturation", "law_init"])
def test_any_prefix_goes_with_any_block(prefix: str, tmp_path: Path) -> None:
    needs("gcc")
    for part in Part:
        loop = example(Loop, Simulation(1.0, 1e-3, record_period=1e-3), controller=example(TSMC))
        folder = tmp_path / part
        folder.mkdir()
        library(exported_unit(loop, part, prefix=prefix, title="a law"), folder)


def test_the_same_loop_gives_the_same_text() -> None:
    loop = load_scenario("rig/encoder-tsmc-sine")
    first, second = (exported_unit(loop, Part.LOOP, **NAMED) for _ in range(2))
    assert first == second


def test_names() -> None:
    assert snake("TSMObserverState") == "tsm_observer_state"
    assert snake("PI") == "pi"
    assert snake("FilteredDerivative") == "filtered_derivative"
    assert identifier("switch") == "switch_"
    assert identifier("xi1") == "xi1"


def test_comments_cannot_end_early() -> None:
    assert comment("a */ b").count("*/") == 1
    assert comment("see ``x`` in :func:`~hydroservo.simulate`::") == "/* see x in hydroservo.simulate: */\n"
