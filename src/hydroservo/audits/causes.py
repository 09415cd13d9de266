"""What may keep a loop oscillating, and how each is switched off: by the names of fields, or by a wrapper."""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

from hydroservo.block import Block, is_block, leaves, replace
from hydroservo.linear.onset import amplified
from hydroservo.loop import AUTO, Loop
from hydroservo.observers import BoundaryLayer, Explicit, Implicit
from hydroservo.pulls import ExplicitReaching, ImplicitReaching, SmoothReaching

FINE_BITS = 32  # the most that a converter has
FINE = 1e-15  # [m] a resolution that nothing tells from none
LITTLE = 1e-3  # what is left of friction, whose laws do not allow none
SHORTER = 0.25  # of the sample period

Change = Callable[[float], float]


class Cause(NamedTuple):
    """One kind of cause.

    Attributes:
        name: of the kind.
        phrase: how the loop is without it, as in "the oscillation dies out without integral action".
        without: the loop without it; None where it has none.
        scale: of the command that remains by that alone.

    Those of one name are tried in turn, until one ends the oscillation.
    """

    name: str
    phrase: str
    without: Callable[[Loop], Loop | None]
    scale: float = 1.0


def by_fields(place: str, changes: Mapping[str, Change]) -> Callable[[Loop], Loop | None]:
    """A loop with the fields of these names changed, wherever they are in a part of it."""

    def without(loop: Loop) -> Loop | None:
        found: dict[str, float] = {}
        for path, value in leaves(loop):
            if not path.startswith(f"{place}.") or ".model." in path or type(value) not in (int, float):
                continue
            for name, change in changes.items():
                new = type(value)(change(value))
                if path.endswith((f".{name}", f"_{name}")) and new != value and math.isfinite(value):
                    found[path] = new
        changed: Loop | None = replace(loop, found) if found else None
        return changed

    return without


def sampled_faster(loop: Loop) -> Loop:
    """The loop at a shorter sample period, and with a delay that is shorter by as much."""
    given = loop.simulation
    substeps = AUTO if given.substeps == AUTO else math.ceil(SHORTER * given.substeps)
    hold: Any = loop.hold
    if hasattr(hold, "delay"):
        hold = hold._replace(delay=SHORTER * hold.delay)
    simulation = given._replace(period=SHORTER * given.period, substeps=substeps)
    return loop._replace(simulation=simulation, hold=hold)


def with_implicit_steps(loop: Loop) -> Loop | None:
    """The loop with implicit steps where its law switches at the sample; None where it does not."""
    law = implicit(loop.controller)
    changed: Loop | None = None if law is loop.controller else loop._replace(controller=law)
    return changed


def implicit(block: Block) -> Any:
    """A block with implicit steps in place of explicit and smoothed ones, in it and in blocks in it."""
    if isinstance(block, Explicit | BoundaryLayer):
        return Implicit()
    if isinstance(block, ExplicitReaching | SmoothReaching):
        return ImplicitReaching()
    parts = {name: (part, implicit(part)) for name, part in block._asdict().items() if is_block(part)}
    changed = {name: new for name, (old, new) in parts.items() if new is not old}
    return block._replace(**changed) if changed else block


def none(_: float) -> float:
    return 0.0


def little(value: float) -> float:
    return LITTLE * value


def no_overlap(lap: float) -> float:
    return min(lap, 0.0)


FRICTION = {
    "coulomb": little,
    "breakaway": little,
    "bristle_stiffness": little,  # so that bristles bend as far, and what they do is as fast
    "bristle_damping": little,
}
EDGES = {
    "lap": no_overlap,
    "extra_lap_pa": no_overlap,
    "extra_lap_at": no_overlap,
    "extra_lap_pb": no_overlap,
    "extra_lap_bt": no_overlap,
}

CAUSES = (
    Cause("integral action", "without integral action", by_fields("controller", {"integral_gain": none})),
    Cause("dry friction", "without dry friction", by_fields("plant", FRICTION)),
    Cause(
        "valve hysteresis",
        "without the valve's hysteresis",
        by_fields("valve", {"hysteresis": none}),
    ),
    Cause("valve overlap", "without the valve's overlap", by_fields("valve", EDGES)),
    Cause(
        "overlap compensation",
        "without compensation of the overlap",
        by_fields("controller", {"extend_overlap": none, "retract_overlap": none}),
    ),
    Cause(
        "converter steps",
        "without the steps of the command's converter",
        by_fields("controller", {"bits": lambda _: FINE_BITS}),
    ),
    Cause(
        "sensor steps",
        "without the steps of the sensors",
        by_fields("sensors", {"resolution": lambda _: FINE, "bits": none}),
    ),
    Cause("sensor noise", "without the sensors' noise", by_fields("sensors", {"noise": none})),
    Cause("switching", "with implicit steps in place of its switching", with_implicit_steps),
    Cause("sampling", "at a quarter of the sample period and delay", sampled_faster),
    Cause("gain", "at half the gain", partial(amplified, factor=0.5), 0.5),
    Cause("gain", "at a tenth of the gain", partial(amplified, factor=0.1), 0.1),
)
