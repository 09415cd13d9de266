"""The circuit of a loop: lines end at symbols, whatever blocks it has, and its text is well formed."""

from collections import Counter
from itertools import combinations, pairwise
from typing import NamedTuple
from xml.etree import ElementTree

import pytest

import hydroservo as hs
from hydroservo.core.block import Block, paths
from hydroservo.core.hooks import drives_in
from hydroservo.figures.circuit import sheet_of
from hydroservo.figures.circuit.cylinder import rods
from hydroservo.machine.drives import (
    CheckValve,
    Counterbalance,
    Hoses,
    Lines,
    LoadSensing,
    PortValves,
    PressureCompensator,
    ValveOnSupply,
)
from hydroservo.machine.supplies import ReliefValve

AXIS = hs.load_scenario("axis/position")
CRANE = hs.load_scenario("axis/crane")
PUMP = hs.load_scenario("axis/pump-controlled")
CHECK, RELIEF, OIL, VALVE = CheckValve(2e4, 1e-9), ReliefValve(2e7, 1e-10), AXIS.plant.oil, ValveOnSupply()


def counterbalance(drive: Block = VALVE, in_line_b: bool = False) -> Counterbalance:
    return Counterbalance(3.0, 2e7, 1e6, 1e-3, 1e6, CHECK, 1e-4, OIL, drive, in_line_b)


def hoses(drive: Block = VALVE) -> Hoses:
    return Hoses.from_dimensions(2.0, 0.012, 46e-6, OIL, drive=drive)


class Ejector(NamedTuple):
    """A drive of a plug-in, before another one."""

    drive: Block = VALVE


class Muscle(NamedTuple):
    """One that ends a chain."""

    strength: float = 1.0


class Winch(NamedTuple):
    """One that stands in the valve's place."""

    valveless = True


class Cow(NamedTuple):
    """A mechanism of a plug-in."""

    legs: int = 4


class Well(NamedTuple):
    """A supply of one."""

    depth: float = 1.0


OWN = {Ejector, Muscle, Winch}
DRIVES = {
    "hoses": hoses(),
    "lines": Lines(1e-4, 1e6, 1e9, OIL),
    "port valves": PortValves(RELIEF, CHECK),
    "port valves behind hoses": hoses(PortValves(RELIEF, CHECK)),
    "counterbalance": counterbalance(),
    "two counterbalance valves": counterbalance(counterbalance(hoses(), True)),
    "compensator": PressureCompensator(1e6),
    "load sensing": LoadSensing(2e6, 0.05),
    "both": LoadSensing(2e6, 0.05, PressureCompensator(1e6)),
    "hoses behind both": LoadSensing(2e6, 0.05, PressureCompensator(1e6, PortValves(RELIEF, CHECK, hoses()))),
    "plug-in": Ejector(),
    "plug-in at the end": hoses(Muscle()),
}
LOOPS = {
    **{f"axis: {name}": AXIS._replace(drive=drive) for name, drive in DRIVES.items()},
    **{f"crane: {name}": CRANE._replace(drive=drive) for name, drive in DRIVES.items()},
    "two pumps": PUMP._replace(drive=PUMP.drive._replace(displacement_ratio=0.5)),
    "no pilots": PUMP._replace(drive=PUMP.drive._replace(check_valve=CHECK)),
    "case drain": PUMP._replace(drive=PUMP.drive._replace(case_leakage=1e-12)),
    "pump in hoses": PUMP._replace(drive=hoses(PUMP.drive)),
    "a drive in the valve's place": PUMP._replace(drive=Winch()),
    "a mechanism": AXIS._replace(plant=AXIS.plant._replace(mechanism=Cow())),
    "a supply": AXIS._replace(drive=Muscle(), supply=Well()),
    "a body on a cart": AXIS._replace(plant=AXIS.plant._replace(carried=CRANE.plant.carried)),
}


def loop_of(name: str) -> Block:
    return LOOPS[name] if name in LOOPS else hs.load_scenario(name)


@pytest.mark.parametrize("name", [*hs.scenarios(), *LOOPS])
def test_every_line_ends_at_a_port_and_every_port_has_a_line(name):
    sheet = sheet_of(loop_of(name))
    ends = Counter(end for line in sheet.lines for end in (line.start, line.end))
    ports = {f"{symbol.name}.{port}" for symbol in sheet.symbols.values() for port in symbol.ports}
    assert set(ends) == ports
    assert [end for end, lines in ends.items() if end.endswith(".") and lines < 2] == []
    for line in sheet.lines:
        assert (line.points[0], line.points[-1]) == (sheet.at(line.start), sheet.at(line.end))
        assert all(x0 == x1 or y0 == y1 for (x0, y0), (x1, y1) in pairwise(line.points)), line


