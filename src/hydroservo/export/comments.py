"""Texts of people as comments of C."""

import re

from hydroservo.errors import one_line

WIDTH = 110  # of the longest line, as of the docstrings that comments come from
MARKUP = re.compile(r"``|(?<=:):$|:\w+:(?=`)|`~?", re.MULTILINE)


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
