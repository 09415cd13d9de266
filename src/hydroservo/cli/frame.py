"""The frame of commands: what all of them do with what they find."""

import inspect
import shlex
import shutil
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, TypeVar

import typer

from hydroservo.cli.messages import Report, progress_bar, say_warning
from hydroservo.cli.options import WHERE, DecimalComma, FigureFormat, FigureSize, Json, folder_at, is_folder
from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.core.outputs import OutputError, check_outputs, existing_folder, written_or_kept
from hydroservo.show.files import METRICS, REPORT, as_json, origin_in, write_finding
from hydroservo.show.journal import NO_JOURNAL, Journal, journal_of

if TYPE_CHECKING:
    from hydroservo.show import Finding

LOOKS = ("decimal_comma", "figure_format", "figure_size")  # of the files alone
NO_MATTER = ("out", "threads", "workers", "scheduler", "json", "verbose", *LOOKS)  # for what is found

MIB = 2**20  # bytes
Result = TypeVar("Result")
PICTURE_ENDINGS = (".png", ".svg", ".pdf")


def words_of(context: Any) -> list[str]:
    """The words of a command: of one in a group, those of both."""
    return [*words_of(context.parent), str(context.info_name)] if context.parent else ["hydroservo"]


def typed_command(context: typer.Context, left_out: Collection[str] = NO_MATTER) -> list[str]:
    """The running command: its start, then each option, quoted for a shell."""
    parts = [words_of(context)]
    for parameter in context.command.params:
        name = str(parameter.name)
        source = context.get_parameter_source(name)
        if name in left_out or source is None or source.name != "COMMANDLINE":
            continue
        value = context.params[name]
        values = [str(one) for one in (value if isinstance(value, list) else [value])]
        if parameter.param_type_name == "argument":
            parts[0] += values
        elif isinstance(value, bool):
            parts.append([parameter.opts[0] if value else parameter.secondary_opts[0]])
        else:
            parts += [[parameter.opts[0], one] for one in values]
    return [shlex.join(part) for part in parts]


def repeat_command(context: typer.Context) -> str:
    """The command that makes a report again, into a folder."""
    first, *options = typed_command(context, set(NO_MATTER) - set(LOOKS))
    return " \\\n    ".join([f"{first} --out DIR", *options])


class Written(NamedTuple):
    """What became of files."""

    files: Sequence[Path] = ()  # those that took their places
    failure: Exception | None = None  # why others did not, and where they are instead; None if all did

    def check(self) -> None:
        """Fail if something could not be written; to be called after everything else has been printed."""
        if self.failure is not None:
            raise self.failure


def combine_written(first: Written, second: Written) -> Written:
    """What became of two lots of files; of two failures, a defect goes before what could not be written."""
    failures = [one for one in (first.failure, second.failure) if one is not None]
    failures.sort(key=lambda one: isinstance(one, OutputError))
    failure = failures[0] if failures else None
    if len(failures) == 2 and not isinstance(failure, OutputError):
        failures[0].add_note(str(failures[1]))
    elif len(failures) == 2:
        failure = OutputError("; ".join(map(str, failures)))
    return Written([*first.files, *second.files], failure)


def try_outputs(files: Sequence[Path], size: int = 0) -> None:
    """Before a computation, check that its files can be written; warn if ``size`` bytes are not free."""
    check_outputs(files)
    for folder in dict.fromkeys(existing_folder(file) for file in files):
        free = shutil.disk_usage(folder).free
        if free < size:
            said = f"{free / MIB:.3g} MiB are free, and about {size / MIB:.3g} MiB may be needed"
            typer.echo(f"hydroservo: warning: {folder}: {said}", err=True)


def write_or_keep(folder: Path | None, write: Callable[[Path], Sequence[Path]]) -> Written:
    """Write files into a folder, if there is one: all, or into a temporary folder that the failure names."""
    try:
        return Written(() if folder is None else written_or_kept(folder, write))
    except Exception as error:  # whatever it is, what was computed is worth showing
        return Written((), error)


