"""Curves of a law of one's own: the units of both axes, files, points, and what is refused."""

from pathlib import Path

import pytest

from hydroservo import Loop, ScenarioError, load_scenario
from hydroservo.core.curve import Curve
from hydroservo.core.field import Field

LAW = '''"""A P law whose gain is a curve over the speed."""

from typing import Annotated, NamedTuple

from hydroservo import Field, ops
from hydroservo.core.curve import Curve
from hydroservo.core.roles import Controller, role


class CurveState(NamedTuple):
    """The last command."""

    u: Annotated[float, Field("V", "command")]


@role(Controller)
class NAME(NamedTuple):
    """u = k(|v|) e.

    Source: gain schedules. Fails between the points of operation.
    """

    curve: HINT

    def init(self):
        return CurveState(0.0)

    def step(self, s, y, r, dt):
        return CurveState(self.curve.value(ops.absolute(y.velocity)) * (r.value - y.position))
'''
DECLARED = 'Annotated[Curve, Field("V/m", "gain", over="m/s")]'
UNDECLARED = "Curve"
OF_SIGNAL = 'Annotated[Curve, Field("V/y", "gain over the {y}", over="y")]'
OF_MILLIMETRES = DECLARED.replace("m/s", "mm/s")
HINTS = [DECLARED, UNDECLARED, OF_SIGNAL, OF_MILLIMETRES]
BY_HAND = '[["0 m/s", "130 V/m"], ["40 mm/s", "95 V/m"], [0.1, 70.0], ["0.25 m/s", "0.055 V/mm"]]'
SI = Curve.from_samples([0.0, 0.04, 0.1, 0.25], [130.0, 95.0, 70.0, 55.0])


@pytest.fixture
def axis(tmp_path: Path):
    """Loads the axis of the examples with a gain curve that is declared and given in some way."""

    def load(table: str, hint: str = DECLARED, files: dict[str, str] | None = None) -> Loop:
        for name, text in (files or {}).items():
            (tmp_path / name).write_text(text)
        law, name = tmp_path / "gain_curve.py", f"GainCurve{HINTS.index(hint)}"
        law.write_text(LAW.replace("HINT", hint).replace("NAME", name))
        scenario = tmp_path / "my.toml"
        base = Path(__file__).parents[2] / "examples" / "axis.toml"
        scenario.write_text(f'base = "{base}"\ncontroller = {{ type = "{name}", curve = {{ {table} }} }}\n')
        return load_scenario(scenario, plugins=[law])

    return load


def curve_of(loop: Loop) -> list[list[float]]:
    curve: Curve = loop.controller.curve
    return [curve.knots.tolist(), curve.samples.tolist()]


@pytest.mark.parametrize("hint", [DECLARED, UNDECLARED])
@pytest.mark.parametrize(
    "text",
    [
        "v [m/s],k [V/m]\n0,130\n0.04,95\n0.1,70\n0.25,55\n",
        "v [mm/s];k [V/mm]\n0;0,13\n40;0,095\n100;0,07\n250;0,055\n",
        "v [cm/s]\tk [mV/mm]\n0\t130\n4\t95\n10\t70\n25\t55\n",
    ],
)
def test_a_file_is_read_in_its_units(axis, hint: str, text: str) -> None:
    found = curve_of(axis('file = "gain.csv"', hint, {"gain.csv": text}))
    assert found == [pytest.approx(SI.knots), pytest.approx(SI.samples)]


def test_columns_are_chosen_by_name(axis) -> None:
    text = "k [V/m],T [K],v [m/s]\n130,300,0\n95,301,0.04\n70,302,0.1\n55,303,0.25\n"
    found = curve_of(axis('file = "gain.csv", column = "k", over = "v"', files={"gain.csv": text}))
    assert found == [pytest.approx(SI.knots), pytest.approx(SI.samples)]


def test_points_are_typed(axis) -> None:
    assert curve_of(axis(f"points = {BY_HAND}")) == [pytest.approx(SI.knots), pytest.approx(SI.samples)]


def test_a_curve_may_be_over_what_the_loop_controls(axis) -> None:
    loop = axis('points = [["0 mm/s", "100 V s/m"], ["50 mm/s", "50 V s/m"]]', OF_SIGNAL)
    assert curve_of(loop) == [[0.0, 0.05], pytest.approx([100.0, 50.0])]


def test_a_mass_is_in_kilograms_where_nothing_is_declared(axis) -> None:
    loop = axis('file = "gain.csv"', UNDECLARED, {"gain.csv": "m [kg],n [rpm]\n0,0\n2,60\n"})
    assert curve_of(loop) == [[0.0, 2.0], pytest.approx([0.0, 6.283185307179586])]


WRONG = [
    ('file = "gain.csv"', "t [s],k [V/m]\n0,1\n1,2\n", r"column 't \[s\]' does not convert to m/s"),
    ('file = "gain.csv"', "v [m/s],k [V/s]\n0,1\n1,2\n", r"column 'k \[V/s\]' does not convert to V/m"),
    (
        'file = "gain.csv"',
        "v [m/s],k [V/m]\n0,1\n2,2\n1,3\n",
        "line 4, column v .*: '1' is not after that in",
    ),
    (
        'file = "gain.csv", time = "v"',
        "",
        "curve.time: unknown key .* it must be one of file, column, scale, offset, over, points",
    ),
    (
        'file = "gain.csv", points = [[0, 1], [1, 2]]',
        "",
        "curve.file: 'gain.csv' is given beside .*curve.points",
    ),
    ("points = 3", "", r'must be a list of pairs: \[\["0 m/s", "0 V/m"\], \["1 m/s", "1 V/m"\]\]'),
    ("points = [[0, 1], [1]]", "", r"curve.points\[1\]: .* must be a pair, as in"),
    ('points = [["0 s", "1 V/m"]]', "", r"curve.points\[0\]: .*'0 s' does not convert to m/s"),
    ("points = [[0, true]]", "", r"curve.points\[0\]: .*True must be a number, or one with a unit"),
    ("points = [[0, 1]]", "", "curve.points: .* must be at least 2"),
    ("points = [[0, 1], [0, 2]]", "", r"curve.points: .* x\[1\] = 0.0: must be above x\[0\] = 0"),
    ("", "", 'curve: .*a file is needed, or points: {file = "curve.csv", column = "y", over = "x"}'),
]


@pytest.mark.parametrize(("table", "text", "problem"), WRONG)
def test_what_is_no_curve_is_refused_in_one_line(axis, table: str, text: str, problem: str) -> None:
    with pytest.raises(ScenarioError, match=problem) as caught:
        axis(table, files={"gain.csv": text})
    assert len(str(caught.value).splitlines()) == 1


def test_the_unit_of_the_axis_must_be_si(axis) -> None:
    with pytest.raises(ScenarioError, match="curve has the unit mm/s, which is not SI"):
        axis(f"points = {BY_HAND}", OF_MILLIMETRES)


def test_a_demand_may_be_typed_in_points() -> None:
    points = {"type": "Recorded", "series": {"points": [["0 s", "0 mm/s"], ["0.5 s", "12 mm/s"]]}}
    loop = load_scenario("paper/sine-pi", {"reference": points})
    assert loop.reference.series.value(0.5) == pytest.approx(0.012)


def test_the_unit_of_the_axis_is_text() -> None:
    with pytest.raises(TypeError, match="are text, not 'V', 'gain', over=3"):
        Field("V", "gain", over=3)  # type: ignore[arg-type]
