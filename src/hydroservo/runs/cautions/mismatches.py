"""Numbers of different blocks of a loop that are allowed one by one and do not go together."""

import math
from collections.abc import Iterator
from typing import Any

from hydroservo.control.loop import Loop
from hydroservo.core.block import Block, field_at, is_block, leaves
from hydroservo.core.formatting import quantity
from hydroservo.core.hooks import drives_in, is_valveless, line_pressures
from hydroservo.machine.drives import Hoses
from hydroservo.machine.valves import StraightEdges

HEAVY = 0.5  # of the moving mass, up to which the oil before the piston is left out
WITHOUT_MASS = "has no mass in Hoses, so that peaks and resonances come out wrong; use Lines"
COARSEST = 0.1  # of a stroke, up to which a count measures it
DIGITAL = ("reference.", "controller.", "sensors.")
ROUNDED = 1.0 + 1e-9  # by which an instant or a rate at its limit may be off


def mismatch_cautions(loop: Loop) -> list[str]:
    """What of a loop's numbers cannot be meant together: lines, none where nothing is wrong.

    Args:
        loop: the loop, wired.

    Fails to see what it looks for in a user's block that calls it otherwise than those that ship.
    """
    asked = (late_load(loop), shut(loop), *beyond_the_rate(loop), *short_ranges(loop), *coarse(loop))
    return [line for line in (*asked, *high_starts(loop), *empty_supply(loop), *massless_oil(loop)) if line]


def late_load(loop: Loop) -> str:
    """That a load begins at the run's end or after it."""
    begins, ends = getattr(loop.load, "time", 0.0), loop.simulation.duration
    if begins * ROUNDED < ends:
        return ""
    return f"the load does not come: load.time is {begins:g} s, and the run ends at {ends:g} s"


def shut(loop: Loop) -> str:
    """That the largest command does not move the spool past the lap of its edges, or to where they open."""
    law = loop.controller
    while not hasattr(law, "saturation") and hasattr(law, "controller"):
        law = law.controller
    limit = getattr(getattr(law, "saturation", None), "limit", math.inf)
    orifice = getattr(loop.valve, "orifice", None)
    lap, shape = max(getattr(orifice, "lap", 0.0), 0.0), getattr(orifice, "shape", None) or StraightEdges()
    moved = getattr(loop.valve, "gain", math.inf) * limit
    opened = (opening for x in (moved, -moved) for opening in shape.openings(x))
    if not moved > 0.0 or max(opened) > lap:
        return ""
    why = f"its lap is {quantity(lap, 'm')}" if lap else "its edges overlap by more"
    return f"the valve stays shut: the largest command moves the spool by {quantity(moved, 'm')}, and {why}"


def beyond_the_rate(loop: Loop) -> Iterator[str]:
    """Which frequencies are beyond half the sample rate."""
    most = 0.5 / loop.simulation.period
    for path, value in leaves(loop):
        if not path.startswith(DIGITAL) or "frequency" not in path.rpartition(".")[2]:
            continue
        hertz = value / (2.0 * math.pi) if field_at(loop, path).unit == "rad/s" else value
        if most * ROUNDED < hertz < math.inf:
            yield f"{path} is {quantity(hertz, 'Hz')}, beyond half the sample rate, {quantity(most, 'Hz')}"


def short_ranges(loop: Loop) -> Iterator[str]:
    """Which transducers do not reach the supply's pressure."""
    if is_valveless(loop.drive):
        return
    highest = line_pressures(loop).supply
    for path, block in blocks(loop.sensors, "sensors"):
        reach = getattr(block, "range_high", math.inf)
        if reach < highest:
            ends, comes = quantity(reach, "Pa"), quantity(highest, "Pa")
            yield f"{path}.range_high is {ends}, and the supply has {comes}: beyond the range nothing is read"


def coarse(loop: Loop) -> Iterator[str]:
    """Which resolutions of a position sensor are too coarse for the stroke."""
    stroke = getattr(loop.plant, "stroke", math.inf)
    for path, block in blocks(loop.sensors, "sensors"):
        count = getattr(block, "resolution", 0.0)
        if count > COARSEST * stroke:
            sizes = quantity(count, "m"), quantity(stroke, "m")
            yield f"{path}.resolution is {sizes[0]}, and the stroke {sizes[1]}: a few counts tell no position"


def empty_supply(loop: Loop) -> Iterator[str]:
    """Whether the supply starts without pressure."""
    line = line_pressures(loop)
    if not is_valveless(loop.drive) and not line.supply > line.tank:
        here = quantity(line.supply, "Pa")
        yield f"the supply starts at {here}; give what it is charged to: start.given.supply.pressure"


def high_starts(loop: Loop) -> Iterator[str]:
    """Which chambers start above the supply's pressure."""
    if is_valveless(loop.drive):
        return
    highest = line_pressures(loop).supply
    for name in ("start_pressure_a", "start_pressure_b"):
        starts = getattr(loop.plant, name, 0.0)
        if highest < starts < math.inf:
            here, most = quantity(starts, "Pa"), quantity(highest, "Pa")
            yield f"plant.{name} is {here}, above the {most} of the supply"


def massless_oil(loop: Loop) -> Iterator[str]:
    """Which hoses leave out oil that is as heavy as the load, or waves that are slower than the valve."""
    moved, area = moving_mass(loop), getattr(loop.plant, "area_a", getattr(loop.plant, "piston_area", 0.0))
    corner, line = valve_corner(loop.valve), line_pressures(loop)
    middle = 0.5 * (line.supply + line.tank)
    for drive in drives_in(loop.drive):
        if not isinstance(drive, Hoses) or drive.inertance == 0.0:
            continue
        felt = drive.inertance * area**2
        stiffness = drive.oil.bulk_modulus(middle) / max(drive.volume_a, drive.volume_b)
        wave = 0.25 * math.sqrt(stiffness / drive.inertance)
        if felt > HEAVY * moved:
            masses = quantity(felt, "kg"), quantity(moved, "kg")
            yield f"the oil in a hose, felt as {masses[0]} by a piston that moves {masses[1]}, {WITHOUT_MASS}"
        elif wave < corner:
            rates = quantity(wave, "Hz"), quantity(corner, "Hz")
            yield f"the oil in a hose, with waves of {rates[0]} behind a valve of {rates[1]}, {WITHOUT_MASS}"


def moving_mass(loop: Loop) -> float:
    """What the rod moves at the start [kg]; infinite where that is not known."""
    plant: Any = loop.plant
    mechanism = getattr(plant, "mechanism", None)
    if mechanism is None:
        return float(getattr(plant, "mass", math.inf))
    return float(mechanism.inertia(plant.start_position))


def valve_corner(valve: Block) -> float:
    """The frequency that a valve follows [Hz]; 0 where that is not known."""
    rate = getattr(valve, "natural_frequency", 1.0 / getattr(valve, "time_constant", math.inf))
    return float(rate) / (2.0 * math.pi)


def blocks(block: Block, path: str) -> Iterator[tuple[str, Block]]:
    """A block and those in it, by their paths."""
    yield path, block
    for name, value in block._asdict().items():
        if is_block(value):
            yield from blocks(value, f"{path}.{name}")
