"""Linear models of machine, law and loop: names, points, what is not exact, and what is refused."""

import math

import numpy as np
import pytest

import hydroservo as hs
from hydroservo import Loop, ParameterError, linearize, load_scenario, replace, simulate
from hydroservo.control.controllers import PI
from hydroservo.control.holds import DelayedHold
from hydroservo.control.references import Ramp
from hydroservo.core.command_scale import CommandScale, commands_in
from hydroservo.linear import Linearization
from hydroservo.linear.finding import linearization_finding
from hydroservo.machine.loads import Constant
from hydroservo.machine.starts import Steady
from hydroservo.runs.provenance import scenario_hash
from tests.support.tiers import mostly


def rig(**changes: object) -> Loop:
    return replace(load_scenario("rig/1khz-pi-sine"), {"load": Constant(), **changes})


def names(model: Linearization, what: str) -> list[str]:
    return [one.name for one in getattr(model, what)]


def test_states_inputs_and_outputs_have_names_and_units() -> None:
    model = linearize(rig())
    assert names(model, "states") == [
        "plant.velocity",
        "plant.hydraulic_force",
        "plant.position",
        "valve.opening",
    ]
    assert [one.unit for one in model.states] == ["m/s", "N", "m", "m"]
    assert [(one.name, one.unit) for one in model.inputs] == [("command", "V"), ("load.force", "N")]
    assert names(model, "outputs")[-1] == "controlled"
    shapes = [getattr(model, name).shape for name in "ABCD"]
    outputs = len(model.outputs)
    assert shapes == [(4, 4), (4, 2), (outputs, 4), (outputs, 2)]
    assert model.period == 0.0
    assert model.inexact == ()


def test_its_tables_hold_its_poles_and_steady_gains() -> None:
    model = linearize(rig())
    found = linearization_finding(model)
    poles, gains = found.tables
    pairs = [complex(row[0].value, row[1].value) for row in poles.rows]  # type: ignore[arg-type]
    assert pairs == [pole for pole in model.poles.tolist() if pole.imag >= 0.0]
    for row in gains.rows:
        expected = [model.steady_gain(str(row[0].value), one.name) for one in model.inputs]
        assert [cell.value for cell in row[1:-1]] == expected
    assert [one.hash for one in found.origins] == [scenario_hash(rig())]


def test_in_another_unit_of_commands_a_gain_is_by_that_unit() -> None:
    model = linearize(rig())
    with commands_in(CommandScale(current=0.04)):
        _, gains = linearization_finding(model).tables
    assert gains.columns[1].heading == "by 1 mA of command"
    expected = model.steady_gain("velocity", "command") / 4.0
    assert gains.rows[0][1].value == pytest.approx(expected, rel=1e-15)


def test_a_law_is_a_map_from_what_it_measures() -> None:
    """u = k_p (r - v) + i, i' = i + k_i h (r - v), with the integral's new value in u."""
    loop = rig(controller=PI(3.0, 600.0))
    model = linearize(loop, "controller")
    assert names(model, "states") == ["controller.integral"]
    assert names(model, "inputs") == ["velocity", "reference.value"]
    np.testing.assert_allclose(model.A, [[1.0]])
    np.testing.assert_allclose(model.B, [[-0.6, 0.6]], rtol=1e-12)
    np.testing.assert_allclose(model.C, [[1.0]])
    np.testing.assert_allclose(model.D, [[-3.6, 3.6]], rtol=1e-12)
    assert model.period == 1e-3


def test_the_closed_loop_moves_as_the_simulation_does() -> None:
    """A small step of the demand, by the model and by the run."""
    loop = rig(controller=PI(2.0, 100.0))
    height = 1e-5
    demand = Ramp(0.0, height, 1e6, 0.0)
    short = loop.simulation._replace(duration=0.1, record_period=1e-3)
    data = simulate(loop._replace(reference=demand, simulation=short), metrics=[])
    model = linearize(loop, "loop")
    row, column = names(model, "outputs").index("velocity"), names(model, "inputs").index("reference.value")
    x, ours = np.zeros(len(model.states)), []
    for value in data["reference.value"].values:
        ours.append(model.C[row] @ x + model.D[row, column] * value)
        x = model.A @ x + model.B[:, column] * value
    assert np.abs(data["plant.velocity"].values - ours).max() < 1e-5 * height


@pytest.mark.parametrize("delay", [0.0, 4e-4])
def test_a_sampled_machine_is_the_continuous_one_held(delay: float) -> None:
    loop = rig(hold=DelayedHold(delay)) if delay else rig()
    slow, held = linearize(loop), linearize(loop, sampled=True)
    w = np.array([1.0, 30.0])
    ours = held.response(w, "velocity", "command")
    late = np.exp(-1j * w * (delay + 0.5e-3))
    np.testing.assert_allclose(ours, slow.response(w, "velocity", "command") * late, rtol=2e-4)
    assert np.allclose(
        np.log(held.poles[held.poles != 0.0]) / 1e-3, slow.poles[np.argsort(np.abs(slow.poles))], rtol=1e-6
    )


