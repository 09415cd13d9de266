"""What is translated is the text of what runs; what a user wrote cannot leave its comment or string."""

import ast
import functools
import linecache
from pathlib import Path
from types import FunctionType

import pytest

from hydroservo import Loop
from hydroservo.core.errors import HydroservoError
from hydroservo.export.c.project import write_c_project
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part
from hydroservo.export.vectors import make_vectors
from hydroservo.language.names import identifier
from hydroservo.language.scope import TranslationError
from hydroservo.scenario import load_plugin
from hydroservo.testing.examples import example
from tests.support.export.projects import check
from tests.support.export.small_laws import FIRST, HEAD, NAMED, assert_same
from tests.support.export.small_laws import law as law_of
from tests.support.needs import needs
from tools.targets.host import library


def law(folder: Path, body: str) -> Loop:
    """A law of its own: one text is loaded once, from wherever it first lay."""
    return law_of(folder, f"{body}\n# {folder}")


def loaded(file: Path, loop: Loop) -> Loop:
    """A loop with the law of a file."""
    cls = next(one for one in load_plugin(file) if one.__name__ == "Law")
    return loop._replace(controller=example(cls))


def refusal(loop: Loop, folder: Path) -> str:
    with pytest.raises(TranslationError) as caught:
        exported_unit(loop, Part.CONTROLLER, **NAMED)
    message = str(caught.value)
    assert message.startswith(f"{folder}/law.py, line ")
    assert "\n" not in message
    return message


def changed(loop: Loop, monkeypatch: pytest.MonkeyPatch, step: object) -> Loop:
    monkeypatch.setattr(type(loop.controller), "step", step)
    return loop


def test_a_decorator_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    loop = law(tmp_path, "return LawState(1.0, 0.0)")
    plain = type(loop.controller).step

    @functools.wraps(plain)
    def twice(self, s, y, r, dt):  # type: ignore[no-untyped-def]
        return plain(self, plain(self, s, y, r, dt), y, r, dt)

    changed(loop, monkeypatch, twice)
    with pytest.raises(TranslationError, match="a decorator gave it __wrapped__, which hides what runs"):
        exported_unit(loop, Part.CONTROLLER, **NAMED)


