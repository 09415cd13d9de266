"""Whether a log can be of the scenario's machine, and whether its signals fit together."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.block import Block, leaves
from hydroservo.core.errors import ScenarioError
from hydroservo.core.formatting import MINUS, plain_quantity, quantity
from hydroservo.identification.log import COMMAND, EXTERNAL_FORCE
from hydroservo.identification.regression import regression, thin_out
from hydroservo.identification.segments import Segment, UnderstoodLog, noise_of

ABOVE = 3.0  # times the supply, that a chamber's pressure may be
BEYOND = 0.1  # of the stroke, by which a sensor's zero may lie beside the machine's
PRESSURES = frozenset({"pressure_a", "pressure_b"})
SIGMAS = 5.0  # of a speed's noise, within which the direction of motion is not known
SLOW = 0.02  # of the largest speed, within which the piston may stick
FEWEST = 20  # samples in either direction
UNEXPLAINED = 0.4  # of the force's deviation: a force that no one recorded acts too, which has any sign
LEAST_SHARE = 0.05  # of the force's deviation: less friction may be an error of the sensors' gains
SURE = 0.5  # correlation from which two signals go together
CLEARLY = 2.0  # half intervals below 0
CLEARER = 0.5  # times what other pressures leave unexplained, below which these are the right ones
CLEARER_SHARE = 0.8  # times the share of their force that others leave so

Samples = NDArray[np.float64]
Rows = Mapping[str, Samples]


def stroke_of(plant: Block) -> float:
    """The stroke of a plant [m]; inf without one."""
    return float(getattr(plant, "stroke", math.inf))


def check_positions(logs: Iterable[UnderstoodLog], stroke: float) -> None:
    """Refuse positions far outside of the stroke [m], as of a wrong unit or a zero at mid-stroke.

    With them the piston would begin behind the ends of its cylinder.
    """
    if not math.isfinite(stroke):
        return
    for one in logs:
        rows = [part.measured["position"] for part in one.segments if "position" in part.measured]
        if not rows:
            continue
        every = np.concatenate(rows)
        low, high = float(np.nanmin(every)), float(np.nanmax(every))
        if low < -BEYOND * stroke or high > (1.0 + BEYOND) * stroke:
            first, last, whole = (plain_quantity(at, "m") for at in (low, high, stroke))
            problem = (
                f"lies between {first} and {last}, and the scenario's piston between 0 and {whole}: are its "
                "unit and its zero those of the machine?"
            )
            raise ScenarioError(one.log.name, "position", problem)


def check_pressures(logs: Iterable[UnderstoodLog], supply: float) -> None:
    """Refuse pressures far above that of the supply [Pa], as of a wrong unit."""
    for one in logs:
        for name in ("pressure_a", "pressure_b"):
            rows = [part.measured[name] for part in one.segments if name in part.measured]
            if rows and (usual := float(np.nanmedian(np.concatenate(rows)))) > ABOVE * supply:
                here, most = plain_quantity(usual, "Pa"), plain_quantity(supply, "Pa")
                problem = f"is {here} in the median, and the scenario's supply has {most}: is its unit right?"
                raise ScenarioError(one.log.name, name, problem)


class Resistance(NamedTuple):
    """What the force on the piston works against, by the balance of forces."""

    friction: tuple[float, float]  # at the mean speed, and half its interval [N]
    mass: tuple[float, float]  # and half its interval [kg]
    swing: float  # standard deviation of the force [N]
    scatter: float  # that of what is not explained [N]

    @property
    def sign(self) -> float:
        """1 where friction and mass, of which the surer one counts, are above 0, -1 below, 0 if unknown."""
        if self.scatter > UNEXPLAINED * self.swing:
            return 0.0
        (friction, half), (mass, wide) = self.friction, self.mass
        half = max(half, LEAST_SHARE * self.swing)
        value, unsure = (friction, half) if abs(friction) * wide >= abs(mass) * half else (mass, wide)
        return float(np.sign(value)) if abs(value) > unsure else 0.0

    @property
    def is_negative(self) -> bool:
        """Whether both friction and mass are clearly below 0, however much is not explained."""
        return all(value < -CLEARLY * half for value, half in (self.friction, self.mass))

    @property
    def shown(self) -> str:
        """What is below 0 of it."""
        if self.sign >= 0.0 and not self.is_negative:
            return "a force that does not fit the motion"
        if self.friction[0] < 0.0:
            return f"a friction of {quantity(self.friction[0], 'N').replace(MINUS, '-')}"
        return f"a mass of {self.mass[0]:.3g} kg"

    def fits_better(self, other: "Resistance") -> bool:
        """Whether it leaves clearly less unexplained than another one, of its own force too."""
        less = self.scatter < CLEARER * other.scatter
        return less and self.scatter * other.swing < CLEARER_SHARE * other.scatter * self.swing


def check_balance(logs: Sequence[UnderstoodLog], loop: Loop | None, *, driven: bool) -> None:
    """Refuse a log whose signals contradict each other.

    Without a loop no areas are known; ``driven`` says whether a command that contradicts the rest counts.
    """
    areas = None if loop is None else areas_of(loop.plant)
    for log in logs:
        problem = balance_problem(
            [with_scenario_load(one, loop) for one in log.segments], areas, driven=driven
        )
        if problem:
            raise ScenarioError(log.log.name, "", problem)


def areas_of(plant: Block) -> tuple[float, float] | None:
    """A_A and A_B [m^2]; None of a plant without pistons."""
    known = dict(leaves(plant))
    a, b = (known.get(f"area_{side}", known.get("piston_area")) for side in "ab")
    return None if a is None or b is None else (float(a), float(b))


def with_scenario_load(one: Segment, loop: Loop | None) -> Segment:
    """A stretch with the scenario's load, where no force at the rod was recorded."""
    if loop is None or EXTERNAL_FORCE in one.inputs or "force" in one.measured:
        return one
    force = np.array([loop.load.force(t) for t in one.time.tolist()])
    return one._replace(inputs={**one.inputs, EXTERNAL_FORCE: force})


