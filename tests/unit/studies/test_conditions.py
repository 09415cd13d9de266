"""Conditions: the same for every law, others for each purpose, and none that depends on another."""

from collections.abc import Mapping, Sequence

import numpy as np
import pytest

from hydroservo.core.block import value_at
from hydroservo.scenario.load import Assembly
from hydroservo.studies.cells import LawInCell, conditions_digest, laws_in_cells
from hydroservo.studies.conditions import DrawnConditions, draw_conditions
from hydroservo.studies.spec import AxisLevel, StudySpec
from hydroservo.studies.spec_file import read_study


def entrants(**changes: object) -> dict[tuple[str, str], LawInCell]:
    study = read_study("small", {f"conditions.{name}": value for name, value in changes.items()})
    return {(one.law.name, one.cell.name): one for one in laws_in_cells(study)}


@pytest.fixture(scope="module")
def small() -> dict[tuple[str, str], LawInCell]:
    return entrants()


def test_all_laws_meet_the_same_conditions_in_all_cells(small: dict[tuple[str, str], LawInCell]) -> None:
    first = small["pi", "low"].drawn
    for one in small.values():
        for split, kinds in one.drawn.items():
            for kind, drawn in kinds.items():
                for path, values in drawn.columns.items():
                    assert values.tolist() == first[split][kind].columns[path].tolist()


def test_more_conditions_leave_those_there_are(small: dict[tuple[str, str], LawInCell]) -> None:
    more = entrants(test=60)["pi", "low"].drawn["test"]["sine"].columns
    few = small["pi", "low"].drawn["test"]["sine"].columns
    assert all(more[path][: values.size].tolist() == values.tolist() for path, values in few.items())


def test_no_condition_is_of_two_splits(small: dict[tuple[str, str], LawInCell]) -> None:
    own = small["pi", "low"].drawn
    masses = [
        set(own[split]["sine"].columns["plant.mass"].tolist()) for split in ("train", "validation", "test")
    ]
    assert sum(map(len, masses)) == len(set.union(*masses))


def test_kinds_take_turns(small: dict[tuple[str, str], LawInCell]) -> None:
    own = small["pi", "low"].drawn["test"]
    assert own["sine"].numbers.tolist() == list(range(0, 40, 2))
    assert own["square"].numbers.tolist() == list(range(1, 40, 2))


def test_stress_is_the_test_machines_further_out(small: dict[tuple[str, str], LawInCell]) -> None:
    own, nominal = small["pi", "low"].drawn, 6.0
    test, stress = own["test"]["sine"], own["stress"]["sine"]
    deviations = np.tile(test.columns["plant.mass"][:3] / nominal - 1.0, 4)
    expected = nominal * (1.0 + np.repeat([0.5, 1.0, 1.5, 2.0], 3) * deviations)
    np.testing.assert_allclose(stress.columns["plant.mass"], expected, rtol=1e-14)
    np.testing.assert_array_equal(
        stress.columns["load.amplitude"], np.tile(test.columns["load.amplitude"][:3], 4)
    )
    assert stress.scales.tolist() == np.repeat([0.5, 1.0, 1.5, 2.0], 3).tolist()


def test_machines_differ_and_what_laws_believe_does_not(small: dict[tuple[str, str], LawInCell]) -> None:
    one = small["lq", "low"]
    assert np.ptp(one.drawn["test"]["sine"].columns["plant.mass"]) > 3.0
    loop = one.contender.assemblies["sine"].loop
    assert value_at(loop.controller, "model.plant.mass") == 6.0
    assert not any(path.startswith("controller.") for path in one.drawn["test"]["sine"].columns)


def test_the_conditions_of_a_cell_are_drawn_once(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = []

    def counted(study: StudySpec, levels: Sequence[AxisLevel], assemblies: Mapping[str, Assembly]) -> object:
        drawn.append([level.name for level in levels])
        return draw_conditions(study, levels, assemblies)

    monkeypatch.setattr("hydroservo.studies.cells.draw_conditions", counted)
    found = entrants()
    assert drawn == [["low"], ["high"]]
    for one in found.values():
        own = draw_conditions(read_study("small"), one.cell.levels, one.contender.assemblies)
        assert about(own) == about(one.drawn)


def about(drawn: Mapping[str, Mapping[str, DrawnConditions]]) -> list[str]:
    return [conditions_digest(one) for kinds in drawn.values() for one in kinds.values()]
