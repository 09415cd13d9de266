"""Commands print and write what they did, in form and in numbers; tests.support.outputs records it anew."""

import math

import pytest

from tests.support.outputs import COMMANDS, outputs_of, stored

pytestmark = pytest.mark.slow

CLOSE = (
    1e-4  # relative; between processors searches take other candidates in last digits, and limits other steps
)
SEARCHES = ("tune", "study", "limit")  # whose numbers are those of a search


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_prints_and_writes_what_it_did(name):
    before, now = stored()[name], outputs_of(name)
    for part in ("status", "stdout", "files"):
        assert now[part] == before[part], part
    assert list(now["json"]) == list(before["json"])
    if name.startswith(SEARCHES):
        return
    for path, value in now["json"].items():
        assert alike(value, before["json"][path]), path


def alike(one, other):
    """Whether two values are the same, numbers but for last digits."""
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=CLOSE, abs_tol=1e-12)
    return one == other
