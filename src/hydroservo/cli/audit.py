"""The command that asks whether a loop is what its law assumes."""

from functools import partial

from hydroservo.cli.frame import CommandOutput, with_output
from hydroservo.cli.options import Changes, Plugins, Scenario, load_loop


@with_output()
def audit_command(scenario: Scenario, changes: Changes, plugins: Plugins, answer: CommandOutput) -> None:
    """Check what a scenario's law assumes, whether its loop oscillates and why, and predict its chatter.

    Each assumption has a margin, the factor by which it holds: bounds on disturbances, the sample rate, the
    valve's lag, noise, limits. Those measured on a run say when it was worst. Where that run oscillates to
    its end, it goes on without each possible cause in turn, and what ends the oscillation is named. Chatter
    is predicted by harmonic balance, without a run. With --out it also writes a report (report.html, its
    tables as CSV and LaTeX in tables), a picture of the margins (margins.png, margins.svg) and the numbers
    (metrics.json).

    Examples:

    - `hydroservo audit paper/sine-tsmc`
    - `hydroservo audit rig/1khz-tsmc-sine --set valve.time_constant=4ms --out audit`
    """
    from hydroservo.audits import audit
    from hydroservo.audits.finding import audit_finding

    loop = load_loop(scenario, changes, plugins)
    answer(scenario, lambda _: audit(loop), partial(audit_finding, scenario=scenario))
