"""Options that several commands take."""

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydroservo.cli.remarks import say_warning
from hydroservo.errors import HydroservoWarning

if TYPE_CHECKING:
    from hydroservo.loop import Loop

__all__ = ["Changes", "Json", "Plugins", "Scenario", "Strict", "Verbose", "loaded"]

Scenario = Annotated[
    str, typer.Argument(metavar="SCENARIO", help="A scenario file (TOML), or the name of a built-in one.")
]
Changes = Annotated[
    list[str],
    typer.Option(
        "--set",
        metavar="a.b=VALUE",
        default_factory=list,
        show_default=False,
        help="Change one entry of the scenario: `plant.mass=8kg`, "
        "`simulation.period='100 us'`, `controller.type=PI`. A plain number is in SI units. "
        "May be given again.",
    ),
]
Plugins = Annotated[
    list[Path],
    typer.Option(
        "--plugin",
        metavar="FILE",
        default_factory=list,
        show_default=False,
        help="Run this Python file, whose blocks a scenario may then name as a type. May be given again.",
    ),
]
Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object, in SI units, and nothing else on stdout.")
]
Strict = Annotated[
    bool, typer.Option("--strict", help="Round after every operation: the same bits everywhere, slower.")
]
Verbose = Annotated[
    bool,
    typer.Option(
        "--verbose",
        help="Say on stderr whether machine code was compiled or found on disk, and why it cannot be kept.",
    ),
]


def loaded(scenario: str, changes: Sequence[str], plugins: Sequence[Path]) -> "Loop":
    """The loop of a scenario with what ``--set`` changes in it; what its files warn of is said on stderr."""
    from hydroservo.scenario import load_scenario, parse_override

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", HydroservoWarning)
        loop = load_scenario(scenario, dict(map(parse_override, changes)), plugins)
    ours = [str(one.message) for one in said if one.category is HydroservoWarning]
    for text in dict.fromkeys(ours):
        say_warning(scenario, text)
    for one in said:
        if one.category is not HydroservoWarning:  # of a plug-in, or of a library
            warnings.showwarning(one.message, one.category, one.filename, one.lineno)
    return loop
