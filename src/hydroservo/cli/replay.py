"""How one run of a batch is run again, alone and with its trajectory."""

import math
import shlex
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from hydroservo.block import leaves, replace, value_at
from hydroservo.errors import ScenarioError
from hydroservo.loop import Loop
from hydroservo.provenance import scenario_hash
from hydroservo.scenario import load_scenario, parse_override
from hydroservo.scenario.load import Machine, model_path

__all__ = ["Origin", "command"]

Settings = Mapping[str, float]  # by the path that --set takes

SCALE = "uncertainty.scale"


class Origin(NamedTuple):
    """Where the loop of a batch comes from, as it was typed."""

    scenario: str
    changes: Sequence[str]
    plugins: Sequence[Path]
    strict: bool = False

    def loop(self, settings: Settings) -> Loop:
        """The loop, with more changes."""
        return load_scenario(
            self.scenario, dict(map(parse_override, self.changes)) | dict(settings), self.plugins
        )

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
    loop = origin.loop({})
    wanted = scenario_hash(replace(loop, parameters))
    for kept in ({}, alone(loop, settings)):
        for more in ({}, deviations(origin, loop)):
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


def deviations(origin: Origin, loop: Loop) -> dict[str, float]:
    """What leaves the machine of a loop as it is, but counts deviations in full, whatever their scale was."""
    try:
        nominal, full = origin.nominal(), origin.loop({SCALE: 1.0})
    except ScenarioError:  # in full, the scenario's own deviations lead out of range
        return {}
    found = {SCALE: 1.0}
    for name in Machine._fields:
        for path, value in leaves(getattr(loop, name), f"{name}."):
            if isinstance(value, float) and value != value_at(full, path):
                found[f"uncertainty.{path}"] = deviation(value, value_at(nominal, path))
    return found


def deviation(value: float, nominal: float) -> float:
    """The d for which nominal (1 + d) has the bits of a value, if there is one near."""
    ratio = value / nominal
    near = (ratio, math.nextafter(ratio, math.inf), math.nextafter(ratio, -math.inf))
    return next((one - 1.0 for one in near if nominal * (1.0 + (one - 1.0)) == value), ratio - 1.0)


def alone(loop: Loop, settings: Settings) -> dict[str, float]:
    """What keeps a controller's model, and uncertainty, from following what is set of the machine."""
    known = dict(leaves(loop))
    model = model_path(loop.controller)
    found = {}
    for path in settings:
        if path.partition(".")[0] in Machine._fields:
            found[f"uncertainty.{path}"] = 0.0
            believed = f"{model}.{path}"
            found |= {believed: known[believed]} if believed in known else {}
    return found


def typed(origin: Origin, settings: Settings) -> Iterator[str]:
    yield from ("hydroservo", "run", origin.scenario)
    if origin.strict:
        yield "--strict"
    kept = (change for change in origin.changes if parse_override(change)[0] not in settings)
    for change in (*kept, *(f"{path}={value!r}" for path, value in settings.items())):
        yield from ("--set", change)
    for plugin in origin.plugins:
        yield from ("--plugin", str(plugin))
