"""The hydraulic circuit of a loop, drawn from its blocks with symbols of ISO 1219-1."""

from typing import Any

from hydroservo.control.loop import Loop
from hydroservo.figures.circuit import symbols as sym
from hydroservo.figures.circuit.cylinder import PORT_A, PORT_B, draw_cylinder, measured, moved_by, sag
from hydroservo.figures.circuit.drive import Metering, draw_drive
from hydroservo.figures.circuit.sheet import End, Ends, Sheet
from hydroservo.machine.mechanics.one_link_arm import OneLinkArm

LEVEL, ARM_LEVEL = 60.0, 130.0  # of the cylinder; an arm needs room above
LAW = (304.0, 430.0, 40.0)  # left, right and height of the controller
INPUTS = {"load cell": 418.0, "position": 400.0, "pressure B": 382.0, "pressure A": 364.0}  # along x
DEMAND, FORK = 390.0, 250.0  # along x: the demand's line, and where a command goes two ways
MOST_LETTERS = 17


class Drawing(str):
    """SVG text that a notebook shows as the picture."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        return str(self)


def circuit(loop: Loop) -> Drawing:
    """The hydraulic circuit of a loop as SVG, which takes the colour of the text around it.

    Each symbol stands for a block: cylinder, load, valve or pump, what lies between, supply, sensors and
    controller. Blocks without a symbol of their own, such as those of a plug-in, are boxes with their names.
    Numbers have a place and are empty where they come from a run; a page may fill them in, and move what
    moves, by the attributes ``data-signal``, ``data-slide``, ``data-turn``, ``data-stretch`` and
    ``data-port``.

    Args:
        loop: such as :func:`~hydroservo.scenario.load_scenario` returns.

    Source: ISO 1219-1 (symbols), as published tables of its symbols show them.
    Fails to tell how parts are built: a valve with overlap is drawn as a proportional valve with two
    solenoids, one without as a servo valve.
    """
    return Drawing(sheet_of(loop).svg())


def sheet_of(loop: Any) -> Sheet:
    """The symbols and lines of a loop's circuit."""
    sheet = Sheet()
    level = ARM_LEVEL if isinstance(moved_by(loop.plant), OneLinkArm) else LEVEL
    draw_cylinder(sheet, loop, level)
    known, low = measured(loop), level + sag(loop.plant)
    ends = {letter: End(f"cylinder.{letter}", f"p{letter}") for letter in "AB"}
    for letter, x, y in (("A", PORT_A, low + 98.0), ("B", PORT_B, low + 79.0)):
        if f"pressure_{letter.lower()}" in known:
            draw_transducer(sheet, letter, ends, x, y)
    if "position" in known:
        draw_position_sensor(sheet, low + 56.0)
    pressures = known & {"pressure_a", "pressure_b"}
    metering = draw_drive(sheet, loop, ends, low + (114.0 if pressures else 76.0))
    draw_controller(sheet, loop, metering)
    draw_command(sheet, metering)
    return sheet


def draw_transducer(sheet: Sheet, letter: str, ends: Ends, x: float, y: float) -> None:
    """A pressure transducer at one of the cylinder's lines, which goes on from there."""
    name, at = f"pressure {letter}", x + 24.0 + sym.SENSOR
    ports = {"in": (at - sym.SENSOR, y), "out": (at + sym.SENSOR, y)}
    sheet.place(name, sym.sensor(at, y, "p"), ports, "sensors", f"Pressure transducer {letter}")
    node, end = sheet.node(x, y), ends[letter]
    sheet.work(end.pressure, end.port, node, f"{name}.in")
    ends[letter] = End(node, end.pressure)


def draw_position_sensor(sheet: Sheet, y: float) -> None:
    """A position sensor at the rod."""
    x = sheet.at("cylinder.rod")[0]
    ports = {"in": (x, y - sym.SENSOR), "out": (x + sym.SENSOR, y)}
    sheet.place("position", sym.sensor(x, y, "s"), ports, "sensors", "Position sensor")
    sheet.join("mechanical", "", "cylinder.rod", "position.in")


def draw_controller(sheet: Sheet, loop: Any, metering: Metering) -> None:
    """The controller beside what meters, with its demand and what it measures."""
    (left, right, height), y = LAW, metering.level
    level = sheet.at(metering.commands[0])[1]
    names, demand = law_names(loop.controller), type(loop.reference).__name__
    text = names[-1] if len(names[-1]) <= MOST_LETTERS else f"{names[-1][: MOST_LETTERS - 1]}…"
    measuring = {name: x for name, x in INPUTS.items() if name in sheet.symbols}
    ports = {name: (x, y) for name, x in measuring.items()}
    ports |= {"u": (left, level if y < level < y + height else y + height / 2), "r": (DEMAND, y + height)}
    body = sym.labelled(left, y, right - left, height, text)
    box, below = (left, y, right, y + height), y + height + 26.0
    sheet.place("controller", body, ports, "controller", f"Law, {', '.join(names)}", box)
    box = DEMAND - 40.0, below, DEMAND + 40.0, below + 20.0
    body = sym.label(DEMAND, below + 10.0, demand)
    sheet.place("reference", body, {"out": (DEMAND, below)}, "reference", f"Demand, {demand}", box)
    sheet.join("signal", "", "reference.out", "controller.r")
    sheet.write(DEMAND - 8, below - 8, "reference.value", anchor="end")
    for name, x in measuring.items():
        sheet.join("signal", "", f"{name}.out", f"controller.{name}", (x, sheet.at(f"{name}.out")[1]))


def draw_command(sheet: Sheet, metering: Metering) -> None:
    """The command's line to each solenoid, or to the motor."""
    first, *others = metering.commands
    (x, y), (end, level) = sheet.at("controller.u"), sheet.at(first)
    sheet.write(x - 8, y - 8, "controller.u", anchor="end")
    if not others:
        sheet.join("signal", "", "controller.u", first, *([(end, y)] if level != y else []))
        return
    fork, over = sheet.node(FORK, y), metering.level - 34.0
    sheet.join("signal", "", "controller.u", fork)
    sheet.join("signal", "", fork, first)
    for other in others:
        sheet.join("signal", "", fork, other, (FORK, over), (sheet.at(other)[0], over))


def law_names(law: Any) -> list[str]:
    """A law and those that it wraps, from the outside in."""
    inner = getattr(law, "controller", None)
    return [type(law).__name__, *(law_names(inner) if inner is not None else [])]
