"""What is doubtful of a loop before it runs: demands, numbers that do not go together, and sizes."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from hydroservo.control.controllers import Dither, FixedDemand
from hydroservo.control.loop import Loop
from hydroservo.core.block import Block, field_at, leaves, nested_blocks
from hydroservo.core.errors import ParameterError, one_line
from hydroservo.core.formatting import MINUS, quantity
from hydroservo.core.hooks import at_rest, drives_in, is_valveless, line_pressures
from hydroservo.core.signals import Pressures
from hydroservo.machine.drives import Hoses
from hydroservo.machine.valves import StraightEdges
from hydroservo.runs.evaluation import demand_values

INSTANTS = 1001  # of a run at which its demand is looked at
ROUNDED = 1e-9  # by which an instant or a rate at its limit may be off
IDLE_SHARE = 0.5  # of a command's range which does nothing, up to which the valve goes with its law


def demand_caution(loop: Loop) -> str:
    """That a demand goes where the machine cannot, and where that is; else empty.

    What a machine can do is what the controlled signal's ``reach`` says of it, as the stroke of a position.

    Fails to see a demand that is there and back between two of 1001 instants.
    """
    if not hasattr(loop.controls, "reach"):
        return ""
    times = np.linspace(0.0, loop.simulation.duration, INSTANTS)
    asked = demand_values(loop.reference, times)
    asked = asked[np.isfinite(asked)]
    if not asked.size:
        return ""
    ends = (float(asked.min()), float(asked.max()))
    lines = (out_of_reach(loop, loop.controls, "the demand goes to", value) for value in ends)
    return next(filter(None, lines), "")


def fixed_demands(loop: Loop) -> Iterator[str]:
    """Which fixed demands of the laws in a loop the machine cannot hold."""
    for path, block in nested_blocks(loop.controller, "controller"):
        if isinstance(block, FixedDemand):
            yield out_of_reach(loop, block.controls, f"{path}.value is", block.value)


def out_of_reach(loop: Loop, controls: Any, subject: str, value: float) -> str:
    """That a value of a signal is one that the machine cannot take; else empty."""
    if not hasattr(controls, "reach"):
        return ""
    line = line_pressures(loop)
    if is_valveless(loop.drive):  # which has a pressure of its own, whatever the line's
        line = Pressures(math.inf, line.tank)
    least, most = controls.reach(at_rest(loop), line)
    if least <= value <= most:
        return ""
    signal = controls.declared()
    here, low, high = (quantity(one, signal.unit) for one in (value, least, most))
    return f"{subject} {here}; the machine's {signal.meaning} is from {low} to {high}".replace(MINUS, "-")


def late_caution(loop: Loop) -> str:
    """That a demand begins to change at the run's end or after it; else empty.

    Fails to see it of a demand without a ``time``, and of one that has the same value as long after it.
    """
    begins, ends = getattr(loop.reference, "time", 0.0), loop.simulation.duration
    at = loop.reference.at
    if begins < (1.0 - ROUNDED) * ends or at(begins + ends).value == at(0.0).value:
        return ""
    return f"nothing is asked for: reference.time is {begins:g} s, and the run ends at {ends:g} s"


def command_caution(loop: Loop) -> str:
    """That the spool is at its limit over more than half of the range of its law's command; else empty.

    What a law does at its limit, as anti-windup does, comes too late there. The law's limit is that of its
    ``saturation``, or of the law that it wraps.

    Fails to know a limit that a law has nowhere but in its text.
    """
    path, law = "controller", loop.controller
    while not hasattr(law, "saturation") and hasattr(law, "controller"):
        path, law = f"{path}.controller", law.controller
    limit = getattr(getattr(law, "saturation", None), "limit", 0.0)
    gain, most = getattr(loop.valve, "gain", 0.0), getattr(loop.valve, "max_opening", math.inf)
    if not gain * limit * (1.0 - IDLE_SHARE) > most:
        return ""
    said, asked = quantity(most / gain, "V"), quantity(limit, "V")
    return (
        f"the valve is wide open at {said} (valve.max_opening/valve.gain), and the command goes to {asked} "
        f"({path}.saturation.limit): what is beyond {said} does nothing"
    )


FEWEST = 4  # samples in a period of a dither
HEAVY = 0.5  # of the moving mass, up to which the oil before the piston is left out
WITHOUT_MASS = "has no mass in Hoses, so that peaks and resonances come out wrong; use Lines"
COARSEST = 0.1  # of a stroke, up to which a count measures it
DIGITAL = ("reference.", "controller.", "sensors.")


def mismatch_cautions(loop: Loop) -> list[str]:
    """What of a loop's numbers cannot be meant together: lines, none where nothing is wrong.

    Fails to see what it looks for in a user's block that calls it otherwise than those that ship.
    """
    asked = (
        late_load(loop),
        shut_valve(loop),
        *too_fast_frequencies(loop),
        *coarse_dither(loop),
        *short_ranges(loop),
        *coarse_resolutions(loop),
        *fixed_demands(loop),
    )
    return [line for line in (*asked, *high_starts(loop), *empty_supply(loop), *massless_oil(loop)) if line]


def late_load(loop: Loop) -> str:
    """That a load begins at the run's end or after it."""
    begins, ends = getattr(loop.load, "time", 0.0), loop.simulation.duration
    if begins * (1.0 + ROUNDED) < ends:
        return ""
    return f"the load does not come: load.time is {begins:g} s, and the run ends at {ends:g} s"


