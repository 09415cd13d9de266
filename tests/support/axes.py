"""An axis whose command is given: that of examples/axis.toml, to which a test adds what it is about."""

from pathlib import Path

from hydroservo import Loop, load_scenario

AXIS = Path(__file__).parents[2] / "examples" / "axis.toml"
COMMANDED = {
    "controls": {"type": "Command"},
    "plant.friction": {"type": "Viscous", "coefficient": 0.0},
    "controller": {"type": "OpenLoop"},
    "load": {"type": "Constant", "amplitude": 0.0},
    "valve": {
        "type": "StaticValve",
        "gain": "0.1 mm/V",
        "max_opening": "1 mm",
        "orifice": {
            "type": "FourEdges.rated",
            "rated_flow": "40 L/min",
            "rated_drop": "70 bar",
            "rated_opening": "1 mm",
        },
    },
}


def commanded_axis(changes: dict[str, object]) -> Loop:
    """The axis with a static valve of 40 L/min at 70 bar and 10 V, no load, and some changes."""
    return load_scenario(AXIS, COMMANDED | changes)


def step(initial: str, final: str, time: str) -> dict[str, object]:
    """The table of a step."""
    return {"type": "Step", "initial": initial, "final": final, "time": time}


def viscous(coefficient: str) -> dict[str, object]:
    """The table of a friction in proportion to the velocity."""
    return {"type": "Viscous", "coefficient": coefficient}
