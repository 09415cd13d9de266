"""Loops drawn at random about the border of a verdict, on machines that are built in."""

import math
import random
from collections.abc import Callable
from typing import Any

from hydroservo import Loop, load_scenario

Draw = random.Random
Changes = dict[str, Any]

SHORT: Changes = {"simulation.duration": 0.25, "simulation.record_period": 1e-3}
LUMPED = ("rig/1khz-pi-sine", "laws/lq-sine", "laws/backstepping-sine", "laws/terminal-sine")
SINGLE_ROD = ("axis/position", "axis/pump-controlled", "axis/crane", "rig/excavator-link-pi")
SUBSTEPS = {"axis/position": 24, "axis/pump-controlled": 40, "axis/crane": 40, "rig/excavator-link-pi": 40}
GAINS = {
    "rig/1khz-pi-sine": ("controller.proportional_gain", 3.23),
    "axis/position": ("controller.controller.controller.proportional_gain", 2890.0),
    "axis/pump-controlled": ("controller.controller.proportional_gain", 1994.0),
    "axis/crane": ("controller.controller.controller.proportional_gain", 300.93),
}
STIFF: Changes = {"plant.oil.type": "ConstantOil", "plant.oil.effective_bulk_modulus": 1e9}


def drawn(aim: str, draw: Draw) -> Loop:
    """A loop about the border of one of the verdicts in ``AIMS``."""
    name, changes = AIMS[aim](draw)
    if name in GAINS and draw.random() < 0.5:  # across the limit of stability
        path, usual = GAINS[name]
        changes = {path: usual * 10.0 ** draw.uniform(-0.5, 0.7)} | changes
    if name in SINGLE_ROD and name != "rig/excavator-link-pi":
        changes = {"reference.time": 0.02} | changes
    return load_scenario(name, SHORT | changes)


def away(draw: Draw) -> tuple[str, Changes]:
    """A law that winds up, a speed about 100 m/s, or a load that presses with about 10,000 bar."""
    how = draw.choice(("winds up", "speed", "pressure"))
    if how == "speed":
        changes = {"reference.amplitude": draw.uniform(80.0, 120.0), "reference.frequency": 1.0}
        changes |= {"plant.damping": 1.0, "supply.supply_pressure": 200e5, "simulation.substeps": 20}
        changes |= {"valve.orifice.area_gradient": draw.uniform(0.15, 0.6)}
        return LUMPED[0], changes | {"controller.proportional_gain": draw.uniform(0.1, 1.0)}
    if how == "pressure":
        load = {"load.type": "Step", "load.initial": 0.0, "load.time": 0.1}
        force = draw.choice((-1.0, 1.0)) * draw.uniform(0.3e6, 4e6)
        stiff = {"load.final": force, "plant.oil.effective_bulk_modulus": 1e10, "simulation.substeps": 120}
        return "axis/position", load | STIFF | stiff
    windup = draw.uniform(2000.0, 8000.0)
    if draw.random() < 0.5:
        demand = {"reference.amplitude": draw.uniform(0.2, 2.0), "reference.frequency": 2.0}
        return LUMPED[0], demand | {"controller.anti_windup": windup}
    demand = {"reference.max_rate": draw.uniform(0.1, 1.0), "reference.max_second_rate": 10.0}
    name, inner = draw.choice((("axis/pump-controlled", ""), ("axis/position", ".controller")))
    return name, demand | {f"controller.controller{inner}.anti_windup": windup}


def to_the_ends(draw: Draw) -> tuple[str, Changes]:
    """A demand that ends near an end of the stroke."""
    if draw.random() < 0.5:
        name, frequency = draw.choice(LUMPED), draw.uniform(1.5, 4.0)
        travel = 0.03 / (math.pi * frequency) * draw.uniform(0.9, 1.1)
        up = draw.random() < 0.5
        start = 0.078 - travel if up else travel
        changes = {"reference.amplitude": 0.03 if up else -0.03, "reference.frequency": frequency}
        return name, changes | {"plant.start_position": start}
    name = draw.choice(("axis/position", "axis/pump-controlled", "axis/crane"))
    stroke = 0.18 if name == "axis/crane" else 0.3
    up, near = draw.random() < 0.5, draw.uniform(-0.004, 0.006)
    start, final = (stroke - 0.02, stroke - near) if up else (0.02, near)
    shape = {"reference.max_rate": 0.3, "reference.max_second_rate": 5.0, "reference.max_third_rate": 300.0}
    return name, shape | {
        "plant.start_position": start,
        "reference.initial": start,
        "reference.final": max(final, 0.0),
    }


def torn(draw: Draw) -> tuple[str, Changes]:
    """A load that pulls a chamber towards vacuum; a quarter of them with oil that tears."""
    name = draw.choice(SINGLE_ROD)
    oil: Changes = {} if draw.random() < 0.25 else STIFF
    change: Changes = {
        "load.type": "Step",
        "load.initial": 0.0,
        "load.time": draw.choice((0.06, draw.uniform(0.05, 0.1))),
    }
    if name == "axis/pump-controlled":
        change |= {"load.initial": 12e3, "load.final": draw.uniform(-4e3, 20e3)}
        return name, oil | change
    if name == "axis/position":
        change |= {"load.final": draw.choice((draw.uniform(-35e3, -8e3), draw.uniform(8e3, 35e3)))}
        return name, oil | change
    change |= {"load.final": draw.choice((draw.uniform(-12e3, -3e3), draw.uniform(5e3, 20e3)))}
    return name, oil | change


def coarsely(draw: Draw) -> tuple[str, Changes]:
    """Steps about those that are just short enough, by each integrator."""
    name = draw.choice((*LUMPED, *SINGLE_ROD))
    period = draw.choice((1e-3, 2e-3)) if name == LUMPED[0] else 1e-3
    pairs = max(1, round(0.5 * SUBSTEPS.get(name, 2) * 10.0 ** draw.uniform(-1.5, 0.0)))
    substeps = 2 * pairs if name in SINGLE_ROD else draw.randint(1, 3)
    changes: Changes = {"simulation.period": period, "simulation.substeps": substeps}
    kind = draw.random()
    if kind < 0.25:
        changes["simulation.integrator.type"] = "Rosenbrock"
    elif kind < 0.4:
        changes |= {"simulation.integrator.type": "Tsit5", "simulation.substeps": 1}
        changes |= {"simulation.integrator.most_steps": substeps, "simulation.integrator.tolerance": 1e-5}
    return name, changes | {"simulation.record_period": period}


AIMS: dict[str, Callable[[Draw], tuple[str, Changes]]] = {
    "diverged": away,
    "left the stroke": to_the_ends,
    "below vacuum": torn,
    "steps too coarse": coarsely,
}
