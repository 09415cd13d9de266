"""A page of hydroservo that is served on loopback, and what is asked of it."""

import json
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

HYDROSERVO = (sys.executable, "-c", "from hydroservo.cli import main; main()")


class Page(NamedTuple):
    """A page that is served by a process of its own."""

    url: str
    pid: int

    def asked(self, job: str, **request: object) -> bytes:
        """All that is answered to a request for a job.

        Raises:
            RuntimeError: the job failed.
        """
        headers = {"origin": self.url.rstrip("/"), "content-type": "application/json"}
        body = json.dumps(request).encode()
        url = f"{self.url}api/job/{job}"
        asked = urllib.request.Request(url, body, headers)  # noqa: S310 - the page that was served here
        with urllib.request.urlopen(asked, timeout=120.0) as answer:  # noqa: S310 - likewise
            content: bytes = answer.read()
        if b'"kind": "result"' not in content:
            raise RuntimeError(content[-300:].decode(errors="replace"))
        return content


@contextmanager
def served(scenario: str) -> Iterator[Page]:
    """The page of a scenario on a free port, until the end."""
    words = [*HYDROSERVO, "app", scenario, "--no-browser", "--port", "0"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        try:
            yield Page(process.stdout.readline().strip() if process.stdout else "", process.pid)
        finally:
            process.terminate()
