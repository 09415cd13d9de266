"""How one run of a batch is run again, alone and with its trajectory."""

import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from hydroservo.block import leaves, replace
from hydroservo.errors import ScenarioError
from hydroservo.loop import Loop
from hydroservo.provenance import scenario_hash
from hydroservo.scenario import parse_override
from hydroservo.scenario.load import Assembly, Machine, assembled
from hydroservo.scenario.uncertainty import Deviations

__all__ = ["Origin", "command"]

Settings = Mapping[str, float]  # by the path that --set takes

SCALE = "uncertainty.scale"
MODEL = re.compile(r"controller\.(controller\.)*model\.")  # what a law believes, in wrappers too


class Origin(NamedTuple):
    """Where the loop of a batch comes from, as it was typed."""

    scenario: str
    changes: Sequence[str]
    plugins: Sequence[Path]
    strict: bool = False

    def assembled(self, settings: Settings) -> Assembly:
        """The loop, with more changes, and what it is made of."""
        return assembled(
            self.scenario, dict(map(parse_override, self.changes)) | dict(settings), self.plugins
        )

    def loop(self, settings: Settings) -> Loop:
        """The loop, with more changes."""
        return self.assembled(settings).loop

    def nominal(self) -> Loop:
        """The loop with its machine as it was before uncertainty."""
        return self.loop({SCALE: 0.0})


def command(
    origin: Origin, settings: Settings, parameters: Settings, *, substeps: int | None = None
) -> str | None:
    """The ``hydroservo run`` that replays a run; None if no settings lead to its very loop.

    Args:
        origin: where the loop of the batch comes from.
        settings: what the run sets, values or deviations.
        parameters: the numbers of the loop that are its own, in SI units.
        substeps: how many all runs took, where the scenario leaves that open.
    """
    if substeps is not None:
        settings, parameters = (
            {"simulation.substeps": substeps, **given} for given in (settings, parameters)
        )
    given = origin.assembled({})
    wanted = scenario_hash(replace(given.loop, parameters))
    for kept in ({}, alone(origin, given.loop, settings)):
        for more in ({}, in_full(given.deviations)):
            complete = more | kept | dict(settings)
            if leads_to(origin, complete) == wanted:
                return shlex.join(typed(origin, complete))
    return None


def leads_to(origin: Origin, settings: Settings) -> str | None:
    """The hash of the loop that some settings make, if they make one."""
    try:
        return scenario_hash(origin.loop(settings))
    except ScenarioError:
        return None


def in_full(given: Deviations) -> dict[str, float]:
    """The deviations of a machine by a scale of 1, whatever theirs was."""
    own = {**given.arguments, **given.numbers}
    return {SCALE: 1.0} | {f"uncertainty.{path}": one.scale * one.relative for path, one in own.items()}


def alone(origin: Origin, loop: Loop, settings: Settings) -> dict[str, float]:
    """What keeps a controller's model, and uncertainty, from following what is set of the machine."""
    machine = [path for path in settings if path.partition(".")[0] in Machine._fields]
    found = {f"uncertainty.{path}": 0.0 for path in machine}
    if not machine:
        return found
    try:
        follows = dict(leaves(origin.loop({path: settings[path] for path in machine})))
    except ScenarioError:
        return found
    known = dict(leaves(loop))
    return found | {
        path: value
        for path, value in known.items()
        if MODEL.match(path) and value != follows.get(path, value)
    }


def typed(origin: Origin, settings: Settings) -> Iterator[str]:
    yield from ("hydroservo", "run", origin.scenario)
    if origin.strict:
        yield "--strict"
    kept = (change for change in origin.changes if parse_override(change)[0] not in settings)
    for change in (*kept, *(f"{path}={value!r}" for path, value in settings.items())):
        yield from ("--set", change)
    for plugin in origin.plugins:
        yield from ("--plugin", str(plugin))
