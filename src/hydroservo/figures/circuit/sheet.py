"""A sheet on which symbols stand and lines join their ports; it is written as SVG."""

import math
from collections.abc import Iterable
from html import escape
from itertools import pairwise
from typing import Literal, NamedTuple

Point = tuple[float, float]
Ports = dict[str, Point]
Box = tuple[float, float, float, float]  # left, top, right and bottom
Kind = Literal["work", "pilot", "signal", "mechanical"]

DASHES = {"pilot": "6 3", "signal": "2 3", "mechanical": ""}  # of lines other than working lines
NO_BOX: Box = (0.0, 0.0, 0.0, 0.0)
ROOM = 12.0  # around ports
MARGIN = 8.0  # around all
DOT = 3.0  # radius of a connection of lines
LETTER = 12  # size of a text


class Symbol(NamedTuple):
    """A symbol, placed.

    Attributes:
        name: on this sheet.
        path: of the block that it stands for, within the loop; "" for none.
        title: what it is.
        ports: by name, where lines end.
        body: as SVG.
        box: around it.
    """

    name: str
    path: str
    title: str
    ports: Ports
    body: str
    box: Box


class Line(NamedTuple):
    """A line from a port to another, each as "symbol.port".

    Attributes:
        kind: working lines carry oil, pilot lines its pressure, signal lines voltages.
        pressure: the node of the circuit whose pressure it has, such as "pA"; "" for other kinds.
        start: the first port.
        end: the last port.
        points: where it runs, both ports included.
    """

    kind: Kind
    pressure: str
    start: str
    end: str
    points: list[Point]


class End(NamedTuple):
    """Where a line from the cylinder ends so far, and the node whose pressure it has there."""

    port: str
    pressure: str


Ends = dict[str, End]  # by the cylinder's port


class Sheet:
    """Symbols and lines, in the order in which they were placed."""

    def __init__(self) -> None:
        self.symbols: dict[str, Symbol] = {}
        self.lines: list[Line] = []
        self.values: list[str] = []
        self.states: dict[str, str] = {}  # of drives: the path of the state of each, by that of the block
        self.pressures: dict[str, str | float] = {}  # of nodes: a signal's path, or a constant [Pa]

    def place(
        self,
        name: str,
        body: str,
        ports: dict[str, Point],
        path: str = "",
        title: str = "",
        box: Box = NO_BOX,
    ) -> None:
        """Put a symbol on the sheet; where no box is given it has some room around its ports."""
        if box == NO_BOX:
            xs, ys = zip(*ports.values(), strict=True)
            box = min(xs) - ROOM, min(ys) - ROOM, max(xs) + ROOM, max(ys) + ROOM
        self.symbols[name] = Symbol(name, path, title, ports, body, box)

    def node(self, x: float, y: float) -> str:
        """A point where lines meet, as a port; it becomes a dot where there are three or more."""
        name = f"node{sum(one.startswith('node') for one in self.symbols) + 1}"
        self.place(name, "", {"": (x, y)}, box=(x, y, x, y))
        return f"{name}."

    def at(self, port: str) -> Point:
        """Where a port is."""
        name, _, end = port.rpartition(".")
        return self.symbols[name].ports[end]

    def join(self, kind: Kind, pressure: str, start: str, end: str, *via: Point) -> None:
        """Draw a line from a port over some points to another port."""
        self.lines.append(Line(kind, pressure, start, end, [self.at(start), *via, self.at(end)]))

    def work(self, pressure: str, *ports: str) -> None:
        """Working lines from each port to the next, with a corner where the way is not straight."""
        for start, end in pairwise(ports):
            (x, _), (_, y) = self.at(start), self.at(end)
            straight = (x, y) in (self.at(start), self.at(end))
            self.join("work", pressure, start, end, *(() if straight else ((x, y),)))

    def write(self, x: float, y: float, signal: str = "", text: str = "", anchor: str = "start") -> None:
        """A number beside its place: a run's signal, or a constant that is written already."""
        live = f' data-signal="{signal}"' if signal else ""
        self.values.append(
            f'<text class="value" x="{n(x)}" y="{n(y)}" text-anchor="{anchor}"{live}>{escape(text)}</text>'
        )

    def svg(self) -> str:
        """All of it as SVG, in the colour of the text around it."""
        left, top, right, bottom = self.extent()
        size = f"{n(left)} {n(top)} {n(right - left)} {n(bottom - top)}"
        pressures = " ".join(f"{key}={value}" for key, value in self.pressures.items())
        return "\n".join(
            [
                f'<svg xmlns="http://www.w3.org/2000/svg" class="hs-circuit" viewBox="{size}" '
                f'width="{n(right - left)}" height="{n(bottom - top)}" role="group" '
                f'aria-label="Hydraulic circuit" fill="none" stroke="currentColor" stroke-width="1.5" '
                f'stroke-linejoin="round" data-pressures="{pressures}">',
                *map(line_svg, self.lines),
                *map(symbol_svg, self.symbols.values()),
                *self.dots(),
                f'<g stroke="none" fill="currentColor" font-family="sans-serif" font-size="{LETTER}">',
                *self.values,
                "</g>",
                "</svg>\n",
            ]
        )

    def extent(self) -> Box:
        """What is around all there is."""
        points = [point for line in self.lines for point in line.points]
        boxes = [one.box for one in self.symbols.values()] + [(x, y, x, y) for x, y in points]
        left, top, right, bottom = zip(*boxes, strict=True)
        return min(left) - MARGIN, min(top) - MARGIN, max(right) + MARGIN, max(bottom) + MARGIN

    def dots(self) -> Iterable[str]:
        """A dot at each node where three lines or more meet."""
        ends = [end for line in self.lines for end in (line.start, line.end)]
        for one in self.symbols.values():
            if ends.count(f"{one.name}.") > 2:
                x, y = one.ports[""]
                yield f'<circle cx="{n(x)}" cy="{n(y)}" r="{n(DOT)}" fill="currentColor" stroke="none"/>'


