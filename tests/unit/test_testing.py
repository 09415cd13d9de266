"""Each thing that the contract asks of a block has a block that is not so, and is found."""

import re
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from hypothesis import Phase

from hydroservo import HydroservoError, replace
from hydroservo.control.controllers import DAC, PI, TSMC
from hydroservo.core.roles import Filter, Limiter, Load, Model, Reference, role
from hydroservo.core.signals import Demand
from hydroservo.engine.compiling import compiled_function
from hydroservo.export import compilers
from hydroservo.machine.plants import DesignModel
from hydroservo.machine.sensors import NoPosition
from hydroservo.scenario import load_plugin
from hydroservo.scenario.registry import shipped_classes
from hydroservo.scenario.role_checks import ROLES, possible_roles
from hydroservo.testing import BlockContract, ContractError, answers, behaviour, check_block, contract
from hydroservo.testing.case import case_of
from hydroservo.testing.contract import QUESTIONS, Answer, answer_question, ask, group_by_cause
from hydroservo.testing.examples import example
from hydroservo.testing.loops import block_places, loop_with
from tests.support.needs import needs
from tests.support.plugins import LAW, METRIC

pytestmark = pytest.mark.usefixtures("forgotten")

LOAD = '''\
from typing import Annotated, NamedTuple

from itertools import count

from hydroservo import Field, ops
from hydroservo.core.roles import Load, role


@role(Load)
class Push(NamedTuple):
    """A force."""

    size: Annotated[float, Field("N", "force")] = 2.0

    def force(self, t):
        return self.size

    def next_jump(self, t):
        return 1e300
'''
VALVE = '''\
from typing import Annotated, NamedTuple

from hydroservo import Field
from hydroservo.core.roles import MeteringEdges, Valve, role
from hydroservo.machine.valves import Orifice


class Rigid(NamedTuple):
    pass


@role(Valve)
class Spool(NamedTuple):
    """x_v = k u."""

    gain: Annotated[float, Field("m/V", "spool travel per command", above=0)] = 1e-4
    orifice: MeteringEdges = Orifice(0.61, 0.02, 850.0)

    def init(self):
        return Rigid()

    def deriv(self, s, u):
        return s

    def opening(self, s, u):
        return self.gain * u
'''
EDGES_PROPERTY = "    @property\n    def orifice(self):\n        return self.edges\n\n"
EDGES = "    orifice: MeteringEdges"
COUNT = 'Annotated[float, Field("", "zero crossings of the error", smaller_is_better=True)]'
ROLE, DOCUMENTED, DECLARED, RANGES, FLOATS, PICKLES, RETURNS, FINITE, COMPILED, AGAIN, IN_C = (
    question.name for question in QUESTIONS
)


def block_class(folder: Path, text: str) -> type:
    """The last class that a file with this text defines."""
    path = folder / "mine.py"
    path.write_text(text, encoding="utf-8")
    return load_plugin(path)[-1]


def answer(cls: type, name: str) -> Answer:
    question = next(one for one in QUESTIONS if one.name == name)
    return answer_question(question, case_of(cls))


class Wrong(NamedTuple):
    """A block that is not as it must be, by what is changed in the text of a good one."""

    question: str
    text: str
    changes: dict[str, str]
    line: str  # how the line begins at which it is found
    remark: str  # how the remark begins


