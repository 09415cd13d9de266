"""The cylinder, and what its rod moves; both follow the piston's position."""

import math
from typing import Any, NamedTuple

from hydroservo.control.controlled.force import Force
from hydroservo.core.block import Block
from hydroservo.core.hooks import has_chambers
from hydroservo.figures.circuit import symbols as sym
from hydroservo.figures.circuit.sheet import Sheet, moved, n
from hydroservo.machine.loads.constant import Constant
from hydroservo.machine.mechanics.contact import Contact
from hydroservo.machine.mechanics.mass import Mass
from hydroservo.machine.mechanics.mass_spring_damper import MassSpringDamper
from hydroservo.machine.mechanics.nothing_carried import NothingCarried
from hydroservo.machine.mechanics.one_link_arm import OneLinkArm
from hydroservo.machine.mechanics.swinging_load import SwingingLoad
from hydroservo.machine.plants.cylinder import Cylinder
from hydroservo.machine.plants.load_pressure import LoadPressurePlant
from hydroservo.machine.sensors.missing import missing_signals

LEFT, RIGHT, HALF = 64.0, 200.0, 22.0  # the barrel's ends, and half its height
PORT_A, PORT_B = 74.0, 190.0
PISTON, THICK, TRAVEL = 84.0, 10.0, 76.0  # the piston's left face at the start of its stroke
ROD = 216.0  # the rod's end there
CELL = 16.0  # length of a load cell
MASS, MASS_HALF = 44.0, 24.0
WALL = 424.0
CABLE = 'class="signal" stroke-dasharray="2 3"'
CRANK, LINK, DROOP = 72.0, 108.0, math.radians(10.0)  # of an arm: pin, tip, and how far it hangs half way
SOME_ROD = 0.45  # of the piston's diameter, where areas do not say it
UNEQUAL = 0.2  # share of the piston's area that a second rod takes, where the first takes more


class Stroke(NamedTuple):
    """What follows the piston."""

    length: float  # [m]
    start: float  # [m]

    def moved(self, body: str, how: str, start: float, end: float, at: tuple[float, float] = (0, 0)) -> str:
        """A part that does something from the start of the stroke to its end."""
        ends = 0.0, self.length, start, end
        return moved(body, how, "plant.position", ends, self.start, at)

    def share(self, position: float) -> float:
        return min(max(position / self.length, 0.0), 1.0) if self.length > 0.0 else 0.5


def stroke_of(plant: Block) -> Stroke:
    length = getattr(plant, "stroke", math.nan)
    usable = math.isfinite(length) and length > 0.0
    return Stroke(length if usable else 1.0, getattr(plant, "start_position", 0.5 if not usable else 0.0))


def draw_cylinder(sheet: Sheet, loop: Any, y: float) -> None:
    """Cylinder, load and external force, on the level y."""
    plant, stroke = loop.plant, stroke_of(loop.plant)
    cell = "force" in measured(loop)
    end = ROD + (CELL if cell else 0.0)
    ports = {"A": (PORT_A, y + HALF), "B": (PORT_B, y + HALF)}
    left, right = rods(plant)
    ports["rod"] = (0.5 * (RIGHT + ROD), y + HALF * right)
    body = oil(stroke, y, left, right) + barrel(y, left, right)
    body += stroke.moved(piston(y, left, right), "slide", 0.0, TRAVEL)
    if type(plant) not in (Cylinder, LoadPressurePlant):
        body += sym.label(0.5 * (LEFT + RIGHT), y - HALF - 8, type(plant).__name__)
    far = LEFT - TRAVEL - 12 if left else LEFT
    title = f"Cylinder, {type(plant).__name__}"
    sheet.place("cylinder", body, ports, "plant", title, (far, y - HALF - 20, ROD, y + HALF))
    if cell:
        draw_cell(sheet, stroke, y, y + 38.0 + sag(plant))
    draw_load(sheet, loop, stroke, end, y)
    sheet.write(LEFT, y - HALF - 10, "plant.position")
    sheet.write(LEFT + 70, y - HALF - 10, "plant.velocity")
    chambers = has_chambers(plant)
    sheet.write(PORT_A + 6, y + HALF + 20, "plant.pressure_a" if chambers else "plant.hydraulic_force")
    if chambers:
        sheet.write(PORT_B - 6, y + HALF + 20, "plant.pressure_b", anchor="end")
        sheet.pressures |= {"pA": "plant.pressure_a", "pB": "plant.pressure_b"}


def measured(loop: Any) -> set[str]:
    """What the sensors measure, of position, force and the two pressures."""
    known = {"position", "force", "pressure_a", "pressure_b"}.difference(missing_signals(loop.sensors))
    exact = not hasattr(loop.sensors, "missing")  # such sensors know all: of a force only where it counts
    return known - {"force"} if exact and not isinstance(loop.controls, Force) else known


