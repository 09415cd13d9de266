"""Exported C through the tools of its users; each of them is also shown what it must refuse."""

from pathlib import Path

import numpy as np
import pytest

from hydroservo.export.unit import CModule
from tests.support.export.cppcheck import Finding, findings, unaccepted
from tests.support.export.sanitizers import watched
from tests.support.export.toy import toy
from tests.support.export.variants import changed, each_unit, idling, inlined, inputs, single
from tests.support.needs import needs
from tools.targets.callgrind import instructions
from tools.targets.compilers import ToolError
from tools.targets.host import compiled, library, program
from tools.targets.sources import Rows
from tools.targets.symbols import foreign, undefined

COMPILERS = ("gcc", "clang")

pytestmark = pytest.mark.slow  # several compilers for each

each_compiler = pytest.mark.parametrize("compiler", COMPILERS)
each_sanitizer = pytest.mark.parametrize(
    "compiler", ["gcc", pytest.param("clang", marks=pytest.mark.nightly)]
)


@each_unit
def test_both_compilers_give_the_same_bits_at_every_level(unit: CModule, tmp_path: Path) -> None:
    needs(*COMPILERS)
    found = [
        library(unit, tmp_path, compiler, [level]).run(inputs(unit)).tobytes()
        for compiler in COMPILERS
        for level in ("-O0", "-O2", "-O3")
    ]
    assert len(set(found)) == 1


def law(rows: Rows, gain: float, start: float = 0.0) -> Rows:
    """The toy's law in Python."""
    states, integral = [], start
    for velocity, demand in rows.tolist():
        error = demand - velocity
        integral = integral + 1e-5 * (10.0 * error)
        unlimited = gain * error + integral
        states.append((min(max(unlimited, -10.0), 10.0), integral, unlimited))
    return np.array(states)


def test_states_follow_each_row(tmp_path: Path) -> None:
    needs("gcc")
    rows = inputs(toy())
    built = library(toy(), tmp_path)
    assert built.run(rows).tobytes() == law(rows, 100.0).tobytes()
    assert built.run(rows, {"controller.proportional_gain": 3.0}).tobytes() == law(rows, 3.0).tobytes()
    assert built.start().tolist() == [0.0, 0.0, 0.0]
    anew = np.concatenate([law(rows[:150], 100.0), law(rows[150:], 100.0)])
    assert built.run(rows, restart=150).tobytes() == anew.tobytes()


@each_unit
def test_the_program_does_what_the_library_does(unit: CModule, tmp_path: Path) -> None:
    needs("gcc")
    given = None if unit.inlined else {"controller.integral_gain": 1e3}
    states = program(unit, tmp_path).run(inputs(unit), given)
    assert states.dtype == (np.float32 if unit.real == "float" else np.float64)
    assert states.tobytes() == library(unit, tmp_path).run(inputs(unit), given).tobytes()


def test_a_unit_is_given_what_it_has(tmp_path: Path) -> None:
    needs("gcc")
    with pytest.raises(ValueError, match="no parameters: gain"):
        library(toy(), tmp_path).run(inputs(toy()), {"gain": 1.0})
    with pytest.raises(ValueError, match="they are inlined"):
        library(inlined(), tmp_path).run(inputs(inlined()), {})
    with pytest.raises(ValueError, match="a step is given 2 numbers"):
        library(toy(), tmp_path).run(np.zeros((5, 3)))


def test_a_command_must_be_the_states(tmp_path: Path) -> None:
    needs("gcc")
    other = changed(toy(), "return state->u;", "return state->unlimited;")
    with pytest.raises(AssertionError, match="commands are not those of the state"):
        library(other, tmp_path).run(inputs(other))
    with pytest.raises(ToolError):
        program(other, tmp_path).run(inputs(other))


@each_compiler
@pytest.mark.parametrize(
    ("old", "new", "warning"),
    [
        ("(void)parameters;", "", "unused-parameter"),
        ("const double error =", "const int error =", "conversion"),
        ("const double error =", "double state = 0.0; const double error = state +", "shadow"),
        ("static double ops_clip", "double ops_clip", "missing-prototypes"),
    ],
)
def test_a_warning_is_an_error(compiler: str, old: str, new: str, warning: str, tmp_path: Path) -> None:
    needs(compiler)
    with pytest.raises(ToolError, match=warning):
        library(changed(toy(), old, new), tmp_path, compiler)


@each_compiler
def test_single_precision_holds_no_double(compiler: str, tmp_path: Path) -> None:
    needs(compiler)
    with pytest.raises(ToolError, match="double-promotion"):
        library(changed(single(), "parameters->proportional_gain *", "100.0 *"), tmp_path, compiler)


