"""What ``hydroservo batch`` draws, and the loops that its printed commands simulate."""

import shlex

from hydroservo import Loop
from hydroservo.cli.options import parse_ranges, replay_command
from hydroservo.core.block import replace
from hydroservo.scenario import load_scenario, parse_override
from hydroservo.scenario.load import assemble
from hydroservo.scenario.parameter_draws import Drawn, draw_runs, variations

NAME = "paper/sine-backstepping"  # whose controller has a model of the machine


def drawn(*ranges, changes=(), seed=0, runs=50, seeds=False, name=NAME):
    assembly = assemble(name, dict(map(parse_override, changes)))
    varied = variations(assembly, parse_ranges(ranges))
    return assembly.loop, draw_runs(assembly, varied, runs, seed=seed, seeds=seeds)


def replayed(text: str) -> Loop:
    """The loop that a printed command simulates."""
    words = shlex.split(text)
    assert words[:2] == ["hydroservo", "run"]
    assert set(words[3::2]) == {"--set"}
    return load_scenario(words[2], dict(map(parse_override, words[4::2])))


def again(name: str, changes: list[str], found: Drawn, run: int) -> Loop:
    """The loop that the command simulates which is printed for a run."""
    return replayed(replay_command(["hydroservo", "run", name], changes, (), found.changes(run)))


def alone(loop: Loop, found: Drawn, run: int) -> Loop:
    """The loop of a run as the batch has it."""
    return replace(loop, {path: column[run].item() for path, column in found.parameters.items()})
