"""Asks all of a block, without pytest."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from hydroservo.scenario.fits import declared_roles, line_reached
from hydroservo.testing.case import Case, ContractError, case_of
from hydroservo.testing.questions import QUESTIONS, Question, ask, behaviour_module

TRANSLATED = {"gives the same bits compiled", "gives the same bits in C"}  # what no compiler takes fails both


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
        answer = answer_to(question, case)
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


def answer_to(question: Question, case: Case) -> Answer:
    """What comes of a question, with whatever the block's methods raise as a line."""
    about = (case.cls.__name__, case.role.__name__, question.name)
    try:
        remark = ask(question, case, derandomize=True, database=None)
    except ContractError as error:
        return Answer(*about, False, str(error), error.line)
    except Exception as error:  # of the block's own text
        text = f"{type(error).__name__}: {' '.join(str(error).split())}"
        return Answer(*about, False, text, line_reached(error, case.cls))
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
