"""The nearest right name for a wrong one."""

from collections.abc import Iterable
from difflib import get_close_matches

LONGEST = 64  # characters; hardly a right name is longer, and matching takes the square of it


def nearest(wrong: str, right: Iterable[str]) -> str:
    """A question to end a message with: "; did you mean PI?", or nothing where no name is near."""
    if len(wrong) > LONGEST:
        return ""
    names = {name.lower(): name for name in right}
    near = get_close_matches(wrong.lower(), names, n=1)
    return f"; did you mean {names[near[0]]}?" if near else ""


def one_of(wrong: str, right: Iterable[str]) -> str:
    """What a name must be, and the nearest one."""
    names = list(right)
    return f"must be one of {', '.join(names)}{nearest(wrong, names)}"
