"""One server and one browser for all journeys."""

import pytest

from tests.support.browser import CHROMIUM, browser, served
from tests.support.needs import needs


@pytest.fixture(scope="session")
def chromium():
    needs(CHROMIUM)
    with browser() as found:
        yield found


@pytest.fixture(scope="session")
def server():
    with served("axis/position") as found:
        yield found