SIZE = "return self.size"
STEP, FORCE, GAIN = "    def step", "    def force", "    gain"  # how lines begin
FIELD = 'Annotated[float, Field("V s/m", "gain k", above=0)]'
WRONG = {
    "no role": Wrong(
        *(ROLE, LAW, {"@role(Controller)\n": "", "def step": "def stop"}),
        *("class Law", "declares no role, and does not have the methods of any"),
    ),
    "an unclear role": Wrong(
        *(ROLE, LAW, {"@role(Controller)\n": ""}),
        *("class Law", "has the methods of Controller, Differentiator, Observer"),
    ),
    "no command": Wrong(
        *(ROLE, LAW, {"    u: Anno": "    v: Anno"}),
        *("    def init", "its state has no u, which that of a Controller must have"),
    ),
    "a part of another role": Wrong(
        *(ROLE, LAW, {"= 2.0\n": "= 2.0\n    observer: Observer = Implicit()\n"}),
        *("    observer", "observer cannot be an Observer: it says that its role is Realisation"),
    ),
    "no state": Wrong(
        *(ROLE, LAW, {"State(0.0)": "(0.0,)"}, "    def init", "init returns (0.0,): must be a NamedTuple")
    ),
    "a property that must be a field": Wrong(
        *(
            ROLE,
            VALVE,
            {EDGES: "    edges: MeteringEdges", "    def init": EDGES_PROPERTY + "    def init"},
        ),
        *(
            "    def orifice",
            "orifice is a property, which compiled code cannot read; write a field, orifice: MeteringEdges",
        ),
    ),
    "a block that must be a field": Wrong(
        *(ROLE, VALVE, {"    orifice: MeteringEdges = ": "    orifice = "}),
        *(
            "class Spool",
            "orifice is a class attribute, which compiled code cannot read; write a field, orifice: Mete",
        ),
    ),
    "no field for a role": Wrong(
        *(ROLE, VALVE, {EDGES: "    edges: MeteringEdges"}),
        *(
            "class Spool",
            "has no orifice, which a Valve must have; write a field, orifice: MeteringEdges",
        ),
    ),
    "no default": Wrong(
        *(
            ROLE,
            LAW,
            {" = 2.0": ""},
            GAIN,
            "has no default for gain: give one, or call check_block with an example",
        )
    ),
    "no docstring": Wrong(DOCUMENTED, LAW, {'    """u = k e."""\n': ""}, "class Law", "has no docstring"),
    "no field": Wrong(DECLARED, LAW, {FIELD: "float"}, GAIN, "gain has no unit; write gain: Annotated["),
    "no unit": Wrong(DECLARED, LAW, {'"V s/m"': '"Volt-s/m"'}, GAIN, "the unit 'Volt-s/m' of gain "),
    "a wrong unit in SI's place": Wrong(
        DECLARED, LAW, {'"V s/m"': '"V s/m bar"'}, GAIN, "the unit 'V s/m bar' of gain is "
    ),
    "another unit than SI's": Wrong(
        *(DECLARED, LAW, {'"V s/m"': '"mV s/mm"'}, GAIN),
        "the unit 'mV s/mm' of gain is not SI: declare it in 'V s/m'; scenarios may still give mV s/mm",
    ),
    "another unit of a state": Wrong(
        *(DECLARED, LAW, {'"V", "command"': '"mV", "command"'}, "    u"),
        "the unit 'mV' of u is not SI: declare it in 'V'",
    ),
    "a percentage": Wrong(
        *(DECLARED, METRIC, {'"", "zero crossings of': '"%", "zero crossings of'}, "    zero_crossings"),
        "the unit '%' of zero_crossings is not SI: declare it in ''",
    ),
    "no meaning": Wrong(
        *(DECLARED, LAW, {'"gain k"': '""'}, GAIN, "gain has no meaning: Field('V s/m', meaning, ...)")
    ),
    "no meaning in a state": Wrong(DECLARED, LAW, {'"command"': '""'}, "    u", "u has no meaning"),
    "out of range": Wrong(
        RANGES, LAW, {"= 2.0": "= -2.0"}, GAIN, "gain = -2.0: must be a finite number above"
    ),
    "a check that stops": Wrong(
        *(RANGES, LAW, {"    def init": "    def check(self):\n        ops.no()\n\n    def init"}),
        *("        ops.no()", "AttributeError: module 'hydroservo.core.ops' has no attribute 'no'"),
    ),
    "a whole number": Wrong(
        *(FLOATS, LAW, {"State(0.0)": "State(0)"}, "    def init", "u of init is 0: must be a float")
    ),
    "a first command": Wrong(
        *(FLOATS, LAW, {"State(0.0)": "State(1.0)"}, "    def init", "its first command, u of init, is 1 V")
    ),
    "a whole number in a step": Wrong(
        *(RETURNS, LAW, {"State(self": "State(2 + 0 * int(self", "velocity))": "velocity)))"}),
        *(STEP, "step returns State(u=2), not like State(u=0.0) of init"),
    ),
    "a whole force": Wrong(RETURNS, LOAD, {SIZE: "return 2"}, FORCE, "force returns 2: must be a float"),
    "infinite": Wrong(FINITE, LOAD, {SIZE: f"{SIZE} * 1e308 * 1e9"}, FORCE, "force gives inf for"),
    "stops": Wrong(FINITE, LOAD, {SIZE: f"{SIZE} / 0.0"}, f"        {SIZE}", "ZeroDivisionError: "),
    "not compiled": Wrong(
        *(COMPILED, LOAD, {SIZE: f"{SIZE} + len(globals())"}, f"        {SIZE}", "force cannot be compiled")
    ),
    "other bits the next time": Wrong(
        *(AGAIN, LOAD, {SIZE: "return next(self.numbers)", FORCE: f"    numbers = count(0.5)\n\n{FORCE}"}),
        *(FORCE, "force gives other numbers for the same inputs"),
    ),
    "no metrics": Wrong(
        *(ROLE, METRIC, {"Counted(m.count)": "m.count"}),
        *("    def values", "values returns 0.0: must be a NamedTuple"),
    ),
    "a metric in words": Wrong(
        *(ROLE, METRIC, {"Counted(m.count)": "Counted('few')"}),
        *("    def values", "zero_crossings of values is 'few': must be a float or a flag"),
    ),
    "no unit of a metric": Wrong(
        *(
            DECLARED,
            METRIC,
            {COUNT: "float"},
        ),
        *("    zero_crossings", "zero_crossings has no unit"),
    ),
    "a metric that is a flag at times": Wrong(
        *(RETURNS, METRIC, {"Counted(m.count)": "Counted(m.count or False)"}),
        *("    def values", "values gives Counted(zero_crossings="),
    ),
    "a whole number in a monitor's step": Wrong(
        *(RETURNS, METRIC, {"0.0), error)": "0.0), 2)"}), *(STEP, "step returns Crossings(count=")
    ),
    "an infinite count": Wrong(
        *(FINITE, METRIC, {"1.0, 0.0)": "1e308, 1e308) * 10.0"}),
        *(STEP, "step gives inf in count for "),
    ),
    "builtins": Wrong(
        *(COMPILED, LAW, {"State(self": "State(0.0 + round(self", "velocity))": "velocity)))"}),
        *("        return State(0.0", "step cannot be compiled: round("),
    ),
}


