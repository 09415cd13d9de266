"""Each signal that a loop can control with each source of demands: from text to runs, pictures and C."""

from itertools import cycle
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from hydroservo import Loop, ScenarioError, load_scenario, plot, replace, simulate, simulate_batch, tune
from hydroservo.core.block import value_at
from hydroservo.export.fmu import FmiVersion
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part
from hydroservo.runs.cautions import quietly
from hydroservo.runs.objective import Aim
from tests.support.export.agreement import assert_same_run
from tests.support.export.fmus import parts_make_the_run, unpacked
from tests.support.tiers import mostly

SIGNALS = {  # unit, amount of a demand, gain
    "Velocity": ("m/s", 0.03, "5 V s/m"),
    "Position": ("m", 0.04, "10 V/m"),
    "Force": ("N", 100.0, "1e-3 V/N"),
    "HydraulicForce": ("N", 100.0, "1e-3 V/N"),
    "LoadPressure": ("Pa", 2e5, "1e-6 V/Pa"),
    "PressureA": ("Pa", 2e6, "1e-6 V/Pa"),
    "PressureB": ("Pa", 2e6, "1e-6 V/Pa"),
    "Command": ("V", 1.0, ""),
}
SOURCES = {  # {y} stands for an amount with its unit
    "Step": 'initial = "0 {u}"\nfinal = "{y} {u}"\ntime = "3 ms"',
    "Ramp": 'initial = "0 {u}"\nfinal = "{y} {u}"\nrate = "{y} {u}/s"\ntime = "0 s"',
    "Sine": 'amplitude = "{y} {u}"\nfrequency = "50 Hz"',
    "Square": 'amplitude = "{y} {u}"\nperiod = "8 ms"',
    "Chirp": 'amplitude = "{y} {u}"\nfirst_frequency = "9 Hz"\nlast_frequency = "99 Hz"\nsweep_time = "5 ms"',
    "Multisine": 'amplitude = "{y} {u}"\nfrequency = "50 Hz"\nharmonics = 3',
    "Recorded": 'series = {{ file = "demand.csv", time = "t", column = "y" }}',
    "PointToPoint": 'initial = "0 {u}"\nfinal = "{y} {u}"\nmax_rate = "{y} {u}/s"\n'
    'max_second_rate = "{y} {u}/s^2"\nmax_third_rate = "{y} {u}/s^3"\ntime = "1 ms"',
}
FALLING = {"PressureB"}  # as the command rises
LOOP = """
title = "each signal with each demand"
[simulation]
duration = "10 ms"
period = "1 ms"
record_period = "1 ms"
substeps = 50
[controls]
type = "{signal}"
[plant]
type = "Cylinder"
area_a = "4.91 cm^2"
area_b = "4.91 cm^2"
dead_volume_a = "5 cm^3"
dead_volume_b = "5 cm^3"
stroke = "78 mm"
start_position = "39 mm"
[plant.mechanism]
type = "MassSpringDamper"
mass = "6 kg"
stiffness = "1e4 N/m"
rest_position = "39 mm"
[plant.oil]
type = "ConstantOil"
effective_bulk_modulus = "7000 bar"
[valve]
type = "StaticValve"
gain = "2e-5 m/V"
max_opening = "5 mm"
[valve.orifice]
type = "Orifice"
discharge_coefficient = 0.62
area_gradient = "24 mm"
density = "850 kg/m^3"
[supply]
type = "IdealSupply"
supply_pressure = "40 bar"
[controller]
{law}
[reference]
type = "{source}"
"""


def text_of(signal: str, source: str, unit: str | None = None) -> str:
    own, amount, gain = SIGNALS[signal]
    law = f'type = "PI"\nproportional_gain = "{gain}"' if gain else 'type = "OpenLoop"'
    if signal in FALLING:
        law = f'type = "InvertedPolarity"\n[controller.controller]\n{law}'
    demand = SOURCES[source].format(u=unit or own, y=f"{amount:g}")
    return LOOP.format(signal=signal, source=source, law=law) + demand


def loop_of(folder: Path, signal: str, source: str, unit: str | None = None) -> Loop:
    own, amount, _ = SIGNALS[signal]
    rows = "".join(f"{0.001 * i},{amount * i / 10}\n" for i in range(11))
    (folder / "demand.csv").write_text(f"t [s],y [{unit or own}]\n{rows}")
    path = folder / "loop.toml"
    path.write_text(text_of(signal, source, unit))
    return load_scenario(path)


def in_plain_python(loop: Loop) -> xr.Dataset:
    return quietly(simulate)(loop, compiled=False)


@pytest.mark.parametrize("source", SOURCES)
@pytest.mark.parametrize("signal", SIGNALS)
def test_a_loop_of_text_runs_in_the_units_of_its_signal(signal: str, source: str, tmp_path: Path) -> None:
    loop = loop_of(tmp_path, signal, source)
    unit = SIGNALS[signal][0]
    data = in_plain_python(loop)
    assert not data["diverged"]
    named = loop.controls.declared().meaning
    assert data["controlled.value"].attrs == {"units": unit, "long_name": named}
    assert data["reference.value"].attrs == {"units": unit, "long_name": f"{named} demand"}
    assert data["reference.rate"].attrs["units"] == {"m/s": "m/s^2"}.get(unit, f"{unit}/s")
    assert np.ptp(data["reference.value"].values) > 0.0
    if signal == "Command":
        assert "rms_error" not in data
        assert (data["controller.u"].values == data["reference.value"].values).all()
    else:
        assert data["rms_error"].attrs["units"] == unit
        assert data["rms_error"].attrs["long_name"] == f"rms of the {named} error"
        assert data["controlled.value"].values == pytest.approx(own_signal(data, loop, signal), abs=0.0)


