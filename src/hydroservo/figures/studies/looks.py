"""Colours of families and marks of observers, the same in all pictures of a study."""

import math
from collections.abc import Iterable, Mapping
from itertools import cycle

from matplotlib.colors import to_hex, to_rgb

from hydroservo.figures.style import PALETTE

# Source: Okabe and Ito, 2008, and for more than six Paul Tol's muted scheme, 2021.
FAMILIES = (*PALETTE, "#332288", "#882255", "#999933", "#44AA99")
MARKS = ("o", "^", "s", "D", "v", "P", "*", "X")
INK = "#1c2733"
SOFT = "#5b6875"
TIE = "#c3c9cf"
DARK = 0.55  # the luminance below which writing is white
LUMINANCE = (0.2126, 0.7152, 0.0722)  # Source: ITU-R BT.709


def distinct(names: Iterable[str]) -> list[str]:
    """The names without repetitions, in order of their first appearance."""
    return list(dict.fromkeys(names))


def family_colours(families: Iterable[str]) -> dict[str, str]:
    """A colour for each family of laws, in order of appearance; from the eleventh on they come again."""
    return dict(zip(distinct(families), cycle(FAMILIES), strict=False))


def observer_marks(observers: Iterable[str]) -> Mapping[str, str]:
    """A mark for each observer but that without a name; from the ninth on they come again."""
    return dict(zip((name for name in distinct(observers) if name), cycle(MARKS), strict=False))


def paler(colour: str, share: float) -> str:
    """A colour of which a share between 0 (white) and 1 is left."""
    red, green, blue = (1.0 - share * (1.0 - part) for part in to_rgb(colour))
    return to_hex((red, green, blue))


def ink_on(colour: str) -> str:
    """The colour of writing that is readable on another."""
    light = math.fsum(weight * part for weight, part in zip(LUMINANCE, to_rgb(colour), strict=True))
    return "#ffffff" if light < DARK else INK
