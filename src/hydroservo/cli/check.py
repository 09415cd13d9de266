"""The command that asks of a user's blocks what hydroservo asks of its own."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydroservo.cli.commands import USER_ERROR, say_error
from hydroservo.cli.messages import progress_bar
from hydroservo.cli.options import Json
from hydroservo.core.errors import ScenarioError
from hydroservo.core.outputs import temporary_folder

if TYPE_CHECKING:
    from hydroservo.testing import Answer

NOTES = "HYPOTHESIS_STORAGE_DIRECTORY"  # in the environment: where hypothesis keeps what it saw of files

File = Annotated[Path, typer.Argument(metavar="FILE", help="A Python file, executed as --plugin would.")]


def check_command(file: File, json: Json = False) -> None:
    """Check that each block in a Python file is what a block must be.

    That it has all that belongs to its role, declares its numbers, stays finite, gives the same bits in
    plain Python, compiled, and in C as an export writes it, and more. The answers give the line of
    what is wrong, and the exit status is 2 if anything is.

    Examples:

    - `hydroservo check my_controller.py`
    - `hydroservo check my_controller.py --json`
    """
    from hydroservo.show.files import as_json
    from hydroservo.testing.contract import group_by_cause

    blocks = blocks_in(file)
    with discard_hypothesis_notes(), progress_bar(str(file)) as report:
        found = list(ask_blocks(blocks, report))
    wrong = [answer for answer in found if not answer.ok]
    causes = group_by_cause(found)
    if json:
        typer.echo(as_json({"file": str(file), "ok": not wrong, "answers": [asdict(one) for one in found]}))
    else:
        show_answers(str(file), causes)
    if wrong:
        say_error(f"{file}: {summarize_answers(found, sum(not group[0].ok for group in causes))}")
        raise typer.Exit(USER_ERROR)


def summarize_answers(found: "Sequence[Answer]", causes: int) -> str:
    """How much is wrong, and what was not asked for that."""
    from hydroservo.testing.contract import QUESTIONS

    wrong = sum(not answer.ok for answer in found)
    blocks = {(answer.block, answer.role) for answer in found}
    left = len(blocks) * len(QUESTIONS) - len(found)
    text = f"{wrong} of {len(found)} answers are wrong"
    text += f", for {causes} cause{'s' if causes > 1 else ''}" if causes < wrong else ""
    return text + (f"; {left} more can be checked once that is fixed" if left else "")


@contextmanager
def discard_hypothesis_notes() -> Iterator[None]:
    """What hypothesis keeps goes into a temporary folder; without that, into one beside the user's files."""
    if NOTES in os.environ:
        yield
        return

    with temporary_folder() as folder:
        os.environ[NOTES] = str(folder)
        try:
            yield
        finally:
            del os.environ[NOTES]


def blocks_in(file: Path) -> Sequence[type]:
    """The classes of a file that say a role or have the methods of one."""
    from hydroservo.scenario import load_plugin
    from hydroservo.scenario.registry import plugin_other_classes
    from hydroservo.scenario.role_checks import possible_roles

    found = [cls for cls in load_plugin(file) if possible_roles(cls)]
    if not found:
        others = ", ".join(sorted(plugin_other_classes()))
        problem = (
            "has no block: no class declares a role, as with @role(Controller), or has the methods of one"
        )
        problem += f"; not NamedTuples, as blocks are: {others}" if others else ""
        raise ScenarioError(str(file), "", problem)
    return found


def ask_blocks(blocks: Sequence[type], report: Any) -> Iterator["Answer"]:
    from hydroservo.testing import answers
    from hydroservo.testing.contract import QUESTIONS

    for i, cls in enumerate(blocks):
        for j, answer in enumerate(answers(cls)):
            yield answer
            done = min(i + (j + 1) / len(QUESTIONS), i + 1)
            report(done / len(blocks), cls.__name__)


def show_answers(file: str, causes: "Sequence[Sequence[Answer]]") -> None:
    """What was asked of the blocks of a file, and what came of it; a row for those wrong for one cause."""
    from rich.markup import escape
    from rich.table import Table

    from hydroservo.show.terminal import show

    table = Table(title=escape(file), title_justify="left")
    table.add_column("block", no_wrap=True)
    table.add_column("role", no_wrap=True)
    table.add_column("asked", no_wrap=True)
    table.add_column("answer", overflow="fold")
    before = None
    for group in causes:
        about = (group[0].block, group[0].role)
        if before not in (None, about):
            table.add_section()
        shown = ("", "") if before == about else map(escape, about)
        table.add_row(*shown, "\n".join(one.question for one in group), answer_text(group[-1]))
        before = about
    show(table)


def answer_text(answer: "Answer") -> str:
    from rich.markup import escape

    if answer.ok:
        return f"[green]ok[/]{escape(f' ({answer.remark})' if answer.remark else '')}"
    place = f"line {answer.line}: " if answer.line else ""
    return f"[bold red]{place}[/]{escape(answer.remark)}"
