"""What is asked of a block, question by question."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from hydroservo.core.errors import HydroservoError
from hydroservo.scenario.role_checks import declared_roles, line_reached, source_file
from hydroservo.testing import declarations
from hydroservo.testing.case import Case, ContractError, case_of

TRANSLATED = {"gives the same bits compiled", "gives the same bits in C"}  # what no compiler takes fails both


class Question(NamedTuple):
    """Something that is asked of a block."""

    name: str  # in a few words
    check: Callable[..., str | None]  # raises a ContractError; may return what was not tried
    examples: int = 0  # how many random blocks and inputs it is asked with; 0 where it needs none
    basis: bool = False  # whether questions of behaviour need it to be answered well
    behaviour: bool = False  # True of what is asked of how it behaves


def behaviour_module() -> ModuleType:
    """The questions that draw random numbers."""
    try:
        from hydroservo.testing import behaviour as found
    except ModuleNotFoundError as error:
        if error.name != "hypothesis":
            raise
        raise HydroservoError("hypothesis is needed here: pip install 'hydroservo[testing]'") from None
    return found


def same_in_c(case: Case) -> str:
    from hydroservo.testing.loops import check_translated

    return check_translated(case)


def of_behaviour(name: str) -> Callable[..., None]:
    """A check of how a block behaves, loaded with hypothesis when it is asked."""

    def check(case: Case, draw: Any) -> None:
        getattr(behaviour_module(), name)(case, draw)

    return check


QUESTIONS = (
    Question("fits its role", declarations.check_fits_role),
    Question("is documented", declarations.check_documented),
    Question("declares its numbers", declarations.check_declared),
    Question("is in its own ranges", declarations.check_own_ranges, basis=True),
    Question("starts with floats, at rest", declarations.check_floats, basis=True),
    Question("pickles", declarations.check_pickles),
    Question("returns what its role says", of_behaviour("check_kinds"), 6, basis=True, behaviour=True),
    Question("stays finite", of_behaviour("check_finite"), 15, behaviour=True),
    Question("gives the same bits compiled", of_behaviour("check_compiled"), 15, behaviour=True),
    Question("gives the same bits again", of_behaviour("check_repeatable"), 6, behaviour=True),
    Question("gives the same bits in C", same_in_c, behaviour=True),
)


def ask(question: Question, case: Case, **settings: Any) -> str:
    """Ask a question, with random examples where it needs them."""
    with np.errstate(all="ignore"):  # what a block makes of odd inputs is for the questions to judge
        return ask_at_random(question, case, settings) if question.examples else question.check(case) or ""


def ask_at_random(question: Question, case: Case, settings: Mapping[str, Any]) -> str:
    """Ask a question with random blocks and inputs."""
    behaviour_module()
    from hypothesis import HealthCheck, Phase, given
    from hypothesis import settings as set_to
    from hypothesis import strategies as st
    from hypothesis.errors import Unsatisfiable

    usual = set_to(
        max_examples=question.examples,
        phases=(Phase.explicit, Phase.reuse, Phase.generate, Phase.shrink),
        deadline=None,  # a first call compiles for a second
        report_multiple_bugs=False,
        suppress_health_check=list(HealthCheck),  # they are about the drawing, not about the block
    )
    once = set_to(usual, **settings)

    @once
    @given(data=st.data())
    def run(data: st.DataObject) -> None:
        question.check(case, data.draw)

    try:
        run()
    except Unsatisfiable:
        return "not tried: no inputs were found that it takes"
    return ""


@dataclass(frozen=True)
class Answer:
    """What came of a question.

    Attributes:
        block: the name of the block's class.
        role: the name of its role; "" where it has none.
        question: what was asked.
        ok: False where the block is not so.
        remark: what is wrong, or what was not tried; "" where all is well.
        line: of the block's file where it is wrong; 0 where that is not known.
    """

    block: str
    role: str
    question: str
    ok: bool
    remark: str = ""
    line: int = 0


def answers(block: Any, role: type | None = None) -> Iterator[Answer]:
    """Ask all of a block, one question after the other; the same block gives the same answers.

    After a block that does not fit its role nothing else is asked, and not how it behaves after one whose
    numbers are not as they must be, or whose methods return something else.

    Args:
        block: the block, or its class.
        role: in which it is asked; each that it says, or the only one whose methods it has, if None.

    Raises:
        HydroservoError: hypothesis is not there.
    """
    behaviour_module()
    cls = block if isinstance(block, type) else type(block)
    try:
        said = declared_roles(cls)
    except ValueError:
        said = ()
    for one in (role,) if role is not None or not said else said:
        yield from answers_in(block, cls, one)


def answers_in(block: Any, cls: type, role: type | None) -> Iterator[Answer]:
    """The answers of a block in one role; None for the only one that it may have."""
    try:
        case = case_of(block, role)
    except ContractError as error:
        name = role.__name__ if role else ""
        yield Answer(cls.__name__, name, QUESTIONS[0].name, False, str(error), error.line)
        return
    sound = True
    for question in QUESTIONS:
        if question.behaviour and not sound:
            return
        answer = answer_question(question, case)
        yield answer
        if question is QUESTIONS[0] and not answer.ok:
            return
        sound = sound and (answer.ok or not question.basis)


def group_by_cause(given: Sequence[Answer]) -> list[list[Answer]]:
    """Answers, with those together that are wrong for one cause: one remark, or one line not translated."""
    groups: list[list[Answer]] = []
    for answer in given:
        same = next((group for group in groups if have_one_cause(group[0], answer)), None)
        if same is None:
            groups.append([answer])
        else:
            same.append(answer)
    return groups


def have_one_cause(first: Answer, answer: Answer) -> bool:
    """Whether two answers are wrong for one cause."""
    if (
        first.ok
        or answer.ok
        or (first.block, first.role, first.line) != (answer.block, answer.role, answer.line)
    ):
        return False
    refused = {first.question, answer.question} == TRANSLATED
    return first.remark == answer.remark or (refused and first.line > 0)


def answer_question(question: Question, case: Case) -> Answer:
    """What comes of a question, with whatever the block's methods raise as a line."""
    about = (case.cls.__name__, case.role.__name__, question.name)
    try:
        remark = ask(question, case, derandomize=True, database=None)
    except ContractError as error:
        return Answer(*about, False, str(error), error.line)
    except Exception as error:  # of the block's own text
        text = f"{type(error).__name__}: {' '.join(str(error).split())}"
        return Answer(*about, False, text, line_reached(error, source_file(case.cls)))
    return Answer(*about, True, remark)


