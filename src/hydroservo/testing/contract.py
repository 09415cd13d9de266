"""The contract of a block: what is asked of each, as a list, as a function, and as a base of test classes."""

from collections.abc import Callable, Iterator
from types import ModuleType
from typing import Any, NamedTuple

from hydroservo.block import Block
from hydroservo.errors import HydroservoError
from hydroservo.scenario.fits import roles_of, said_roles
from hydroservo.testing import declarations
from hydroservo.testing.case import Case, ContractError
from hydroservo.testing.lines import line_of, line_reached

__all__ = ["QUESTIONS", "Answer", "BlockContract", "Question", "answers", "case_of", "check_block"]


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


class Answer(NamedTuple):
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
        settings: of hypothesis.

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

    once = set_to(
        max_examples=question.examples,
        phases=(Phase.explicit, Phase.reuse, Phase.generate, Phase.shrink),
        deadline=None,  # a first call compiles for a second
        report_multiple_bugs=False,
        **settings,
    )

    @once
    @given(data=st.data())
    def run(data: st.DataObject) -> None:
        question.check(case, data.draw)

    run()
    return ""


def case_of(block: Any, role: type | None = None) -> Case:
    """A block to be asked, by itself or by its class, whose defaults it then has.

    Args:
        block: the block or its class.
        role: in which it is asked; the one that it says, or whose methods it has, if None.

    Raises:
        ContractError: the class has no defaults, or the role is not clear.
    """
    cls = block if isinstance(block, type) else type(block)
    return Case(example_of(block) if isinstance(block, type) else block, role or only_role(cls))


def only_role(cls: type) -> type:
    """The role that a class says, or the only one whose methods it has."""
    try:
        roles = roles_of(cls)
    except ValueError as error:
        raise ContractError(str(error), line_of(cls)) from None
    names = [role.__name__ for role in roles]
    if not roles:
        raise ContractError("says no role, and has not the methods of any", line_of(cls))
    if len(roles) > 1:
        way = "ask in one of them" if said_roles(cls) else "say which it is, by @role(...) above the class"
        raise ContractError(f"has the methods of {', '.join(names)}; {way}", line_of(cls))
    return roles[0]


def example_of(cls: Any) -> Block:
    """A block with the defaults of its class."""
    given = getattr(cls, "_field_defaults", {})
    open_fields = [name for name in cls._fields if name not in given]
    if open_fields:
        problem = f"has no default for {', '.join(open_fields)}: give one, or ask of an example"
        raise ContractError(problem, line_of(cls, open_fields[0]))
    return cls()


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
        """Ask a question by its name.

        Raises:
            ContractError: the block is not so.
        """
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