class CommandOutput(NamedTuple):
    """How a command answers: what its user wants of its finding."""

    context: typer.Context  # of the command line
    folder: Path | None = None  # for a report; None without one
    file: Path | None = None  # for a picture or another file of the finding alone; None without one
    files: Sequence[Path] = ()  # those that a command writes itself
    journal: Journal = NO_JOURNAL  # what figures a journal is to have
    json: bool = False  # whether the numbers are printed as JSON

    def present(
        self,
        name: str,
        compute: "Callable[[Report], Result]",
        describe: "Callable[[Result], Finding]",
        *,
        size: int = 0,
        others: Sequence[Path] = (),
        write_more: Callable[[Result], Written] | None = None,
    ) -> Result:
        """Compute a result, write it where it was wanted or can be kept, show its finding and return it.

        Its largest file takes about ``size`` bytes; ``others`` are files that ``compute`` or ``write_more``
        writes besides."""

        folder = self.file.parent if self.file else self.folder
        known = [self.file] if self.file else [folder / METRICS, folder / REPORT] if folder else []
        files = [*known, *others]
        self.check_commas(files)
        try_outputs(files, size)
        with progress_bar(name) as report:
            result = compute(report)
            if files:
                report(1.0, "writing files")
            left = write_more(result) if write_more else Written()
            finding = describe(result)
            left = combine_written(left, write_or_keep(folder, lambda place: self.write(place, finding)))
        for remark in finding.remarks:
            say_warning(name, remark)
        if self.json:
            typer.echo(as_json(finding.numbers))
        else:
            from hydroservo.show.terminal import show_finding

            show_finding(finding)
            list_files(self.folder, left.files)
        left.check()
        return result

    def check_commas(self, files: Sequence[Path]) -> None:
        """Refuse decimal commas where no CSV file is written."""
        tables = self.folder or any(one.suffix.lower() == ".csv" for one in files)
        if self.journal.decimal_comma and not tables:
            problem = "changes CSV files, and this command writes none; add --out DIR"
            raise HydroservoError(f"--decimal-comma {problem}")

    def write(self, place: Path, finding: "Finding") -> list[Path]:
        """Write the report of a finding into a folder, or the one file that is wanted of it."""
        if self.file is None:
            return write_finding(place, finding, repeat_command(self.context), self.journal)
        file, ending = place / self.file.name, self.file.suffix.lower()
        if ending in PICTURE_ENDINGS:
            return [finding.pictures[0].draw().save(file, origin=origin_in(finding))]
        for name, write in finding.files.items():
            if name.endswith(ending):
                write(file)
        return [file]


def with_output(
    about: str = "Write the results to this folder.", endings: Sequence[str] = (), *, several: bool = False
) -> Callable[[Callable[..., Any]], Callable[..., None]]:
    """Decorate a command so that the options of its output reach it as one ``output``."""
    shape, more = ("FILE|DIR" if endings else "DIR"), (" May be given again." if several else "")
    option = typer.Option(
        "--out", metavar=shape, parser=str if endings else folder_at, help=f"{about}{more} {WHERE}"
    )
    out: Any = list[str] if several else str if endings else Path
    options = {
        "out": (Annotated[out | None, option], None),
        "figure_size": (FigureSize, None),
        "figure_format": (FigureFormat, None),
        "decimal_comma": (DecimalComma, False),
        "json": (Json, False),
    }
    own = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind)
        for name, (kind, default) in options.items()
    ]
    context = inspect.Parameter("context", inspect.Parameter.KEYWORD_ONLY, annotation=typer.Context)

    def framed(command: Callable[..., Any]) -> Callable[..., None]:
        @wraps(command)
        def called(**given: Any) -> None:
            wanted = {name: given.pop(name) for name in ("context", *options)}
            command(**given, output=output_from(wanted, endings, several=several))

        signature = inspect.signature(command, eval_str=True)
        parameters = [
            one.replace(kind=inspect.Parameter.KEYWORD_ONLY)
            for name, one in signature.parameters.items()
            if name != "output"
        ]
        place = list(signature.parameters).index("output")
        parameters[place:place] = own
        called.__signature__ = inspect.Signature([context, *parameters])  # type: ignore[attr-defined]
        called.__annotations__ = {one.name: one.annotation for one in (context, *parameters)}
        return called

    return framed


def output_from(wanted: Mapping[str, Any], endings: Sequence[str], *, several: bool) -> CommandOutput:
    """Build the answer from the values of its options."""
    out = wanted["out"]
    files, folder = files_and_folder(out if several else [out], endings) if out and endings else ([], out)
    journal = journal_of(wanted["figure_format"], wanted["figure_size"], folder, wanted["decimal_comma"])
    file = files[0] if files and not several else None
    return CommandOutput(
        wanted["context"], folder or None, file, files if several else (), journal, wanted["json"]
    )


def files_and_folder(texts: Sequence[str], endings: Sequence[str]) -> tuple[list[Path], Path | None]:
    """The files that ``--out`` names, and the folder; None if it names none."""
    folders = [text for text in texts if is_folder(text, endings)]
    files = [Path(text) for text in texts if text not in folders]
    for file in files:
        if file.suffix.lower() not in endings:
            allowed = f"must end in one of {', '.join(endings)}, or be a folder, with a / at its end"
            raise ParameterError("--out", str(file), allowed)
    if len(folders) > 1:
        raise HydroservoError(f"--out: {folders[0]} and {folders[1]} are both folders; give one, and files")
    return files, Path(folders[0]) if folders else None


def list_files(folder: Path | None, files: Sequence[Path]) -> None:
    """Say which files were written; those of a folder by their names in it, tables and figures as folders."""
    inside = [file.relative_to(folder) for file in files if folder and file.is_relative_to(folder)]
    others = [str(file) for file in files if not (folder and file.is_relative_to(folder))]
    if others:
        typer.echo(f"written: {', '.join(others)}")
    if inside:
        names = dict.fromkeys(one.name if one.parent == Path() else f"{one.parts[0]}/" for one in inside)
        typer.echo(f"written to {folder}: {', '.join(names)}")
