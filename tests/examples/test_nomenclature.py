"""Every symbol that a declared number is explained by stands in the nomenclature."""

import re
from pathlib import Path

import pytest

from hydroservo.core.block import declared_fields
from hydroservo.scenario.registry import PACKAGES

PAGE = Path(__file__).parents[2] / "docs" / "nomenclature.md"
# K_sv, beta_e, d_L1, mu_1; and x1, xi1, f2, a1, written without the underscore in code
SYMBOL = re.compile(r"\b(?:[A-Za-z]+_[A-Za-z]*\d?|(?:xi|zeta|[adfgksvxz])[12])\b")


def symbols(text: str) -> set[str]:
    return {found.replace("_", "").replace("eps", "epsilon") for found in SYMBOL.findall(text)}


def explained() -> set[str]:
    """The symbols of the page: {\\hat d}_{L1} and d_L1 are one, and so are \\xi_1 and xi1."""
    math = re.findall(r"\$([^$]+)\$", PAGE.read_text(encoding="utf-8"))
    bare = (re.sub(r"\\(hat|d*dot)\b|[{}\\_ ]", "", formula) for formula in math)
    return {part for formula in bare for part in re.split(r"[-+=/,]|(?<=[a-z])(?=[A-Z]p)", formula)}


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.__name__)
def test_symbols_are_explained(package: object) -> None:
    classes = (getattr(package, name) for name in package.__all__)  # type: ignore[attr-defined]
    fields = [field for cls in classes for field in declared_fields(cls).values()]
    used = {symbol for field in fields for symbol in symbols(field.meaning)}
    assert used - explained() == set()
