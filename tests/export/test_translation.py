"""How Python becomes C: what is kept, what is left out, and what is refused with its line."""

import math
from pathlib import Path

import numpy as np
import pytest
from benchmarks.targets.host import library

from hydroservo import Loop, Simulation
from hydroservo.controllers import PI, TSMC, Saturation
from hydroservo.errors import LoopError, ParameterError
from hydroservo.export.exported import Exported, Part, Precision
from hydroservo.export.names import identifier, is_identifier, snake
from hydroservo.export.scope import TranslationError
from hydroservo.export.units import exported
from hydroservo.export.wrap import WIDTH, comment, wrapped
from hydroservo.scenario import load_plugin, load_scenario
from hydroservo.signals import Demand, Measurement
from needs import needs

HEAD = '''\
"""A law of a test."""

import math
from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Field
from hydroservo.signals import Demand, Measurement

SLOPE = 2.5
TURNS = 4
NAMES = ["u"]


class LawState(NamedTuple):
    """A command, and a number beside it."""

    u: Annotated[float, Field("V", "command")]
    beside: Annotated[float, Field("V", "number beside it")]


class Law(NamedTuple):
    """A law of a test: u = ..."""

    gain: Annotated[float, Field("V s/m", "gain of the law", "this test")] = 3.0
    unused: Annotated[float, Field("V", "read by nobody", "this test")] = 7.0
    turns: Annotated[int, Field("", "whole number", "this test", at_least=1, at_most=9)] = 2
    reverse: bool = False

    def init(self):
        return LawState(0.0, 0.0)

    def pair(self, a, b):
        return a + b, a - b

    def step(self, s, y, r, dt):
'''
FIRST = HEAD.count("\n") + 1  # the line of the first statement
NAMED = {"prefix": "law", "title": "a law"}
Y = Measurement(0.25, 100.0, 0.03, 1.5, 2e6, 1e6)
R = Demand(0.75, -2.0, 30.0)


def law(folder: Path, body: str, **changes: object) -> Loop:
    """A loop with a law whose step is this text."""
    lines = "".join(f"        {line}\n" for line in body.splitlines())
    file = folder / "law.py"
    file.write_text(HEAD + lines, encoding="utf-8")
    cls = next(one for one in load_plugin(file) if one.__name__ == "Law")
    return Loop(Simulation(1.0, 1e-3, record_period=1e-3), controller=cls(**changes))


def translated(folder: Path, body: str, **changes: object) -> Exported:
    return exported(law(folder, body, **changes), Part.CONTROLLER, **NAMED)


def refusal(folder: Path, body: str) -> str:
    with pytest.raises(TranslationError) as caught:
        translated(folder, body)
    message = str(caught.value)
    assert message.startswith(f"{folder}/law.py, line ")
    assert "\n" not in message
    return message


TRANSLATED = [
    "return LawState(self.gain * (r.value - y.velocity), s.u)",
    "e = r.value\nif e > 0.3:\n    u = self.gain * e\nelse:\n    u = -e\nreturn LawState(u, 0.0)",
    "if y.velocity > 0.5:\n    return LawState(1.0, 0.0)\nreturn LawState(2.0, s.u)",
    "u = 1.0 if 0.0 < y.velocity <= 0.25 and not r.rate > 0.0 else 2.0\nreturn LawState(u, 0.0)",
    "u = 1.0 if y.velocity > 5.0 or r.value > 0.5 else 2.0\nreturn LawState(u, 0.0)",
    "u = 0.0\nfor i in range(self.turns):\n    u += (i + 1.0) * y.velocity\nreturn LawState(u, dt)",
    "u = 0.0\nfor _ in range(TURNS):\n    u = u + SLOPE\nreturn LawState(u, 0.0)",
    "u = 100.0\nwhile u > 1.0:\n    u = 0.5 * u\nreturn LawState(u, 0.0)",
    "a, b = y.velocity, r.value\na, b = b, a\nreturn LawState(a, b)",
    "a, b = self.pair(y.velocity, r.value)\nreturn LawState(a, b)",
    "s = LawState(s.u + 1.0, s.beside)\ns = LawState(s.u * 2.0, s.u)\nreturn s",
    "m = Measurement(y.velocity, 1.0, 2.0, 3.0, 4.0, 5.0)\nreturn LawState(m.velocity, m.command)",
    "u: float = ops.where(self.reverse, -y.velocity, y.velocity)\nreturn LawState(u, 0.0)",
    "return ops.where(y.velocity > 0.0, LawState(1.0, 2.0), s)",
    "half = float(1 << self.turns) / 2\nreturn LawState(u=half, beside=y.command ** 2)",
    "return LawState(ops.power(math.e, y.velocity), ops.floor(-3.5 * r.value))",
    "switch = y.velocity\ndouble = r.value\nreturn LawState(switch - (double - dt), 1e-300 * switch)",
    "x = y.velocity\nx -= 1.0 - (2.0 - x)\nreturn LawState(x / 3.0 * r.rate / (x * 2.0), -(-x))",
]


