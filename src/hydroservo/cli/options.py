"""Options that several commands take."""

import os
import shlex
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from glob import escape
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydroservo.cli.messages import say_warning, warn_of_sizes
from hydroservo.core.builtin import titles
from hydroservo.core.errors import HydroservoError, HydroservoWarning, ParameterError, ScenarioError, short
from hydroservo.show.journal import FIGURE_FORMATS, FigureWidth

if TYPE_CHECKING:
    from hydroservo.control.loop import Loop
    from hydroservo.scenario.tables import TableEntry

VARY = "--vary"
LONGEST = 4096  # characters of one option
WHERE = "A name with an ending is a file; one without, or with a / at its end, is a folder."


def scenarios_like(incomplete: str) -> list[str]:
    """Built-in scenarios, and TOML files and folders, whose names begin so."""
    return [*names_starting(titles("scenario"), incomplete), *files_like(incomplete)]


def studies_like(incomplete: str) -> list[str]:
    """Built-in studies, and TOML files and folders, whose names begin so."""
    return [*names_starting(titles("studies"), incomplete), *files_like(incomplete)]


def parts_like(incomplete: str) -> list[str]:
    """Built-in parts, and TOML files and folders, whose names begin so."""
    from hydroservo.scenario.part_files import part_texts

    return [*names_starting(part_texts(), incomplete), *files_like(incomplete)]


def types_like(incomplete: str) -> list[str]:
    """Roles and types whose names begin so."""
    from hydroservo.scenario.descriptions import types_by_role

    roles = types_by_role()
    types = {name for names in roles.values() for name in names}
    return sorted(names_starting({"simulation", *roles, *types}, incomplete))


def names_starting(names: Iterable[str], incomplete: str) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]


def files_like(incomplete: str) -> Iterator[str]:
    typed = Path(incomplete)
    folder, name = (typed, "") if incomplete.endswith("/") or not incomplete else (typed.parent, typed.name)
    for path in sorted(folder.glob(f"{escape(name)}*")):
        if path.is_dir():
            yield f"{path}/"
        elif path.suffix == ".toml":
            yield str(path)


def list_option(name: str, metavar: str, text: str) -> Any:
    """An option that may be given again, a list of what it was given."""
    text = f"{text} May be given again."
    return typer.Option(name, metavar=metavar, default_factory=list, show_default=False, help=text)