@each_unit
@each_sanitizer
def test_sanitizers_are_silent(unit: CModule, compiler: str, tmp_path: Path) -> None:
    needs(compiler, "gcc")
    states = watched(unit, tmp_path, compiler).run(inputs(unit))
    assert states.tobytes() == library(unit, tmp_path).run(inputs(unit)).tobytes()


@each_sanitizer
@pytest.mark.parametrize(
    ("expression", "error"),
    [
        ("(double)(int)(1e300 * error)", "outside the range"),
        ("(double)(1 << (40 - (int)(error > 9.0)))", "shift exponent"),
        ("(&state->u)[3 + (int)(error > -9.0)]", "buffer-overflow"),
    ],
)
def test_undefined_behaviour_stops_the_program(
    compiler: str, expression: str, error: str, tmp_path: Path
) -> None:
    needs(compiler)
    unit = changed(toy(), ".integral = integral,", f".integral = {expression},")
    with pytest.raises(ToolError, match=error):
        watched(unit, tmp_path, compiler).run(inputs(unit))


@each_compiler
@pytest.mark.parametrize("level", ["-O0", "-O1", "-O2", "-O3"])
def test_nothing_is_called_but_roots(compiler: str, level: str, tmp_path: Path) -> None:
    needs(compiler, "nm")
    assert foreign(undefined(compiled(toy(), tmp_path, compiler, [level]))) == set()


@each_compiler
def test_a_call_of_the_maths_library_is_seen(compiler: str, tmp_path: Path) -> None:
    needs(compiler, "nm")
    unit = changed(toy(), "self->limit, self->limit)", "self->limit, pow(self->limit, u) + sqrt(u))")
    assert foreign(undefined(compiled(unit, tmp_path, compiler, ["-O2"]))) == {"pow"}


@pytest.mark.nightly
@each_unit
def test_cppcheck_finds_nothing_but_accepted_deviations(unit: CModule, tmp_path: Path) -> None:
    needs("cppcheck")
    assert unaccepted(findings(unit, tmp_path)) == []


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("old", "new", "rule"),
    [
        (
            "double saturation_apply(const toy_saturation *self, double u) {",
            "double saturation_apply(const toy_saturation *self, double u) {\n    u = 2.0 * u;",
            "17.8",
        ),
        (
            "    return ops_clip(",
            "    if (u > self->limit) {\n        return self->limit;\n    }\n    return ops_clip(",
            "15.5",
        ),
        ("(parameters->proportional_gain * error) +", "parameters->proportional_gain * error +", "12.1"),
        ("return (x < low) ? low :", "return (x < low) ? low + high :", "12.1"),
        ("    (void)parameters;", "    double *unread;\n    (void)parameters;", "unusedVariable"),
        (
            "    (void)parameters;",
            "    double number;\n    state->u = number;\n    (void)parameters;",
            "uninitvar",
        ),
    ],
)
def test_cppcheck_finds(old: str, new: str, rule: str, tmp_path: Path) -> None:
    needs("cppcheck")
    found = unaccepted(findings(changed(toy(), old, new), tmp_path))
    assert rule in {one.rule for one in found}


@pytest.mark.nightly
def test_brackets_that_cppcheck_loses_are_seen(tmp_path: Path) -> None:
    needs("cppcheck")
    unit = changed(toy(), "return (x < low) ? low :", "return (x < low) ? (low + high) :")
    assert unaccepted(findings(unit, tmp_path)) == []


def test_an_accepted_deviation_is_one_by_its_number() -> None:
    other = Finding("toy.c:1", "17.8", "")
    assert unaccepted([Finding("toy.c:1", "19.2", ""), other]) == [other]


@pytest.mark.nightly
def test_callgrind_counts_the_instructions_of_a_step(tmp_path: Path) -> None:
    needs("gcc", "valgrind")
    fewer = instructions(idling(1000), inputs(toy(), 100), tmp_path)
    assert instructions(idling(2000), inputs(toy(), 100), tmp_path) == fewer + 1000
    with pytest.raises(ToolError, match="did not see toy_step"):
        instructions(toy(), inputs(toy(), 0), tmp_path)


def test_a_missing_tool_skips_or_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("HYDROSERVO_TOOLS", raising=False)
    with pytest.raises(pytest.skip.Exception, match="missing: no-such-tool"):
        needs("gcc", "no-such-tool")
    monkeypatch.setenv("HYDROSERVO_TOOLS", "all")
    with pytest.raises(pytest.fail.Exception, match="missing: no-such-tool"):
        needs("gcc", "no-such-tool")
