"""Asks all of a block, without pytest."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from hydroservo.scenario.fits import said_roles
from hydroservo.scenario.lines import line_reached
from hydroservo.testing.case import Case, ContractError, case_of
from hydroservo.testing.questions import QUESTIONS, Question, ask, behaviour

__all__ = ["Answer", "answer_of", "answers", "check_block"]


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

    After a block that does not fit its role nothing else is asked.

    Args:
        block: the block, or its class.
        role: in which it is asked; each that it says, or the only one whose methods it has, if None.

    Raises:
        HydroservoError: hypothesis is not there.
    """
    behaviour()
    cls = block if isinstance(block, type) else type(block)
    try:
        said = said_roles(cls)
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
    for question in QUESTIONS:
        answer = answer_of(question, case)
        yield answer
        if question is QUESTIONS[0] and not answer.ok:
            return


def answer_of(question: Question, case: Case) -> Answer:
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
