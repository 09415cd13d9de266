"""What linear algebra finds before a run, gains and starts, has the same bits on another processor."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

DESIGNED = ("laws/lq-sine", "laws/internal-model-sine", "laws/h-infinity-sine")
STEADY = ("axis/position", "axis/crane")
PROGRAM = """
import json, sys
from tests.support.digests import digests_of
print(json.dumps([digests_of(scenario) for scenario in sys.argv[1:]]))
"""


@pytest.mark.nightly  # runs thrice
def test_gains_and_starts_have_the_same_bits_with_other_kernels_of_openblas() -> None:
    found = [bits_with(kernel) for kernel in ("Prescott", "Nehalem", "")]
    assert found[0] == found[1] == found[2]


def bits_with(kernel: str) -> list[dict[str, str]]:
    """Digests of runs in a process of its own; without a kernel OpenBLAS takes this processor's."""
    environment = {**os.environ, "OPENBLAS_CORETYPE": kernel}
    ran = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", PROGRAM, *DESIGNED, *STEADY],
        cwd=Path(__file__).parents[2],
        env=environment if kernel else dict(os.environ),
        capture_output=True,
        text=True,
        check=True,
    )
    bits: list[dict[str, str]] = json.loads(ran.stdout)
    return bits