def balance_problem(
    segments: Sequence[Segment], areas: tuple[float, float] | None, *, driven: bool = True
) -> str:
    """What in a log contradicts the machine, in one line with its cause where that is known; else empty.

    The force of the pressures, less the force on the rod that was recorded, is explained by least squares::

        A_A p_A - A_B p_B - F_ext = M dv/dt + F_c sgn(v) + b v + k x + F_0

    A weight, a spring and an overrunning load are in F_0 and k and may have any sign, M and F_c + b |v| not.
    A positive command must move the piston out.

    Without areas [m^2] the hydraulic force was measured. ``driven`` is as :func:`check_balance` has it.

    Fails to see a wrong log in which the piston moves one way only, or hardly at all, and takes a load that
    acts along each motion, as a motor on the rod may, for a sign of wrong signals.
    """
    stretches = [(period, rows) for one in segments for period, rows in [balance_rows(one)] if "v" in rows]
    if correlation(stretches, "v", "slope") < -SURE:
        return "velocity and position contradict each other: reverse the sign of one of them"
    moved = "position" if all("position" in rows for _, rows in stretches) else "velocity"
    follows = correlation(stretches, COMMAND, "v")
    found = resistance(stretches, areas)
    if found is None:
        problem = ""
    elif areas is None or not all(rows.keys() >= PRESSURES for _, rows in stretches):
        wrong = f"hydraulic_force or {moved} is reversed: together they give {found.shown}"
        problem = wrong if found.sign < 0.0 else ""
    else:
        swapped = [
            (period, {**rows, "pressure_a": rows["pressure_b"], "pressure_b": rows["pressure_a"]})
            for period, rows in stretches
        ]
        other = resistance(swapped, areas)
        problem = pressure_problem(found, other or found, moved, follows)
    if not problem and driven and follows < -SURE:
        wrong = "command is" if found is not None and found.sign > 0.0 else f"command or {moved} is"
        return f"{wrong} reversed: the piston goes in as the command rises"
    return problem


