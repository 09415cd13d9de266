"""What a law supposes of its loop, what a run of it asks and shows, and the chatter that is foretold."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from hydroservo.audits.chatter import Chatter, chatter
from hydroservo.audits.describing import command_limit
from hydroservo.audits.facts import facts_of
from hydroservo.audits.finding import audit_finding
from hydroservo.audits.oscillation import OSCILLATION, SustainedOscillation, sustained_oscillation
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.control.loop import Loop
from hydroservo.control.monitors import ChamberPressures, SupplyLine
from hydroservo.core.assumptions import Assumption, Facts
from hydroservo.core.block import Block, is_block
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import Field
from hydroservo.core.hooks import drives_in, has_chambers, is_valveless
from hydroservo.machine.drives.load_sensing import LoadSensing
from hydroservo.machine.plants.design_model import DesignModel
from hydroservo.runs.arguments import checked_loop
from hydroservo.show import Finding
from hydroservo.show.html import html_of

ABOVE = 1.01  # times the supply's pressure, from which a chamber is above it
AT_LIMIT = 0.99  # of the limit, for a converter has one step less above zero


class Strain(NamedTuple):
    """Extremes of a run; nan where the machine has none."""

    pressure_min: Annotated[float, Field("Pa", "lowest gauge pressure in a chamber")]
    low_pressure_time: Annotated[float, Field("s", "time with a chamber below the atmosphere's pressure")]
    pressure_max: Annotated[float, Field("Pa", "highest gauge pressure in a chamber")]
    supply_pressure: Annotated[float, Field("Pa", "highest gauge pressure of the supply")]
    limited: Annotated[float, Field("", "share of the time with the command at its limit")]

    @property
    def above_supply(self) -> bool:
        return self.pressure_max > ABOVE * self.supply_pressure


def strain_monitors(loop: Loop) -> list[Block]:
    """What a run needs to be asked."""
    return [ChamberPressures(), SupplyLine()] if has_chambers(loop.plant) else []


def strain(loop: Loop, run: Any) -> Strain | None:
    """The extremes of a run; None where it diverged.

    The run has the command recorded, and the metrics of :func:`strain_monitors`.

    Fails to see the supply of a drive that has a pump for itself: what it has then is nan.
    """
    if bool(run["diverged"]):
        return None
    low, below, high, supply = (
        float(run[name]) if name in run else math.nan
        for name in ("pressure_min", "low_pressure_time", "pressure_max", "supply_pressure_max")
    )
    own_pump = is_valveless(loop.drive) or any(isinstance(one, LoadSensing) for one in drives_in(loop.drive))
    limited = np.abs(run["controller.u"].to_numpy()) >= AT_LIMIT * command_limit(loop.controller)
    return Strain(low, below, high, math.nan if own_pump else supply, float(np.mean(limited)))


class BlockAssumptions(NamedTuple):
    """A block of a law, and what it supposes.

    Attributes:
        path: of the block in the loop.
        block: its class.
        assumptions: what it supposes; None where it does not say.
    """

    path: str
    block: str
    assumptions: tuple[Assumption, ...] | None


def assumptions_in(law: Block, facts: Facts, path: str = "controller") -> Iterator[BlockAssumptions]:
    """What a law supposes, and each block in it, the outermost first."""
    own = tuple(law.assumptions(facts)) if hasattr(law, "assumptions") else None
    if own is not None or hasattr(law, "step"):
        yield BlockAssumptions(path, type(law).__name__, own)
    inner = law.within(facts) if hasattr(law, "within") else facts
    for name, value in law._asdict().items():
        if is_block(value) and not isinstance(value, DesignModel | Saturation):
            yield from assumptions_in(value, inner, f"{path}.{name}")


@dataclass(frozen=True)
class Audit:
    """The audit of a loop.

    Attributes:
        asked: each block of the law, and what it supposes.
        lost: whether the run diverged that the measured ones are asked of.
        chatter: what is foretold; None where the loop has no steady state to foretell from.
        no_forecast: why there is none; else empty.
        oscillation: of the run; None of an open loop, and of a run that diverged.
        strain: extremes of the run; None where it diverged.
        loop: that was asked about.
    """

    asked: tuple[BlockAssumptions, ...]
    lost: bool
    chatter: Chatter | None
    no_forecast: str
    oscillation: SustainedOscillation | None = None
    strain: Strain | None = None
    loop: Loop | None = None

    def assumptions(self) -> Iterator[Assumption]:
        """All of them."""
        for one in self.asked:
            yield from one.assumptions or ()

    def finding(self) -> Finding:
        """What it says, as commands and notebooks show it."""
        return audit_finding(self)

    def _repr_html_(self) -> str:
        return html_of(self.finding())

    @property
    def holds(self) -> bool | None:
        """Whether all assumptions hold that can be told; None if none can."""
        known = [one.holds for one in self.assumptions() if one.holds is not None]
        return all(known) if known else None


def audit(loop: Loop, *, time: float | None = None) -> Audit:
    """Ask whether a loop is what its law's theorems suppose, and whether it oscillates or will chatter.

    The law, and each block in it with ``assumptions``, says what it supposes: bounds on disturbances against
    switching gains (Lemma 2), gains against the sample rate and the valve's lag, noise and limits as known,
    and more. Each has a margin, the factor by which it holds. Disturbances, their rates and the command are
    the largest of one run of the loop; all else is of its numbers. An oscillation that the run keeps to its
    end is measured on it, and what it dies out without is sought by
    :func:`~hydroservo.audits.sustained_oscillation`. Chatter is foretold by
    :func:`~hydroservo.audits.chatter`, from no run.

    Args:
        loop: the loop.
        time: the instant from which chatter is foretold [s]; None for that of the largest demand and load.

    Raises:
        ParameterError, LoopError: as :func:`~hydroservo.simulate`.

    Source: the hypotheses are those of each law's source.
    Fails to prove a loop good: it may be lost by what no block supposes in so many words. How often it is
    right is in the documentation.
    """
    monitors = [OSCILLATION, *strain_monitors(checked_loop(loop))]
    facts, data = facts_of(loop, ["controller.u"], monitors)
    found, reason = None, ""
    try:
        found = chatter(loop, time=time)
    except ParameterError as error:
        reason = str(error)
    return Audit(
        tuple(assumptions_in(facts.loop.controller, facts)),
        bool(data["diverged"]),
        found,
        reason,
        sustained_oscillation(loop, data),
        strain(loop, data),
        loop,
    )
