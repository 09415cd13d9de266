"""Frequent slips in numbers, units and TOML, and what to write instead."""

import re
from collections.abc import Callable

__all__ = ["quantity_slip", "toml_slip"]

SPACES = " '\N{RIGHT SINGLE QUOTATION MARK}\N{NO-BREAK SPACE}\N{NARROW NO-BREAK SPACE}"
NUMBER = r"[+-]?[0-9]+(?:\.[0-9]+)?"
COMMA = re.compile(
    rf"(?P<whole>[+-]?[0-9]+(?:[.{SPACES}][0-9]{{3}})*),(?P<part>[0-9]+)(?P<rest>[^0-9,.].*|)", re.DOTALL
)
THOUSANDS = re.compile(
    rf"(?P<number>[+-]?[0-9]{{1,3}}(?:[,{SPACES}][0-9]{{3}})+(?:\.[0-9]+)?)(?P<rest>[^0-9].*|)", re.DOTALL
)
RANGE = re.compile(
    rf"{NUMBER}\s*(?:[^\s0-9.]*\s*(?:\.\.+|…|\N{{EN DASH}}|\bto\b)|-)\s*{NUMBER}(?:\s.*|[^\s0-9.].*|)",
    re.DOTALL,
)
TEN = re.compile(
    rf"(?P<number>{NUMBER})\s*[*·\N{{MULTIPLICATION SIGN}}x]\s*10\s*"
    r"(?:\^|\*\*)?\(?(?P<power>[+-]?[0-9]{1,2})\)?(?P<rest>.*)",
    re.DOTALL,
)
SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
IN_BRACKETS = re.compile(rf"(?P<number>{NUMBER}(?:[eE][+-]?[0-9]+)?)\s*\[(?P<unit>[^\[\]]+)\]")

UNQUOTED = re.compile(rf"=\s*(?P<text>{NUMBER}(?:[eE][+-]?[0-9]+)?\s*[A-Za-zµμ°%Ω][^,}}\]#\"]*)")
DECIMAL_COMMA = re.compile(r"=\s*(?P<whole>[+-]?[0-9]+),(?P<part>[0-9]+)\s*(?:$|[#A-Za-z}\]])")
BARE_WORD = re.compile(r"=\s*(?P<text>[A-Za-z][\w.]*)\s*(?:$|[,}\]#])")
STRING = re.compile(r"\"[^\"]*\"|'[^']*'")
PLACE = re.compile(r"\(at line ([0-9]+), column [0-9]+\)$")


def without(signs: str, text: str) -> str:
    return "".join(sign for sign in text if sign not in signs)


def comma(found: re.Match[str]) -> str:
    whole, part, rest = without(f".{SPACES}", found["whole"]), found["part"], found["rest"]
    point = f"'{whole}.{part}{rest}'"
    if len(part) == 3 and len(whole.lstrip("+-")) <= 3:
        return f"has a comma; write {point} or '{whole}{part}{rest}'"
    return f"has a decimal comma; write {point}"


def thousands(found: re.Match[str]) -> str:
    return f"separates thousands; write '{without(f',{SPACES}', found['number'])}{found['rest']}'"


SLIPS: tuple[tuple[re.Pattern[str], Callable[[re.Match[str]], str]], ...] = (
    (COMMA, comma),
    (THOUSANDS, thousands),
    (TEN, lambda found: f"is a product; write '{found['number']}e{int(found['power'])}{found['rest']}'"),
    (RANGE, lambda _: "is a range, and one number is needed; batch, tune and identify take ranges"),
    (IN_BRACKETS, lambda found: f"has brackets around its unit; write '{found['number']} {found['unit']}'"),
)


def quantity_slip(text: str) -> str:
    """What is wrong with a number as half of the world writes it; "" where nothing is known."""
    plain = text.strip().translate(SUPERSCRIPTS)
    matches = ((slip.fullmatch(plain), problem) for slip, problem in SLIPS)
    return next((problem(found) for found, problem in matches if found), "")


def toml_slip(text: str, problem: str) -> str:
    """What to write where TOML cannot be read, to end a message with; "" where nothing is known.

    Args:
        text: of the file.
        problem: what the parser says, with its line.
    """
    lines, place = text.splitlines(), PLACE.search(problem)
    number = int(place[1]) if place else len(lines)
    line = lines[number - 1] if 0 < number <= len(lines) else ""
    if found := DECIMAL_COMMA.search(line):
        return f"; the decimal sign is a point: {found['whole']}.{found['part']}"
    if found := UNQUOTED.search(line):
        return f'; a number with a unit needs quotes: "{found["text"].strip()}"'
    if (found := BARE_WORD.search(line)) and found["text"] not in ("true", "false", "inf", "nan"):
        return f'; a text needs quotes: "{found["text"]}"'
    bare = STRING.sub("", line).partition("#")[0]
    return "; a table in braces is one line" if bare.count("{") > bare.count("}") else ""
