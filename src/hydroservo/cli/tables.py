"""Tables on the terminal, in the units an engineer reads."""

import math
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.syntax import Syntax
from rich.table import Table

from hydroservo.cli.summary import RunSummary
from hydroservo.field import CONTROLLED, Field
from hydroservo.formatting import Scale, quantity, scales_of, yes_or_no
from hydroservo.runs.behaviour import behaviour
from hydroservo.runs.divergence import BEYOND

if TYPE_CHECKING:
    from rich.console import RenderableType

    from hydroservo.papers.tsmc_eha_2021.study import Verdict
    from hydroservo.scenario.descriptions import Description
    from hydroservo.testing import Answer

NO_NUMBER = "-"
WELL = (
    "[green]The run did not diverge.[/]",
    "[green]The run did not diverge, and the piston stayed inside its stroke.[/]",
)
PIPED_WIDTH = 120  # characters a line where there is no terminal to ask


def show(*things: "RenderableType") -> None:
    """Print to stdout, in colour if that is a terminal."""
    console = Console(width=None if sys.stdout.isatty() else PIPED_WIDTH, highlight=False, emoji=False)
    for thing in things:
        console.print(thing)


def show_run(summary: RunSummary, fields: Mapping[str, Field], said: str) -> None:
    """The metrics of one run, declared by their fields, its verdict, and what else is said of it."""
    show(run_table(summary, fields), *verdict(summary, fields), *filter(None, [escape(said)]))


def run_table(summary: RunSummary, fields: Mapping[str, Field]) -> Table:
    """The metrics of one run, declared by their fields."""
    heading = f"{escape(summary.scenario)}   (hash {summary.hash}, seed {summary.seed})"
    table = Table(title=heading, title_justify="left")
    table.add_column("metric", no_wrap=True)
    table.add_column("value", justify="right", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    table.add_column("meaning")
    own = had([summary], fields)
    scales = scales_in([summary], own)
    for name, field in own.items():
        scale = scales[field.unit]
        table.add_row(name, *row([summary], name, scale), scale.label, field.meaning)
    return table


def show_comparison(
    summaries: Sequence[RunSummary],
    labels: Sequence[str],
    fields: Mapping[str, Field],
    winners: Mapping[str, set[int]],
    unequal: Sequence[str],
) -> None:
    """The metrics of several runs side by side, the best of each row marked, and in what else they differ."""
    table = comparison_table(summaries, labels, fields, winners)
    show(table, *map(escape, unequal), *verdicts_of(summaries, labels, fields))


def comparison_table(
    summaries: Sequence[RunSummary],
    labels: Sequence[str],
    fields: Mapping[str, Field],
    winners: Mapping[str, set[int]],
) -> Table:
    """The metrics of several runs side by side, the best of each row marked."""
    table = Table(caption_justify="left")
    table.add_column("metric", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    for label in labels:
        table.add_column(escape(label), justify="right", overflow="fold")
    own = had(summaries, fields)
    scales = scales_in(summaries, own)
    for name, field in own.items():
        values = row(summaries, name, scales[field.unit])
        best = alike(values, winners.get(name, set()), summaries)
        marked = [f"[bold green]{text} *[/]" if i in best else f"{text}  " for i, text in enumerate(values)]
        table.add_row(name, scales[field.unit].label, *marked)
        if best:
            table.caption = "* best of the runs that did not diverge"
    return table


def verdicts_of(
    summaries: Sequence[RunSummary], labels: Sequence[str], fields: Mapping[str, Field]
) -> list[str]:
    """Lines for each run that diverged, left the stroke or oscillates."""
    return [
        f"{escape(label)}: {line}"
        for label, summary in zip(labels, summaries, strict=True)
        for line in verdict(summary, fields)
        if line not in WELL
    ]


def had(summaries: Sequence[RunSummary], fields: Mapping[str, Field]) -> dict[str, Field]:
    """The declarations of those metrics that some run has."""
    return {name: field for name, field in fields.items() if any(name in one.metrics for one in summaries)}


def alike(texts: Sequence[str], best: set[int], summaries: Sequence[RunSummary]) -> set[int]:
    """The best runs, with those whose number reads the same; none where all do."""
    shown = {texts[i] for i in best}
    judged = {
        i for i, summary in enumerate(summaries) if not summary.metrics["diverged"] and texts[i] != NO_NUMBER
    }
    found = {i for i in judged if texts[i] in shown}
    return found if found < judged else set()


def row(summaries: Sequence[RunSummary], name: str, scale: Scale) -> list[str]:
    """One metric of each run as text; "-" for a run that does not have it."""
    return [as_text(value, scale) for value in values_of(summaries, name)]


def values_of(summaries: Sequence[RunSummary], name: str) -> list[float]:
    """One metric of each run; nan for a run that does not have it."""
    return [summary.metrics.get(name, math.nan) for summary in summaries]


def scales_in(summaries: Sequence[RunSummary], fields: Mapping[str, Field]) -> dict[str, Scale]:
    """The one unit of each quantity of a table of metrics, by its SI unit."""
    return scales_of((field.unit, values_of(summaries, name)) for name, field in fields.items())


def as_text(value: float | bool, scale: Scale) -> str:
    """A number in characters that every terminal has."""
    if isinstance(value, bool):
        return yes_or_no(value)
    return f"{scale.of(value):.4g}" if math.isfinite(value) else NO_NUMBER


def verdict(summary: RunSummary, fields: Mapping[str, Field]) -> list[str]:
    """In a line each: whether the run diverged and by what, left its stroke, oscillates or cavitates."""
    metrics = summary.metrics
    if metrics["diverged"]:
        cause, time = escape(summary.diverged_by), quantity(metrics["diverged_at"], "s")
        what = cause if BEYOND in cause else f"{cause} stopped being finite"
        return [f"[bold red]DIVERGED[/]: {what} at {time}."]
    lines = [WELL["stroke_left" in metrics]]
    if metrics.get("stroke_left"):
        low, high = 1e3 * metrics["position_min"], 1e3 * metrics["position_max"]
        lines = [f"[bold yellow]LEFT THE STROKE[/]: the piston went from {low:.4g} mm to {high:.4g} mm."]
    return [*lines, *(f"[bold yellow]{escape(line)}[/]" for line in behaviour(metrics, fields))]


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


def show_verdicts(verdicts: "Sequence[Verdict]") -> None:
    """The paper's claims, each judged as reproduced, to the letter of the print and over all conditions."""
    table = Table()
    table.add_column("claim")
    table.add_column("what it says")
    table.add_column("as reproduced")
    table.add_column("to the letter")
    table.add_column("over all conditions", justify="right")
    for one in verdicts:
        tally = f"holds in {one.holds} of {one.total}"
        judged = (holds(one.reproduced), holds(one.to_the_letter))
        table.add_row(escape(one.claim), escape(one.title), *judged, tally)
    show(table)


def holds(true: bool) -> str:
    return "[green]holds[/]" if true else "[red]fails[/]"
