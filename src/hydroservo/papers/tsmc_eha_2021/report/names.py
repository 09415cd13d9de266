"""The names of the paper's controllers, runs and conditions in the report, with symbols, as they are set."""

import re
from collections.abc import Mapping
from typing import Any

import xarray as xr

from hydroservo.core.formatting import MINUS, NONE
from hydroservo.papers.tsmc_eha_2021.claims import Condition, PaperRun

SIGNS = {"+-": "±", "<=": "≤", "-Delta": f"{MINUS}Δ", "Delta": "Δ", "m/s^2": "m/s²"}
GREEK = ("alpha", "beta", "delta", "mu", "rho", "xi", "zeta")  # as HTML names them
LETTER = "|".join(GREEK)
SYMBOL = re.compile(
    r"(?P<code>\b[a-z]+(?:\.[a-z_0-9]*[a-z_0-9])+(?: = \w+)?)"  # the name of a parameter
    r"|\^\((?P<power>[^()]*)\)"
    rf"|\b(?P<base>{LETTER}|[A-Za-z]{{1,2}})(?:_(?P<named>[A-Za-z0-9]+)|(?P<index>\d))\b"
    rf"|\b(?P<greek>{LETTER})\b"
)
Trajectories = Mapping[str, xr.Dataset]  # the six runs shown, by demand and controller, such as "sine-tsmc"

FLAGS = ("demand_jumps", "stroke_left", "diverged")  # the metrics that are true or false
NAMES = {"pi": "PI", "backstepping": "backstepping", "tsmc": "TSMC"}
DELTAS = {-1: f"{MINUS}Δ", 0: "nominal", 1: "+Δ"}  # the six uncertain parameters


def html_symbols(text: str) -> Any:
    """Plain text as HTML in which symbols look like symbols and names of parameters like code."""
    from markupsafe import Markup, escape

    return Markup(SYMBOL.sub(html_symbol, str(escape(plain_signs(text)))))  # noqa: S704 - escaped just before


def plain_signs(text: str) -> str:
    """The text with the signs that it stands for: ± for +-, a true minus, Δ for Delta."""
    for typed, read in SIGNS.items():
        text = text.replace(typed, read)
    text = re.sub(r"(?<=\d) us\b", " µs", text)
    return re.sub(r"(?<=[ (])-(?=[ \w])", MINUS, text)


def html_symbol(found: re.Match[str]) -> str:
    if found["code"]:
        return f"<code>{found['code']}</code>"
    if found["power"]:
        return f"<sup>{SYMBOL.sub(html_symbol, found['power'])}</sup>"
    base = found["base"] or found["greek"]
    sub = found["named"] or found["index"]
    return f"<i>{f'&{base};' if base in GREEK else base}</i>" + (f"<sub>{sub}</sub>" if sub else "")


def mathematical(text: str) -> str:
    """The text with its symbols set as matplotlib sets them."""
    return re.sub(r"d_L(\d)", r"$d_{L\1}$", text)


def run_name(demand: str, controller: str) -> str:
    """A run of some condition, such as "PI on the sine"."""
    return f"{NAMES[controller]} on the {demand}"


def condition_name(condition: Condition | PaperRun) -> list[str]:
    """The five parts of a condition, each as it is read."""
    return [
        condition.reading,
        DELTAS[condition.delta],
        condition.realisation or NONE,
        condition.valve,
        plain_signs(condition.period),
    ]
