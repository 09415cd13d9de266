"""All commands, each imported once it is asked for; what one raises becomes a line and an exit status."""

import os
import shlex
import sys
import warnings
from collections import UserDict
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache, partial
from itertools import pairwise
from pkgutil import resolve_name
from traceback import walk_tb
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup
from typer.main import get_group

from hydroservo._version import __version__
from hydroservo.cli.interrupts import INTERRUPTED, acknowledge_interrupt
from hydroservo.cli.messages import SAID
from hydroservo.core.command_scale import commands_in
from hydroservo.core.errors import (
    HydroservoError,
    HydroservoWarning,
    LoopError,
    ParameterError,
    clipped,
    defect,
    nearest,
    one_line,
    system_problem,
)

PLACES = {  # in the order of the help
    "run": "run:run_command",
    "compare": "run:compare_command",
    "batch": "batch:batch_command",
    "tune": "tune:tune_command",
    "study": "studies:study_command",
    "limit": "analysis:limit_command",
    "linearize": "analysis:linearize_command",
    "bode": "analysis:bode_command",
    "identify": "identify:identify_command",
    "map": "identify:map_command",
    "log": "identify:log_command",
    "check": "check:check_command",
    "audit": "analysis:audit_command",
    "describe": "listings:describe_command",
    "schema": "listings:schema_command",
    "app": "run:app_command",
    "paper": "studies:paper_command",
    "scenarios": "listings:scenarios_app",
    "parts": "listings:parts_app",
    "studies": "listings:studies_app",
    "export": "export:export_app",
}
USER_ERROR, DEFECT = 2, 1
TRACEBACK = "HYDROSERVO_TRACEBACK"  # in the environment: what is unexpected is shown whole
UsageError: Any = typer.BadParameter.__base__  # click's, or that of typer's own copy of click


class LateCommands(UserDict[str, Any]):
    """Commands by name, each imported once it is asked for."""

    def __getitem__(self, name: str) -> Any:
        return command_of(name, self.data[name])


@cache
def command_of(name: str, place: str) -> Any:
    """The command that a function is, or a group of some."""
    found, holder = resolve_name(f"hydroservo.cli.{place}"), typer.Typer(rich_markup_mode="markdown")
    add = partial(holder.add_typer, name=name) if isinstance(found, typer.Typer) else holder.command(name)
    add(found)
    return get_group(holder).commands[name]


class Commands(TyperGroup):
    """The commands, with what they raise turned into a message and an exit status."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.commands = LateCommands(PLACES)

    def main(self, args: Sequence[str] | None = None, *others: Any, **options: Any) -> NoReturn:
        try:
            check_words(sys.argv[1:] if args is None else args)
            sys.exit(super().main(args, *others, **{**options, "standalone_mode": False}))
        except UsageError as error:
            if error.format_message():  # if not, help has been shown
                say_error(usage_problem(error))
            sys.exit(USER_ERROR)
        except OSError as error:  # of --help and --version, which are printed before any command
            say_error(system_problem(error))
            sys.exit(USER_ERROR)

    def invoke(self, ctx: Any) -> Any:
        try:
            SAID.clear()  # of the command before, in one process
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", HydroservoWarning)  # a result has them; the command says them
                with commands_in(None):
                    result = super().invoke(ctx)
            sys.stdout.flush()
        except HydroservoError as error:
            say_error(str(error))
            raise typer.Exit(USER_ERROR) from error
        except KeyboardInterrupt as error:
            acknowledge_interrupt(interrupted_method(error))
            raise typer.Exit(INTERRUPTED) from error
        except BrokenPipeError as error:
            raise typer.Exit(1) from error  # the reader, such as head, has all it wants
        except OSError as error:
            say_error(system_problem(error))
            raise typer.Exit(USER_ERROR) from error
        except MemoryError as error:  # numpy's says how much was asked for, Python's own nothing
            why = f": {one_line(str(error))}" if str(error) else ""
            say_error(f"there is too little memory{why}; record less often, or run fewer at once")
            raise typer.Exit(USER_ERROR) from error
        except ImportError as error:  # of a module that the system does not let load, or that is not there
            say_error(f"a library cannot be loaded: {one_line(str(error))}")
            raise typer.Exit(USER_ERROR) from error
        except (typer.Exit, typer.Abort, UsageError):
            raise
        except Exception as error:
            if TRACEBACK in os.environ:
                raise
            say_error(f"{defect(error)}; with {TRACEBACK}=1 in the environment it says where")
            raise typer.Exit(DEFECT) from error
        return result


def check_words(words: Sequence[str]) -> None:
    """Refuse a word that is empty, as a shell makes it of a variable that is not set, or not UTF-8.

    An empty path would be the current folder, and reports and results hold the names of files as UTF-8.
    """
    for before, word in pairwise(["", *words]):
        name, mark, value = word.partition("=")
        if not word.strip() or (mark and name.startswith("--") and not value.strip()):
            after = f" after {before}" if before else ""
            raise UsageError(f"{name} is empty" if mark else f"the word{after} is empty")
        try:
            word.encode()
        except UnicodeEncodeError:
            encoding = sys.getfilesystemencoding().upper()  # ASCII where a locale knows nothing else
            raise UsageError(f"{word!r} is not {encoding}, as all words must be") from None


class ListingGroup(TyperGroup):
    """The commands on what has names, which a name alone is taken for."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        try:
            return super().resolve_command(ctx, args)
        except UsageError as error:
            if "Did you mean" not in error.message:
                said = shlex.join(["hydroservo", ctx.info_name, "show", args[0]])
                error.message = f"{error.message.removesuffix('.')}; {said} prints what has that name"
            raise


@contextmanager
def errors_name_scenario(scenario: str) -> Iterator[None]:
    """Errors of a run, whose loop does not know where it is from, name its scenario."""
    try:
        yield
    except (ParameterError, LoopError) as error:
        raise HydroservoError(f"{scenario}: {error}") from error


def interrupted_method(error: BaseException) -> str:
    """Which method of a block of a user's own was interrupted, for one may never return; none for others."""
    for frame, line in reversed([*walk_tb(error.__traceback__)]):
        kind, code = type(frame.f_locals.get("self")), frame.f_code
        if hasattr(kind, "_fields") and not kind.__module__.startswith("hydroservo."):
            return f" in {kind.__name__}.{code.co_name} ({code.co_filename}, line {line})"
    return ""


def say_error(message: str) -> None:
    typer.echo(f"hydroservo: {message}", err=True)


def usage_problem(error: Any) -> str:
    """What is wrong with the words of a command, and where it is said what they may be."""
    words = error.ctx.command_path.split(" ")[1:] if error.ctx else []
    path = " ".join(["hydroservo", *words])  # whatever the program was started as
    if hasattr(error, "possibilities"):  # an option that is not there
        options = [name for param in error.ctx.command.params for name in param.opts]
        text = error.message + nearest(error.option_name, options)
    else:
        text = error.format_message().removesuffix(".").replace(": Value error, ", ": ")
    return clipped(one_line(f"{text[:1].lower()}{text[1:]}"), 1000) + f" (see {path} --help)"


app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
)


def print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"hydroservo {__version__}")
        raise typer.Exit


@app.callback()
def main_options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=print_version, is_eager=True, help="Print the version and exit."),
    ] = False,
) -> None:
    """Simulate servo-hydraulic axes, and tune, compare and export their controllers.

    Start with `hydroservo scenarios` and `hydroservo run paper/sine-tsmc`.
    """
