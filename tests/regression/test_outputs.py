"""Commands print and write what they did, in form; tests.support.outputs records it anew."""

import pytest

from tests.support.outputs import COMMANDS, outputs_of, stored

pytestmark = pytest.mark.slow

SEARCHES = (
    "audit",
    "batch seeds",
    "identify",
    "limit",
    "study",
    "tune",
)  # last digits choose their sentences


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_prints_and_writes_what_it_did(name):
    before, now = stored()[name], outputs_of(name)
    for part in ("status", "files", "json"):
        assert now[part] == before[part], part
    assert name.startswith(SEARCHES) or now["stdout"] == before["stdout"]