def check_block(block: Any, role: type | None = None) -> None:
    """Ask all of a block; without pytest.

    Args:
        block: the block, or its class.
        role: in which it is asked; that which it says if None.

    Raises:
        ContractError: the first thing that is not as it must be.
        HydroservoError: hypothesis is not there.
    """
    for answer in answers(block, role):
        if not answer.ok:
            raise ContractError(f"{answer.block} {answer.question}? {answer.remark}", answer.line)


class BlockContract:
    """Base of a test class, for pytest: all that is asked of a block, a test each.

    ::

        class TestMyController(BlockContract):
            block = MyController()

    Attributes:
        block: the block, or its class.
        role: in which it is asked; that which it says if None.
    """

    block: Any
    role: type | None = None

    def ask(self, name: str) -> None:
        """Ask a question by its name."""
        question = next(one for one in QUESTIONS if one.name == name)
        ask(question, case_of(self.block, self.role))

    def test_fits_its_role(self) -> None:
        self.ask("fits its role")

    def test_is_documented(self) -> None:
        self.ask("is documented")

    def test_declares_its_numbers(self) -> None:
        self.ask("declares its numbers")

    def test_is_in_its_own_ranges(self) -> None:
        self.ask("is in its own ranges")

    def test_starts_with_floats_at_rest(self) -> None:
        self.ask("starts with floats, at rest")

    def test_pickles(self) -> None:
        self.ask("pickles")

    def test_returns_what_its_role_says(self) -> None:
        self.ask("returns what its role says")

    def test_stays_finite(self) -> None:
        self.ask("stays finite")

    def test_gives_the_same_bits_compiled(self) -> None:
        self.ask("gives the same bits compiled")

    def test_gives_the_same_bits_again(self) -> None:
        self.ask("gives the same bits again")

    def test_gives_the_same_bits_in_c(self) -> None:
        self.ask("gives the same bits in C")
