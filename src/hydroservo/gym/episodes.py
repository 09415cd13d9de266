"""What the episodes of an environment are drawn from: the machines and demands of a scenario."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from hydroservo.control.loop import Loop
from hydroservo.core.errors import ParameterError
from hydroservo.core.validation import whole_number
from hydroservo.runs.arguments import checked_mapping
from hydroservo.scenario import Assembly, assemble
from hydroservo.scenario.other_tables import Deviation
from hydroservo.scenario.ranges import as_entries, relative
from hydroservo.scenario.sampling import (
    Columns,
    assembly_of_loop,
    draw_values,
    loop_parameters,
    uniform_numbers,
    variations,
)

MOST_DRAWS = 100_000  # sets of parameters, each with a start of its own to be found

Ranges = Mapping[str, str | tuple[float, float]]


def environment_assembly(
    source: str | Path | Loop,
    changes: Mapping[str, object] | None,
    plugins: Sequence[str | Path],
    signal: str,
) -> Assembly:
    """The scenario of an environment.

    Args:
        source: its name or file, or a loop.
        changes: as of :func:`~hydroservo.load_scenario`.
        plugins: as there.
        signal: that it must control, such as "velocity".
    """
    if isinstance(source, Loop):
        for name, value in (("changes", changes), ("plugins", plugins)):
            if value:
                problem = "must be left out where scenario is a loop; pass it to load_scenario"
                raise ParameterError(name, value, problem)
        found = assembly_of_loop(source)
    else:
        found = assemble(source, changes, plugins)
    meaning = found.loop.controls.declared().meaning
    if meaning != signal:
        name = "a loop" if isinstance(source, Loop) else str(source)
        raise ParameterError("scenario", name, f"must control the {signal}; it controls the {meaning}")
    return found


def draw_parameter_sets(scenario: Assembly, vary: Ranges | None, draws: int) -> Columns:
    """The sets of parameters that episodes have, by path in SI units; the scenario's seed says which.

    What the scenario's uncertainty names deviates by one factor a set, drawn evenly from -1 to 1 times its
    scale, so that numbers which go together stay together. What is to vary besides is drawn by itself.

    Args:
        scenario: of the environment.
        vary: further ranges by path, or others in place of the uncertainty's, as of
            :func:`~hydroservo.scenario.sampling.draws`.
        draws: how many sets.
    """
    own = checked_mapping("vary", {} if vary is None else vary, "paths to ranges")
    whole_number("draws", draws, 1, MOST_DRAWS)
    seed, wide = scenario.loop.simulation.seed, largest_deviations(scenario)
    ranges = {path: relative(-abs(most), abs(most)) for path, most in wide.items() if path not in own}
    together = uniform_numbers(seed, "uncertainty.scale", draws)
    varied = variations(scenario, as_entries({**ranges, **own}))
    values = {}
    for one in varied:
        share = uniform_numbers(seed, one.path, draws) if one.path in own else together
        values[one.path], _ = draw_values(
            one, share if one.path in own or wide[one.path] > 0.0 else 1.0 - share
        )
    return loop_parameters(scenario, varied, values)


def largest_deviations(scenario: Assembly) -> dict[str, float]:
    """How far a scenario's uncertainty leads each number from its nominal value, relative, where it does."""
    said = {**scenario.truth.arguments, **scenario.truth.numbers}
    found = {path: one.scale * one.relative for path, one in said.items() if isinstance(one, Deviation)}
    return {path: most for path, most in found.items() if most != 0.0}