Scenario = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO",
        help="A scenario file (TOML), or the name of a built-in one.",
        autocompletion=scenarios_like,
    ),
]
LogScenario = Annotated[
    str | None,
    typer.Option(
        "--scenario",
        metavar="SCENARIO",
        autocompletion=scenarios_like,
        help="A scenario file (TOML), or the name of a built-in one: what is known of the machine, and in "
        "`[identify.columns]` which column of a log holds which signal.",
    ),
]
Scenarios = Annotated[
    list[str],
    typer.Argument(
        metavar="SCENARIO",
        help="Scenario files (TOML) or names of built-in ones.",
        autocompletion=scenarios_like,
    ),
]
Changes = Annotated[
    list[str],
    list_option(
        "--set",
        "a.b=VALUE",
        "Change one entry of the scenario: `plant.mass=8kg`, `simulation.period='100 us'`, "
        "`controller.type=PI`. A plain number is in SI units.",
    ),
]
Plugins = Annotated[
    list[Path],
    list_option(
        "--plugin",
        "FILE",
        "Run this Python file, whose blocks a scenario may then name as a type, or allow this FMU.",
    ),
]
FigureSize = Annotated[
    FigureWidth | None,
    typer.Option(
        "--figure-size",
        help="Write each picture as a figure for a journal too, into the folder figures of --out, as wide as "
        "one column of two or as both.",
    ),
]
FigureFormat = Annotated[
    str | None,
    typer.Option(
        "--figure-format",
        metavar="F,F,...",
        show_default="svg,pdf",
        help=f"Formats of these figures: {', '.join(FIGURE_FORMATS)}; without a size they are as wide as the "
        "report's. pgf needs a LaTeX installation.",
    ),
]
DecimalComma = Annotated[
    bool,
    typer.Option(
        "--decimal-comma",
        help="Write CSV for spreadsheets with decimal commas; semicolons separate the cells.",
    ),
]
Threads = Annotated[
    int | None,
    typer.Option("--threads", metavar="N", min=1, show_default="all cores", help="How many threads to use."),
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
CommandAt = Annotated[
    str | None,
    typer.Option(
        "--command",
        metavar="COMMAND",
        help="Command under which the machine has settled: `0.2V`, or in the scenario's unit of commands. "
        "Without it, that of a steady start, or 0.",
    ),
]
Force = Annotated[
    str | None,
    typer.Option(
        "--load", metavar="FORCE", help="Force on the rod: `2kN`. Without it, the scenario's load at t = 0."
    ),
]


def vary_option(help_text: str) -> Any:
    """The option that gives numbers ranges, in the words of a command."""
    return list_option(VARY, "PATH=LOW..HIGH", help_text)


def parse_quantity(option: str, text: str | None, unit: str) -> float | None:
    """The number in an SI unit that an option says, with its unit or in SI; None where it is not given."""
    from hydroservo.scenario.quantities import si_value

    if text is None:
        return None
    try:
        return float(text)
    except ValueError:
        pass
    try:
        return si_value(text, unit)
    except ValueError as error:
        raise ParameterError(option, text, str(error)) from None


def log_columns_of(scenario: str, changes: Sequence[str], plugins: Sequence[Path]) -> dict[str, Any]:
    """Which column of a log holds which signal, as a scenario says."""
    from hydroservo.identification.log import log_mapping
    from hydroservo.scenario import assemble, parse_override

    return log_mapping(assemble(scenario, dict(map(parse_override, changes)), plugins).log_columns)


def load_loop(scenario: str, changes: Sequence[str], plugins: Sequence[Path]) -> "Loop":
    """The loop of a scenario with what ``--set`` changes in it; what its files warn of is said on stderr."""
    from hydroservo.scenario import parse_override

    return load_with_warnings(scenario, dict(map(parse_override, changes)), plugins)


def load_with_warnings(
    scenario: str | Path, changes: Mapping[str, object], plugins: Sequence[str | Path]
) -> "Loop":
    """What :func:`~hydroservo.load_scenario` returns; what its files warn of is said on stderr.

    So is a size that no machine has, before a run of it that may take long.
    """
    from hydroservo.scenario import load_scenario

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", HydroservoWarning)
        loop = load_scenario(scenario, changes, plugins)
    ours = [str(one.message) for one in said if one.category is HydroservoWarning]
    for text in ours:
        say_warning(str(scenario), text)
    warn_of_sizes(str(scenario), loop)
    for one in said:
        if one.category is not HydroservoWarning:  # of a plug-in, or of a library
            warnings.showwarning(one.message, one.category, one.filename, one.lineno)
    return loop


def check_one_place(workers: int | None, scheduler: str | None) -> None:
    """Refuse processes of this machine where a scheduler's workers are to do it."""
    if workers is not None and scheduler is not None:
        raise HydroservoError(
            "--workers run on this machine, and --scheduler has its own: give one of the two"
        )


def parse_ranges(texts: Sequence[str], option: str = VARY) -> "dict[str, TableEntry]":
    """The texts LOW..HIGH of ``--vary PATH=LOW..HIGH`` by path, each path once."""
    from hydroservo.scenario.ranges import as_entries
    from hydroservo.scenario.scenario_files import PATH

    found: dict[str, str] = {}
    for text in texts:
        path, equals, value = (part.strip() for part in text.partition("="))
        if not (equals and ".." in value and PATH.fullmatch(path)) or len(text) > LONGEST:
            raise ScenarioError(option, "", f"{short(text)} must be of the form PATH=LOW..HIGH")
        if path in found:
            raise ScenarioError(option, path, "is given twice")
        found[path] = value
    return as_entries(found, option)


def replay_command(
    command: Sequence[str], changes: Sequence[str], plugins: Sequence[Path], settings: Mapping[str, float]
) -> str:
    """A command for a shell, with settings by path that go before the changes given."""
    from hydroservo.scenario import parse_override

    kept = [change for change in changes if parse_override(change)[0] not in settings]
    words = list(command)
    for change in (*kept, *(f"{path}={value!r}" for path, value in settings.items())):
        words += ["--set", change]
    for plugin in plugins:
        words += ["--plugin", str(plugin)]
    return shlex.join(words)


def is_folder(text: str, endings: Sequence[str] = ()) -> bool:
    """Whether a name means a folder: it has no ending, or a slash at its end, or there is such a folder."""
    path = Path(text)
    ending = path.suffix.lower()
    return text.endswith(("/", os.sep)) or not ending or (ending not in endings and path.is_dir())


def folder_at(text: str | Path) -> Path:
    """The folder that ``--out`` of a command names that leaves several files."""
    path, typed = Path(text), os.fspath(text)
    if not is_folder(typed):
        raise typer.BadParameter(f"{typed!r} is a file, by its ending; for a folder write {f'{typed}/'!r}")
    if path.exists() and not path.is_dir():
        raise typer.BadParameter(f"{typed!r} is a file, and this command writes into a folder")
    return path


def file_at(text: str | Path) -> Path:
    """The file that ``--out`` of a command names that leaves one."""
    typed = os.fspath(text)
    if is_folder(typed):
        raise typer.BadParameter(f"{typed!r} is a folder, and this command writes a file, with an ending")
    return Path(text)
