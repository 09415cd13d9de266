"""Graphic symbols of ISO 1219-1 as SVG, each about a point; the sizes are multiples of a module of 10."""

from html import escape
from typing import Any

from hydroservo.figures.circuit.sheet import LETTER, Point, Sheet, head, n

BOX = 40.0  # side of a position of a directional valve
SMALL = 28.0  # and of the one of a pressure valve
PUMP = 24.0  # radius of pumps and motors
SENSOR = 10.0  # radius of what measures
SOLENOID = (30.0, 18.0)  # width and height
REACH = 20.0  # from the middle of a valve of two ports to each of them
SOLID = 'fill="currentColor" stroke="none"'
LIGHT = 'fill="currentColor" fill-opacity="0.08"'
DARK = 'fill="currentColor" fill-opacity="0.3"'
FINE = 'stroke-width="1.2"'
PILOT = 'stroke-width="1.2" stroke-dasharray="4 2"'


def path(d: str, look: str = "") -> str:
    return f'<path d="{d}"{f" {look}" if look else ""}/>'


def rect(x: float, y: float, w: float, h: float, look: str = "") -> str:
    extra = f" {look}" if look else ""
    return f'<rect x="{n(x)}" y="{n(y)}" width="{n(w)}" height="{n(h)}"{extra}/>'


def circle(x: float, y: float, r: float, look: str = "") -> str:
    return f'<circle cx="{n(x)}" cy="{n(y)}" r="{n(r)}"{f" {look}" if look else ""}/>'


def clipped(x: float, y: float, w: float, h: float, body: str) -> str:
    """What is within a frame; the rest is not seen."""
    name = f"within-{n(x)}-{n(y)}-{n(w)}-{n(h)}"  # on a page of many circuits equal names are equal frames
    return f'<clipPath id="{name}">{rect(x, y, w, h)}</clipPath><g clip-path="url(#{name})">{body}</g>'


def label(x: float, y: float, text: str, anchor: str = "middle", size: float = LETTER) -> str:
    """A text on the line through a point."""
    look = f'text-anchor="{anchor}" font-family="sans-serif" font-size="{n(size)}" {SOLID}'
    return f'<text x="{n(x)}" y="{n(y + 0.36 * size)}" {look}>{escape(text)}</text>'


def segment(*points: Point, look: str = "") -> str:
    """A line over some points."""
    return path("M" + "L".join(f"{n(x)} {n(y)}" for x, y in points), look)


def fine(*points: Point) -> str:
    """A thinner line over some points."""
    return segment(*points, look=FINE)


def arrow(start: Point, tip: Point, look: str = FINE) -> str:
    return segment(start, tip, look=look) + head(start, tip)


def spring(start: Point, end: Point, width: float = 5.0, turns: int = 3) -> str:
    """A zigzag between two points on a level or a plumb line."""
    (x0, y0), (x1, y1) = start, end
    along = [(k + 0.5) / (2 * turns) for k in range(2 * turns)]
    side = [width if k % 2 else -width for k in range(2 * turns)]
    level = y0 == y1
    points = [
        (x0 + t * (x1 - x0) + (0.0 if level else s), y0 + t * (y1 - y0) + (s if level else 0.0))
        for t, s in zip(along, side, strict=True)
    ]
    return fine(start, *points, end)


def hatched(x: float, y: float, w: float, h: float) -> str:
    """A solid body: hatched."""
    lines = []
    for at in range(8, int(w + h), 8):
        x0, y0 = x + min(at, w), y + max(at - w, 0.0)
        x1, y1 = x + max(at - h, 0.0), y + min(at, h)
        lines.append(f"M{n(x0)} {n(y0)}L{n(x1)} {n(y1)}")
    return rect(x, y, w, h) + path("".join(lines), 'stroke-width="0.8"')


def ground(x: float, y: float, h: float) -> str:
    """A wall to the right of x, which stands still."""
    strokes = "".join(f"M{n(x)} {n(y + at)}l6 -6" for at in range(8, int(h) + 1, 8))
    return segment((x, y), (x, y + h), look='stroke-width="2"') + path(strokes, 'stroke-width="0.8"')


def tank(x: float, y: float) -> str:
    """A reservoir that is open to the air; the line ends in it, at (x, y) from above."""
    return path(f"M{n(x - 12)} {n(y)}v10h24v-10") + segment((x, y), (x, y + 6))


def check_valve(x: float, y: float, loaded: bool) -> str:
    """A check valve that opens upwards: a ball on a seat, with a spring where one loads it."""
    ball, top, bottom = 6.0, y - REACH, y + REACH
    seat = path(f"M{n(x - 9)} {n(y + 1)}L{n(x)} {n(y + 10)}L{n(x + 9)} {n(y + 1)}")
    above = segment((x, top), (x, y - ball - 1.5))
    if loaded:
        above = spring((x, y - ball - 1.5), (x, top))
    return circle(x, y - 1.5, ball) + seat + segment((x, y + 10), (x, bottom)) + above


