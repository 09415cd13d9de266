"""Starts the server, and ends with it."""

import secrets
import socket
import webbrowser
from collections.abc import Callable, Sequence
from pathlib import Path
from threading import Timer
from typing import TYPE_CHECKING, NamedTuple

from hydroservo.app.source import Home
from hydroservo.core.errors import HydroservoError, ParameterError, require
from hydroservo.core.outputs import temporary_folder
from hydroservo.runs.arguments import checked_path

if TYPE_CHECKING:
    from hydroservo.app.guard import Door

PORT = 8642
SOON = 0.3  # s, after which the server answers


class Address(NamedTuple):
    """Where the page is to be.

    Attributes:
        host: an address of this machine.
        port: its port, 0 for any that is free; None for the usual one, or any if that is taken.
    """

    host: str = "127.0.0.1"
    port: int | None = None


def serve(
    scenario: str,
    changes: Sequence[str] = (),
    plugins: Sequence[str | Path] = (),
    address: Address = Address(),  # noqa: B008, for it is a tuple
    browser: bool = True,
    say: Callable[[str], None] = print,
) -> None:
    """Serve the page of a scenario until an interrupt."""
    require("starlette", "app", "the page")
    import uvicorn

    from hydroservo.app.guard import LOOPBACK, Door
    from hydroservo.app.routes import application

    listening = open_socket(address)
    host, port = address.host, listening.getsockname()[1]
    door = Door(host, port, "" if host in LOOPBACK else secrets.token_urlsafe(16))
    with temporary_folder() as folder:
        files = tuple(str(checked_path("plugins", one).absolute()) for one in plugins)
        page = application(Home(scenario, files, folder), door, list(changes))
        where = page_url(door)
        say(where)
        if browser:
            Timer(SOON, webbrowser.open, [where]).start()
        config = uvicorn.Config(
            page,
            log_level="critical",  # what it tells of jobs that end with it is not for the user
            access_log=False,
            timeout_graceful_shutdown=1,
            server_header=False,
            ws="none",
        )
        uvicorn.Server(config).run(sockets=[listening])


def open_socket(address: Address) -> socket.socket:
    host, port = address
    if port is not None and not 0 <= port < 2**16:
        raise ParameterError("port", port, "must be from 0, for any that is free, to 65535")
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    for one in (PORT, 0) if port is None else (port,):
        try:
            listening = socket.create_server((host, one), family=family)
            listening.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)  # else an answer waits 40 ms
            return listening
        except OSError as error:
            problem = error
    asked = f"--host {host}" + ("" if port is None else f" --port {port}")
    raise HydroservoError(f"{asked}: {problem.strerror or problem}")


def page_url(door: "Door") -> str:
    """The address to open."""
    host = f"[{door.host}]" if ":" in door.host else door.host
    return f"http://{host}:{door.port}/" + (f"?token={door.token}" if door.token else "")
