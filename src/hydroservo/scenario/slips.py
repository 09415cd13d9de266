"""Frequent slips in numbers, units and TOML, and what to write instead."""

import re
from collections.abc import Callable

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
    r"(?:\^|\*\*)\s*\(?(?P<power>[+-]?[0-9]{1,2})\)?(?P<rest>[^0-9].*|)",
    re.DOTALL,
)
RAISED = re.compile("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+")
SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
IN_BRACKETS = re.compile(rf"(?P<number>{NUMBER}(?:[eE][+-]?[0-9]+)?)\s*\[(?P<unit>[^\[\]]+)\]")

UNQUOTED = re.compile(rf"=\s*(?P<text>{NUMBER}(?:[eE][+-]?[0-9]+)?\s*[A-Za-zµμ°%Ω][^,}}\]#\"]*)")
DECIMAL_COMMA = re.compile(r"=\s*(?P<whole>[+-]?[0-9]+),(?P<part>[0-9]+)\s*(?:$|[#A-Za-z}\]])")
BARE_WORD = re.compile(r"=\s*(?P<text>[A-Za-z][\w.]*)\s*(?:$|[,}\]#])")
STRING = re.compile(r"\"[^\"]*\"|'[^']*'")
PLACE = re.compile(r"\(at line ([0-9]+), column [0-9]+\)$")


def strip_signs(signs: str, text: str) -> str:
    return "".join(sign for sign in text if sign not in signs)


def comma_problem(match: re.Match[str]) -> str:
    whole, part, rest = strip_signs(f".{SPACES}", match["whole"]), match["part"], match["rest"]
    point = f"'{whole}.{part}{rest}'"
    if len(part) == 3 and len(whole.lstrip("+-")) <= 3:
        return f"has a comma; write {point} or '{whole}{part}{rest}'"
    return f"has a decimal comma; write {point}"


def thousands_problem(match: re.Match[str]) -> str:
    return f"separates thousands; write '{strip_signs(f',{SPACES}', match['number'])}{match['rest']}'"


SLIPS: tuple[tuple[re.Pattern[str], Callable[[re.Match[str]], str]], ...] = (
    (COMMA, comma_problem),
    (THOUSANDS, thousands_problem),
    (TEN, lambda match: f"is a product; write '{match['number']}e{int(match['power'])}{match['rest']}'"),
    (RANGE, lambda _: "is a range; give one number here (ranges are for batch, tune and identify)"),
    (IN_BRACKETS, lambda match: f"has brackets around its unit; write '{match['number']} {match['unit']}'"),
)


def quantity_slip(text: str) -> str:
    """Advice on a number as half of the world writes it; "" where there is none."""
    plain = RAISED.sub(lambda match: f"^{match[0].translate(SUPERSCRIPTS)}", text.strip())
    matches = ((slip.fullmatch(plain), problem) for slip, problem in SLIPS)
    return next((problem(match) for match, problem in matches if match), "")


def toml_slip(text: str, problem: str) -> str:
    """Advice on a text that is not TOML, to end a message with; "" where there is none.

    Args:
        text: of the file.
        problem: what the parser says, with its line.
    """
    lines, place = text.splitlines(), PLACE.search(problem)
    number = int(place[1]) if place else len(lines)
    line = lines[number - 1] if 0 < number <= len(lines) else ""
    if match := DECIMAL_COMMA.search(line):
        return f"; the decimal sign is a point: {match['whole']}.{match['part']}"
    if match := UNQUOTED.search(line):
        return f'; a number with a unit needs quotes: "{match["text"].strip()}"'
    if (match := BARE_WORD.search(line)) and match["text"] not in ("true", "false", "inf", "nan"):
        return f'; a text needs quotes: "{match["text"]}"'
    bare = STRING.sub("", line).partition("#")[0]
    return "; a table in braces is one line" if bare.count("{") > bare.count("}") else ""
