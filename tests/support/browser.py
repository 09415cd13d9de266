"""A page's server as a process, and a browser that looks at it."""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

CHROMIUM = "chromium"
START = "from hydroservo.cli import main; main()"
MASS = "plant.mechanism.mass"
PATIENCE = 30_000  # ms: a new combination of blocks is compiled first


class Served(NamedTuple):
    """A server of a page."""

    process: subprocess.Popen[str]
    url: str

    @property
    def port(self) -> int:
        return int(self.url.rpartition(":")[2].strip("/").partition("/")[0])


@contextmanager
def served(*words: str) -> Iterator[Served]:
    """``hydroservo app`` with words; it ends with the block."""
    command = [sys.executable, "-c", START, "app", "--no-browser", *words]
    if "--port" not in words:
        command += ["--port", "0"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        url = process.stdout.readline().strip()
        assert re.fullmatch(r"http://[^ ]+", url), url
        yield Served(process, url)
    finally:
        process.kill()
        process.wait()
        if process.stdout is not None:
            process.stdout.close()


@contextmanager
def browser() -> Iterator[Any]:
    """The distribution's Chromium, without a window."""
    import shutil

    from playwright.sync_api import sync_playwright

    sandbox = [] if os.geteuid() else ["--no-sandbox"]  # which Chromium refuses to root
    with sync_playwright() as tools:
        found = tools.chromium.launch(executable_path=shutil.which(CHROMIUM), args=sandbox)
        yield found
        found.close()


@contextmanager
def shown(browser: Any, url: str, **looks: Any) -> Iterator[Any]:
    """A page in a context of its own, with its first run drawn; an error in its console fails."""
    context = browser.new_context(**looks)
    page = context.new_page()
    page.set_default_timeout(PATIENCE)
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(url)
    answered(page)
    yield page
    context.close()
    assert errors == []


def answered(page: Any) -> None:
    """Wait until a run is drawn, and up to date."""
    page.wait_for_selector("#metrics td")
    page.wait_for_selector("body:not(.stale)")


def open_groups(page: Any) -> None:
    """Open all groups of parameters."""
    page.evaluate("for (const one of document.querySelectorAll('details')) one.open = true")


def field(page: Any, path: str) -> Any:
    """The field of a number."""
    return page.locator(f"[id='field-{path}']")


def problem(page: Any, path: str) -> Any:
    """Where it is said what is wrong with a number or block."""
    return page.locator(f"[id='problem-{path}']")


def enter(page: Any, path: str, text: str) -> None:
    """Enter a number."""
    field(page, path).fill(text)
    field(page, path).press("Enter")


def numbers_shown(page: Any) -> list[str]:
    """Margins, metrics of this run and values in the circuit."""
    places = page.locator("#margins dd, #metrics td:nth-child(2), #drawing .value")
    return [text for text in places.all_text_contents() if any(map(str.isdigit, text))]


def in_full_contrast(place: Any) -> bool:
    """Whether nothing around a text makes it pale."""
    pale = (
        "for (let at = one; at; at = at.parentElement) if (getComputedStyle(at).opacity !== '1') return false"
    )
    return bool(place.is_visible() and place.evaluate(f"(one) => {{ {pale}; return true; }}"))
