"""What a law supposes of its loop, what a run of it shows, and the chatter that is foretold of it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from hydroservo.assumptions import Assumption, Facts
from hydroservo.audits.chatter import Chatter, chatter
from hydroservo.audits.facts import facts_of
from hydroservo.audits.finding import audit_finding
from hydroservo.audits.strain import Strain, strain, strain_monitors
from hydroservo.audits.sustained import OSCILLATION, Sustained, sustained
from hydroservo.block import Block, is_block
from hydroservo.controllers.saturation import Saturation
from hydroservo.errors import ParameterError
from hydroservo.loop import Loop
from hydroservo.plants.design_model import DesignModel
from hydroservo.runs.arguments import checked_loop
from hydroservo.show import Finding
from hydroservo.show.html import html_of


class Asked(NamedTuple):
    """A block of a law, and what it supposes.

    Attributes:
        path: of the block in the loop.
        block: its class.
        assumptions: what it supposes; None where it does not say.
    """

    path: str
    block: str
    assumptions: tuple[Assumption, ...] | None


def asked(law: Block, facts: Facts, path: str = "controller") -> Iterator[Asked]:
    """What a law supposes, and each block in it, the outermost first.

    Args:
        law: the law, designed.
        facts: of its loop.
        path: of the law in the loop.
    """
    own = tuple(law.assumptions(facts)) if hasattr(law, "assumptions") else None
    if own is not None or hasattr(law, "step"):
        yield Asked(path, type(law).__name__, own)
    inner = law.within(facts) if hasattr(law, "within") else facts
    for name, value in law._asdict().items():
        if is_block(value) and not isinstance(value, DesignModel | Saturation):
            yield from asked(value, inner, f"{path}.{name}")


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

    asked: tuple[Asked, ...]
    lost: bool
    chatter: Chatter | None
    no_forecast: str
    oscillation: Sustained | None = None
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
    :func:`~hydroservo.audits.sustained`. Chatter is foretold by
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
        tuple(asked(facts.loop.controller, facts)),
        bool(data["diverged"]),
        found,
        reason,
        sustained(loop, data),
        strain(loop, data),
        loop,
    )