def pressure_problem(found: Resistance, other: Resistance, moved: str, follows: float) -> str:
    """What contradicts the force of the pressures, and what makes it so as far as the log knows.

    With areas that differ, pressures of the wrong chambers leave much of the force unexplained; with areas
    that do not, the command says whether the motion or the pressures are the wrong way round.
    """
    opposite = found.is_negative and other.sign > 0.0
    swapped = other.fits_better(found) or (opposite and follows > SURE)
    right = found.fits_better(other)
    if swapped and other.sign < 0.0:
        return f"pressure_a and pressure_b are swapped, and {moved} is reversed"
    if found.sign > 0.0 or (found.sign == 0.0 and not opposite and not (swapped and other.sign > 0.0)):
        return ""
    if swapped or (follows > SURE and not right):
        return f"pressure_a and pressure_b are swapped: as they are, they give {found.shown}"
    if follows > SURE:
        return f"{moved} and command are reversed: the pressures, which contradict both, give {found.shown}"
    if follows < -SURE or right:
        beside = "command and pressures" if follows < -SURE else "the pressures"
        return f"{moved} is reversed: the piston moves against {beside}, which gives {found.shown}"
    return f"pressure_a and pressure_b are swapped, or {moved} is reversed: together they give {found.shown}"


def balance_rows(one: Segment) -> tuple[float, Rows]:
    """The signals of a stretch as means, with its velocity, its slope of position and its acceleration."""
    names = {COMMAND, EXTERNAL_FORCE}
    rows = {**{name: row for name, row in one.inputs.items() if name in names}, **one.measured}
    period, few = thin_out(one.period, rows)
    if few[next(iter(few))].size < FEWEST:
        return period, {}
    if "position" in few:
        few["slope"] = np.gradient(few["position"], period)
    if "velocity" in few or "slope" in few:
        few["v"] = few["velocity"] if "velocity" in few else few["slope"]
        few["acceleration"] = np.gradient(few["v"], period)
    return period, few


def correlation(stretches: Sequence[tuple[float, Rows]], first: str, second: str) -> float:
    """Of two signals, over the stretches that have both; 0 where none does."""
    both = [np.stack([rows[first], rows[second]]) for _, rows in stretches if {first, second} <= rows.keys()]
    if not both:
        return 0.0
    one, other = np.concatenate(both, axis=1)
    there = np.isfinite(one + other)
    if there.sum() < FEWEST or not np.ptp(one[there]) or not np.ptp(other[there]):
        return 0.0
    return float(np.corrcoef(one[there], other[there])[0, 1])


def resistance(
    stretches: Sequence[tuple[float, Rows]], areas: tuple[float, float] | None
) -> Resistance | None:
    """What the force works against; None where too little moves, or no force was measured."""
    parts, speeds = [], []
    for _, rows in stretches:
        force, v = force_of(rows, areas), rows["v"]
        if force is None:
            continue
        columns = [rows["acceleration"], np.sign(v), v, np.ones(v.size)]
        design = np.stack([*columns, rows.get("position", np.zeros(v.size))], axis=1)
        slowest = max(SIGMAS * noise_of(v), SLOW * float(np.nanmax(np.abs(v), initial=0.0)))
        on = np.isfinite(design.sum(axis=1) + force) & (np.abs(v) > slowest)
        parts.append((design[on], force[on]))
        speeds.append(v[on])
    every = np.concatenate([*speeds, np.zeros(0)])
    if min((every > 0.0).sum(), (every < 0.0).sum()) < FEWEST:
        return None
    return resistance_fit(parts, float(np.abs(every).mean()))


def resistance_fit(parts: Sequence[tuple[Samples, Samples]], speed: float) -> Resistance | None:
    """The regression, with as many of its columns as can be told apart."""
    swing = float(np.std(np.concatenate([force for _, force in parts])))
    for kept in ([0, 1, 2, 3, 4], [0, 1, 2, 3], [0, 1, 3], [1, 3]):
        found = regression([(columns[:, kept], force) for columns, force in parts])
        if found is not None:
            weights = np.array([(0.0, 1.0, speed, 0.0, 0.0)[one] for one in kept])
            heavy = np.array([float(one == 0) for one in kept])
            friction = float(weights @ found.values), found.half(weights)
            mass = float(heavy @ found.values), found.half(heavy)
            return Resistance(friction, mass, swing, found.scatter)
    return None


def force_of(rows: Rows, areas: tuple[float, float] | None) -> Samples | None:
    """The hydraulic force, from the pressures or as logged, less that at the rod [N]; None without."""
    if areas is not None and rows.keys() >= PRESSURES:
        driving = areas[0] * rows["pressure_a"] - areas[1] * rows["pressure_b"]
    elif "hydraulic_force" in rows:
        driving = rows["hydraulic_force"]
    else:
        return None
    against: Samples = rows.get("force", rows.get(EXTERNAL_FORCE, np.zeros(driving.size)))
    return np.asarray(driving - against)