def shut_valve(loop: Loop) -> str:
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


def too_fast_frequencies(loop: Loop) -> Iterator[str]:
    """Which frequencies are beyond half the sample rate."""
    most = 0.5 / loop.simulation.period
    for path, value in leaves(loop):
        if not path.startswith(DIGITAL) or "frequency" not in path.rpartition(".")[2]:
            continue
        hertz = value / (2.0 * math.pi) if field_at(loop, path).unit == "rad/s" else value
        if most * (1.0 + ROUNDED) < hertz < math.inf:
            yield f"{path} is {quantity(hertz, 'Hz')}, beyond half the sample rate, {quantity(most, 'Hz')}"


def coarse_dither(loop: Loop) -> Iterator[str]:
    """Which dither has too few samples in a period to be the wave that it is meant to be."""
    rate = 1.0 / loop.simulation.period
    for path, block in nested_blocks(loop.controller, "controller"):
        if isinstance(block, Dither) and block.frequency * FEWEST > rate * (1.0 + ROUNDED):
            here, most = quantity(block.frequency, "Hz"), quantity(rate / FEWEST, "Hz")
            few = f"{rate / block.frequency:.3g} samples a period"
            yield f"{path}.frequency is {here}, {few}; a square wave needs {FEWEST}, {most} here"


def short_ranges(loop: Loop) -> Iterator[str]:
    """Which transducers do not reach the supply's pressure."""
    if is_valveless(loop.drive):
        return
    highest = line_pressures(loop).supply
    for path, block in nested_blocks(loop.sensors, "sensors"):
        reach = getattr(block, "range_high", math.inf)
        if reach < highest:
            ends, comes = quantity(reach, "Pa"), quantity(highest, "Pa")
            yield f"{path}.range_high is {ends}, and the supply has {comes}: beyond the range nothing is read"


def coarse_resolutions(loop: Loop) -> Iterator[str]:
    """Which resolutions of a position sensor are too coarse for the stroke."""
    stroke = getattr(loop.plant, "stroke", math.inf)
    for path, block in nested_blocks(loop.sensors, "sensors"):
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


MACHINE = ("plant.", "valve.", "supply.", "drive.")
AREAS, MODULI = (1e-6, 5.0), (1e6, 1e11)  # [m^2], [Pa]
USUAL = {  # in SI units by a number's name, with room beyond any catalogue
    "area_a": AREAS,
    "area_b": AREAS,
    "piston_area": AREAS,
    "stroke": (1e-4, 50.0),
    "max_opening": (1e-6, 0.1),
    "mass": (1e-4, 1e7),
    "supply_pressure": (1e4, 5e8),
    "bulk_modulus": MODULI,
    "effective_bulk_modulus": MODULI,
    "liquid_bulk_modulus": MODULI,
    "density": (100.0, 5000.0),
    "time_constant": (1e-7, 100.0),
}


def size_cautions(loop: Block) -> list[str]:
    """Which numbers of a loop's machine are out of all proportion, as a bore of 50 m for one of 50 mm is.

    Fails to know a slip that stays within what is usual, and numbers of other names.
    """
    found = []
    for path, value in leaves(loop):
        name = path.rpartition(".")[2]
        if not path.startswith(MACHINE) or name not in USUAL:
            continue
        least, most = USUAL[name]
        if least <= value <= most:
            continue
        unit = field_at(loop, path).unit
        here, low, high = (quantity(one, unit) for one in (value, least, most))
        found.append(
            f"{path} is {here}, and machines have {low} to {high}: is its unit right? "
            "A number without one is in SI units"
        )
    return found


def loop_cautions(loop: Loop) -> list[str]:
    """Lines about a loop that a user should know before it runs, empty ones among them."""
    asked = (demand_caution(loop), late_caution(loop), command_caution(loop))
    return [*asked, *own_cautions(loop), *size_cautions(loop), *mismatch_cautions(loop)]


def own_cautions(loop: Loop) -> list[str]:
    """Lines of blocks about their own numbers that are allowed and doubtful."""
    lines = {
        path: block_caution(block, path) for path, block in nested_blocks(loop) if hasattr(block, "caution")
    }
    return [f"{path}: {line}" for path, line in lines.items() if line]


def block_caution(block: Block, path: str) -> str:
    """The line of a block that has a method ``caution``."""
    try:
        return one_line(str(block.caution()))
    except Exception as error:
        kind = type(block).__name__
        problem = f"its method caution fails: {type(error).__name__}: {error}"
        raise ParameterError(path or kind, kind, problem) from None
