"""sgn in a sampled loop: the trajectories that Siconos compares its own with."""

import numpy as np
import pytest
from scipy.linalg import expm

from hydroservo.control.observers import Explicit, Implicit

# control/src/tests/iSMC.ref and eSMC.ref of siconos/siconos: dx/dt = A x + B u under u = u_eq + u_s, with u_s
# of size 1 against the sign of C x, taken at the next sample or at this one; rows of sample, x1, x2, u.
A, B, SURFACE = np.array([[0.0, 1.0], [19.0, -2.0]]), np.array([0.0, 1.0]), np.array([1.0, 1.0])
START, PERIOD = (-15.0, 20.0), 0.05
AT_THE_NEXT = """
0 -1.500000000000000e+01 2.000000000000000e+01 2.942873615858686e+02
20 -2.706138767147150e+00 6.824706262545671e+00 5.392704762780318e+01
60 2.102372937227726e+00 8.950665248745704e-02 -4.089904644240295e+01
104 8.905334706795295e-01 -8.718573060341583e-01 -1.774126271559127e+01
105 8.477232889106416e-01 -8.477232889106416e-01 -1.653584714336789e+01
110 6.608921822767830e-01 -6.608921822767830e-01 -1.289148504864030e+01
170 3.331567503454464e-02 -3.331567503454464e-02 -6.498617143776717e-01
"""
AT_THIS_ONE = """
0 -1.500000000000000e+01 2.000000000000000e+01 2.942873615858686e+02
104 8.905334706788154e-01 -8.718573060334056e-01 -1.836859151081985e+01
105 8.469616384321266e-01 -8.778092306952398e-01 -1.554378817818917e+01
106 8.055288757279397e-01 -7.875567684449730e-01 -1.671014270115045e+01
110 6.587495455823109e-01 -6.419931498511831e-01 -1.384646214947241e+01
170 2.134918692742775e-02 -9.872110693482521e-03 -1.410712450237107e+00
"""
BOTH = expm(np.block([[A, B[:, np.newaxis]], [np.zeros((1, 3))]]) * PERIOD)
MOVED, DRIVEN = BOTH[:2, :2], BOTH[:2, 2]
LEVER = float(SURFACE @ DRIVEN)  # of a held u on the surface


def equivalent(x: np.ndarray) -> float:
    """u_eq: -(C B)^-1 C A x in the mean of this sample and the next that it leads to."""
    project = SURFACE @ A / (SURFACE @ B)
    ahead = MOVED @ x - 0.5 * DRIVEN * (project @ x)
    after = np.linalg.solve(np.eye(2) + 0.5 * np.outer(DRIVEN, project), ahead)
    return float(-0.5 * project @ (x + after))


def at_the_next(x: np.ndarray, u_eq: float) -> float:
    rate = LEVER / PERIOD
    s = float(SURFACE @ (MOVED @ x + DRIVEN * u_eq))
    return Implicit().first(s, 0.0, rate, 0.0, 0.5, PERIOD).estimate / rate


def at_this_one(x: np.ndarray, u_eq: float) -> float:
    return Explicit().first(float(SURFACE @ x), 0.0, 1.0, 0.0, 0.5, PERIOD).estimate


@pytest.mark.parametrize(
    ("switching", "published"), [(at_the_next, AT_THE_NEXT), (at_this_one, AT_THIS_ONE)], ids=["iSMC", "eSMC"]
)
def test_the_trajectory_is_the_published_one(switching, published: str) -> None:  # type: ignore[no-untyped-def]
    """Theirs was integrated; with a tolerance of some 1e-11 a step."""
    rows = {int(row.split()[0]): [*map(float, row.split()[1:])] for row in published.split("\n") if row}
    x = np.array(START)
    for k in range(max(rows) + 1):
        u_eq = equivalent(x)
        u = u_eq + switching(x, u_eq)
        if k in rows:
            assert [*x, u] == pytest.approx(rows[k], abs=1e-9)
        x = MOVED @ x + DRIVEN * u