def run(unit: Exported, rows: np.ndarray, folder: Path) -> np.ndarray:
    """The states after each row, by a library of its own: one that is loaded must not be written again."""
    own = folder / f"{unit.real}{unit.inlined}"
    own.mkdir()
    return library(unit, own).run(rows)


@pytest.mark.parametrize("body", TRANSLATED)
@pytest.mark.parametrize("changes", [{}, {"turns": 3, "reverse": True}], ids=["as given", "changed"])
def test_c_does_what_python_does(body: str, changes: dict[str, object], tmp_path: Path) -> None:
    needs("gcc")
    loop = law(tmp_path, body, **changes)
    unit = exported(loop, Part.CONTROLLER, **NAMED)
    numbers = dict(zip([f"measurement.{name}" for name in Y._fields], Y, strict=True))
    numbers |= dict(zip([f"demand.{name}" for name in R._fields], R, strict=True))
    row = [numbers[signal.path] for argument in unit.arguments for signal in argument.signals]
    found = library(unit, tmp_path).run(np.array([row, row]))
    state, expected = loop.controller.init(), []
    for _ in range(2):
        state = loop.controller.step(state, Y, R, 1e-3)
        expected.append([*state])
    assert found.tolist() == expected


REFUSED = [
    ("return LawState(math.tanh(y.velocity), 0.0)", 0, "math.tanh", "use ops.tanh"),
    ("return LawState(max(y.velocity, 0.0), 0.0)", 0, "max", "use ops.maximum"),
    ("u = 1.0\nreturn LawState(abs(u), 0.0)", 1, "abs", "use ops.absolute"),
    ("return LawState(math.exp(y.velocity), 0.0)", 0, "math.exp", "use ops.power(math.e, x)"),
    ("if y.velocity:\n    return s\nreturn s", 0, "'y.velocity' is a number", "compare it"),
    ("return LawState(y.velocity ** 1.5, 0.0)", 0, "a ** b", "use ops.power"),
    ("return LawState(y.velocity % 1.0, 0.0)", 0, "a % b", "ops.floor"),
    ("return LawState(sum([y.velocity, 1.0]), 0.0)", 0, "[y.velocity, 1.0]", "only ops"),
    ("if y.velocity > 0.0:\n    v = 1.0\nreturn LawState(v, 0.0)", 2, "v may have no value", "on every path"),
    ("print(y.velocity)\nreturn s", 0, "print", "only ops"),
    ("if y.velocity > 0.0:\n    return s", 0, "without a return", "every path"),
    ("if y.velocity > 0.0:\n    return y\nreturn s", 2, "different types", "one type"),
    ("u = 1\nu = y.velocity\nreturn LawState(u, 0.0)", 1, "u changes its type", "write 1.0 and not 1"),
    ("try:\n    return s\nfinally:\n    pass", 0, "'try'", "only ops"),
    ("return LawState(y.velocity, 0.0)._replace(u=1.0)", 0, "_replace", "only ops"),
    ("return LawState(s.v, 0.0)", 0, "neither a field nor a method 'v'", "only ops"),
    ("return LawState(float(len(NAMES)), 0.0)", 0, "NAMES is a list", "floats and blocks"),
    ("return LawState(1.0)", 0, "given no beside", "every field"),
    ("return LawState(ops.where(y.velocity, 1.0, 0.0), 0.0)", 0, "not a truth value", "compare it"),
    ("return LawState(self.step(s, y, r, dt).u, 0.0)", None, "calls itself", ""),
    ("for x in (1.0, 2.0):\n    pass\nreturn s", 0, "only range(count)", "count from 0"),
    ("return (lambda: s)()", 0, "lambda", "only ops"),
    ("f = [y]\nreturn s", 0, "'[y]'", "only ops"),
    ("return LawState(ops.power(y.velocity), 0.0)", 0, "missing a required argument", "only ops"),
    ("a, b = y\nreturn s", 0, "6 values for 2 names", "give each a name"),
]


@pytest.mark.parametrize(("body", "line", "problem", "way_out"), REFUSED, ids=[one[0] for one in REFUSED])
def test_what_has_no_equal_in_c_is_refused(
    body: str, line: int | None, problem: str, way_out: str, tmp_path: Path
) -> None:
    message = refusal(tmp_path, body)
    assert problem in message
    assert way_out in message
    if line is not None and "without a return" not in problem:
        assert f"line {FIRST + line}, Law.step" in message


def test_what_nobody_reads_is_left_out(tmp_path: Path) -> None:
    unit = translated(tmp_path, "spare = r.jerk * y.position\nreturn LawState(self.gain * y.velocity, 0.0)")
    assert [one.path for one in unit.parameters] == ["controller.gain", "simulation.period"]
    assert [one.path for argument in unit.arguments for one in argument.signals] == ["measurement.velocity"]
    assert [one.path for one in unit.states] == ["controller.u", "controller.beside"]
    for name in ("unused", "spare", "jerk", "position"):
        assert name not in unit.source.partition("*/")[2]


