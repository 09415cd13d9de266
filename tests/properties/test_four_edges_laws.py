"""What four metering edges must do, whatever their lap, clearance and size."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo.core.signals import PortFlows, Pressures
from hydroservo.machine.valves import CurvedEdges, FourCurves, FourEdges, StraightEdges
from hydroservo.testing.examples import example

openings = st.one_of(st.just(0.0), st.floats(1e-9, 5e-3), st.floats(-5e-3, -1e-9))
pressures = st.floats(-1e5, 5e7)
lines = st.builds(Pressures, supply=pressures, tank=st.floats(-1e5, 1e6))
edges_of_any_lap = st.builds(
    lambda lap, clearance, drop: example(FourEdges, lap=lap, clearance=clearance, transition_drop=drop),
    st.one_of(st.just(0.0), st.floats(1e-9, 1e-3), st.floats(-1e-3, -1e-9)),
    st.one_of(st.just(0.0), st.floats(1e-7, 1e-4)),
    st.one_of(st.just(0.0), st.floats(1e2, 1e6)),
)
edges_of_any_kind = st.builds(
    lambda edges, shape, regeneration: edges._replace(shape=shape, regeneration=regeneration),
    edges_of_any_lap,
    st.sampled_from([StraightEdges(), example(CurvedEdges), example(FourCurves)]),
    st.booleans(),
)
ratios = st.floats(0.2, 1.0)


@given(edges=edges_of_any_kind, ratio=ratios, opening=openings, line=lines, a=pressures, b=pressures)
def test_what_flows_in_flows_out(
    edges: FourEdges, ratio: float, opening: float, line: Pressures, a: float, b: float
) -> None:
    flows = edges._replace(area_ratio_b=ratio).port_flows(opening, line, a, b)
    largest = max(map(abs, flows))
    assert flows.supply + flows.b == pytest.approx(flows.a + flows.tank, rel=1e-12, abs=1e-12 * largest)


@given(edges=edges_of_any_lap, opening=openings, line=lines, a=pressures, b=pressures)
def test_port_flows_are_odd(edges: FourEdges, opening: float, line: Pressures, a: float, b: float) -> None:
    """Spool reversed and ports exchanged, the cylinder's flows are exchanged and reversed."""
    ahead, back = edges.port_flows(opening, line, a, b), edges.port_flows(-opening, line, b, a)
    assert back == PortFlows(-ahead.b, -ahead.a, ahead.supply, ahead.tank)


@given(edges=edges_of_any_lap, opening=openings, supply=st.floats(0.0, 5e7), load=pressures)
def test_load_flow_is_odd(edges: FourEdges, opening: float, supply: float, load: float) -> None:
    assert edges.flow(-opening, supply, -load) == -edges.flow(opening, supply, load)


@given(edges=edges_of_any_lap, opening=openings, line=lines, share=st.floats(-1.0, 1.0))
def test_the_load_flow_is_that_of_both_ports(
    edges: FourEdges, opening: float, line: Pressures, share: float
) -> None:
    drop = line.supply - line.tank
    mean, load = 0.5 * (line.supply + line.tank), share * drop
    flows = edges.port_flows(opening, line, mean + 0.5 * load, mean - 0.5 * load)
    flow = edges.flow(opening, drop, load)
    rounding = 1e-6 * edges.flow(5e-3, 5e7, 0.0) if edges.transition_drop == 0.0 else 1e-14
    near = pytest.approx(flow, rel=1e-7, abs=rounding)
    assert (flows.a, flows.b) == (near, near)


@given(
    edges=edges_of_any_lap,
    pair=st.tuples(openings, openings).map(sorted),
    supply=st.floats(0.0, 5e7),
    share=st.floats(-1.0, 1.0),
)
def test_flow_rises_with_the_opening(
    edges: FourEdges, pair: list[float], supply: float, share: float
) -> None:
    low, high = (edges.flow(opening, supply, share * supply) for opening in pair)
    assert low <= high + 1e-12 * abs(high)


@given(
    edges=edges_of_any_lap,
    opening=openings,
    supply=st.floats(0.0, 5e7),
    pair=st.tuples(pressures, pressures).map(sorted),
)
def test_flow_falls_with_the_load(edges: FourEdges, opening: float, supply: float, pair: list[float]) -> None:
    high, low = (edges.flow(opening, supply, load) for load in pair)
    assert low <= high + 1e-12 * abs(high)


@given(edges=edges_of_any_kind, opening=openings, line=lines, a=pressures, b=pressures)
def test_edges_create_no_power(edges: FourEdges, opening: float, line: Pressures, a: float, b: float) -> None:
    """Each edge passes oil down its own drop only, so what enters carries at least what leaves."""
    flows = edges.port_flows(opening, line, a, b)
    terms = (flows.supply * line.supply, flows.b * b, -flows.a * a, -flows.tank * line.tank)
    assert sum(terms) >= -1e-12 * max(map(abs, terms)) - 1e-100  # the square of a tiny opening is 0
