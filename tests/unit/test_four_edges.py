"""Four metering edges at points where the answer is plain; what holds everywhere is in the properties."""

import math

import pytest
from scipy.optimize import brentq

from hydroservo import ParameterError
from hydroservo.core.signals import Pressures
from hydroservo.machine.valves import FourEdges, Orifice
from hydroservo.testing.examples import example
from tests.support.equality import assert_same_block

LITRE_PER_MINUTE = 1e-3 / 60.0
IDEAL = example(FourEdges, lap=0.0, clearance=0.0, transition_drop=0.0)
SERVO = {"rated_flow": 40.0 * LITRE_PER_MINUTE, "rated_drop": 70e5, "rated_opening": 5e-4}
PROPORTIONAL = {"rated_flow": 100.0 * LITRE_PER_MINUTE, "rated_drop": 10e5, "rated_opening": 3e-3}


def null_leakage(edges: FourEdges, supply: float) -> float:
    """With A and B blocked, where symmetric edges leave half the supply's pressure in both."""
    flows = edges.port_flows(0.0, Pressures(supply, 0.0), 0.5 * supply, 0.5 * supply)
    assert flows.a == flows.b == 0.0
    return flows.supply


@pytest.mark.parametrize("opening", [-5e-3, -1e-5, 0.0, 2e-6, 3e-3])
@pytest.mark.parametrize("load", [-39e5, -1e5, 0.0, 2e5, 40e5])
def test_ideal_edges_are_the_square_root_law(opening: float, load: float) -> None:
    assert IDEAL.flow(opening, 40e5, load) == pytest.approx(
        example(Orifice).flow(opening, 40e5, load), rel=1e-14
    )
    line, ports = Pressures(41e5, 2e5), (21.5e5 + 0.5 * load, 21.5e5 - 0.5 * load)
    wanted = example(Orifice).port_flows(opening, line, *ports)
    assert IDEAL.port_flows(opening, line, *ports) == pytest.approx(wanted, rel=1e-14)


def test_the_defaults_are_the_paper_s_size() -> None:
    assert_same_block(example(FourEdges).simplified(), example(Orifice))
    assert example(FourEdges).lap == 0.0


def test_no_drop_no_flow() -> None:
    for edges in (IDEAL, example(FourEdges)):
        assert edges.port_flows(1e-3, Pressures(3e5, 3e5), 3e5, 3e5) == (0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("datasheet", [SERVO, PROPORTIONAL], ids=["servo", "proportional"])
@pytest.mark.parametrize("lap", [-2e-5, 0.0, 1e-4])
@pytest.mark.parametrize("leakage", [0.3, 1.0])
def test_a_datasheet_s_rated_flow_and_null_leakage_come_out(
    datasheet: dict[str, float], lap: float, leakage: float
) -> None:
    leaked = leakage * LITRE_PER_MINUTE
    if lap < 0.0:
        leaked += null_leakage(FourEdges.rated(**datasheet)._replace(lap=lap), 140e5)
    edges = FourEdges.rated(**datasheet, lap=lap, null_leakage=leaked, supply_pressure=140e5)
    flow = edges.flow(datasheet["rated_opening"], datasheet["rated_drop"], 0.0)
    assert flow == pytest.approx(datasheet["rated_flow"], rel=1e-14)
    assert null_leakage(edges, 140e5) == pytest.approx(leaked, rel=1e-10)
    through_a = edges.port_flows(
        datasheet["rated_opening"],
        Pressures(datasheet["rated_drop"], 0.0),
        0.5 * datasheet["rated_drop"],
        0.5 * datasheet["rated_drop"],
    ).a
    assert through_a == pytest.approx(datasheet["rated_flow"], rel=1e-14)


@pytest.mark.parametrize("datasheet", [SERVO, PROPORTIONAL], ids=["servo", "proportional"])
def test_the_square_root_law_passes_its_rated_flow(datasheet: dict[str, float]) -> None:
    edges = Orifice.rated(**datasheet)
    flow = edges.flow(datasheet["rated_opening"], datasheet["rated_drop"], 0.0)
    assert flow == pytest.approx(datasheet["rated_flow"], rel=1e-15)
    area = edges.area_gradient * datasheet["rated_opening"]
    through_one_edge = 0.62 * area * math.sqrt(2.0 * 0.5 * datasheet["rated_drop"] / 850.0)
    assert through_one_edge == pytest.approx(datasheet["rated_flow"], rel=1e-14)


def test_leakage_of_the_edges_of_a_single_rod() -> None:
    edges = FourEdges.rated(**SERVO, null_leakage=1e-5, supply_pressure=210e5, area_ratio_b=0.5)
    assert null_leakage(edges, 210e5) == pytest.approx(1e-5, rel=1e-10)


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        ({"lap": 5e-4}, "rated_opening"),
        ({"lap": -1e-4, "null_leakage": 1e-7, "supply_pressure": 140e5}, "null_leakage"),
        ({"null_leakage": 1.0, "supply_pressure": 140e5}, "null_leakage"),
        ({"null_leakage": SERVO["rated_flow"], "supply_pressure": 140e5}, "null_leakage"),
        ({"null_leakage": 1e-6}, "supply_pressure"),
    ],
)
def test_a_datasheet_that_no_edges_have(arguments: dict[str, float], key: str) -> None:
    with pytest.raises(ParameterError, match=f"{key} = "):
        FourEdges.rated(**SERVO, **arguments)