def relief_valve(x: float, y: float, side: int) -> str:
    """A relief valve from above to below: an adjustable spring shuts it, on a side, 1 for the right."""
    half, off = 0.5 * SMALL, -6.0 * side
    edge, far = x + side * half, x - side * (half + 7)
    body = rect(x - half, y - half, SMALL, SMALL) + arrow((x + off, y - half), (x + off, y + half))
    body += segment((x, y - REACH), (x, y - half)) + segment((x, y + half), (x, y + REACH))
    body += spring((edge, y), (edge + side * 16, y), 5.0)
    body += arrow((edge + side * 2, y + 9), (edge + side * 15, y - 10))
    return body + segment(
        (x, y - REACH + 2), (far, y - REACH + 2), (far, y), (x - side * half, y), look=PILOT
    )


def pump(x: float, y: float, *, both: bool = False, level: bool = False, variable: bool = False) -> str:
    """A pump: a solid triangle where oil leaves it, two where it may leave either way."""
    r = PUMP
    turned = f' transform="rotate(90 {n(x)} {n(y)})"' if level else ""
    ends = path(f"M{n(x)} {n(y - r)}l-7 12h14z", SOLID)
    if both:
        ends += path(f"M{n(x)} {n(y + r)}l-7 -12h14z", SOLID)
    body = circle(x, y, r) + f"<g{turned}>{ends}</g>"
    if variable:
        body += arrow((x - r - 5, y + r + 3), (x + r + 4, y - r - 2))
    return body


def motor(x: float, y: float, r: float = PUMP) -> str:
    """An electric motor."""
    return circle(x, y, r) + label(x, y, "M", size=14)


def shaft(start: Point, end: Point) -> str:
    """A shaft or another mechanical link: two lines, on the level or plumb."""
    (x0, y0), (x1, y1) = start, end
    dx, dy = (0.0, 2.5) if y0 == y1 else (2.5, 0.0)
    return segment((x0 - dx, y0 - dy), (x1 - dx, y1 - dy)) + segment((x0 + dx, y0 + dy), (x1 + dx, y1 + dy))


def accumulator(x: float, y: float) -> str:
    """An accumulator with gas, whose oil comes from below, at (x, y)."""
    d = f"M{n(x - 12)} {n(y - 22)}v-20a12 12 0 0 1 24 0v20a12 12 0 0 1 -24 0z"
    gas = path(f"M{n(x - 5)} {n(y - 46)}h10l-5 9z")
    return path(d) + segment((x - 12, y - 32), (x + 12, y - 32)) + gas + segment((x, y - 10), (x, y))


def sensor(x: float, y: float, letter: str) -> str:
    """What measures: a circle with the letter of the quantity."""
    return circle(x, y, SENSOR) + label(x, y - 0.5, letter)


def solenoid(x: float, y: float, coils: int, side: int) -> str:
    """A solenoid right of and below (x, y), on a side of its valve: a line for a coil, an arrow."""
    w, h = SOLENOID
    middle, lean = x + w / 2, 5.0 * side
    lines = fine((middle - lean, y + h), (middle + lean, y))
    if coils == 2:
        lines = fine((middle - 9, y + h), (middle - 3, y))
        lines += fine((middle + 9, y + h), (middle + 3, y))
    return rect(x, y, w, h) + lines + arrow((x + 3, y + h + 5), (x + w - 3, y - 6))


def labelled(x: float, y: float, w: float, h: float, text: str) -> str:
    """A block that has no symbol: a box with its name."""
    return rect(x, y, w, h) + label(x + w / 2, y + h / 2, text)


def place_tank(sheet: Sheet, name: str, x: float, y: float, path: str = "") -> None:
    """A reservoir with the port "T"."""
    sheet.place(name, tank(x, y), {"T": (x, y)}, path, "Tank")


def place_check(sheet: Sheet, name: str, valve: Any, path: str, at: Point) -> None:
    """A check valve that opens upwards, about a point, with the ports "in" and "out"."""
    x, y = at
    body = check_valve(x, y, getattr(valve, "cracking_pressure", 0.0) > 0.0)
    sheet.place(name, body, {"in": (x, y + REACH), "out": (x, y - REACH)}, path, "Check valve")


def place_relief(sheet: Sheet, name: str, path: str, at: Point, side: int = 1) -> None:
    """A relief valve from above to below about a point, with the ports "in" and "out"."""
    x, y = at
    box = x - 34, y - REACH, x + 34, y + REACH
    ports = {"in": (x, y - REACH), "out": (x, y + REACH)}
    sheet.place(name, relief_valve(x, y, side), ports, path, "Pressure relief valve", box)
