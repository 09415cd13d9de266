"""Oil with mass in long lines, against a model written apart and the peak of a valve that shuts."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hydroservo import Loop, ParameterError, replace, simulate
from hydroservo.core.block import value_at, values
from hydroservo.core.hooks import resting
from hydroservo.core.signals import Feed, Pressures
from hydroservo.core.states import filled
from hydroservo.machine.drives import Lines
from hydroservo.machine.oils import AeratedOil, ConstantOil
from hydroservo.machine.plants import Cylinder, LoadPressurePlant
from hydroservo.machine.valves import NoEdges
from hydroservo.runs.cautions.loop import mismatch_cautions
from hydroservo.runs.run import complete_loop
from hydroservo.testing.examples import example
from tests.support.axes import commanded_axis, step, viscous

LENGTH, BORE, VISCOSITY, BULK, DENSITY = 30.0, 12e-3, 32e-6, 1.2e9, 850.0
PIPE = math.pi / 4.0 * BORE**2
SOUND = math.sqrt(BULK / DENSITY)
PISTON, MASS, DAMPING, STROKE, SUPPLY = math.pi / 4.0 * (0.05**2 - 0.028**2), 50.0, 500.0, 0.5, 200e5
DEAD = 2e-5  # as Cylinder.from_diameters has it
VALVE_RATE, DAMPING_RATIO, TRANSITION = 2.0 * math.pi * 150.0, math.sqrt(0.5), 1e5
EDGE = 30e-3 / 60.0 / 1e-3 / (35e5 / (35e5**2 + TRANSITION**2) ** 0.25)
CELLS = 5
AXIS = {
    "simulation": {"duration": "0.5 s", "period": "0.2 ms", "record_period": "0.2 ms", "substeps": "auto"},
    "reference": step("10 V", "0 V", "0.4 s"),
    "supply.supply_pressure": "200 bar",
    "plant.bore": "50 mm",
    "plant.rod": "28 mm",
    "plant.rods": 2,
    "plant.stroke": "500 mm",
    "plant.start_position": "50 mm",
    "plant.mechanism.mass": "50 kg",
    "plant.friction": viscous("500 N s/m"),
    "valve.type": "SecondOrderValve.from_response",
    "valve.frequency_90": "150 Hz",
    "valve.frequency_3db": "150 Hz",
    "valve.orifice.rated_flow": "30 L/min",
}
PIPES = {
    "length": "30 m",
    "inner_diameter": "12 mm",
    "kinematic_viscosity": "32 mm^2/s",
    "oil": {"type": "ConstantOil", "effective_bulk_modulus": "12000 bar"},
}
LINES = {"type": "Lines.from_dimensions", "highest_frequency": "15 Hz", **PIPES}
HOSES = {"type": "Hoses.from_dimensions", **PIPES}


def edge(opening: float, drop: float) -> float:
    return EDGE * max(opening, 0.0) * drop / (drop**2 + TRANSITION**2) ** 0.25


def rates(_: float, y: np.ndarray, command: float) -> np.ndarray:
    """Of the axis with CELLS cells of compliance, inertance and laminar loss in each line."""
    compliance, inertance = PIPE * LENGTH / CELLS / BULK, DENSITY * LENGTH / PIPE / CELLS
    resistance = 128.0 * VISCOSITY * DENSITY * LENGTH / (math.pi * BORE**4) / CELLS
    x, v, a, b, spool, speed = y[:6]
    opening = min(max(spool, -1e-3), 1e-3)
    pressures_a, flows_a, pressures_b, flows_b = np.split(y[6:], 4)
    fed_a = edge(opening, SUPPLY - pressures_a[0]) - edge(-opening, pressures_a[0])
    fed_b = edge(opening, pressures_b[0]) - edge(-opening, SUPPLY - pressures_b[0])
    into, out = np.append(fed_a, flows_a), np.append(fed_b, flows_b)
    return np.concatenate(
        [
            [v, (PISTON * (a - b) - DAMPING * v) / MASS],
            [BULK / (DEAD + PISTON * x) * (flows_a[-1] - PISTON * v)],
            [BULK / (DEAD + PISTON * (STROKE - x)) * (PISTON * v - flows_b[-1])],
            [speed, VALVE_RATE**2 * (1e-4 * command - spool) - 2.0 * DAMPING_RATIO * VALVE_RATE * speed],
            (into[:-1] - into[1:]) / compliance,
            (pressures_a - np.append(pressures_a[1:], a) - resistance * flows_a) / inertance,
            (out[1:] - out[:-1]) / compliance,
            (np.append(pressures_b[1:], b) - pressures_b - resistance * flows_b) / inertance,
        ]
    )


def end(path: str, first: int) -> tuple[str, int]:
    """The cell at the valve: its path, and where its numbers begin in the rows of the model above."""
    return "drive" + ".drive" * (CELLS - 1) + f".{path}", 6 + first * CELLS


def test_a_valve_that_shuts_sends_the_waves_of_a_model_written_apart() -> None:
    start = np.concatenate([[0.05, 0.0, 1e7, 1e7, 0.0, 0.0], *([np.full(CELLS, 1e7), np.zeros(CELLS)] * 2)])
    how = {"method": "LSODA", "rtol": 1e-8, "atol": 1e-9}
    opened = solve_ivp(rates, (0.0, 0.4), start, args=(10.0,), max_step=1e-3, **how).y[:, -1]
    instants = np.linspace(0.4, 0.5, 501)
    shut = solve_ivp(rates, (0.4, 0.5), opened, t_eval=instants, args=(0.0,), max_step=1e-3, **how).y
    run = simulate(commanded_axis(AXIS | {"drive": LINES})).sel(time=instants, method="nearest")
    pairs = [end("pressure_a", 0), end("flow_a", 1), end("pressure_b", 2), end("flow_b", 3)]
    for path, row in [("plant.pressure_a", 2), ("plant.pressure_b", 3), ("plant.velocity", 1), *pairs]:
        size = np.abs(shut[row]).max()
        np.testing.assert_allclose(run[path], shut[row], rtol=0.0, atol=1e-4 * size, err_msg=path)
    peak = float(run[pairs[0][0]].max())
    assert peak > 150e5  # without the oil's mass it is 114 bar


def test_oil_that_is_stopped_at_once_falls_and_rises_by_joukowsky() -> None:
    """rho c v over the way of the wave to the cylinder and back, but for the ring of the cells."""
    speed, held = 5.0, 200e5
    lines = Lines.from_dimensions(LENGTH, BORE, 1e-12, ConstantOil(BULK), highest_frequency=60.0)
    rest = resting(example(Loop, plant=example(Cylinder), drive=lines)).drive
    flows = {"flow_a": PIPE * speed, "flow_b": PIPE * speed}
    state, path = rest.init(), ""
    while hasattr(value_at(state, path) if path else state, "flow_a"):
        prefix = f"{path}." if path else ""
        state = replace(state, {f"{prefix}{name}": flow for name, flow in flows.items()})
        state = replace(state, {f"{prefix}pressure_a": held, f"{prefix}pressure_b": held})
        path = f"{prefix}drive"
    shut = Feed(0.0, NoEdges(), 0.0, Pressures(held, 0.0))

    def rates(_: float, numbers: np.ndarray) -> list[float]:
        return values(rest.deriv(filled(state, iter(numbers.tolist())), shut, held, held))

    back = 2.0 * LENGTH / SOUND
    found = solve_ivp(rates, (0.0, 0.9 * back), values(state), rtol=1e-7, atol=1e-9, max_step=1e-4)
    last = path.rpartition(".")[0].count("drive") * 4
    plateau = found.y[:, found.t > 0.3 * back]
    rise = DENSITY * SOUND * speed
    assert held - plateau[last].mean() == pytest.approx(rise, rel=0.02)
    assert plateau[last + 1].mean() - held == pytest.approx(rise, rel=0.02)


def test_steady_flow_meets_hagen_and_poiseuille() -> None:
    lines = Lines.from_dimensions(3.0, 0.0127, 46e-6, ConstantOil(1e9), highest_frequency=1e3)
    count, cell = 0, lines
    while isinstance(cell, Lines):
        count, cell = count + 1, cell.drive
    assert count == math.ceil(2.0 * math.pi * 1e3 * 3.0 / (0.49 * math.sqrt(1e9 / 850.0)))
    assert count * lines.resistance == pytest.approx(128.0 * 850.0 * 46e-6 * 3.0 / (math.pi * 0.0127**4))
    assert count * lines.volume == pytest.approx(math.pi / 4.0 * 0.0127**2 * 3.0)
    assert count * lines.inertance == pytest.approx(850.0 * 3.0 / (math.pi / 4.0 * 0.0127**2))


def test_too_many_cells_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"highest_frequency = 200.0: must be at most 123.5 "):
        Lines.from_dimensions(LENGTH, BORE, VISCOSITY, ConstantOil(BULK), highest_frequency=200.0)


def test_air_that_is_free_near_0_makes_no_more_cells() -> None:
    """Ten metres up to 100 Hz at 50 bar: 2 pi f l / (0.49 c) = 10.3."""
    oil = AeratedOil()
    cells = 2.0 * math.pi * 100.0 * 10.0 / (0.49 * math.sqrt(oil.bulk_modulus(50e5) / 850.0))
    lines = Lines.from_dimensions(10.0, 12e-3, 46e-6, oil)
    assert len(str(lines).split("Lines(")) - 1 == math.ceil(cells) < 40


def test_a_plant_without_chambers_is_refused() -> None:
    with pytest.raises(ParameterError, match="Lines"):
        complete_loop(example(Loop, plant=example(LoadPressurePlant), drive=example(Lines)))


def test_hoses_whose_oil_is_heavy_are_warned_of() -> None:
    (said,) = mismatch_cautions(commanded_axis(AXIS | {"drive": HOSES}))
    assert said.startswith(
        "the oil in a hose, felt as 410 kg by a piston that moves 50.0 kg, has no mass in Hoses"
    )


@pytest.mark.parametrize(("length", "valve", "warned"), [(2.0, "20 Hz", False), (2.0, "200 Hz", True)])
def test_hoses_whose_waves_are_slower_than_the_valve_are_warned_of(
    length: float, valve: str, warned: bool
) -> None:
    """c/(4 l) is 149 Hz."""
    changes = AXIS | {"drive": HOSES | {"length": length}, "plant.mechanism.mass": 1e4}
    changes |= {f"valve.frequency_{name}": valve for name in ("90", "3db")}
    said = mismatch_cautions(commanded_axis(changes))
    assert [line.partition(" behind")[0] for line in said] == [
        "the oil in a hose, with waves of 149 Hz"
    ] * warned
