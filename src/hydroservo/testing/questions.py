"""What is asked of a block, question by question."""

from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from hydroservo.core.errors import HydroservoError
from hydroservo.testing import declarations
from hydroservo.testing.case import Case


class Question(NamedTuple):
    """Something that is asked of a block.

    Attributes:
        name: in a few words.
        check: raises a ContractError where the block is not so; may return what of it was not tried.
        examples: how many random blocks and inputs it is asked with; 0 where it needs none.
        basis: True where how a block behaves can be asked only of one that is so.
        behaviour: True of what is asked of how it behaves.
    """

    name: str
    check: Callable[..., str | None]
    examples: int = 0
    basis: bool = False
    behaviour: bool = False


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
    from hydroservo.testing.translation import check_translated

    return check_translated(case)


def returns_as_declared(case: Case, draw: Any) -> None:
    behaviour_module().check_kinds(case, draw)


def stays_finite(case: Case, draw: Any) -> None:
    behaviour_module().check_finite(case, draw)


def same_compiled(case: Case, draw: Any) -> None:
    behaviour_module().check_compiled(case, draw)


def same_again(case: Case, draw: Any) -> None:
    behaviour_module().check_repeatable(case, draw)


QUESTIONS = (
    Question("fits its role", declarations.check_fits_role),
    Question("is documented", declarations.check_documented),
    Question("declares its numbers", declarations.check_declared),
    Question("is in its own ranges", declarations.check_own_ranges, basis=True),
    Question("starts with floats, at rest", declarations.check_floats, basis=True),
    Question("pickles", declarations.check_pickles),
    Question("returns what its role says", returns_as_declared, 6, basis=True, behaviour=True),
    Question("stays finite", stays_finite, 15, behaviour=True),
    Question("gives the same bits compiled", same_compiled, 15, behaviour=True),
    Question("gives the same bits again", same_again, 6, behaviour=True),
    Question("gives the same bits in C", same_in_c, behaviour=True),
)


def ask(question: Question, case: Case, **settings: Any) -> str:
    """Ask a question, with random examples where it needs them.

    Args:
        question: the question.
        case: of whom.
        settings: of hypothesis, in place of the usual ones.

    Returns:
        What of it was not tried; "" if nothing.
    """
    with np.errstate(all="ignore"):  # what a block makes of odd inputs is for the questions to judge
        return (
            question.check(case) or "" if not question.examples else ask_at_random(question, case, settings)
        )


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
