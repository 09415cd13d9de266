"""Lists on the terminal: names with titles, types with their keys, answers of a check, and TOML."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.syntax import Syntax
from rich.table import Table

from hydroservo.core.field import CONTROLLED
from hydroservo.show.terminal import show

if TYPE_CHECKING:
    from hydroservo.scenario.keys import Description
    from hydroservo.testing import Answer


def show_titles(titles: Mapping[str, str]) -> None:
    """Names and titles of scenarios or studies."""
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for name, text in titles.items():
        table.add_row(f"[bold]{escape(name)}[/]", escape(text))
    show(table)


def show_names(types: Mapping[str, Sequence[str]]) -> None:
    """Types by their roles."""
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for role, names in types.items():
        table.add_row(f"[bold]{escape(role)}[/]", escape(", ".join(names)))
    show(table)


def show_descriptions(found: "Sequence[Description]") -> None:
    """Types of one name in words, each with the keys of its table."""
    for about in found:
        table = Table(caption_justify="left")
        for name in ("key", "default", "unit", "range"):
            table.add_column(name, no_wrap=True)
        table.add_column("meaning")
        for key in about.keys:
            one = key.as_dict()
            default = one["default"] or "[yellow]needed[/]"
            table.add_row(one["name"], default, *(escape(one[name]) for name in ("unit", "range", "meaning")))
        units = [key.as_dict()["unit"] for key in about.keys]
        said = ['a plain number is in this unit; others in quotes, such as "63 mm"'] if any(units) else []
        if any(CONTROLLED in unit for unit in units):
            said.append(f"{CONTROLLED}: the unit of the controlled signal, such as m/s or m")
        table.caption = "\n".join(said)
        heading = f"[bold]{escape(about.name)}[/]: {', '.join(about.roles)}"
        show(heading, "", escape(about.text), "", table if about.keys else "It takes no keys.")


def show_toml(text: str) -> None:
    """A scenario with its syntax in colour, for a terminal."""
    highlighted = Syntax("", "toml", background_color="default").highlight(text)
    Console().print(highlighted, soft_wrap=True, end="")


def show_answers(file: str, causes: "Sequence[Sequence[Answer]]") -> None:
    """What was asked of the blocks of a file, and what came of it; a row for those wrong for one cause."""
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
    if answer.ok:
        return f"[green]ok[/]{escape(f' ({answer.remark})' if answer.remark else '')}"
    place = f"line {answer.line}: " if answer.line else ""
    return f"[bold red]{place}[/]{escape(answer.remark)}"