@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_found_with_its_line(
    wrong: Wrong, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if "def step" in wrong.text:  # the many numbers of a step shrink for half a minute, and none is looked at
        monkeypatch.setattr(contract, "ask", partial(ask, phases=[Phase.generate]))
    text = wrong.text
    for old, new in wrong.changes.items():
        assert old in text
        text = text.replace(old, new, 1)
    cls = block_class(tmp_path, text)
    found = next(iter(answers(cls))) if wrong.question == ROLE else answer(cls, wrong.question)
    assert not found.ok
    assert found.remark.startswith(wrong.remark)
    assert text.splitlines()[found.line - 1].startswith(wrong.line)


def test_other_bits_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = compiled_function(another_force)
    monkeypatch.setattr(behaviour, "compiled_method", lambda *_: other)
    found = answer(block_class(tmp_path, LOAD), COMPILED)
    assert re.match(r"force gives (\S+) in plain Python and 3.0 compiled, for ", found.remark)


def another_force(block: Any, t: float) -> float:
    return 3.0


@pytest.mark.parametrize(
    ("text", "changes", "together"),
    [
        (LOAD, {SIZE: f"{SIZE} / 0.0"}, [[RETURNS]]),
        (LOAD, {"= 2.0": "= -2.0", '"force")': '"force", above=0)'}, [[RANGES]]),
        (LOAD, {SIZE: f"{SIZE} + len(globals())"}, [[COMPILED, IN_C]]),
        (LOAD, {SIZE: f"{SIZE} / (self.size - 2.0)"}, [[RETURNS]]),
        (LAW, {"    gain:": '    mode: str = "fast"\n    gain:'}, [[DECLARED, RANGES]]),
        (LAW, {"= 2.0": "= -2.0", "State(0.0)": "State(0)"}, [[RANGES], [FLOATS]]),
    ],
)
def test_answers_that_are_wrong_for_one_cause_stand_together(
    tmp_path: Path, text: str, changes: dict[str, str], together: list[list[str]]
) -> None:
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new, 1)
    found = list(answers(block_class(tmp_path, text)))
    wrong = [group for group in group_by_cause(found) if not group[0].ok]
    assert [[one.question for one in group] for group in wrong] == together
    if together[0][0] != COMPILED:  # how it behaves can be asked no more
        assert found[-1].question == RETURNS if together == [[RETURNS]] else PICKLES


