"""What a study's file may say, and what is said where it says something else."""

from pathlib import Path

import pytest

from hydroservo import ParameterError, ScenarioError
from hydroservo.studies.cells import laws_in_cells, map_cells
from hydroservo.studies.spec_file import read_study

SMALL = """
base = "rig/noisy-1khz"
laws.pi.scenario = "laws/pi-sine"
laws.lq.scenario = "laws/lq-sine"
conditions.vary."plant.mass" = "-30%..+30%"
"""


def refused(tmp_path: Path, text: str) -> str:
    file = tmp_path / "study.toml"
    file.write_text(text, "utf-8")
    with pytest.raises(ScenarioError) as caught:
        list(laws_in_cells(read_study(file)))
    return str(caught.value).removeprefix(f"{file}: ")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "needs [laws]"),
        ("[laws", "is not TOML"),
        (SMALL + "seach.seeds = 2", "seach: unknown key (value {'seeds': 2}); it must be one of"),
        (
            SMALL + "search.sedes = 2",
            "search.sedes: unknown key (value 2); it must be one of candidates, seeds",
        ),
        (SMALL + 'reference = "lp"', "reference: 'lp' must be one of pi, lq"),
        (SMALL + 'metric = "rms"', "metric: 'rms' must be one of"),
        (SMALL + "conditions.test = 0", "conditions.test: 0 must be a whole number from 1 to 100000"),
        (SMALL + "limits.conditions = 201", "limits.conditions: 201 must be a whole number from 0 to 200"),
        (SMALL + "limits.condition = 2", "limits.condition: unknown key (value 2); it must be one of"),
        (SMALL + "search.levels = [1, 0]", "search.levels: [1, 0] must be a list of numbers from 0.001 to"),
        (SMALL + "search.levels = [nan]", "search.levels: [nan] must be a list of numbers from 0.001 to"),
        (SMALL + "search.levels = [2]", "search.levels: [2] must contain 1, the activity of the reference"),
        (SMALL + 'search.step = "1 mm"', "search.step: '1 mm' does not convert to s"),
        (SMALL + 'search.step = "0 s"', "search.step: '0 s' must be a time above 0"),
        (SMALL + "search.candidates = 255", "search.candidates: 255 must be a whole number from 256"),
        (SMALL + 'laws.lq.observers = ["eso"]', "laws.lq.observers: ['eso'] names 'eso'; it "),
        (
            SMALL + 'laws.less = { of = "tsmc", without = "it" }',
            "laws.less.of: 'tsmc' must be a law before it",
        ),
        (
            SMALL + 'laws."P I".scenario = "laws/pi-sine"',
            "laws.P I: must be a name of lower-case letters, digits and hyphens",
        ),
        (SMALL + "axes.rate.label = 'x'", "axes.rate: needs levels"),
        (
            SMALL + 'conditions.vary."controller.proportional_gain" = "1..2"',
            "conditions.vary.controller.proportional_gain: belongs to a law; conditions concern the machine",
        ),
        (SMALL + 'conditions.vary."plant.maas" = "1..2"', "conditions.vary.plant.maas: must be one of"),
        (SMALL + 'known."KalmanObserver.velocity_noise" = "sensors.noise"', "must be a number of the loop"),
        (
            SMALL + 'known."KalmanObsever.velocity_noise" = "sensors.velocity_noise"',
            "there is no type 'KalmanObsever'; did you mean KalmanObserver",
        ),
        (
            SMALL + 'known."KalmanObserver.noise" = "sensors.velocity_noise"',
            "is for a field 'noise' of KalmanObserver, which must be one of",
        ),
        (SMALL.replace("rig/noisy-1khz", "laws/pi-sine"), "base: 'laws/pi-sine' has a [controller]; it must"),
        (
            SMALL + "laws.lq.set.plant.mass = 7.0",
            "laws.lq: sets plant.mass, which does not belong to the law",
        ),
        (SMALL + "laws.pi.unwrapped = true", "laws.pi.unwrapped: is for a law in a wrapper"),
        (SMALL + "axes.a.levels.b.value = nan", "axes.a.levels.b.value: nan must be a number from"),
        (SMALL + 'axes.a.levels.b.value = "1"', "axes.a.levels.b.value: '1' must be a number from"),
        (
            SMALL + 'laws.less = { of = "pi", without = "it", family = "PI" }',
            "laws.less.family: unknown key",
        ),
        (SMALL + 'laws.pi.without = "it"', "laws.pi.without: unknown key"),
        (
            SMALL
            + 'laws.lq.observers = ["e"]\nlaws.lq-e.scenario = "laws/lq-sine"'
            + '\nobservers.e.set.type = "HighGainObserver"',
            "makes a second law named lq-e",
        ),
        (
            SMALL + "axes.x.levels = { a-b = {}, a = {} }\naxes.y.levels = { c = {}, b-c = {} }",
            "axes: two cells are named a-b-c; rename a level",
        ),
        (
            SMALL + 'laws.pi.observers = ["e"]\nobservers.e.set.type = "HighGainObserver"',
            "laws.pi-e.observers: is for a law with an observer",
        ),
        (
            SMALL + 'set.simulation.substeps = "auto"',
            "simulation.substeps: must be a number, the same for all",
        ),
        (
            SMALL.replace("laws/pi-sine", "laws/pj-sine"),
            "is not a built-in name, and there is no such file in",
        ),
        (SMALL.replace('"-30%..+30%"', '"0 %"'), "must be a range"),
        (SMALL.replace("-30%..+30%", "70..130%"), "'130%' has no sign; write '+70%..+130%' for"),
        (
            SMALL.replace("-30%..+30%", "-40%..+30%") + "conditions.stress = [1, 3]",
            "conditions.stress: leads to plant.mass = -",
        ),
        (
            SMALL.replace('vary."plant.mass" = "-30%..+30%"', "seed = 1"),
            "conditions.validation: condition 0 is also one of train; let more vary in [conditions.vary]",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) and len(value) < 60 else "",
)
def test_what_is_wrong_is_said_in_a_line(tmp_path: Path, text: str, says: str) -> None:
    said = refused(tmp_path, text)
    assert says in said
    assert "\n" not in said


def test_a_study_that_is_not_there_is_no_file_and_no_name() -> None:
    with pytest.raises(ScenarioError, match="no built-in study of that name; did you mean small"):
        read_study("smal")


def test_what_is_no_name_and_no_path_is_refused() -> None:
    with pytest.raises(ParameterError, match="must be the name of a study, or the path of a file"):
        read_study(3)  # type: ignore[arg-type]


def test_changes_lie_over_the_file() -> None:
    study = read_study("small", {"search.candidates": 512, "laws.pi.family": "P"})
    assert (study.search.candidates, study.laws["pi"].family) == (512, "P")
    assert study.search.seeds == read_study("small").search.seeds


def test_a_law_without_a_part_keeps_its_wrapper(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    wrapped = 'laws.pi.wrapped = { type = "DAC", bits = 12 }\n'
    file.write_text(SMALL + wrapped + 'laws.less = { of = "pi", without = "it" }', "utf-8")
    assert read_study(file).laws["less"].wrapped == {"type": "DAC", "bits": 12}


def test_a_law_has_each_of_its_observers_and_the_cells_are_all_combinations() -> None:
    study = read_study("velocity")
    assert {"lq-kalman", "lq-high-gain", "lq-terminal"} < set(study.laws)
    assert [cell.name for cell in map_cells(study)][:3] == [
        "1khz-low-fast",
        "1khz-low-slow",
        "1khz-high-fast",
    ]
    assert len(map_cells(study)) == 8