@pytest.mark.parametrize("name", [*hs.scenarios(), *LOOPS])
def test_oil_reaches_the_cylinder_from_a_source(name):
    lines = [line for line in sheet_of(loop_of(name)).lines if line.kind == "work"]
    joined = [{end.rpartition(".")[0] for end in (line.start, line.end)} for line in lines]
    reached, found = {"cylinder"}, True
    while found:
        found = {name for names in joined if names & reached for name in names} - reached
        reached |= found
    assert reached & {"source", "pump", "accumulator"}


@pytest.mark.parametrize("name", [*hs.scenarios(), *LOOPS])
def test_no_line_runs_on_top_of_another(name):
    lines = sheet_of(loop_of(name)).lines
    runs = [run for line in lines for run in pairwise(line.points) if run[0] != run[1]]
    for one, other in combinations(runs, 2):
        assert overlap(one, other) == 0.0, (one, other)


def overlap(one, other):
    """The length that two level or plumb stretches have in common."""
    for along in (0, 1):
        across = 1 - along
        if len({end[across] for end in (*one, *other)}) == 1:
            low = max(min(end[along] for end in run) for run in (one, other))
            high = min(max(end[along] for end in run) for run in (one, other))
            return max(high - low, 0.0)
    return 0.0


def test_it_is_the_same_text_each_time_and_well_formed() -> None:
    for name in ("axis/crane", "axis/pump-controlled", "axis/press"):
        text = hs.circuit(loop_of(name))
        assert text == hs.circuit(loop_of(name))
        assert text._repr_html_() == text
        root = ElementTree.fromstring(text)
        assert root.get("class") == "hs-circuit"
        assert "<style" not in text
        assert " style=" not in text  # the page of the app allows none


def test_names_of_plug_ins_are_escaped() -> None:
    odd = type("A<B", (Muscle,), {})()
    assert "A&lt;B" in hs.circuit(AXIS._replace(drive=odd))
    ElementTree.fromstring(hs.circuit(AXIS._replace(drive=odd)))


def test_rods_are_as_thick_as_the_areas_say() -> None:
    left, right = rods(AXIS.plant)
    assert left == 0.0
    assert 1.0 - right**2 == pytest.approx(AXIS.plant.area_b / AXIS.plant.area_a)
    both = AXIS.plant._replace(area_a=AXIS.plant.area_b, area_b=AXIS.plant.area_a)
    left, right = rods(both)
    assert (1.0 - left**2) / (1.0 - right**2) == pytest.approx(both.area_a / both.area_b)


@pytest.mark.parametrize(("name", "title"), [("axis/position", "Proportional"), ("axis/press", "Servo")])
def test_overlap_tells_proportional_from_servo_valves(name, title):
    symbol = sheet_of(loop_of(name)).symbols["valve"]
    assert symbol.title.startswith(title)
    assert {"A", "B", "P", "T"} <= set(symbol.ports)
    for letter in "ABPT":
        assert f">{letter}</text>" in symbol.body


def test_sensors_are_tied_to_what_they_measure() -> None:
    known = {
        "axis/position": {"position"},
        "axis/press": {"position", "load cell"},
        "axis/position-lq": {"position", "pressure A", "pressure B"},
    }
    for name, sensors in known.items():
        sheet = sheet_of(loop_of(name))
        tied = {line.start.removesuffix(".out") for line in sheet.lines if line.end.startswith("controller.")}
        assert tied - {"reference"} == sensors


def test_each_part_leads_to_a_block_of_the_loop() -> None:
    for name in hs.scenarios():
        loop = loop_of(name)
        for symbol in sheet_of(loop).symbols.values():
            at = loop
            for step in filter(None, symbol.path.split(".")):
                at = getattr(at, step)


def test_what_moves_follows_signals_that_a_run_has() -> None:
    for name in ("axis/crane", "axis/pump-controlled", "paper/sine-pi"):
        loop = loop_of(name)
        recorded = set(paths(loop.init()))
        for one in ElementTree.fromstring(hs.circuit(loop)).iter():
            moving = {one.get(f"data-{how}") for how in ("slide", "switch", "turn", "stretch")}
            assert moving - {None} <= recorded, name


@pytest.mark.parametrize(
    "name", [name for name in LOOPS if not OWN & {type(one) for one in drives_in(LOOPS[name].drive)}]
)
def test_each_pressure_is_a_signal_or_a_constant(name):
    loop = LOOPS[name]
    nodes = dict(
        one.split("=") for one in ElementTree.fromstring(hs.circuit(loop)).get("data-pressures").split()
    )
    recorded = {path for path in paths(loop.init()) if "pressure" in path}
    signals = {
        node for node, source in nodes.items() if not source.replace(".", "").replace("e", "").isdigit()
    }
    assert {nodes[node] for node in signals} <= recorded
    assert {"pA", "pB", "pP", "pT"} <= set(nodes)