def rods(plant: Block) -> tuple[float, float]:
    """The diameters of the rod on the left and on the right, as shares of the piston's."""
    a, b = getattr(plant, "area_a", 1.0), getattr(plant, "area_b", 1.0)
    if hasattr(plant, "piston_area") or a == b:
        return SOME_ROD, SOME_ROD
    if a > b:
        return 0.0, math.sqrt(1.0 - b / a)
    full = b / (1.0 - UNEQUAL)
    return math.sqrt(1.0 - a / full), math.sqrt(UNEQUAL)


def barrel(y: float, left: float, right: float) -> str:
    """The barrel, open where rods pass."""
    top, bottom = y - HALF, y + HALF
    d = f"M{n(LEFT)} {n(y - HALF * left)}V{n(top)}H{n(RIGHT)}V{n(y - HALF * right)}"
    d += f"M{n(RIGHT)} {n(y + HALF * right)}V{n(bottom)}H{n(LEFT)}V{n(y + HALF * left)}"
    return sym.path(d)


def oil(stroke: Stroke, y: float, left: float, right: float) -> str:
    """The oil in both chambers, around the rods; what leaves the barrel is not seen."""
    body = ""
    ends = (("pA", left, LEFT - TRAVEL, PISTON), ("pB", right, PISTON + THICK, RIGHT))
    for port, rod, start, end in ends:
        gap = HALF * (1.0 - rod)
        d = f"M{n(start)} {n(y - HALF)}H{n(end)}v{n(gap)}H{n(start)}z"
        d += f"M{n(start)} {n(y + HALF)}H{n(end)}v{n(-gap)}H{n(start)}z"
        body += sym.path(d, f'class="oil" data-port="{port}" {sym.LIGHT} stroke="none"')
    return sym.clipped(LEFT, y - HALF, RIGHT - LEFT, 2 * HALF, stroke.moved(body, "slide", 0.0, TRAVEL))


def piston(y: float, left: float, right: float) -> str:
    """The piston with its rods."""
    body = sym.rect(PISTON, y - HALF, THICK, 2 * HALF, sym.DARK)
    for share, start, end in ((right, PISTON + THICK, ROD), (left, PISTON, LEFT - TRAVEL - 12)):
        d = HALF * share
        body += sym.path(f"M{n(start)} {n(y - d)}H{n(end)}V{n(y + d)}H{n(start)}") if share else ""
    return body


def moved_by(plant: Block) -> Any:
    """The mechanism that the rod moves, without the workpiece that it meets; None where a plant has none."""
    mechanism = getattr(plant, "mechanism", None)
    return mechanism.mechanism if isinstance(mechanism, Contact) else mechanism


def sag(plant: Block) -> float:
    """How much further down sensors have their place, for what hangs from the load."""
    hangs = isinstance(getattr(plant, "carried", None), SwingingLoad)
    return 44.0 if hangs and not isinstance(moved_by(plant), OneLinkArm) else 0.0


def draw_cell(sheet: Sheet, stroke: Stroke, y: float, low: float) -> None:
    """A load cell between rod and load; its cable, on the level ``low``, follows it."""
    middle, end = ROD + CELL / 2, WALL - 6
    box = sym.rect(ROD, y - 10, CELL, 20) + sym.label(middle, y, "F")
    box += sym.segment((middle, y + 10), (middle, low), look=CABLE)
    cable = sym.segment((middle, low), (end, low), look=CABLE)
    shortest = (end - middle - TRAVEL) / (end - middle)
    body = stroke.moved(box, "slide", 0.0, TRAVEL)
    body += stroke.moved(cable, "stretch", 1.0, shortest, (end, 0.0))
    edges = ROD, y - 10, end, low
    sheet.place("load cell", body, {"out": (end, low)}, "sensors", "Load cell", edges)