def test_what_numpy_warns_of_is_not_heard(tmp_path: Path) -> None:
    text = LOAD.replace(SIZE, "return float(np.log(self.size - 2.0) + np.exp(1e6 * t))")
    cls = block_class(tmp_path, text.replace("from itertools import count", "import numpy as np"))
    assert answer(cls, FINITE).remark.startswith("force gives ")  # a warning would be an error here


def test_nothing_is_wrong_with_a_good_block(tmp_path: Path) -> None:
    cls = block_class(tmp_path, LOAD)
    found = list(answers(cls))
    assert [one.question for one in found] == [question.name for question in QUESTIONS]
    assert all(one.ok for one in found), found
    assert {(one.block, one.role) for one in found} == {("Push", "Load")}
    check_block(cls(3.0))


def test_a_monitor_is_asked_all_but_for_c(tmp_path: Path) -> None:
    found = list(answers(block_class(tmp_path, METRIC)))
    assert [one.question for one in found] == [question.name for question in QUESTIONS]
    assert all(one.ok for one in found), found
    assert {one.remark for one in found} == {"", "not tried: a metric is not part of what is exported"}


def test_a_law_that_believes_in_its_machine_is_asked_with_a_model() -> None:
    assert (
        case_of(TSMC).block.model
        == case_of(DAC(controller=example(TSMC))).block.controller.model
        == example(DesignModel)
    )
    known = replace(example(DesignModel), {"plant.mass": 9.0})
    assert case_of(example(TSMC, model=known)).block.model == known


def test_the_same_block_gives_the_same_answers(tmp_path: Path) -> None:
    cls = block_class(tmp_path, LOAD.replace(SIZE, "return self.size * 1e308 * t"))
    assert answer(cls, FINITE) == answer(cls, FINITE)


def test_without_pytest_the_first_thing_that_is_wrong_is_raised(tmp_path: Path) -> None:
    cls = block_class(tmp_path, LOAD.replace("return self.size", "return 2"))
    with pytest.raises(
        ContractError, match=r"^Push returns what its role says\? force returns 2: must be"
    ) as caught:
        check_block(cls)
    assert caught.value.line == 15


class Locked(NamedTuple):
    """A block that is another one after a pickle."""

    size: float = 2.0

    def __reduce__(self) -> Any:
        return Locked, (1.0,)

    def force(self, t: float) -> float:
        return self.size

    def next_jump(self, t: float) -> float:
        return 1e300


def test_a_pickle_that_is_another_block_is_found() -> None:
    assert answer(Locked, PICKLES).remark == "comes back from a pickle as Locked(size=1.0)"


@role(Load, Reference)
class Both(NamedTuple):
    """A force and a demand."""

    def force(self, t: float) -> float:
        return 1.0

    def next_jump(self, t: float) -> float:
        return 1e300

    def at(self, t: float) -> Demand:
        return Demand(1, 0.0, 0.0)


def test_a_block_of_two_roles_is_asked_in_both() -> None:
    found = list(answers(Both))
    assert [one.role for one in found] == ["Load"] * len(QUESTIONS) + ["Reference"] * 7  # returns
    assert next(one.remark for one in found if not one.ok).endswith("whose value is not a float")
    with pytest.raises(ContractError, match=r"has the methods of Load, Reference; ask in one of them"):
        case_of(Both)


def test_a_sensor_may_know_nothing() -> None:
    assert answer(NoPosition, FINITE).ok
    assert answer(NoPosition, IN_C).remark == "not tried: the controller beside it needs the velocity"


REMEMBERING = """
from hydroservo.core.vectors import vector

Memory = vector("Memory", {size}, Field("V", "command, by age"))


class Remembered(NamedTuple):
    u: Annotated[float, Field("V", "command")]
    memory: Memory


@role(Controller)
class Remembering(NamedTuple):
    \"\"\"u = k e + q times the command of some time ago.\"\"\"

    gain: Annotated[float, Field("V s/m", "gain k", above=0)] = 2.0

    def init(self):
        return Remembered(0.0, Memory(*[0.0] * {size}))

    def step(self, s, y, r, dt):
        u = self.gain * (r.value - y.velocity) + 0.5 * s.memory[-1]
        return Remembered(u, s.memory.shifted(u))
"""


