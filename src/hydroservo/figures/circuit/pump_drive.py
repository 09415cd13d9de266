"""A pump between the cylinder's ports, with the valves that replenish and relieve its lines."""

from typing import Any

from hydroservo.figures.circuit import symbols as sym
from hydroservo.figures.circuit.cylinder import PORT_A, PORT_B
from hydroservo.figures.circuit.sheet import Ends, Sheet, n

MIDDLE = 0.5 * (PORT_A + PORT_B)
PUMP, MOTOR = 18.0, 12.0  # radii, where two pumps share a shaft
HEADER = 112.0  # from the pump's level to the line that replenishes


def draw_pump_drive(sheet: Sheet, drive: Any, where: str, ends: Ends, y: float) -> tuple[float, float]:
    """Pump, motor and valves from the level y on: the level of the controller, and where all ends."""
    axis, two = y + 70.0, drive.displacement_ratio != 1.0
    body, outer = two_pumps(axis) if two else one_pump(axis, y + 14.0)
    at = {"A": (MIDDLE - outer, axis), "B": (MIDDLE + outer, axis), "P": (MIDDLE, axis + HEADER)}
    at["u"] = (MIDDLE, axis - MOTOR) if two else (MIDDLE + PUMP, y + 14.0)
    drained = two or drive.case_leakage > 0.0
    if drained:
        at["T"] = (MIDDLE, axis + (PUMP + 8.0 if two else sym.PUMP))
    sheet.place("pump", body, at, where, "Pump and servo motor")
    if drained:
        sym.place_tank(sheet, "drain", MIDDLE, axis + 64.0)
        sheet.join("work" if two else "pilot", "pT" if two else "", "pump.T", "drain.T")
    taps = {letter: draw_side(sheet, drive, where, letter, ends, axis) for letter in ends}
    for letter, other, x in (("A", "B", PORT_A + 34.0), ("B", "A", PORT_B - 34.0)):
        if "x" in sheet.symbols[f"check {letter}"].ports:
            (_, level), (_, pilot) = sheet.at(taps[other]), sheet.at(f"check {letter}.x")
            sheet.join("pilot", "", taps[other], f"check {letter}.x", (x, level), (x, pilot))
    sheet.work("pP", ends["A"].port, "pump.P", ends["B"].port)
    sheet.write(PORT_A - 8, y + 20.0, f"{sheet.states[where]}.speed", anchor="end")
    return y - 6.0, axis + HEADER + 12.0


def draw_side(sheet: Sheet, drive: Any, where: str, letter: str, ends: Ends, axis: float) -> str:
    """The line to a port, with its check and its relief valve: where the other's pilot taps it."""
    x, out = (PORT_A, -1) if letter == "A" else (PORT_B, 1)
    far, middle, header = x + 46.0 * out, axis + 76.0, axis + HEADER
    check, relief, (port, pressure) = f"check {letter}", f"relief {letter}", ends[letter]
    sym.place_check(sheet, check, drive.check_valve, f"{where}.check_valve", (x, middle))
    sym.place_relief(sheet, relief, f"{where}.relief", (far, middle), out)
    tap, bottom = sheet.node(x, axis), sheet.node(x, header)
    sheet.work(pressure, port, tap, f"pump.{letter}")
    sheet.join("work", pressure, tap, f"{relief}.in", (far, axis))
    sheet.join("work", "pP", f"{relief}.out", bottom, (far, header))
    sheet.work("pP", f"{check}.in", bottom)
    ends[letter] = ends[letter]._replace(port=bottom)
    if getattr(drive.check_valve, "pilot_ratio", 0.0) > 0.0:
        sheet.symbols[check].ports["x"] = (x - 9.0 * out, middle + 1.0)
        start, tap = tap, sheet.node(x, axis + (32.0 if letter == "B" else 42.0))
        sheet.work(pressure, start, tap)
    sheet.work(pressure, tap, f"{check}.out")
    return tap


def one_pump(axis: float, above: float) -> tuple[str, float]:
    """A pump of two directions below its motor, and how far its ports are from the middle."""
    body = sym.pump(MIDDLE, axis, both=True, level=True) + sym.motor(MIDDLE, above, PUMP)
    return body + sym.shaft((MIDDLE, above + PUMP), (MIDDLE, axis - sym.PUMP)), sym.PUMP


def two_pumps(axis: float) -> tuple[str, float]:
    """Two pumps on one motor's shaft, each between a port and the tank."""
    gap, r = MOTOR + 4.0 + PUMP, PUMP
    body = sym.motor(MIDDLE, axis, MOTOR)
    for side in (-1, 1):
        x = MIDDLE + side * gap
        body += sym.circle(x, axis, r) + sym.path(f"M{n(x)} {n(axis + r)}v8H{n(MIDDLE)}")
        body += sym.path(f"M{n(x + side * r)} {n(axis)}l{-10 * side} -6v12z", sym.SOLID)
        body += sym.path(f"M{n(x)} {n(axis + r)}l-6 -10h12z", sym.SOLID)
        body += sym.shaft((MIDDLE + side * MOTOR, axis), (x - side * r, axis))
    return body, gap + r
