"""The directional valve: three positions that slide in a frame that stands."""

from typing import Any

from hydroservo.figures.circuit import symbols as sym
from hydroservo.figures.circuit.sheet import Sheet, head, moved, n

BOX = sym.BOX
MIDDLE = 132.0  # of the valve, along x
LEFT, RIGHT = MIDDLE - 1.5 * BOX, MIDDLE + 1.5 * BOX
NEAR, FAR = 0.25 * BOX, 0.75 * BOX  # of the ports, in a position
ENVELOPE = 4.0  # from the positions to the lines along them: any position between is possible, too
LETTER = 10.0
SHUT = 0.001  # of the spool's travel, within which the middle position is shown


def draw_valve(sheet: Sheet, valve: Any, y: float, sensing: bool) -> tuple[str, ...]:
    """The valve with its upper edge at y, and the ports that its command goes to.

    Args:
        sheet: the sheet.
        valve: the block.
        y: of the upper edge.
        sensing: whether it has a port that shows the load's pressure.
    """
    edges = valve.orifice
    lap = getattr(edges, "lap", 0.0)
    left = MIDDLE - 0.5 * BOX
    bottom = y + BOX
    ports = {
        "A": (left + NEAR, y),
        "B": (left + FAR, y),
        "P": (left + NEAR, bottom),
        "T": (left + FAR, bottom),
    }
    if sensing:
        ports["LS"] = (MIDDLE, bottom)
    body = sym.rect(LEFT, y, 3 * BOX, BOX) + spool(valve, y, lap, sensing)
    for level in (y - ENVELOPE, bottom + ENVELOPE):
        body += sym.segment((LEFT, level), (RIGHT, level))
    for letter, side in (("A", -1), ("B", 1), ("P", -1), ("T", 1)):
        x, at = ports[letter]
        body += sym.label(x + 7 * side, at + (11 if at == bottom else -11), letter, size=LETTER)
    sheet.write(RIGHT + 28, y + BOX + 8, "valve.opening")
    name = type(valve).__name__
    if lap > 0.0:
        body += proportional(y)
        ports |= {"u": (RIGHT + sym.SOLENOID[0], y + 11.0), "u2": (LEFT - sym.SOLENOID[0] / 2, y + 2.0)}
        title = f"Proportional directional valve, {name}"
        sheet.place("valve", body, ports, "valve", title, (LEFT - 34, y - 10, RIGHT + 34, bottom + 6))
        return "valve.u", "valve.u2"
    body += servo(y)
    ports["u"] = (RIGHT + 16.0 + sym.SOLENOID[0], y + 20.0)
    box = LEFT, y - 6, RIGHT + 46, bottom + 6
    sheet.place("valve", body, ports, "valve", f"Servo valve, {name}", box)
    return ("valve.u",)


def spool(valve: Any, y: float, lap: float, sensing: bool) -> str:
    """The three positions, of which the one that is taken moves to the ports; the frame stands."""
    regenerates = bool(getattr(valve.orifice, "regeneration", False))
    positions = (
        forward(regenerates, sensing) + shift(centre(lap, sensing), BOX) + shift(reverse(sensing), 2 * BOX)
    )
    dividers = "".join(sym.segment((k * BOX, 0), (k * BOX, BOX)) for k in range(4))
    follows, shut = "valve.opening", max(lap, SHUT * getattr(valve, "max_opening", 0.0))
    if not hasattr(valve.init(), "opening"):
        follows, shut = "controller.u", shut / getattr(valve, "gain", 1.0)
    inside = moved(positions + dividers, "switch", follows, (-shut, shut, -BOX, BOX), 0.0)
    placed = f'<g transform="translate({n(LEFT)} {n(y)})">{inside}</g>'
    return sym.clipped(LEFT, y, 3 * BOX, BOX, placed)


def shift(body: str, x: float) -> str:
    return f'<g transform="translate({n(x)} 0)">{body}</g>'


def forward(regenerates: bool, sensing: bool) -> str:
    """P to A and B to T; or, where it regenerates, B to P, too."""
    body = sym.arrow((NEAR, BOX), (NEAR, 1))
    if regenerates:
        body += sym.fine((FAR, 0), (FAR, 24), (NEAR, 24)) + head((FAR, 24), (NEAR, 24)) + stop(FAR, BOX)
    else:
        body += sym.arrow((FAR, 0), (FAR, BOX - 1))
    return body + (sensed((BOX / 2, BOX), (BOX / 2, 32), (NEAR, 32)) if sensing else "")


def reverse(sensing: bool) -> str:
    """P to B and A to T."""
    body = sym.arrow((NEAR, BOX), (FAR, 1)) + sym.arrow((NEAR, 0), (FAR, BOX - 1))
    return body + (sensed((BOX / 2, BOX), (BOX / 2, 30), (BOX / 2 - 5, 30)) if sensing else "")


def centre(lap: float, sensing: bool) -> str:
    """All ports shut; with underlap all are joined by throttles."""
    if lap < 0.0:
        body = sym.fine((NEAR, 0), (NEAR, BOX)) + sym.fine((FAR, 0), (FAR, BOX))
        body += sym.fine((NEAR, BOX / 2), (FAR, BOX / 2))
        for x in (NEAR, FAR):
            for at in (8, BOX - 8):
                body += sym.path(f"M{n(x - 4)} {at - 4}q3 4 0 8M{n(x + 4)} {at - 4}q-3 4 0 8", sym.FINE)
        return body
    body = stop(NEAR, 0) + stop(FAR, 0) + stop(NEAR, BOX) + stop(FAR, BOX)
    return body + (sensed((BOX / 2, BOX), (BOX / 2, 35), (FAR, 35)) if sensing else "")


def sensed(*points: tuple[float, float]) -> str:
    return sym.segment(*points, look='stroke-width="1.2" stroke-dasharray="3 2"')


def stop(x: float, y: float) -> str:
    """A port that is shut."""
    inner = 10.0 if y == 0.0 else y - 10.0
    return sym.fine((x, y), (x, inner)) + sym.fine((x - 5, inner), (x + 5, inner))


def proportional(y: float) -> str:
    """A proportional solenoid and a centring spring at either end."""
    body = sym.solenoid(LEFT - sym.SOLENOID[0], y + 2, 1, -1) + sym.solenoid(RIGHT, y + 2, 1, 1)
    body += sym.spring((LEFT, y + 31), (LEFT - 20, y + 31))
    return body + sym.spring((RIGHT, y + 31), (RIGHT + 20, y + 31))


def servo(y: float) -> str:
    """A motor of two coils, a hydraulic pilot stage, and the spool's position fed back to it."""
    body = sym.rect(RIGHT, y + 11, 16, 18) + sym.path(f"M{n(RIGHT + 2)} {n(y + 20)}l10 -5.5v11z", sym.SOLID)
    body += sym.solenoid(RIGHT + 16, y + 11, 2, 1)
    return body + sym.fine((RIGHT, y + 36), (RIGHT + 24, y + 36), (RIGHT + 24, y + 29))
