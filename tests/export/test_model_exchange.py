"""FMUs of a machine's equations: integrated by others they are the machine that is simulated."""

import math
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from hydroservo import simulate
from hydroservo.control.loop import Loop
from hydroservo.core.block import leaves, replace
from hydroservo.core.signals import MachineOutputs
from hydroservo.export.fmu import FmiVersion
from hydroservo.export.of_loop import exported_unit, nominal_size
from hydroservo.export.unit import Part
from hydroservo.machine.loads import Step
from hydroservo.machine.plants import Cylinder
from hydroservo.runs.run import runnable_loop
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example
from tests.support.export.exchanges import Exchange, rk4
from tests.support.export.fmus import Instance, unpacked

pytestmark = pytest.mark.slow  # each builds a library or a program

FORCE = "external.force"
SAMPLES = 500


def unpacked_part(loop: Loop, part: Part, version: FmiVersion, folder: Path) -> Path:
    unit = exported_unit(loop, part, prefix=f"own_{part}", title=f"a {part}")
    (folder / part).mkdir()
    return unpacked(unit, version, folder / part)


@pytest.fixture(scope="module")
def stepped() -> Loop:
    """A loop whose load jumps between two samples."""
    return example(Loop, plant=example(Cylinder), load=Step(initial=10.0, final=90.0, time=0.0105))


