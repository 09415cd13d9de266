"""The command that serves a page."""

import json
import signal
import socket
import urllib.request

import pytest

from hydroservo.app.serving import Address, open_socket
from tests.support.browser import served
from tests.support.commands.processes import needs_posix
from tests.support.commands.runner import failed

pytestmark = pytest.mark.slow  # it runs and draws


def test_the_page_is_served_until_an_interrupt():
    with served("rig/1khz-pi-sine") as server:
        assert server.url.startswith("http://127.0.0.1:")
        assert b"<title>hydroservo</title>" in urllib.request.urlopen(server.url).read()
        server.process.send_signal(signal.SIGINT)
        assert server.process.wait(20) == 130


@needs_posix
@pytest.mark.parametrize(
    ("number", "word"),
    [(signal.SIGINT, "interrupted"), (signal.SIGTERM, "terminated"), (signal.SIGHUP, "hung up")],
)
def test_the_page_takes_its_folder_with_it(number, word, tmp_path, monkeypatch, capfd):
    """And the job that it does, without another word."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    with served("rig/1khz-pi-sine") as server:
        (folder,) = tmp_path.iterdir()
        (folder / "a-users-log.csv").write_text("time [s]\n")
        asked = json.dumps({"changes": {"simulation.duration": "2000 s"}}).encode()
        headers = {"Origin": server.url.rstrip("/")}
        request = urllib.request.Request(f"{server.url}api/job/run", asked, headers)
        with urllib.request.urlopen(request) as answer:
            answer.read(8)
            server.process.send_signal(number)
            assert server.process.wait(20) == 128 + number
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr().err == f"hydroservo: {word}; nothing was left half-written\n"


def test_an_answer_does_not_wait_to_be_acknowledged():
    with open_socket(Address(port=0)) as listening, socket.create_connection(listening.getsockname()) as _:
        there, _ = listening.accept()
        with there:
            assert there.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_what_cannot_be_served_is_one_line():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        assert f"--port {port}" in failed("app", "--no-browser", "--port", port)
    assert "port = 70000" in failed("app", "--no-browser", "--port", "70000")
    assert "no built-in scenario" in failed("app", "nothing/there", "--no-browser")
    assert "--host 192.0.2.1 --port 0:" in failed("app", "--no-browser", "--host", "192.0.2.1", "--port", "0")
    assert "--host 192.0.2.1:" in failed("app", "--no-browser", "--host", "192.0.2.1")
