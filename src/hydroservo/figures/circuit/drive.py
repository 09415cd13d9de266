"""What lies between cylinder and supply: the stages of a drive, and the valve or pump that meters."""

from collections.abc import Callable
from typing import Any, NamedTuple

from hydroservo.core.block import Block
from hydroservo.core.hooks import drives_in, is_valveless
from hydroservo.figures.circuit import symbols as sym
from hydroservo.figures.circuit.cylinder import PORT_A, PORT_B
from hydroservo.figures.circuit.pump_drive import draw_pump_drive
from hydroservo.figures.circuit.sheet import End, Ends, Sheet
from hydroservo.figures.circuit.supply import draw_compensator, draw_supply
from hydroservo.figures.circuit.valve import MIDDLE, draw_valve
from hydroservo.machine.drives.counterbalance import Counterbalance
from hydroservo.machine.drives.hoses import Hoses
from hydroservo.machine.drives.lines import Lines
from hydroservo.machine.drives.load_sensing import LoadSensing
from hydroservo.machine.drives.port_valves import PortValves
from hydroservo.machine.drives.pressure_compensator import PressureCompensator
from hydroservo.machine.drives.pump_drive import PumpDrive
from hydroservo.machine.drives.valve_on_supply import ValveOnSupply

X = {"A": PORT_A, "B": PORT_B}
OUT = {"A": -1, "B": 1}  # away from the middle
WITHOUT_STATE = (PortValves, PressureCompensator)  # whose state is that of the drive in them
ON_FEED = (PressureCompensator, LoadSensing)  # between supply and valve
Stage = Callable[[Sheet, Any, str, Ends, float], float]


class Metering(NamedTuple):
    """Where what meters stands, and the ports that its command goes to."""

    level: float
    commands: tuple[str, ...]


def draw_drive(sheet: Sheet, loop: Any, ends: Ends, y: float) -> Metering:
    """All below the cylinder, from the level y on."""
    drives = [("drive" + ".drive" * i, one) for i, one in enumerate(drives_in(loop.drive))]
    state = "drive"
    for where, one in drives:
        sheet.states[where] = state
        state += "" if isinstance(one, WITHOUT_STATE) else ".drive"
    for where, one in drives:
        if type(one) not in (*ON_FEED, PumpDrive, ValveOnSupply) and "drive" in one._fields:
            y = STAGES.get(type(one), draw_unknown)(sheet, one, where, ends, y)
    where, last = drives[-1]
    if isinstance(last, PumpDrive):
        y, bottom = draw_pump_drive(sheet, last, where, ends, y)
        draw_supply(sheet, loop.supply, "pump.P", bottom)
        return Metering(y, ("pump.u",))
    if type(last) is not ValveOnSupply:
        y = draw_unknown(sheet, last, where, ends, y)
    if is_valveless(loop.drive):
        return draw_without_valve(sheet, loop, where, y)
    return draw_metering(sheet, loop, drives, ends, y)


def draw_metering(sheet: Sheet, loop: Any, drives: list[tuple[str, Block]], ends: Ends, y: float) -> Metering:
    """The valve, what lies between it and the supply, and the supply."""
    feeds = [(where, one) for where, one in drives if isinstance(one, ON_FEED)]
    level = y + 44.0
    commands = draw_valve(sheet, loop.valve, level, bool(feeds))
    for letter, end in ends.items():
        (x, _), (to, _) = sheet.at(end.port), sheet.at(f"valve.{letter}")
        corners = (x, level - 20.0), (to, level - 20.0)
        sheet.join("work", end.pressure, end.port, f"valve.{letter}", *corners)
    x, bottom = 236.0, level + 66.0
    sym.place_tank(sheet, "tank", x, bottom, "supply")
    t = sheet.at("valve.T")[0]
    sheet.join("work", "pT", "valve.T", "tank.T", (t, level + 58.0), (x, level + 58.0))
    port, below, pump = "valve.P", level + 66.0, ""
    sensed = sheet.node(MIDDLE + 56.0, level + 68.0) if feeds else ""
    if feeds:
        sheet.join("pilot", "", "valve.LS", sensed, (MIDDLE, level + 68.0))
    for where, one in reversed(feeds):
        if isinstance(one, LoadSensing):
            pump, sheet.pressures["pP"] = where, f"{sheet.states[where]}.pressure"
        else:
            port, sensed, below = draw_compensator(sheet, where, port, sensed, below)
    draw_supply(sheet, loop.supply, port, below, sensed if pump else "", pump)
    return Metering(level, commands)


def draw_without_valve(sheet: Sheet, loop: Any, where: str, y: float) -> Metering:
    """A drive without a symbol that stands in the valve's place: the box takes oil and command."""
    box = sheet.symbols[where]
    _, top, right, bottom = box.box
    ports = {"A1": box.ports["A1"], "B1": box.ports["B1"], "P": (MIDDLE, bottom), "u": (right, top + 20.0)}
    sheet.symbols[where] = box._replace(ports=ports)
    draw_supply(sheet, loop.supply, f"{where}.P", y + 6.0)
    return Metering(top, (f"{where}.u",))