@pytest.fixture(scope="module")
def folder(stepped: Loop, version: FmiVersion, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return unpacked_part(stepped, Part.EQUATIONS, version, tmp_path_factory.mktemp("equations"))


@pytest.mark.parametrize("name", ["rig/1khz-tsmc-sine", "paper/sine-tsmc"])
def test_a_controller_and_an_integrator_of_ones_own_make_the_loop(
    name: str, version: FmiVersion, tmp_path: Path
) -> None:
    loop = load_scenario(name)
    period, substeps = loop.simulation.period, loop.simulation.substeps
    brief = loop.simulation._replace(duration=SAMPLES * period, record_period=period)
    data = simulate(loop._replace(simulation=brief), strict=True)
    parts = [unpacked_part(loop, part, version, tmp_path) for part in (Part.CONTROLLER, Part.EQUATIONS)]
    with Instance(parts[0]) as controller, Exchange(parts[1]) as machine:
        controller.begin()
        assert machine.begin().go_on() is None
        x, paths = machine.states, [path for path, _ in leaves(loop.machine(loop.init()))]
        wanted = [f"measurement.{one}" for one in MachineOutputs._fields]
        for k in range(SAMPLES):
            machine.model.setTime(k * period)
            machine.states = x
            assert x.tolist() == [data[path].values[k] for path in paths], k
            seen = {one: machine.get(one.replace("measurement", "outputs"))[0] for one in wanted}
            wish = loop.reference.at(k * period)._asdict()
            demand = {f"demand.{one}": value for one, value in wish.items()}
            known = {**seen, **demand, "measurement.command": machine.get("controller.u")[0]}
            controller.set({one: value for one, value in known.items() if one in controller.references})
            machine.set({"controller.u": controller.get("controller.u")[0]})
            controller.step(k * period)
            h = period / substeps
            for i in range(substeps):
                x = rk4(machine.rates, k * period + i * h, x, h)


def test_cvode_agrees_with_the_simulation(stepped: Loop, version: FmiVersion, tmp_path: Path) -> None:
    """SUNDIALS integrates the equations, through the jump of the load; FMPy drives it."""
    parts = {part: unpacked_part(stepped, part, version, tmp_path) for part in (Part.EQUATIONS, Part.MACHINE)}
    names = ["plant.velocity", "plant.position", "plant.pressure_a", "plant.pressure_b"]
    run = fmpy.simulate_fmu(
        str(parts[Part.EQUATIONS]),
        stop_time=0.02,
        output_interval=1e-3,
        start_values={"controller.u": 0.4, FORCE: 25.0},
        solver="CVode",
        relative_tolerance=1e-9,
        output=names,
    )
    with Instance(parts[Part.MACHINE]) as machine:
        machine.begin().set({"controller.u": 0.4, FORCE: 25.0})
        for k in range(2000):
            machine.step(k * machine.period)
        for name, found in zip(names, machine.get(*names), strict=True):
            assert found == pytest.approx(run[name][-1], rel=2e-6), name
    assert run["plant.velocity"][-1] > 0.05


def test_rates_are_those_of_the_loop(version: FmiVersion, tmp_path: Path) -> None:
    loop = runnable_loop(load_scenario("rig/excavator-link"))
    data = simulate(load_scenario("rig/excavator-link", {"simulation.duration": "0.3 s"}), strict=True)
    state = loop.machine(loop.init())
    paths = [path for path, _ in leaves(state)]
    with Exchange(unpacked_part(loop, Part.EQUATIONS, version, tmp_path)) as one:
        one.begin().go_on()
        for k in range(0, data.sizes["time"], 30):
            x = [float(data[path].values[k]) for path in paths]
            t, u = float(data["time"].values[k]), float(data["controller.u"].values[k])
            one.set({"controller.u": u, FORCE: 0.0})
            found = one.rates(t, np.array(x)).tolist()
            machine = replace(state, dict(zip(paths, x, strict=True)))
            expected = loop.rates(machine, u, loop.load.force(t))
            assert found == [number for _, number in leaves(expected)]
            one.set({FORCE: 1000.0})
            pushed = loop.rates(machine, u, loop.load.force(t) + 1000.0)
            assert one.rates(t, np.array(x)).tolist() == [number for _, number in leaves(pushed)]


def test_nothing_is_seen_of_a_jump_before_its_event(folder: Path) -> None:
    with Exchange(folder) as one:
        assert one.begin().go_on() == 0.0105
        assert one.get("load.force") == [10.0]
        for time in (math.nextafter(0.0105, 0.0), 0.0105):
            one.model.setTime(time)
            assert one.get("load.force") == [10.0]
        one.model.setTime(0.0106)  # an integrator that looks ahead
        assert one.get("load.force") == [10.0]
        before = one.rates(0.0105, one.states)
        assert one.event(0.0105) is None
        assert one.get("load.force") == [90.0]
        after = one.rates(0.0105, one.states)
        assert after[0] < before[0]
        assert after[1:].tolist() == before[1:].tolist()


@pytest.mark.parametrize("start", [0.0, 0.1, 2.0, -3.0, 1e6])
def test_a_jump_comes_at_the_event_that_is_announced(folder: Path, start: float) -> None:
    """Not a rounding before it, where there would be an event again and again."""
    with Exchange(folder) as one:
        announced = one.begin(start=start).go_on()
        assert announced == pytest.approx(start + 0.0105, abs=1e-9)
        assert one.event(announced) is None
        assert one.get("load.force") == [90.0]


def test_the_start_time_is_where_a_run_starts(folder: Path) -> None:
    with Exchange(folder) as one:
        assert one.begin(start=2.0).go_on() == pytest.approx(2.0105)
        one.model.setTime(2.0105)
        assert one.get("load.force", "time") == [10.0, 2.0105]


def test_the_start_follows_the_parameters(folder: Path) -> None:
    with Exchange(folder) as one:
        one.set({"plant.start_position": 0.05})
        assert one.begin().go_on()
        assert one.states[1] == one.get("plant.position")[0] == one.get("outputs.position")[0] == 0.05
        assert "cannot be set" in refused(one, lambda: one.set({"plant.start_position": 0.04}))


def test_a_parameter_may_change_at_an_event(folder: Path) -> None:
    with Exchange(folder) as one:
        one.begin().set({"plant.mechanism.mass": 18.0})
        one.go_on()
        one.set({"controller.u": 1.0})
        text = refused(one, lambda: one.set({"plant.mechanism.mass": 9.0}))
        assert text == "plant.mechanism.mass cannot be set in the continuous-time mode: it is a parameter"


def test_states_may_be_set_one_by_one_where_they_are_integrated(folder: Path) -> None:
    with Exchange(folder) as one:
        one.begin().go_on()
        before = one.rates(0.001, one.states)
        one.set({"plant.velocity": 0.25})
        assert one.states[0] == 0.25
        assert one.rates(0.001, one.states)[0] < before[0]
        with pytest.raises(FMICallException) as caught:
            one.set({"plant.velocity": math.nan})
        assert caught.value.status == 2
        assert one.get("plant.velocity") == [0.25]
        one.model.enterEventMode()
        assert "the model computes it" in refused(one, lambda: one.set({"plant.velocity": 0.5}))


def test_saved_states_hold_the_time_and_the_mode(folder: Path) -> None:
    with Exchange(folder) as one:
        one.begin().go_on()
        one.set({"controller.u": 0.5})
        before = one.rates(0.003, one.states).tolist()
        saved = one.model.getFMUState()
        one.rates(0.004, one.states + 1.0)
        one.event(0.0105)
        one.model.setFMUState(saved)
        assert one.get("time") == [0.003]
        assert one.rates(0.003, one.states).tolist() == before
        one.model.setTime(0.0105)
        assert one.get("load.force") == [10.0]
        one.model.freeFMUState(saved)


def test_what_is_not_finite_is_discarded(folder: Path) -> None:
    with Exchange(folder) as one:
        one.begin().go_on()
        x = one.states
        with pytest.raises(FMICallException) as caught:
            one.states = np.full(len(x), math.nan)
        assert caught.value.status == 2
        assert one.states.tolist() == x.tolist()
        with pytest.raises(FMICallException) as caught:
            one.rates(0.0, np.full(len(x), 1e308))
        assert caught.value.status == 2
        assert one.messages[-1].startswith("der(plant.")
        one.rates(0.0, x)  # and the instance goes on


def refused(one: Exchange, call: Callable[[], object]) -> str:
    with pytest.raises(FMICallException) as caught:
        call()
    assert caught.value.status == 3
    return one.messages[-1]


@pytest.mark.parametrize(
    ("calls", "text"),
    [
        (("setTime",), "before the initialization mode"),
        (("begin", "setContinuousStates"), "in the event mode"),
        (("begin", "completedIntegratorStep"), "in the event mode"),
        (("begin", "go_on", "enterContinuousTimeMode"), "in the continuous-time mode"),
        (("begin", "go_on", "update"), "in the continuous-time mode"),
        (("begin", "terminate", "setTime"), "after the termination"),
    ],
)
def test_calls_out_of_order_are_refused(folder: Path, calls: tuple[str, ...], text: str) -> None:
    with Exchange(folder) as one:
        model = one.model
        update = "newDiscreteStates" if one.version is FmiVersion.FMI2 else "updateDiscreteStates"
        known = {
            "begin": one.begin,
            "go_on": one.go_on,
            "update": getattr(model, update),
            "terminate": model.terminate,
            "setTime": lambda: model.setTime(0.1),
            "setContinuousStates": lambda: setattr(one, "states", one.states),
            "completedIntegratorStep": model.completedIntegratorStep,
            "enterContinuousTimeMode": model.enterContinuousTimeMode,
        }
        for name in calls[:-1]:
            known[name]()
        said = refused(one, known[calls[-1]])
        assert "must not be called" in said
        assert text in said


def test_other_sizes_and_interfaces_are_refused(folder: Path) -> None:
    with Exchange(folder) as one:
        one.begin().go_on()
        with pytest.raises(FMICallException):
            one.model.getContinuousStates(None, one.count)
        assert "null pointer" in one.messages[-1]
        one.model.reset()
        with pytest.raises(FMICallException):
            one.model.getEventIndicators(None, 3)
        assert one.messages[-1] == "this FMU has no event indicators"


def test_a_state_that_stands_still_has_the_usual_size_of_its_unit() -> None:
    """An integrator's tolerance is a share of it, and CVode stops where that is a share of rounding."""
    rest = {"reference.amplitude": 0.0, "load.amplitude": 0.0, "simulation.duration": 0.01}
    loop = load_scenario("rig/10khz-pi-sine", rest)
    unit = exported_unit(loop, Part.EQUATIONS, prefix="own", title="a machine at rest")
    sizes = {one.path: one.nominal for own in unit.arguments for one in own.signals if one.integrated}
    assert sizes["plant.velocity"] == 0.1
    assert (nominal_size(1.6e-16, "m/s"), nominal_size(0.03, "m/s"), nominal_size(0.0, "V")) == (
        0.1,
        0.03,
        1.0,
    )
