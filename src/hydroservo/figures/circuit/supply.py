"""Where the oil comes from, and what throttles it before the valve."""

from typing import Any

from hydroservo.core.formatting import quantity
from hydroservo.figures.circuit import symbols as sym
from hydroservo.figures.circuit.sheet import Sheet
from hydroservo.machine.supplies.ideal import IdealSupply
from hydroservo.machine.supplies.no_accumulator import NoAccumulator
from hydroservo.machine.supplies.pump import PumpSupply

MOTOR = 62.0  # from a pump's middle to its motor's, to the left


def draw_supply(sheet: Sheet, supply: Any, port: str, y: float, sensed: str = "", control: str = "") -> None:
    """The supply below the port that it feeds, from the level y on.

    Args:
        sheet: the sheet.
        supply: the block.
        port: that it feeds.
        y: where there is room.
        sensed: a port with the load's pressure, which the pump's control follows; "" for none.
        control: the path of that control.
    """
    x = sheet.at(port)[0]
    sheet.pressures.setdefault("pP", getattr(supply, "supply_pressure", "supply.pressure"))
    sheet.pressures["pT"] = getattr(supply, "return_pressure", 0.0)
    if isinstance(supply, PumpSupply):
        draw_pump_supply(sheet, supply, port, y, sensed, control)
        return
    if isinstance(supply, IdealSupply):
        right, low = (x + sym.PUMP + 56.0, y + 52.0) if sensed else (x + 14.0, y + 14.0)
        sheet.write(right, low, text=quantity(supply.supply_pressure, "Pa"))
    if sensed:
        draw_pump(sheet, port, y + 24.0, sensed, control)
        sheet.write(x - 8, y + 4.0, str(sheet.pressures["pP"]), anchor="end")
        return
    name = type(supply).__name__
    body, wide = sym.path(f"M{x} {y}l-9 16h18z", sym.SOLID), 18.0
    if not isinstance(supply, IdealSupply):
        wide = max(60.0, 8.0 * len(name))
        body = sym.labelled(x - wide / 2, y, wide, 30.0, name)
    box = x - wide / 2, y, x + wide / 2, y + 30.0
    sheet.place("source", body, {"P": (x, y)}, "supply", f"Supply, {name}", box)
    sheet.work("pP", port, "source.P")


def draw_pump(sheet: Sheet, port: str, y: float, sensed: str, control: str) -> None:
    """A pump with its motor and a tank below the port that it feeds; y is the level of its pressure port."""
    x, middle, r = sheet.at(port)[0], y + sym.PUMP, sym.PUMP
    body = sym.pump(x, middle, variable=bool(sensed)) + sym.motor(x - MOTOR, middle, 18.0)
    body += sym.shaft((x - MOTOR + 18.0, middle), (x - r, middle))
    box = x - MOTOR - 18, y, x + r, middle + r
    sheet.place("pump", body, {"P": (x, y), "T": (x, middle + r)}, "supply", "Pump and motor", box)
    sym.place_tank(sheet, "pump tank", x, middle + r + 10.0)
    sheet.work("pT", "pump.T", "pump tank.T")
    if not sensed:
        sheet.work("pP", port, "pump.P")
        return
    left, top = x + r + 12.0, middle - 10.0
    body = sym.labelled(left, top, 36.0, 20.0, "LS") + sym.segment((x + r, middle), (left, middle))
    at = {"p": (left + 6, top), "ls": (left + 30, top)}
    sheet.place("control", body, at, control, "Load-sensing control of the pump")
    tap = sheet.node(x, y - 12.0)
    sheet.work("pP", port, tap, "pump.P")
    sheet.join("pilot", "", tap, "control.p", (left + 6, y - 12.0))
    sheet.join("pilot", "", sensed, "control.ls")


def draw_pump_supply(sheet: Sheet, supply: Any, port: str, y: float, sensed: str, control: str) -> None:
    """A pump with a relief valve and, where there is one, an accumulator."""
    x, stores = sheet.at(port)[0], not isinstance(supply.accumulator, NoAccumulator)
    level = y + (52.0 if stores else 8.0)
    header = sheet.node(x, level)
    sheet.work("pP", port, header)
    sheet.write(x + 8, level - 8, str(sheet.pressures["pP"]))
    if stores:
        at, name = x - 58.0, type(supply.accumulator).__name__
        body = sym.accumulator(at, level)
        sheet.place("accumulator", body, {"P": (at, level)}, "supply.accumulator", f"Accumulator, {name}")
        sheet.work("pP", header, "accumulator.P")
    at, middle = x + (130.0 if sensed else 76.0), level + 12.0 + sym.REACH
    sym.place_relief(sheet, "relief", "supply.relief", (at, middle))
    sheet.join("work", "pP", header, "relief.in", (at, level))
    sym.place_tank(sheet, "relief tank", at, middle + sym.REACH + 8.0)
    sheet.work("pT", "relief.out", "relief tank.T")
    if supply.demanded_speed > 0.0:
        draw_pump(sheet, header, level + (26.0 if sensed else 14.0), sensed, control)


def draw_compensator(sheet: Sheet, where: str, port: str, sensed: str, y: float) -> tuple[str, str, float]:
    """A pressure compensator below a port: its inlet, the port of the load's pressure, where it ends."""
    x, half, reach = sheet.at(port)[0], 0.5 * sym.SMALL, sym.REACH
    middle = y + 12.0 + reach
    body = sym.rect(x - half, middle - half, sym.SMALL, sym.SMALL)
    body += sym.arrow((x, middle + half), (x, middle - half))
    body += sym.segment((x, middle - reach), (x, middle - half))
    body += sym.segment((x, middle + half), (x, middle + reach))
    body += sym.spring((x + half, middle + 7), (x + half + 18, middle + 7), 4.0)
    top, left = middle - reach + 2, x - half - 7
    body += sym.segment((x, top), (left, top), (left, middle), (x - half, middle), look=sym.PILOT)
    ports = {"out": (x, middle - reach), "in": (x, middle + reach), "ls": (x + half, middle - 6)}
    name = f"{where} compensator"
    sheet.place(name, body, ports, where, "Pressure compensator")
    sheet.work("pC", port, f"{name}.out")
    tap = sheet.node(sheet.at(sensed)[0], middle - 6)
    sheet.join("pilot", "", sensed, tap)
    sheet.join("pilot", "", tap, f"{name}.ls")
    return f"{name}.in", tap, middle + reach + 10.0
