"""What the server answers: the page's files, and jobs as streams of messages."""

import json
import secrets
import struct
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from importlib.resources import files
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response, StreamingResponse
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from hydroservo._version import __version__
from hydroservo.app.guard import Door, RequestGuard
from hydroservo.app.source import Home
from hydroservo.app.worker import Message, PageWorker
from hydroservo.scenario import scenarios
from hydroservo.scenario.records import RECORD_ENDINGS
from hydroservo.scenario.scenario_files import parse_override

WORKERS = {  # who does which job: a run does not wait for a curve, nor either for what takes long
    "run": "run",
    "form": "run",
    "retype": "run",
    "toml": "run",
    "frequency": "frequency",
    "log": "long",
    "identify": "long",
    "export": "long",
}
MOST_LOGS = 8


def application(home: Home, door: Door, changes: list[str]) -> RequestGuard:
    """The server of a page."""
    workers = {name: PageWorker(home) for name in dict.fromkeys(WORKERS.values())}
    begin = {
        "version": __version__,
        "name": home.given,
        "changes": dict(map(parse_override, changes)),
        "scenarios": scenarios(),
        "logs": list(RECORD_ENDINGS),
    }

    @asynccontextmanager
    async def life(_: Starlette) -> AsyncIterator[None]:
        for name in ("run", "frequency"):
            workers[name].start()
        yield
        for worker in workers.values():
            worker.end()

    async def page(_: Request) -> Response:
        html = files("hydroservo.app") / "static" / "index.html"
        return Response(html.read_bytes(), media_type="text/html")

    async def beginning(_: Request) -> Response:
        return JSONResponse(begin)

    async def job(request: Request) -> Response:
        name = request.path_params["job"]
        try:
            asked = json.loads(await request.body())
            json.dumps(asked, ensure_ascii=False).encode()  # a half of a pair of UTF-16 is no text
        except (ValueError, RecursionError):
            return JSONResponse({"problem": "the request is not valid JSON"}, 400)
        if name not in WORKERS or not isinstance(asked, dict):
            return JSONResponse({"problem": "there is no such request"}, 404)
        worker = workers[WORKERS[name]]
        return StreamingResponse(frames(worker, name, asked), media_type="application/octet-stream")

    async def log(request: Request) -> Response:
        return await keep_log(request, home.folder)

    routes = [
        Route("/", page),
        Route("/api/begin", beginning),
        Route("/api/log", log, methods=["POST"]),
        Route("/api/job/{job}", job, methods=["POST"]),
        Mount("/static", StaticFiles(directory=str(files("hydroservo.app") / "static"))),
    ]
    return RequestGuard(Starlette(routes=routes, lifespan=life), door)


async def frames(worker: PageWorker, job: str, asked: Mapping[str, Any]) -> AsyncIterator[bytes]:
    """The messages of a job as bytes, until it is done or the page stops reading."""
    messages = worker.do(job, asked)
    try:
        async for message in messages:
            yield frame(message)
    finally:
        await messages.aclose()


def frame(message: Message) -> bytes:
    """A message as bytes: the lengths of both parts, JSON padded to four bytes, then the content."""
    text = json.dumps({"kind": message.kind, **message.about}).encode()
    text += b" " * (-len(text) % 4)
    return struct.pack("<II", len(text), len(message.content)) + text + message.content


async def keep_log(request: Request, folder: Path) -> Response:
    """Keep a log from a page, under a name of the server's own; the oldest goes where there are many."""
    ending = request.query_params.get("ending", "").lower()
    if ending not in RECORD_ENDINGS:
        return JSONResponse({"problem": f"a log ends with one of {', '.join(RECORD_ENDINGS)}"}, 415)
    key = secrets.token_hex(8)
    file = folder / f"{key}{ending}"
    try:
        with file.open("wb") as out:
            async for part in request.stream():
                out.write(part)
    except BaseException as error:
        file.unlink(missing_ok=True)
        if isinstance(error, ClientDisconnect):
            return JSONResponse({"problem": "the log did not come whole"}, 400)
        raise
    logs = sorted(
        (one for one in folder.iterdir() if one.suffix in RECORD_ENDINGS), key=lambda one: one.stat().st_mtime
    )
    for old in logs[:-MOST_LOGS]:
        old.unlink(missing_ok=True)
    return JSONResponse({"log": key})
