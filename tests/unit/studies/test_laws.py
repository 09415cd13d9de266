"""Laws as a study has them: with another observer, without a part, on the machine of a cell."""

from pathlib import Path

import pytest

from hydroservo import ScenarioError, load_scenario
from hydroservo.control.controllers import Inverting, ValveInversion
from hydroservo.control.observers import HighGainObserver
from hydroservo.core.block import value_at
from hydroservo.studies.cells import map_cells
from hydroservo.studies.laws import TunableLaw, layered_changes, tunable_law
from hydroservo.studies.spec_file import read_study
from tests.support.plugins import LAW

VELOCITY = read_study("velocity")
CELLS = {cell.name: cell.levels for cell in map_cells(VELOCITY)}


def of(law: str, cell: str = "1khz-high-slow") -> TunableLaw:
    return tunable_law(VELOCITY, VELOCITY.laws[law], CELLS[cell])


def test_an_observer_takes_the_place_of_a_laws_own() -> None:
    one = of("fast-terminal-high-gain")
    law = one.assemblies["sine"].loop.controller
    assert isinstance(law.controller.observer, HighGainObserver)
    place = "controller.controller.observer."
    assert {path for path in one.ranges if path.startswith(place)} == {
        f"{place}velocity_rate",
        f"{place}hydraulic_force_rate",
    }
    assert one.ranges["controller.reach"] == of("fast-terminal-kalman").ranges["controller.reach"]


def test_what_everybody_knows_follows_the_cell() -> None:
    quiet, fast = of("lq-kalman", "1khz-low-slow"), of("lq-kalman", "1khz-high-fast")
    law = quiet.assemblies["sine"].loop.controller
    assert value_at(law, "observer.velocity_noise") == 5e-5
    assert value_at(fast.assemblies["sine"].loop.controller, "time_constant") == 0.003


def test_a_part_that_is_out_is_not_searched() -> None:
    whole, less = of("fast-terminal-kalman"), of("fast-terminal-no-powers")
    gone = {f"controller.controller.error_dynamics.power_gain_{i}" for i in (1, 2)}
    assert set(whole.ranges) - set(less.ranges) == gone
    assert less.assemblies["sine"].loop.controller.controller.error_dynamics.power_gain_1 == 0.0


def test_a_wrapper_can_be_left_out() -> None:
    whole, bare = of("fast-terminal-kalman"), of("fast-terminal-no-inversion")
    assert isinstance(whole.assemblies["sine"].loop.controller, ValveInversion)
    assert isinstance(bare.assemblies["sine"].loop.controller, Inverting)
    assert bare.assemblies["sine"].loop.controller == whole.assemblies["sine"].loop.controller.controller
    moved = {path.replace("controller.controller.", "controller.", 1) for path in whole.ranges}
    assert set(bare.ranges) == moved - {"controller.reach"}


def test_laws_stand_on_the_machine_of_the_built_in_ones() -> None:
    """Its weights of two demands are nothing to a study."""
    own = VELOCITY._replace(base="laws/machine", changes={})
    law = tunable_law(own, own.laws["lq-kalman"], CELLS["1khz-high-slow"])
    assert law.ranges == of("lq-kalman").ranges


def test_rates_are_searched_as_far_as_the_sample_rate_allows() -> None:
    path = "controller.observer.velocity_rate"
    slow, fast = of("lq-high-gain", "1khz-high-slow"), of("lq-high-gain", "4khz-high-slow")
    assert (slow.ranges[path], fast.ranges[path]) == ((1.0, 3000.0), (1.0, 12000.0))
    effort = "controller.effort"
    assert slow.ranges[effort] == fast.ranges[effort]


def test_another_type_drops_what_is_said_of_another() -> None:
    below, above = {"load.type": "Sine", "load.amplitude": 1.0, "valve.gain": 2.0}, {"load.type": "Step"}
    assert layered_changes(below, above) == {"load.type": "Step", "valve.gain": 2.0}
    assert layered_changes(below, {"load.amplitude": 3.0})["load.amplitude"] == 3.0


def test_the_same_type_keeps_what_is_said_below() -> None:
    below = {"load.type": "Sine", "load.amplitude": 1.0, "load.frequency": 2.0}
    assert layered_changes(below, {"load.type": "Sine", "load.amplitude": 3.0}) == {
        **below,
        "load.amplitude": 3.0,
    }


