"""Names in C."""

import keyword
import re

__all__ = ["identifier", "is_identifier", "snake"]

KEYWORDS = (
    "auto break case char const continue default do double else enum extern float for goto if inline int "
    "long register restrict return short signed sizeof static struct switch typedef union unsigned void "
    "volatile while bool true false asm main errno"
)
RESERVED = frozenset(KEYWORDS.split(" "))


def snake(name: str) -> str:
    """A class's name as C writes those of types: TSMObserverState is tsm_observer_state."""
    parted = re.sub(r"([A-Z]+)([A-Z][a-z])", r"\1_\2", name)
    return identifier(re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", parted).lower())


def identifier(name: str) -> str:
    """A name that C allows; one that it has taken gets an underscore behind."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    plain = f"_{plain}" if plain[:1].isdigit() else plain
    return f"{plain}_" if plain in RESERVED else plain


def is_identifier(name: str) -> bool:
    """True for a name that C allows and has not taken."""
    return name.isascii() and name.isidentifier() and not keyword.iskeyword(name) and name not in RESERVED
