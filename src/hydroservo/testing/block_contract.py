"""Asks all of a block, with pytest."""

from typing import Any

from hydroservo.testing.case import case_of
from hydroservo.testing.questions import QUESTIONS, ask


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