@pytest.mark.parametrize("wrap", [functools.cache, functools.partial, staticmethod])
def test_what_is_no_function_is_refused(
    wrap: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    loop = law(tmp_path, "return LawState(self.early(1.0, 2.0), 0.0)")
    cls = type(loop.controller)
    monkeypatch.setattr(cls, "early", wrap(vars(cls)["early"]))  # type: ignore[operator]
    assert "early of Law is not a method of its own" in refusal(loop, tmp_path)


def test_code_that_is_not_that_of_the_text_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    loop = law(tmp_path, "return LawState(1.0, 0.0)")
    plain = type(loop.controller).step
    code = plain.__code__.replace(co_consts=tuple(2.0 if x == 1.0 else x for x in plain.__code__.co_consts))
    changed(loop, monkeypatch, FunctionType(code, plain.__globals__, "step"))
    assert "is not the code that runs" in refusal(loop, tmp_path)


def test_of_a_file_that_changed_meanwhile_what_was_loaded_is_translated(tmp_path: Path) -> None:
    loop = law(tmp_path, "return LawState(1.0, 0.5)")
    before = exported_unit(loop, Part.CONTROLLER, **NAMED)
    file = tmp_path / "law.py"
    file.write_text(file.read_text().replace("LawState(1.0, 0.5)", "LawState(1.5, 0.25)"))
    assert exported_unit(loop, Part.CONTROLLER, **NAMED) == before


def test_a_cell_of_a_notebook_is_translated(tmp_path: Path) -> None:
    """Of which each statement is compiled alone, those that import with the others."""
    text = f"{HEAD}        return LawState(ops.clip(y.velocity, 0.0, 1.0), 0.0)\n"
    file, names = f"<a cell {tmp_path}>", {"__name__": "__main__"}
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    for statement in ast.parse(text).body:
        exec(compile(ast.Module([statement], []), file, "exec"), names)
    from_file = law(tmp_path, "return LawState(ops.clip(y.velocity, 0.0, 1.0), 0.0)")
    in_cell = from_file._replace(controller=names["Law"]())
    of_file, of_cell = (exported_unit(loop, Part.CONTROLLER, **NAMED) for loop in (from_file, in_cell))
    assert of_cell.source.partition("law_step(")[2] == of_file.source.partition("law_step(")[2] != ""


def test_a_lambda_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    loop = changed(law(tmp_path, "return s"), monkeypatch, lambda *given: given[1])
    with pytest.raises(TranslationError, match=r"test_translated_text\.py, line .* it is a lambda"):
        exported_unit(loop, Part.CONTROLLER, **NAMED)


def test_a_class_that_hides_a_field_is_refused(tmp_path: Path) -> None:
    loop = law(tmp_path, "return LawState(self.gain, 0.0)")
    hidden = type("Hidden", (type(loop.controller),), {"gain": 9.0})
    with pytest.raises(TranslationError, match="in place of its field gain"):
        exported_unit(loop._replace(controller=hidden()), Part.CONTROLLER, **NAMED)


def test_a_line_in_column_0(tmp_path: Path) -> None:
    needs("gcc")
    loop = law(tmp_path, "u = 1.0\n#MARK\nreturn LawState(u, 0.0)")
    text = (tmp_path / "law.py").read_text()
    assert "        #MARK" in text
    own = tmp_path / "own"
    own.mkdir()
    (own / "law.py").write_text(text.replace("        #MARK", "# in column 0"))
    assert_same(loaded(own / "law.py", loop), own)


def test_a_method_that_never_stops_calling_itself(tmp_path: Path) -> None:
    loop = law(tmp_path, "return s")
    text = HEAD.replace("def many(", "def deep(self, n):\n        return self.deep(n + 1)\n\n    def many(")
    assert text != HEAD
    (tmp_path / "law.py").write_text(text + f"        return LawState(self.deep(0), 0.0)  # {tmp_path}\n")
    loop = loaded(tmp_path / "law.py", loop)
    with pytest.raises(TranslationError, match="calls itself"):
        exported_unit(loop, Part.CONTROLLER, **NAMED)


@pytest.mark.parametrize(
    ("made", "kind"),
    [
        ("np.float32(2.5)", "float32"),
        ("np.int64(2)", "int64"),
        ("__import__('decimal').Decimal(2)", "Decimal"),
        ("__import__('fractions').Fraction(1, 3)", "Fraction"),
        ("np.array(2.5)", "ndarray"),
    ],
)
def test_numbers_that_c_does_not_have_are_refused(made: str, kind: str, tmp_path: Path) -> None:
    loop = law(tmp_path, "return LawState(y.velocity * SLOPE, 0.0)")
    text = (tmp_path / "law.py").read_text().replace("SLOPE = 2.5", f"SLOPE = {made}")
    (tmp_path / "law.py").write_text(text)
    message = refusal(loaded(tmp_path / "law.py", loop), tmp_path)
    assert f"line {FIRST}, Law.step: SLOPE is a {kind}" in message


def test_a_constant_of_numpy_is_its_float(tmp_path: Path) -> None:
    needs("gcc")
    assert_same(law(tmp_path, "return LawState(y.velocity * ROOT, ROOT)"), tmp_path)


@pytest.mark.parametrize(
    "name", ["_Bool", "DBL_MAX", "__LINE__", "M_PI", "INT64_MAX", "LAW_H", "_Pragma", "new"]
)
def test_names_that_c_has_taken(name: str, tmp_path: Path) -> None:
    needs("gcc")
    assert identifier(name) != name or name == "LAW_H"
    assert_same(law(tmp_path, f"{name} = y.velocity + 1.0\nreturn LawState({name}, 0.0)"), tmp_path)


def test_a_name_that_is_given_itself(tmp_path: Path) -> None:
    needs("gcc")
    needs("clang")
    loop = law(tmp_path, "e = r.value\nif e > 0.0:\n    e = e\nelse:\n    e = -e\nreturn LawState(e, 0.0)")
    library(exported_unit(loop, Part.CONTROLLER, **NAMED), tmp_path, "clang")


TEXTS = ('V"); abort(); ("', "a */ b /* *\\\\", "??/ ?? %d %s", "µ\\x00 \\n | <b> & é", "*\\\\\\n/")


@pytest.mark.parametrize("text", TEXTS)
def test_text_of_a_user_stays_where_it_is_put(text: str, tmp_path: Path) -> None:
    needs("gcc")
    needs("make")
    loop = law(tmp_path, "return LawState(self.gain * y.velocity, s.u)")
    file = tmp_path / "law.py"
    own = file.read_text().replace('"V s/m", "gain of the law"', f"{text!r}, {text!r}")
    file.write_text(own.replace('"V", "number beside it"', f"{text!r}, {text!r}"))
    loop = loaded(file, loop)
    unit = exported_unit(loop, Part.CONTROLLER, **NAMED)
    write_c_project(unit, make_vectors(loop, Part.CONTROLLER, unit), tmp_path / "out")
    done = check(tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("name", ["law.c", "law.h", "law_vectors.h", "law_replay.c"])
def test_a_file_written_by_hand_is_left_alone(name: str, tmp_path: Path) -> None:
    loop = law(tmp_path, "return LawState(y.velocity, s.u)")
    unit = exported_unit(loop, Part.CONTROLLER, **NAMED)
    vectors = make_vectors(loop, Part.CONTROLLER, unit)
    out = tmp_path / "out"
    write_c_project(unit, vectors, out)
    write_c_project(unit, vectors, out)
    (out / name).write_text("int mine;\n")
    with pytest.raises(HydroservoError, match=f"{name}: not written by hydroservo"):
        write_c_project(unit, vectors, out)
    assert (out / name).read_text() == "int mine;\n"
