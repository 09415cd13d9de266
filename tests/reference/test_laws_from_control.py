"""Laws designed in python-control, run by a loop: the same to 1e-9, exported and tuned as any other."""

import math
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest

from hydroservo import Loop, ParameterError, linearize, load_scenario, replace, simulate
from hydroservo.control.controlled import Velocity
from hydroservo.control.controllers import PI, StateSpace
from hydroservo.control.references import Sine
from hydroservo.interop import to_law, to_scenario, to_statespace
from hydroservo.machine.plants import LoadPressurePlant
from hydroservo.machine.sensors import IdealSensors

SAME = 1e-9


def rig(**changes: object) -> Loop:
    return replace(load_scenario("rig/1khz-pi-sine"), {"simulation.duration": 0.3, **changes})


def pi_law(k_p: float, k_i: float, h: float) -> control.TransferFunction:
    """k_p + k_i h z/(z - 1)."""
    return control.tf([k_p + k_i * h, -k_p], [1.0, -1.0], h)


def run(loop: Loop, law: StateSpace) -> np.ndarray:
    return np.asarray(simulate(replace(loop, {"controller": law}))["controller.u"].values)


def test_a_pi_law_from_its_transfer_function_gives_the_run_of_our_own() -> None:
    loop = rig(controller=PI(2.0, 300.0))
    ours = simulate(loop)["controller.u"].values
    theirs = run(loop, to_law(pi_law(2.0, 300.0, 1e-3), loop))
    assert np.abs(theirs - ours).max() < SAME * np.abs(ours).max()


@pytest.mark.parametrize("name", ["laws/lqi-sine", "axis/position", "laws/industrial-sine"])
def test_the_matrices_of_a_built_in_law_give_its_response(name: str) -> None:
    """There and back: the law's linear model, through python-control, is the linear model of the block."""
    loop = load_scenario(name)
    if name.startswith("axis"):  # the law without its converter and the compensation of the dead band
        loop = replace(loop, {"valve.hysteresis": 0.0, "controller": loop.controller.controller.controller})
    command = 1.0 if name.startswith("axis") else None
    model = linearize(loop, "controller", command=command)
    law = to_law(to_statespace(model), loop)
    back = linearize(replace(loop, {"controller": law}), "controller", command=command)
    w = np.geomspace(1.0, 3000.0, 30)
    assert {one.name for one in back.inputs} == {one.name for one in model.inputs}
    for one in model.inputs:
        theirs = back.response(w, "command", one.name)
        np.testing.assert_allclose(theirs, model.response(w, "command", one.name), rtol=1e-9, atol=1e-12)


def seven_states(h: float) -> control.StateSpace:
    """A stable law of the error of no particular use, with a demand of its own and three measured signals."""
    draw = np.random.default_rng(0)
    names = ["reference_value", "reference_rate", "velocity", "hydraulic_force", "position"]
    a = np.diag(np.linspace(-0.5, 0.9, 7)) + np.triu(draw.normal(0.0, 0.1, (7, 7)), 1)
    scale = np.array([1.0, 1e-2, 1.0, 1e-5, 1e-2])
    b, d = draw.normal(0.0, 0.05, (7, 5)) * scale, draw.normal(0.0, 0.5, (1, 5)) * scale
    return control.ss(a, b, draw.normal(0.0, 0.1, (1, 7)), d, h, inputs=names, outputs=["command"])


def linear_loop() -> Loop:
    """A symmetric cylinder on a pump whose check and relief valves stay shut: nothing in it bends."""
    plant = LoadPressurePlant(60.0, 500.0, 5e-4, 1e-4, 7e8, 1e-12, 1.0, 0.0)
    return replace(
        load_scenario("axis/pump-controlled"),
        {
            "controls": Velocity(),
            "plant": plant,
            "sensors": IdealSensors(),
            "load.amplitude": 0.0,
            "supply.supply_pressure": 1e5,
            "drive.check_valve.cracking_pressure": 1e9,
            "drive.relief.cracking_pressure": 1e9,
            "reference": Sine(0.01, 3.0),
            "simulation.duration": 0.5,
            "simulation.substeps": 400,
        },
    )


