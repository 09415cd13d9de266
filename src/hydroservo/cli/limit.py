"""The command that says how much better a law could be."""

from functools import partial

from hydroservo.cli.frame import CommandOutput, with_output
from hydroservo.cli.options import Changes, Plugins, Scenario, load_loop


@with_output()
def limit_command(scenario: Scenario, changes: Changes, plugins: Plugins, answer: CommandOutput) -> None:
    """Show how close a scenario's law comes to the best that any command could do.

    The commands with the least rms error are found by optimal control of the same machine, at the same
    sample rate and within the limits of the command, and played back: where all is known in advance
    (clairvoyant), and where jumps of demand and load are known only once they are there (causal). That takes
    from seconds to minutes. With --out it also writes a report (report.html, its tables as CSV and LaTeX in
    tables), a picture of the three runs (limit.png, limit.svg), the trajectory of each (law.csv, causal.csv,
    clairvoyant.csv) and the numbers (metrics.json).

    Examples:

    - `hydroservo limit rig/1khz-pi-square`
    - `hydroservo limit rig/1khz-pi-square --set valve.time_constant='5 ms' --out limit`
    """
    from hydroservo.limits import limit
    from hydroservo.limits.finding import MEANINGS, limits_finding
    from hydroservo.runs.run import trace_size

    loop = load_loop(scenario, changes, plugins)
    answer(
        scenario,
        lambda report: limit(loop, progress=lambda fraction: report(fraction, scenario)),
        partial(limits_finding, scenario=scenario),
        size=len(MEANINGS) * trace_size(loop) if answer.folder else 0,
    )
