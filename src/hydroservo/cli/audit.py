"""The command that asks whether a loop is what its law supposes."""

from typing import TYPE_CHECKING, Any

import typer

from hydroservo.cli.options import Changes, Json, Plugins, Scenario, loaded

if TYPE_CHECKING:
    from hydroservo.audits import Asked, Audit

__all__ = ["audit"]


def audit(scenario: Scenario, changes: Changes, plugins: Plugins, json: Json = False) -> None:
    """Check what a scenario's law assumes of its loop, and predict its chatter.

    Each assumption has a margin, the factor by which it holds: bounds on disturbances, the sample rate, the
    valve's lag, noise, limits. Those marked "run" are measured on one run. Chatter is predicted by harmonic
    balance, without a run.

    Examples:

    - `hydroservo audit paper/sine-tsmc`
    - `hydroservo audit rig/1khz-tsmc-sine --set valve.time_constant=4ms --json`
    """
    from hydroservo.audits import audit as audited
    from hydroservo.cli.progress import progress_bar
    from hydroservo.runs.results import as_json

    loop = loaded(scenario, changes, plugins)
    with progress_bar(scenario):
        found = audited(loop)
    if json:
        typer.echo(as_json(as_object(scenario, found)))
    else:
        from hydroservo.cli.audit_tables import show_audit

        show_audit(scenario, found)


def as_object(scenario: str, found: "Audit") -> dict[str, Any]:
    """What ``--json`` prints."""
    return {
        "scenario": scenario,
        "holds": found.holds,
        "diverged": found.lost,
        "assumptions": [line for one in found.asked for line in lines(one)],
        "silent": [{"path": one.path, "block": one.block} for one in found.asked if one.assumptions is None],
        "chatter": None if found.chatter is None else found.chatter._asdict(),
        "no_forecast": found.no_forecast,
    }


def lines(one: "Asked") -> list[dict[str, Any]]:
    """A block's assumptions."""
    about = {"path": one.path, "block": one.block}
    return [
        {**about, **assumption._asdict(), "holds": assumption.holds} for assumption in one.assumptions or ()
    ]