@pytest.mark.parametrize(
    "design",
    [
        lambda h: control.tf([2.0 + 40.0 * h, -2.0], [1.0, -1.0], h),
        seven_states,
        lambda h: control.ss(
            [], [], [], [[10.0, -8.0, -1e-4]], h, inputs=["reference_value", "velocity", "hydraulic_force"]
        ),
    ],
    ids=["PI", "seven states", "gains"],
)
def test_the_closed_loop_on_a_linear_machine_is_that_of_python_control(design: Any) -> None:
    """Their recursion on the sampled machine, ours on the differential equations."""
    loop = linear_loop()
    h = loop.simulation.period
    system = design(h)
    data = simulate(replace(loop, {"controller": to_law(system, loop)}))
    r = np.array([data[f"reference.{name}"].values for name in ("value", "rate")])
    machine = to_statespace(linearize(loop, sampled=True))
    law = control.ss(system)
    if law.ninputs == 1:
        law = control.ss(law.A, np.hstack([law.B, -law.B]), law.C, np.hstack([law.D, -law.D]), h)
        law.set_inputs(["reference_value", "velocity"])
    law.set_outputs(["command"])
    law.name = "law"
    asked = ["reference_value", "reference_rate"][: 1 + ("reference_rate" in law.input_labels)]
    outputs = ["velocity", "command"]
    whole = control.interconnect([machine, law], inplist=asked, outlist=outputs, check_unused=False)
    said = control.forced_response(whole, data["time"].values, r[: len(asked)], squeeze=False).outputs
    for ours, theirs in zip((data["plant.velocity"].values, data["controller.u"].values), said, strict=True):
        assert np.abs(ours - theirs).max() < SAME * np.abs(theirs).max()
    assert np.abs(said[0]).max() > 1e-4


def test_a_scenario_with_the_law_runs_the_same_and_is_tuned(tmp_path: Path) -> None:
    loop = rig()
    law = to_law(pi_law(2.0, 300.0, 1e-3), loop)
    path = tmp_path / "mine.toml"
    path.write_text(to_scenario(law, "rig/1khz-pi-sine"))
    read = load_scenario(path, {"simulation.duration": 0.3})
    assert read.controller == law
    np.testing.assert_array_equal(simulate(read)["controller.u"], run(loop, law))
    louder = load_scenario(path, {"controller.first.command": -2.5, "simulation.duration": 0.3})
    assert louder.controller.first.command == -2.5


def test_a_scenario_keeps_the_signals_of_its_law(tmp_path: Path) -> None:
    loop = rig()
    law = to_law(seven_states(1e-3), loop)
    path = tmp_path / "mine.toml"
    path.write_text(to_scenario(law, "rig/1khz-pi-sine"))
    read = load_scenario(path, {"simulation.duration": 0.3})
    signals = [
        type(one.signal).__name__
        for one in (read.controller.first, read.controller.second, read.controller.third)
    ]
    assert signals == ["Velocity", "HydraulicForce", "Position"]
    np.testing.assert_array_equal(simulate(read)["controller.u"], run(loop, law))


def ss(states: int, inputs: list[str] | int, outputs: int = 1, h: float = 1e-3) -> control.StateSpace:
    count = inputs if isinstance(inputs, int) else len(inputs)
    matrices = (
        0.5 * np.eye(states),
        np.ones((states, count)),
        np.ones((outputs, states)),
        np.ones((outputs, count)),
    )
    return control.ss(*matrices, h, inputs=inputs)


@pytest.mark.parametrize(
    ("system", "said"),
    [
        (1.0, "must be a control.StateSpace or a control.TransferFunction"),
        (ss(1, 1, h=2e-3), "must be sampled as the loop is, every 0.001 s"),
        (control.tf([1.0], [1.0, 1.0]), "must be sampled as the loop is"),
        (ss(9, 1), "must have at most 8; use control.balred"),
        (ss(1, 1, 2), "must have one output, the command"),
        (ss(1, ["velocty", "position"]), "did you mean velocity?"),
        (
            ss(1, ["velocity", "position", "force", "hydraulic_force"]),
            "are 4 measured signals; at most 3 are allowed",
        ),
        (control.ss([[math.nan]], [[1.0]], [[1.0]], [[1.0]], 1e-3), "must be finite numbers"),
    ],
)
def test_what_is_no_law_of_the_loop_is_refused_in_one_line(system: Any, said: str) -> None:
    with pytest.raises(ParameterError) as caught:
        to_law(system, rig())
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_is_no_law_is_no_scenario() -> None:
    with pytest.raises(ParameterError, match="must be what to_law returned"):
        to_scenario(1.0, "rig/1khz")  # type: ignore[arg-type]
