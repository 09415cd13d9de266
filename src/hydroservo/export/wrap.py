"""Lines of C that fit a page."""

import re

from hydroservo.errors import one_line

__all__ = ["WIDTH", "comment", "in_comment", "unended", "wrapped"]

WIDTH = 110
BREAKS = re.compile(r"(?<=, )|(?= [-+*/?:] )|(?= && )|(?= \|\| )|(?<= = )")
MARKUP = re.compile(r"``|(?<=:):$|:\w+:(?=`)|`~?", re.MULTILINE)


def wrapped(line: str, depth: int) -> str:
    """A line as several where it is too long, parted where the fewest brackets are open."""
    if len(line) <= WIDTH:
        return line
    pad = "    " * (depth + 1)
    cut = best_break(line, pad)
    if cut is None:
        return line
    return f"{line[:cut].rstrip()}\n{wrapped(pad + line[cut:].lstrip(), depth)}"


def best_break(line: str, pad: str) -> int | None:
    """The last of the outermost places at which a line may be parted."""
    opened, best = 0, None
    places = {match.start() for match in BREAKS.finditer(line)}
    for i, letter in enumerate(line[: WIDTH + 1]):
        depth = opened + line[:i].endswith(" = ")  # as far out as the arguments of a call behind it
        if i in places and line[:i].strip() and i > len(pad) and (best is None or depth <= best[0]):
            best = (depth, i)
        opened += (letter in "([{") - (letter in ")]}")
    return None if best is None else best[1]


def comment(text: str) -> str:
    """A comment of one or more lines, from a text that may be marked up as docstrings are."""
    printable = map(one_line, MARKUP.sub("", text).expandtabs().split("\n"))
    plain = unended("\n".join(printable)).rstrip()
    lines = plain.split("\n")
    if len(lines) == 1 and len(plain) + 6 <= WIDTH:
        return f"/* {plain} */\n"
    return "\n".join(["/*", *(f" * {line}".rstrip() for line in lines), " */", ""])


def unended(text: str) -> str:
    """A text that neither begins nor ends a comment, whatever its lines end with.

    A backslash at the end of a line joins it with the next one before comments are looked for; ??/ is one.
    """
    whole = re.sub(r"\\[ \t\\]*$", "", text.replace("??", "? ?"), flags=re.MULTILINE)
    return whole.replace("*/", "* /").replace("/*", "/ *")


def in_comment(text: str) -> str:
    """A text of one line for the inside of a comment."""
    return unended(one_line(" ".join(text.split()))).strip()