def line_svg(line: Line) -> str:
    """A line as SVG: working lines are solid, pilot lines dashed, signal lines dotted."""
    port = f' data-port="{line.pressure}"' if line.pressure else ""
    dash = DASHES.get(line.kind)
    look = f' stroke-dasharray="{dash}"' if dash else ""
    points = " ".join(f"{n(x)},{n(y)}" for x, y in line.points)
    ends = f'data-from="{line.start}" data-to="{line.end}"'
    drawn = f'<g class="{line.kind}"><polyline points="{points}"{port}{look} {ends}/>'
    start, tip = line.points[-2:]
    tipped = line.kind == "signal" and not line.end.endswith(".")
    return f"{drawn}{head(start, tip) if tipped else ''}</g>"


def symbol_svg(symbol: Symbol) -> str:
    """A symbol as SVG: a group that says for which block it stands."""
    if not symbol.body:
        return ""
    path = f' data-part="{symbol.path}"' if symbol.path else ""
    left, top, right, bottom = symbol.box
    at = f'x="{n(left)}" y="{n(top)}" width="{n(right - left)}" height="{n(bottom - top)}"'
    target = f'<rect {at} stroke="none" pointer-events="all"/>' if symbol.path and symbol.ports else ""
    title = f"<title>{escape(symbol.title)}</title>" if symbol.title else ""
    return f'<g data-symbol="{symbol.name}"{path}>{title}{target}{symbol.body}</g>'


def head(start: Point, tip: Point, size: float = 7.0) -> str:
    """The solid head of an arrow."""
    (x0, y0), (x1, y1) = start, tip
    length = math.hypot(x1 - x0, y1 - y0)
    dx, dy = size * (x1 - x0) / length, size * (y1 - y0) / length
    left, right = (x1 - dx - 0.36 * dy, y1 - dy + 0.36 * dx), (x1 - dx + 0.36 * dy, y1 - dy - 0.36 * dx)
    points = " ".join(f"{n(x)},{n(y)}" for x, y in (tip, left, right))
    return f'<polygon points="{points}" fill="currentColor" stroke="none"/>'


def n(value: float) -> str:
    """A coordinate as text, the same everywhere."""
    return f"{round(value, 2) + 0.0:g}"  # never -0


def moved(
    body: str,
    how: str,
    path: str,
    ends: tuple[float, float, float, float],
    now: float,
    at: Point = (0.0, 0.0),
) -> str:
    """A part that follows a signal of a run; before there is one it stands where the loop begins.

    Args:
        body: as SVG.
        how: "slide" along x, "switch" there and back beyond two values, "turn" about a point, or "stretch"
            along x from one.
        path: of the signal.
        ends: two values of the signal, and what the part does at these [px, degrees, times]; in between in
            proportion.
        now: the signal's value at the start.
        at: the point.
    """
    low, high, start, end = ends
    share = min(max((now - low) / (high - low), 0.0), 1.0) if high > low else 0.5
    numbers = f"{low:.12g} {high:.12g} {start:.6g} {end:.6g}"
    place = f'data-{how}="{path}" data-ends="{numbers}" data-at="{n(at[0])} {n(at[1])}"'
    return f'<g {place} transform="{transform(how, start + (end - start) * share, at)}">{body}</g>'


def transform(how: str, value: float, at: Point) -> str:
    """What moves a part, as SVG has it."""
    x, y = at
    if how == "turn":
        return f"rotate({n(value)} {n(x)} {n(y)})"
    if how == "stretch":
        return f"translate({n(x)} 0) scale({round(value, 4):g} 1) translate({n(-x)} 0)"
    return f"translate({n(value)} 0)"