def draw_unknown(sheet: Sheet, drive: Any, where: str, ends: Ends, y: float) -> float:
    """A drive that has no symbol: a box in both lines with its name."""
    top, bottom, left, name = y + 8.0, y + 48.0, PORT_A - 16.0, type(drive).__name__
    right = max(PORT_B + 16.0, left + 8.0 * len(name))
    ports = {f"{letter}1": (x, top) for letter, x in X.items()}
    ports |= {f"{letter}2": (x, bottom) for letter, x in X.items()}
    body = sym.labelled(left, top, right - left, bottom - top, name)
    sheet.place(where, body, ports, where, f"Drive, {name}", (left, top, right, bottom))
    for letter, end in ends.items():
        sheet.work(end.pressure, end.port, f"{where}.{letter}1")
        ends[letter] = End(f"{where}.{letter}2", f"{where}.{letter}")
    return y + 56.0


def draw_hoses(sheet: Sheet, drive: Any, where: str, ends: Ends, y: float) -> float:
    """A hose in each line: an arc between two connections; or a long line: a pipe with a break."""
    long = isinstance(drive, Lines)
    for letter, end in ends.items():
        x, top, bottom = X[letter], y + 6.0, y + 46.0
        body = sym.path(f"M{x} {top}q{14 * OUT[letter]} 20 0 40")
        body += sym.circle(x, top, 3) + sym.circle(x, bottom, 3)
        if long:
            body = sym.rect(x - 5, top, 10, 40) + sym.path(f"M{x - 9} {top + 18}l18 -6m0 10l-18 6")
        name, pressure = f"{where} {letter}", f"{where}.{letter}"
        title = f"{'Long line' if long else 'Hose'} {letter}"
        sheet.place(name, body, {"in": (x, top), "out": (x, bottom)}, where, title)
        sheet.work(end.pressure, end.port, f"{name}.in")
        sheet.pressures[pressure] = f"{sheet.states[where]}.pressure_{letter.lower()}"
        ends[letter] = End(f"{name}.out", pressure)
    return y + 52.0


def draw_port_valves(sheet: Sheet, drive: Any, where: str, ends: Ends, y: float) -> float:
    """At each line a relief valve to the tank, and a check valve from it."""
    for letter, end in ends.items():
        x, out, middle = X[letter], OUT[letter], y + 34.0
        near, far = x + 34.0 * out, x + 74.0 * out
        check, relief, drain = (f"{where} {name} {letter}" for name in ("check", "relief", "tank"))
        sym.place_check(sheet, check, drive.check_valve, f"{where}.check_valve", (near, middle))
        sym.place_relief(sheet, relief, f"{where}.relief", (far, middle), out)
        sym.place_tank(sheet, drain, near, y + 66.0)
        tap, over, under = sheet.node(x, y + 8.0), sheet.node(near, y + 8.0), sheet.node(near, y + 60.0)
        sheet.work(end.pressure, end.port, tap, over, f"{check}.out")
        sheet.join("work", end.pressure, over, f"{relief}.in", (far, y + 8.0))
        sheet.work("pT", f"{check}.in", under, f"{drain}.T")
        sheet.join("work", "pT", f"{relief}.out", under, (far, y + 60.0))
        ends[letter] = End(tap, end.pressure)
    return y + 80.0


def draw_counterbalance(sheet: Sheet, drive: Any, where: str, ends: Ends, y: float) -> float:
    """A relief valve that the other line pilots, in one line, and a check valve past it."""
    letter, other = ("B", "A") if drive.in_line_b else ("A", "B")
    end, pilot = ends[letter], ends[other]
    x, out, middle = X[letter], OUT[letter], y + 42.0
    past, relief, check, pressure = x + 48.0 * out, f"{where} relief", f"{where} check", f"{where}.{letter}"
    sym.place_relief(sheet, relief, where, (x, middle), out)
    sheet.symbols[relief].ports["x"] = (x - 14.0 * out, middle - 8.0)
    sym.place_check(sheet, check, drive.check_valve, f"{where}.check_valve", (past, middle))
    top, bottom, tap = sheet.node(x, y + 12.0), sheet.node(x, y + 72.0), sheet.node(X[other], middle - 8.0)
    sheet.work(end.pressure, end.port, top, f"{relief}.in")
    sheet.join("work", end.pressure, top, f"{check}.out", (past, y + 12.0))
    sheet.pressures[pressure] = f"{sheet.states[where]}.pressure"
    sheet.work(pressure, f"{relief}.out", bottom)
    sheet.join("work", pressure, f"{check}.in", bottom, (past, y + 72.0))
    sheet.work(pilot.pressure, pilot.port, tap)
    sheet.join("pilot", "", tap, f"{relief}.x")
    left = min(x - 26.0 * out, x + 66.0 * out)
    frame = sym.rect(left, y + 4, 92.0, 76.0, 'stroke-dasharray="10 3 2 3" stroke-width="1"')
    box = left, y + 4, left + 92.0, y + 80.0
    sheet.place(f"{where} frame", frame, {}, where, "Counterbalance valve", box)
    ends[letter], ends[other] = End(bottom, pressure), End(tap, pilot.pressure)
    return y + 84.0


STAGES: dict[type, Stage] = {
    Hoses: draw_hoses,
    Lines: draw_hoses,
    PortValves: draw_port_valves,
    Counterbalance: draw_counterbalance,
}
