"""Tables on the terminal, in the units an engineer reads."""

import math
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.syntax import Syntax
from rich.table import Table

from hydroservo.cli.outcome import Outcome
from hydroservo.metrics import METRIC_FIELDS
from hydroservo.results import readable_unit

if TYPE_CHECKING:
    from rich.console import RenderableType

    from hydroservo.papers.tsmc_eha_2021.study import Verdict

__all__ = ["show", "show_comparison", "show_run", "show_scenarios", "show_toml", "show_verdicts"]

PIPED_WIDTH = 120  # characters a line where there is no terminal to ask
SMALLER_IS_BETTER = (
    "rms_error",
    "max_error",
    "steady_rms_error",
    "steady_max_error",
    "settling_time",
    "overshoot",
    "control_rms",
    "control_total_variation",
    "control_max",
    "estimate_rms_error_1",
    "estimate_rms_error_2",
)


def show(*things: "RenderableType") -> None:
    """Print to stdout, in colour if that is a terminal."""
    console = Console(width=None if sys.stdout.isatty() else PIPED_WIDTH, highlight=False)
    for thing in things:
        console.print(thing)


def show_run(outcome: Outcome) -> None:
    """The metrics of one run and its verdict."""
    heading = f"{escape(outcome.scenario)}   (hash {outcome.hash}, seed {outcome.seed})"
    table = Table(title=heading, title_justify="left")
    table.add_column("metric", no_wrap=True)
    table.add_column("value", justify="right", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    table.add_column("meaning")
    for name, field in METRIC_FIELDS.items():
        unit, (text,) = row([outcome], name)
        table.add_row(name, text, unit, field.meaning)
    show(table, verdict(outcome.metrics))


def show_comparison(outcomes: Sequence[Outcome], labels: Sequence[str]) -> None:
    """The metrics of several runs side by side, the best of each row marked."""
    table = Table(caption="* best of the runs that did not diverge", caption_justify="left")
    table.add_column("metric", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    for label in labels:
        table.add_column(escape(label), justify="right", overflow="fold")
    for name in METRIC_FIELDS:
        unit, values = row(outcomes, name)
        best = best_of(outcomes, name)
        marked = [f"[bold green]{text} *[/]" if i in best else f"{text}  " for i, text in enumerate(values)]
        table.add_row(name, unit, *marked)
    notes = [
        f"{escape(label)}: {verdict(outcome.metrics)}"
        for label, outcome in zip(labels, outcomes, strict=True)
        if outcome.metrics["diverged"] or outcome.metrics["stroke_left"]
    ]
    show(table, *notes)


def row(outcomes: Sequence[Outcome], name: str) -> tuple[str, list[str]]:
    """One metric of each run as text, in a common unit."""
    values = [outcome.metrics[name] for outcome in outcomes]
    finite = [abs(value) for value in values if math.isfinite(value)]
    unit, factor = readable_unit(METRIC_FIELDS[name].unit, max(finite, default=0.0))
    return unit, [as_text(value, factor) for value in values]


def as_text(value: float | bool, factor: float) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{factor * value:.4g}" if math.isfinite(value) else "-"


def best_of(outcomes: Sequence[Outcome], name: str) -> set[int]:
    """Which runs have the best value of a metric; none where there is nothing to choose between."""
    if name not in SMALLER_IS_BETTER:
        return set()
    runs = {
        i: outcome.metrics[name]
        for i, outcome in enumerate(outcomes)
        if not outcome.metrics["diverged"] and math.isfinite(outcome.metrics[name])
    }
    best = {i for i, value in runs.items() if value == min(runs.values())}
    return best if len(best) < len(runs) else set()


def verdict(metrics: Mapping[str, float | bool]) -> str:
    """In one line: did the run diverge, did the piston leave its stroke?"""
    if metrics["diverged"]:
        return "[bold red]DIVERGED[/]: a state stopped being finite, or the error passed ten peak demands."
    if metrics["stroke_left"]:
        low, high = 1e3 * metrics["position_min"], 1e3 * metrics["position_max"]
        return f"[bold yellow]LEFT THE STROKE[/]: the piston went from {low:.4g} mm to {high:.4g} mm."
    return "[green]The run did not diverge, and the piston stayed inside its stroke.[/]"


def show_scenarios(titles: Mapping[str, str]) -> None:
    """Names and titles of scenarios."""
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for name, text in titles.items():
        table.add_row(f"[bold]{escape(name)}[/]", escape(text))
    show(table)


def show_toml(text: str) -> None:
    """A scenario with its syntax in colour, for a terminal."""
    highlighted = Syntax("", "toml", background_color="default").highlight(text)
    Console().print(highlighted, soft_wrap=True, end="")


def show_verdicts(verdicts: "Sequence[Verdict]") -> None:
    """The paper's claims, each as judged at the paper's own conditions and over all conditions."""
    table = Table()
    table.add_column("claim")
    table.add_column("what it says")
    table.add_column("as reproduced")
    table.add_column("to the letter")
    table.add_column("over all conditions", justify="right")
    for one in verdicts:
        tally = f"holds in {one.holds} of {one.total}"
        judged = (holds(one.at_paper), holds(one.to_the_letter))
        table.add_row(escape(one.claim), escape(one.title), *judged, tally)
    show(table)


def holds(true: bool) -> str:
    return "[green]holds[/]" if true else "[red]fails[/]"
