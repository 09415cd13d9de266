"""One server and one browser for all journeys."""

import pytest

from tests.support.browser import CHROMIUM, browser, open_groups, served, shown
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


@pytest.fixture
def page(chromium, server):
    with shown(chromium, server.url, viewport={"width": 1440, "height": 900}) as found:
        open_groups(found)
        yield found
