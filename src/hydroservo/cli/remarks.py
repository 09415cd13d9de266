"""What commands say of runs beside their results."""

from typing import TYPE_CHECKING

import typer

from hydroservo.runs.cautions import WithAttributes, warnings_of

if TYPE_CHECKING:
    from hydroservo.loop import Loop

SAID: set[str] = set()  # warnings of this command


def say_remarks(scenario: str, run: WithAttributes) -> None:
    """What there is to say of a run's integration steps, and its warnings, on stderr."""
    about = run.attrs
    if "substeps" in about:
        typer.echo(
            f"{scenario}: {about['substeps']} substeps a sample; twice as many differ by "
            f"{about['step_error']:.1e} of the machine's largest values",
            err=True,
        )
    for line in warnings_of(run):
        say_warning(scenario, line)


def say_sizes(scenario: str, loop: "Loop") -> None:
    """A size that no machine has, before a run of it that may take long, on stderr."""
    from hydroservo.runs.sizes import size_cautions

    for text in size_cautions(loop):
        say_warning(scenario, text)


def say_warning(scenario: str, text: str) -> None:
    """A warning in one line on stderr, once a command: what is known before a run is in its result too."""
    line = f"hydroservo: warning: {scenario}: {text}"
    if line not in SAID:
        SAID.add(line)
        typer.echo(line, err=True)