def of_file(folder: Path, text: str) -> TunableLaw:
    """The last law of a study."""
    file = folder / "study.toml"
    file.write_text(text, "utf-8")
    study = read_study(file)
    return tunable_law(study, list(study.laws.values())[-1], [])


POSITION = """
base = "axis/machine"
[set]
controls.type = "Position"
plant.start_position = "50 mm"
load.type = "Constant"
reference = { type = "Sine", amplitude = "10 mm", frequency = "1 Hz", offset = "60 mm" }
[laws.adrc]
scenario = "axis/position-adrc"
"""


def test_a_law_of_position_takes_nothing_of_the_law_below_it(tmp_path: Path) -> None:
    """Its scenario lies over one with a PID between the same wrappers."""
    one = of_file(tmp_path, POSITION)
    law = value_at(one.assemblies["all"].loop.controller, "controller.controller")
    assert law == value_at(load_scenario("axis/position-adrc").controller, "controller.controller")
    assert set(one.ranges) == {
        "controller.controller.threshold",
        *(f"controller.controller.controller.{name}" for name in law._fields[:3]),
    }


LQ = """
base = "rig/noisy-1khz"
known."KalmanObserver.velocity_noise" = "sensors.velocity_noise"
[observers.kalman]
set.type = "KalmanObserver"
set.disturbance_1 = 3
set.disturbance_2 = 1e4
set.velocity_noise = 1e-3
set.hydraulic_force_noise = 5.0
vary = { disturbance_1 = "0.01..1000", disturbance_2 = "100..1e+07", velocity_noise = "1e-5..1" }
[laws.lq]
scenario = "laws/lq-sine"
observers = ["kalman"]
"""


def test_what_everybody_knows_is_not_searched(tmp_path: Path) -> None:
    one = of_file(tmp_path, LQ)
    assert "controller.observer.velocity_noise" not in one.ranges
    assert one.changes["controller.observer.velocity_noise"] == 5e-4


@pytest.mark.parametrize("name", ["disturbance_1", "velocity_noise"])
def test_what_a_law_sets_of_its_observer_stays_and_is_not_searched(tmp_path: Path, name: str) -> None:
    path = f"controller.observer.{name}"
    one = of_file(tmp_path, LQ + f"set.{path} = 7.0\n")
    assert value_at(one.assemblies["all"].loop, path) == 7.0
    assert path not in one.ranges
    less = f'[laws.less]\nof = "lq-kalman"\nwithout = "it"\nset.{path} = 8.0\n'
    assert value_at(of_file(tmp_path, LQ + less).assemblies["all"].loop, path) == 8.0


def test_sensors_that_a_scenario_tunes_are_the_studys(tmp_path: Path) -> None:
    own = 'base = "laws/pi-sine"\ntune.vary = { sensors.velocity_noise = "1e-5..1e-3" }'
    (tmp_path / "own.toml").write_text(own, "utf-8")
    one = of_file(tmp_path, 'base = "rig/noisy-1khz"\nlaws.own.scenario = "own.toml"')
    assert set(one.ranges) == {"controller.proportional_gain", "controller.integral_gain"}


def test_numbers_that_a_constructor_makes_are_refused(tmp_path: Path) -> None:
    made = """
    @classmethod
    def doubled(cls, double: Annotated[float, Field("V s/m", "twice the gain", above=0)] = 4.0):
        return cls(double / 2.0)
"""
    (tmp_path / "own.py").write_text(LAW.replace("class Law(", "class StudiedLaw(") + made, "utf-8")
    own = 'base = "rig/noisy-1khz"\nreference = {{ type = "Sine", amplitude = 0.03, frequency = 1.0 }}\n'
    own += 'controller.type = "StudiedLaw{}"\ntune.vary."controller.gain" = "0.1..10"'
    study = 'base = "rig/noisy-1khz"\nplugins = ["own.py"]\nlaws.own.scenario = "own.toml"'
    (tmp_path / "own.toml").write_text(own.format(""), "utf-8")
    assert of_file(tmp_path, study).ranges == {"controller.gain": (0.1, 10.0)}
    (tmp_path / "own.toml").write_text(own.format(".doubled"), "utf-8")
    with pytest.raises(
        ScenarioError, match=r"StudiedLaw\.doubled makes controller\.gain, which a study sets"
    ):
        of_file(tmp_path, study)