def draw_load(sheet: Sheet, loop: Any, stroke: Stroke, x: float, y: float) -> None:
    """What the rod moves, from its end at x on, and the force from outside."""
    plant = loop.plant
    mechanism = getattr(plant, "mechanism", None)
    carried = getattr(plant, "carried", NothingCarried())
    name = "plant.mechanism" if mechanism is not None else "plant"
    inner = moved_by(plant)
    if isinstance(inner, OneLinkArm):
        top, body, reach = draw_arm(stroke, carried, x, y)
    else:
        top, body, reach = draw_mass(inner, carried, stroke, x, y)
    if isinstance(mechanism, Contact):
        face = reach + TRAVEL * stroke.share(mechanism.position)
        body += sym.hatched(face, y - 6, WALL - face, MASS_HALF + 6) + sym.ground(WALL, y - 12, 36)
    push = type(loop.load) is not Constant or loop.load.amplitude != 0.0
    right = max(WALL + 6, x + 4)
    title = f"Load, {type(mechanism or plant).__name__}"
    sheet.place("load", body, {}, name, title, (x, top, right, y + MASS_HALF))
    if push:
        level = y - 14 if not isinstance(inner, OneLinkArm) else y
        from_right = sym.arrow((reach + 34, level), (reach + 1, level), 'stroke-width="2.2"')
        body = stroke.moved(from_right + sym.label(reach + 42, level, "F"), "slide", 0.0, TRAVEL)
        edges = x, y - MASS_HALF, reach + 34 + TRAVEL, y
        sheet.place("force", body, {}, "load", f"External force, {type(loop.load).__name__}", edges)
        sheet.write(WALL + 6, y - MASS_HALF - 10, "load.force", anchor="end")


def draw_mass(inner: Any, carried: Any, stroke: Stroke, x: float, y: float) -> tuple[float, str, float]:
    """A body on a level path, or a mechanism that has no symbol: its top, SVG and right edge."""
    known = inner is None or isinstance(inner, (Mass, MassSpringDamper))
    text = "m" if known else type(inner).__name__
    width = MASS if known else max(MASS, 8.0 * len(text))
    body = sym.rect(x, y - MASS_HALF, width, 2 * MASS_HALF, sym.LIGHT) + sym.label(x + width / 2, y, text)
    edge = x + width
    if isinstance(carried, SwingingLoad):
        body += hanging(carried, x + width / 2, y + MASS_HALF)
    body = stroke.moved(body, "slide", 0.0, TRAVEL)
    if isinstance(inner, MassSpringDamper):
        body += spring_to_wall(inner.damping > 0.0, stroke, edge, y)
    return y - MASS_HALF, body, edge


def spring_to_wall(damped: bool, stroke: Stroke, x: float, y: float) -> str:
    """A spring, and a damper, between the load and a wall: they shorten."""
    body = sym.spring((x, y + 2), (WALL, y + 2), 7.0, 5)
    if damped:
        middle = 0.5 * (x + WALL)
        body += sym.fine((x, y + 17), (middle, y + 17)) + sym.segment((middle, y + 13), (middle, y + 21))
        body += sym.path(f"M{n(middle - 10)} {n(y + 11)}H{n(middle + 8)}V{n(y + 23)}h-18", sym.FINE)
        body += sym.fine((middle + 8, y + 17), (WALL, y + 17))
    span = WALL - x
    body = stroke.moved(body, "stretch", 1.0, (span - TRAVEL) / span, (WALL, 0.0))
    return body + sym.ground(WALL, y - 20, 48)


def draw_arm(stroke: Stroke, carried: Any, x: float, y: float) -> tuple[float, str, float]:
    """A link on a hinge, which the rod turns by a crank and so raises: its top, SVG and the rod's pin."""
    hinge = x + TRAVEL / 2, y - CRANK
    tip = hinge[0] + LINK * math.cos(DROOP), hinge[1] + LINK * math.sin(DROOP)
    foot = hinge[0], y + 9
    d = "M" + "L".join(f"{n(a)} {n(b)}" for a, b in ((hinge[0] - 5, hinge[1] - 5), (tip[0], tip[1] - 4)))
    d += f"L{n(tip[0])} {n(tip[1] + 4)}L{n(foot[0] + 5)} {n(foot[1])}H{n(foot[0] - 5)}Z"
    turned = sym.path(d, sym.LIGHT)
    turn = math.degrees(math.atan2(TRAVEL / 2, CRANK))
    if isinstance(carried, SwingingLoad):
        upright = stroke.moved(hanging(carried, *tip), "turn", -turn, turn, tip)
        turned += sym.circle(*tip, 3.0, sym.SOLID) + upright
    else:
        turned += sym.circle(*tip, 8.0, sym.DARK)
    body = stroke.moved(turned, "turn", turn, -turn, hinge)
    body += sym.circle(*hinge, 4.0, sym.SOLID) + sym.path(f"M{n(hinge[0])} {n(hinge[1])}l-9 -14h-5h28h-5z")
    body += stroke.moved(sym.circle(x, y, 4.0, sym.SOLID), "slide", 0.0, TRAVEL)
    return hinge[1] - 30, body, x


def hanging(carried: Any, x: float, y: float) -> str:
    """A body that hangs at (x, y) and swings."""
    body = sym.segment((x, y), (x, y + 34)) + sym.circle(x, y + 42, 8.0, sym.DARK)
    ends = -math.pi, math.pi, 180.0, -180.0
    return moved(body, "turn", "plant.carried.angle", ends, carried.start_angle, (x, y))