def test_the_point_may_be_an_instant_of_a_run() -> None:
    """At rest before a demand begins it is the steady point; later it is where the run is."""
    loop = rig(reference=Ramp(0.0, 0.05, 10.0, 0.2))
    np.testing.assert_allclose(linearize(loop, time=0.1).A, linearize(loop).A, rtol=1e-9, atol=1e-9)
    later = linearize(loop, time=0.3)
    assert later.A[1, 1] < linearize(loop).A[1, 1]  # the open valve damps
    there = simulate(loop)
    opening = float(there["valve.opening"].sel(time=0.3, method="nearest"))
    steady = linearize(loop, command=opening / loop.valve.gain)
    np.testing.assert_allclose(later.A[1], steady.A[1], rtol=1e-2)


def test_a_load_and_a_command_are_part_of_the_point() -> None:
    loaded = linearize(rig(), command=0.1, force=500.0)
    assert not np.allclose(loaded.A, linearize(rig(), command=0.1).A, rtol=1e-3)
    assert np.allclose(linearize(rig(start=Steady(0.1))).A, linearize(rig(), command=0.1).A)


def test_a_kink_is_said_with_its_error() -> None:
    """A valve's hysteresis: to one side the spool follows, to the other it stays."""
    model = linearize(load_scenario("axis/position"), command=1.0)
    said = {(one.of, one.by): one for one in model.inexact}
    kink = said["valve.speed", "command"]
    assert kink.error == pytest.approx(abs(kink.value), rel=1e-3)
    smooth = replace(load_scenario("axis/position"), {"valve.hysteresis": 0.0})
    assert linearize(smooth, command=1.0).inexact == ()


def test_steady_gains_integrate_differentiate_or_stay() -> None:
    model = linearize(rig())
    assert model.steady_gain("position", "command") == math.inf
    assert model.steady_gain("velocity", "command") > 0.0
    assert linearize(rig(), "loop").steady_gain("velocity", "added_command") == 0.0


@pytest.mark.parametrize(
    "name",
    mostly(
        pytest.mark.nightly,
        [name for name in hs.scenarios() if "-square" not in name],
        ["axis/position", "paper/sine-tsmc"],
    ),
)
@pytest.mark.slow  # every built-in scenario
def test_every_machine_has_a_linear_model(name: str) -> None:
    model = linearize(load_scenario(name))
    assert np.isfinite(model.A).all()
    assert model.frequencies.max() > 10.0


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda: linearize("rig/1khz-pi-sine"), "loop = 'rig/1khz-pi-sine': must be a Loop"),
        (
            lambda: linearize(rig(), "machin"),
            "unit = 'machin': must be one of machine, controller, loop; did",
        ),
        (lambda: linearize(rig(), command=math.nan), "start.command = nan: must be a finite number [V]"),
        (lambda: linearize(rig(), force=math.inf), "force = inf: must be a finite number [N]"),
        (lambda: linearize(rig(), time=0.0), "time = 0.0: must be a finite number at least 0.002"),
        (
            lambda: linearize(rig(), time=0.1, command=1.0),
            "is of a run, which has a command and a load of its",
        ),
        (
            lambda: linearize(load_scenario("axis/force"), force=9e5),
            "plant.start_pressure_a = 'auto': rest under 9e+05 [N] needs",
        ),
        (
            lambda: linearize(load_scenario("cases/drift"), command=0.1),
            "start = 'Steady': has no steady state under 0.1 V",
        ),
        (
            lambda: linearize(rig()).response(1.0, "speed", "command"),
            "output = 'speed': must be one of velocity",
        ),
        (lambda: linearize(rig()).response(1.0, "velocity", "comand"), "did you mean command?"),
        (
            lambda: linearize(rig()).response(math.nan, "velocity", "command"),
            "frequencies = nan: must be a fin",
        ),
        (lambda: linearize(rig()).response("fast", "velocity", "command"), "must be numbers [rad/s]"),
        (
            lambda: linearize(rig(), "loop").response(4000.0, "velocity", "load.force"),
            "must be at most 3141.59 [rad/s], Nyquist's frequency",
        ),
    ],
)
def test_what_cannot_be_linearised_says_so_in_one_line(ask, said: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ParameterError) as caught:
        ask()
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_machine_out_of_all_proportion_has_no_linear_model() -> None:
    loop = load_scenario("axis/position", {"plant.mechanism.mass": 1e-300})
    with pytest.raises(
        ParameterError, match=r"plant = 'Cylinder': has slopes up to .*, too steep for a linear"
    ):
        linearize(loop)