def own_signal(data: xr.Dataset, loop: Loop, signal: str) -> np.ndarray:
    """What is controlled, from the recorded machine."""
    state = {
        name: data[f"plant.{name}"].values for name in ("velocity", "position", "pressure_a", "pressure_b")
    }
    if signal == "LoadPressure":
        return state["pressure_a"] - state["pressure_b"]
    if signal == "HydraulicForce":
        return loop.plant.area_a * state["pressure_a"] - loop.plant.area_b * state["pressure_b"]
    if signal == "Force":
        return 1e4 * (state["position"] - 0.039)
    return state[
        {"Velocity": "velocity", "Position": "position"}.get(signal, f"pressure_{signal[-1].lower()}")
    ]


@pytest.mark.parametrize("signal", [name for name in SIGNALS if name != "Command"])
@pytest.mark.parametrize("share", [0.5, 1.5])
def test_the_loop_takes_its_signal_towards_the_demand(signal: str, share: float, tmp_path: Path) -> None:
    """In the first sample period, from rest."""
    loop = loop_of(tmp_path, signal, "Step")
    demand = {"reference.final": share * SIGNALS[signal][1], "reference.time": 0.0}
    data = in_plain_python(replace(loop, demand))
    asked, found = data["reference.value"].values[0], data["controlled.value"].values[:2]
    assert (found[1] - found[0]) * (asked - found[0]) > 0.0


@pytest.mark.parametrize("source", SOURCES)
@pytest.mark.parametrize("signal", SIGNALS)
def test_a_demand_in_another_unit_is_refused_in_one_line(signal: str, source: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError) as caught:
        loop_of(tmp_path, signal, source, "kg")
    assert ("demand.csv" if source == "Recorded" else "reference.") in str(caught.value)
    assert "kg" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("signal", SIGNALS)
def test_the_picture_is_labelled_with_the_signal(signal: str, tmp_path: Path) -> None:
    loop = loop_of(tmp_path, signal, "PointToPoint")
    figure = plot(in_plain_python(loop))
    labels = " ".join(axes.get_ylabel() for axes in figure.axes).lower()
    assert loop.controls.declared().meaning.lower() in labels


@pytest.mark.slow
@pytest.mark.parametrize("signal", SIGNALS)
def test_a_batch_and_a_search_are_of_the_signal(signal: str, tmp_path: Path) -> None:
    loop = loop_of(tmp_path, signal, "PointToPoint")
    table = quietly(simulate_batch)(
        loop, {"reference.max_rate": np.array([0.5, 1.0]) * loop.reference.max_rate}
    )
    rate = table["reference.max_rate"].attrs["units"]
    assert rate == {"Velocity": "m/s^2"}.get(signal, f"{SIGNALS[signal][0]}/s")
    if signal != "Command":
        path = (
            "controller.controller.proportional_gain" if signal in FALLING else "controller.proportional_gain"
        )
        gain = value_at(loop, path)
        found = tune(Aim([loop]), {path: (0.1 * gain, gain)}, candidates=64, bounded=False)
        again = quietly(simulate)(replace(loop, found.parameters))
        assert 0.1 * gain <= found.parameters[path] <= gain
        assert found.after[0] == pytest.approx(float(again["rms_error"]), rel=1e-6)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::hydroservo.HydroservoWarning")  # of a demand below no pressure at all
@pytest.mark.parametrize("source", mostly(pytest.mark.nightly, SOURCES, ["PointToPoint"]))
@pytest.mark.parametrize("signal", SIGNALS)
def test_the_loop_in_c_gives_its_bits(signal: str, source: str, tmp_path: Path) -> None:
    """Law and demand in it."""
    assert_same_run(loop_of(tmp_path, signal, source), tmp_path, compiled=False)


@pytest.mark.nightly
@pytest.mark.filterwarnings("ignore::hydroservo.HydroservoWarning")  # as above
@pytest.mark.parametrize(("signal", "source"), [*zip(cycle(SIGNALS), SOURCES, strict=False)])
def test_the_law_as_an_fmu_gives_the_bits_of_the_run(signal: str, source: str, tmp_path: Path) -> None:
    """Beside its machine as another FMU, each signal and each demand once: neither FMU knows of the other."""
    loop = loop_of(tmp_path, signal, source)
    folders = []
    for part in (Part.CONTROLLER, Part.MACHINE):
        (tmp_path / part).mkdir()
        unit = exported_unit(loop, part, prefix="unit", title=f"{part} of {signal}")
        folders.append(unpacked(unit, FmiVersion.FMI2, tmp_path / part))
    parts_make_the_run(loop, simulate(loop, metrics=(), compiled=False), *folders)