@pytest.mark.parametrize("size", [71, 300])
def test_a_state_of_many_numbers_is_no_fault(size: int, tmp_path: Path) -> None:
    needs("cc")
    cls = block_class(tmp_path, LAW + REMEMBERING.replace("{size}", str(size)))
    assert [answer(cls, name) for name in (RETURNS, FINITE, AGAIN, IN_C)] == [
        Answer("Remembering", "Controller", name, ok=True) for name in (RETURNS, FINITE, AGAIN, IN_C)
    ]


@pytest.mark.nightly
def test_what_cannot_be_drawn_is_not_tried(tmp_path: Path) -> None:
    fields = "".join(f"    gain_{i}: {FIELD.replace('V s/m', '')} = 2.0\n" for i in range(4000))
    cls = block_class(tmp_path, LAW.replace("    gain:", f"{fields}    gain:"))
    assert answer(cls, RETURNS) == Answer(
        "Law", "Controller", RETURNS, ok=True, remark="not tried: no inputs were found that it takes"
    )


WEIGHT = """
@role(Mechanism)
class Ram(NamedTuple):
    \"\"\"A weight.\"\"\"

    mass: Annotated[float, Field("kg", "mass", above=0)] = 600.0

    def inertia(self, position):
        return self.mass

    def resistance(self, position, velocity):
        return -9.81 * self.mass
"""
SHORT = "    def positions(self):\n        return -0.01, 0.01\n"


def test_a_weight_that_the_machine_of_the_check_cannot_hold_is_no_fault(tmp_path: Path) -> None:
    needs("cc")
    text = LOAD.replace("import Load", "import Load, Mechanism") + WEIGHT
    assert answer(block_class(tmp_path, text), IN_C) == Answer("Ram", "Mechanism", IN_C, ok=True)
    found = answer(block_class(tmp_path, text + SHORT), IN_C)
    assert found.ok
    assert found.remark.startswith(
        "not tried: the machine of this check does not go with it: plant.mechanism"
    )


def test_bits_in_c_are_compared_where_there_is_a_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    needs("cc")
    assert answer(PI, IN_C) == Answer("PI", "Controller", IN_C, ok=True)
    monkeypatch.setattr(compilers, "COMPILERS", ())
    monkeypatch.delenv("CC", raising=False)
    assert answer(PI, IN_C).remark.startswith("bits not compared: no C compiler was found")


def test_there_is_a_loop_for_a_block_of_each_role() -> None:
    for cls in shipped_classes():
        for one in possible_roles(cls):
            assert loop_with(example(cls), one) is not None, cls
    assert {one for cls in shipped_classes() for one in possible_roles(cls)} == set(ROLES)


def test_there_is_a_loop_for_a_users_block_of_each_role_that_a_scenario_can_name() -> None:
    assert set(ROLES) - {place.kind for place in block_places()} == {Filter, Limiter, Model}


def test_each_question_has_a_test_of_its_name() -> None:
    tests = [name for name in vars(BlockContract) if name.startswith("test_")]
    assert tests == [f"test_{re.sub(r'[^a-z]+', '_', question.name.lower())}" for question in QUESTIONS]


def test_without_hypothesis_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("behaviour", "drawing"):
        monkeypatch.delitem(sys.modules, f"hydroservo.testing.{name}", raising=False)
        monkeypatch.delattr(f"hydroservo.testing.{name}", raising=False)
    monkeypatch.setitem(sys.modules, "hypothesis", None)
    with pytest.raises(HydroservoError, match=r"^hypothesis is needed here: pip install"):
        check_block(PI)


def test_the_package_is_imported_without_what_it_needs_later() -> None:
    code = "import sys, hydroservo.testing; print({'hypothesis', 'numba', 'pytest'} & sys.modules.keys())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


PYTEST = """
from hydroservo.testing import BlockContract
from mine import Push


class TestPush(BlockContract):
    block = Push(3.0)
"""


def test_pytest_asks_of_a_users_block(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(LOAD.replace(SIZE, "return 2"), encoding="utf-8")
    (tmp_path / "test_mine.py").write_text(PYTEST, encoding="utf-8")
    words = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        "-k",
        "fits or documented or returns",
    ]
    done = subprocess.run([*words, "."], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "ContractError: force returns 2: must be a float" in done.stdout
    assert "1 failed, 2 passed, 8 deselected" in done.stdout