def test_names_units_and_sources_are_there() -> None:
    unit = exported(load_scenario("paper/sine-tsmc"), Part.CONTROLLER, prefix="tsmc", title="the paper's law")
    for text in (unit.header, unit.source):
        assert text.startswith("/*\n * the paper's law\n")
        assert f"scenario with hash {unit.hash}" in text
        assert f"hydroservo {unit.version}" in text
        assert max(map(len, text.splitlines())) <= WIDTH
    assert "double linear_gain_1; /* [1/s] gain mu_1 */" in " ".join(unit.header.split())
    assert ".linear_gain_1 = 10000.0, /* [1/s] */" in unit.source
    assert "eqs. (19)-(22) of doi:10.1007/s42401-021-00087-w" in unit.source
    for name in ("xi1", "acceleration", "xi1_rate", "drift"):
        assert f"const double {name} = " in " ".join(unit.source.split())


def test_tunable_and_fixed_parameters() -> None:
    unit = exported(load_scenario("rig/excavator-link"), Part.MACHINE, prefix="machine", title="a machine")
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
    loop = Loop(Simulation(1.0, 1e-3, record_period=1e-3), controller=PI())
    rows = np.array([[0.1, 1.0, 0.3], [0.2, 0.5, -0.4]])
    units = [exported(loop, Part.CONTROLLER, **NAMED, inlined=inlined) for inlined in (False, True)]
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
    units = {p: exported(loop, Part.CONTROLLER, **NAMED, precision=p) for p in Precision}
    assert "double" not in units[Precision.SINGLE].source.partition("*/")[2].replace("double-", "")
    names = [one.path for argument in units[Precision.SINGLE].arguments for one in argument.signals]
    size = {"measurement.velocity": 1e-5, "measurement.load_force": 100.0, "measurement.command": 0.5}
    rows = draw.normal(size=(50, len(names))) * [size.get(name, 1e-5) for name in names]
    found = {p: run(unit, rows, tmp_path) for p, unit in units.items()}
    single, double = found[Precision.SINGLE], found[Precision.DOUBLE]
    assert single.dtype == np.float32
    assert np.allclose(single, double, rtol=1e-3, atol=1e-3 * np.nanmax(np.abs(double), axis=0))
    assert not np.array_equal(single, double)


@pytest.mark.parametrize("part", [Part.MACHINE, Part.LOOP])
def test_single_precision_is_for_controllers(part: Part) -> None:
    with pytest.raises(LoopError, match="in double precision only"):
        exported(Loop(), part, **NAMED, precision=Precision.SINGLE)


def test_a_number_beyond_single_precision_is_refused() -> None:
    loop = Loop(Simulation(1.0, 1e-3, record_period=1e-3), controller=PI(saturation=Saturation(1e300)))
    with pytest.raises(LoopError, match="1e\\+300 is out of the range of single precision"):
        exported(loop, Part.CONTROLLER, **NAMED, precision=Precision.SINGLE)


@pytest.mark.parametrize("prefix", ["", "2law", "a-law", "double", "a law", "größe", "law;"])
def test_a_prefix_is_a_name_of_c(prefix: str) -> None:
    assert not is_identifier(prefix)
    with pytest.raises(ParameterError, match="prefix"):
        exported(Loop(), Part.CONTROLLER, prefix=prefix, title="")


@pytest.mark.parametrize("prefix", ["pi", "tsmc", "ops", "loop", "state", "saturation", "law_init"])
def test_any_prefix_goes_with_any_block(prefix: str, tmp_path: Path) -> None:
    needs("gcc")
    for part in Part:
        loop = Loop(Simulation(1.0, 1e-3, record_period=1e-3), controller=TSMC())
        folder = tmp_path / part
        folder.mkdir()
        library(exported(loop, part, prefix=prefix, title="a law"), folder)


def test_the_same_loop_gives_the_same_text() -> None:
    loop = load_scenario("rig/encoder-tsmc-sine")
    first, second = (exported(loop, Part.LOOP, **NAMED) for _ in range(2))
    assert first == second


def test_names() -> None:
    assert snake("TSMObserverState") == "tsm_observer_state"
    assert snake("PI") == "pi"
    assert snake("FilteredDerivative") == "filtered_derivative"
    assert identifier("switch") == "switch_"
    assert identifier("xi1") == "xi1"


def test_long_lines_are_parted_at_the_outermost_place() -> None:
    line = "    const double x = " + " + ".join(f"(first_{i} * second_{i})" for i in range(9)) + ";"
    parted = wrapped(line, 1).splitlines()
    assert max(map(len, parted)) <= WIDTH
    assert all(part.count("(") == part.count(")") for part in parted)
    assert "".join(part.strip() for part in parted).replace(" ", "") == line.replace(" ", "")


def test_comments_cannot_end_early() -> None:
    assert comment("a */ b").count("*/") == 1
    assert comment("see ``x`` in :func:`~hydroservo.simulate`::") == "/* see x in hydroservo.simulate: */\n"
