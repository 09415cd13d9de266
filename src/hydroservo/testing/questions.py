"""What is asked of a block, question by question."""

from collections.abc import Callable
from types import ModuleType
from typing import Any, NamedTuple

from hydroservo.errors import HydroservoError
from hydroservo.testing import declarations
from hydroservo.testing.case import Case

__all__ = ["QUESTIONS", "Question", "ask", "behaviour"]


class Question(NamedTuple):
    """Something that is asked of a block.

    Attributes:
        name: in a few words.
        check: raises a ContractError where the block is not so; may return what of it was not tried.
        examples: how many random blocks and inputs it is asked with; 0 where it needs none.
    """

    name: str
    check: Callable[..., str | None]
    examples: int = 0


def behaviour() -> ModuleType:
    """The questions that draw random numbers.

    Raises:
        HydroservoError: hypothesis, which draws them, is not there.
    """
    try:
        from hydroservo.testing import behaviour as found
    except ModuleNotFoundError as error:
        if error.name != "hypothesis":
            raise
        raise HydroservoError("hypothesis is needed here: pip install 'hydroservo[testing]'") from None
    return found


def translated(case: Case) -> str:
    from hydroservo.testing.translation import check_translated

    return check_translated(case)


QUESTIONS = (
    Question("fits its role", declarations.check_role),
    Question("is documented", declarations.check_documented),
    Question("declares its numbers", declarations.check_declared),
    Question("is in its own ranges", declarations.check_numbers),
    Question("starts with floats, at rest", declarations.check_floats),
    Question("pickles", declarations.check_pickles),
    Question("returns what its role says", lambda case, draw: behaviour().check_kinds(case, draw), 6),
    Question("stays finite", lambda case, draw: behaviour().check_finite(case, draw), 15),
    Question("gives the same bits compiled", lambda case, draw: behaviour().check_compiled(case, draw), 15),
    Question("gives the same bits again", lambda case, draw: behaviour().check_repeatable(case, draw), 6),
    Question("gives the same bits in C", translated),
)


def ask(question: Question, case: Case, **settings: Any) -> str:
    """Ask a question, with random examples where it needs them.

    Args:
        question: the question.
        case: of whom.
        settings: of hypothesis, in place of the usual ones.

    Returns:
        What of it was not tried; "" if nothing.

    Raises:
        ContractError: the block is not so. What its methods raise comes through.
    """
    if not question.examples:
        return question.check(case) or ""
    behaviour()
    from hypothesis import Phase, given
    from hypothesis import settings as set_to
    from hypothesis import strategies as st

    usual = set_to(
        max_examples=question.examples,
        phases=(Phase.explicit, Phase.reuse, Phase.generate, Phase.shrink),
        deadline=None,  # a first call compiles for a second
        report_multiple_bugs=False,
    )
    once = set_to(usual, **settings)

    @once
    @given(data=st.data())
    def run(data: st.DataObject) -> None:
        question.check(case, data.draw)

    run()
    return ""