@pytest.mark.parametrize("lap", [5e-5, 2e-4])
def test_overlap_is_half_the_dead_band(lap: float) -> None:
    """Within it an edge without clearance passes nothing, beyond it what a shorter opening would."""
    edges = IDEAL._replace(lap=lap)
    for side in (-1.0, 1.0):
        assert edges.flow(side * 0.999 * lap, 40e5, 0.0) == 0.0
        beyond = edges.flow(side * (lap + 1e-4), 40e5, 5e5)
        assert beyond == pytest.approx(IDEAL.flow(side * 1e-4, 40e5, 5e5), rel=1e-11)


def test_a_small_drop_is_laminar() -> None:
    """Half the drop, half the flow; and the slope at no drop is K/sqrt(d_t)."""
    edges = example(FourEdges, clearance=0.0, transition_drop=2e5)
    line = Pressures(1e3, 0.0)
    whole = edges.port_flows(1e-3, line, 0.0, 0.0).a
    assert edges.port_flows(1e-3, line, 500.0, 0.0).a == pytest.approx(0.5 * whole, rel=1e-5)
    slope = 0.62 * 0.024 * 1e-3 * math.sqrt(2.0 / 850.0) / math.sqrt(2e5)
    assert whole / 1e3 == pytest.approx(slope, rel=1e-5)


def test_a_large_drop_is_turbulent() -> None:
    smooth, sharp = example(FourEdges, clearance=0.0), IDEAL
    ratio = smooth.flow(1e-3, 100e5, 0.0) / sharp.flow(1e-3, 100e5, 0.0)
    assert 1.0 - 0.26 * (1.0 / 50.0) ** 2 < ratio < 1.0


def test_port_b_may_have_smaller_edges() -> None:
    full, half = example(FourEdges), example(FourEdges, area_ratio_b=0.5)
    ports = Pressures(40e5, 2e5), 20e5, 10e5
    assert half.port_flows(1e-3, *ports).a == full.port_flows(1e-3, *ports).a
    assert half.port_flows(1e-3, *ports).b == pytest.approx(0.5 * full.port_flows(1e-3, *ports).b, rel=1e-15)


@pytest.mark.parametrize("opening", [-1e-3, 1e-3])
def test_each_edge_lets_oil_back(opening: float) -> None:
    flows = example(FourEdges, clearance=0.0).port_flows(opening, Pressures(40e5, 2e5), 60e5, 1e5)
    assert (flows.a < 0.0) == (opening > 0.0 or flows.tank > 0.0)
    assert (flows.supply < 0.0) == (opening > 0.0)
    assert (flows.tank < 0.0) == (opening > 0.0)


LAPS = {"extra_lap_pa": 2e-5, "extra_lap_at": -3e-5, "extra_lap_pb": 4e-5, "extra_lap_bt": 7e-5}


@pytest.mark.parametrize("opening", [-2e-4, -5e-5, 0.0, 1e-5, 8e-5, 3e-4])
def test_each_edge_may_have_a_lap_of_its_own(opening: float) -> None:
    """The flows are those of four single edges, each of edges that all have its lap."""
    edges = example(FourEdges, lap=1e-5, clearance=2e-6, area_ratio_b=0.7)
    line, a, b = Pressures(80e5, 3e5), 30e5, 45e5
    found = edges._replace(**LAPS).port_flows(opening, line, a, b)

    def single(name: str, up: float, down: float, side: float) -> float:
        e = edges._replace(lap=1e-5 + LAPS[name]).uncovered(side * opening)
        return edges.conductance() * e * edges.root(up - down)

    pa, at = single("extra_lap_pa", line.supply, a, 1.0), single("extra_lap_at", a, line.tank, -1.0)
    pb, bt = single("extra_lap_pb", line.supply, b, -1.0), single("extra_lap_bt", b, line.tank, 1.0)
    assert found == pytest.approx((pa - at, 0.7 * (bt - pb), pa + 0.7 * pb, at + 0.7 * bt), rel=1e-13)


def test_edges_of_several_laps_pass_their_rated_flow_and_leakage() -> None:
    """Out of blocked ports nothing flows, at pressures that are no half of the supply's."""
    leaked = 0.4 * LITRE_PER_MINUTE
    edges = FourEdges.rated(**SERVO, **LAPS, null_leakage=leaked, supply_pressure=140e5, area_ratio_b=0.5)
    assert edges.flow(5e-4, 70e5, 0.0) == pytest.approx(SERVO["rated_flow"], rel=1e-14)
    line = Pressures(140e5, 0.0)
    a = brentq(lambda p: edges.port_flows(0.0, line, p, p).a, 0.0, 140e5, xtol=1e-6)
    b = brentq(lambda p: edges.port_flows(0.0, line, p, p).b, 0.0, 140e5, xtol=1e-6)
    assert abs(a - 70e5) > 5e5
    assert edges.port_flows(0.0, line, a, b).supply == pytest.approx(leaked, rel=1e-9)
    with pytest.raises(ParameterError, match=r"rated_opening = .* lap of the edge P-A, 0.0006 \[m\]"):
        FourEdges.rated(**SERVO, lap=1e-4, extra_lap_pa=5e-4)


@pytest.mark.parametrize("edges", [Orifice, FourEdges])
def test_a_valve_rated_with_heavier_oil_passes_more_of_a_lighter_one(edges: type) -> None:
    usual = edges.rated(**SERVO, density=850.0)
    assert edges.rated(**SERVO, density=850.0, rated_density=850.0) == usual
    rated = edges.rated(**SERVO, density=833.0, rated_density=868.0)
    assert rated.density == 833.0
    assert rated._replace(density=868.0).flow(5e-4, 70e5, 0.0) == pytest.approx(
        SERVO["rated_flow"], rel=1e-14
    )
    ratio = rated.flow(5e-4, 70e5, 0.0) / SERVO["rated_flow"]
    assert ratio == pytest.approx(math.sqrt(868.0 / 833.0), rel=1e-14)
