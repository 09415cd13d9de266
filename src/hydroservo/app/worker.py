"""A process that computes for a page, and can be ended whatever it does."""

import asyncio
from collections.abc import AsyncGenerator, Mapping
from contextlib import suppress
from multiprocessing import get_context
from typing import Any, NamedTuple

from hydroservo.app.form import Stopped, failure_at_field
from hydroservo.app.source import Home
from hydroservo.core.command_scale import commands_in
from hydroservo.scenario import load_plugin
from hydroservo.work.execution import begin_worker, single_threaded_children

PATIENCE = 1.5  # s, more than GRACE, in which the last job of the same page ends
LOOK = 0.05  # s between two looks for a page that has gone
GRACE = 1.0  # s in which a computation may end by itself


class Message(NamedTuple):
    """What a worker says of a job."""

    kind: str  # "progress", "result", "error" or "stopped"; all but the first are the last of a job
    about: dict[str, Any]  # what is said
    content: bytes = b""  # bytes that go with it

    @property
    def last(self) -> bool:
        return self.kind != "progress"


class PageWorker:
    """One job after the other, in a process of its own that is started with the first."""

    def __init__(self, home: Home) -> None:
        self.home = home
        self.lock = asyncio.Lock()
        self.process: Any = None
        self.pipe: Any = None
        self.ending: set[asyncio.Task[None]] = set()

    def start(self) -> None:
        """Start the process, if none runs."""
        if self.process is not None and self.process.is_alive():
            return
        context = get_context("spawn")  # a copy would have the locks of this one's threads
        self.pipe, there = context.Pipe()
        self.process = context.Process(target=run_worker, args=(there, self.home), daemon=True)
        with single_threaded_children():
            self.process.start()
        there.close()

    def end(self) -> None:
        """End the process at once."""
        if self.process is not None:
            self.process.kill()
            self.process.join()
            self.pipe.close()
            self.process = None

    async def do(self, job: str, request: Mapping[str, Any]) -> AsyncGenerator[Message, None]:
        """What is said of a job until it is done; who stops listening ends it."""
        if not await self.is_free(PATIENCE):
            yield Message("progress", {"done": 0.0, "what": "waiting for another tab"})
            await self.lock.acquire()
        done = False
        try:
            self.start()
            self.pipe.send((job, request))
            while not done:
                message = await self.heard()
                done = message.last
                yield message
        finally:
            if done:
                self.lock.release()
            else:
                task = asyncio.get_running_loop().create_task(self.stop())
                self.ending.add(task)
                task.add_done_callback(self.ending.discard)

    async def is_free(self, patience: float) -> bool:
        """Whether this job is the only one within some seconds [s]; a job of this page may be ending."""
        try:
            await asyncio.wait_for(self.lock.acquire(), patience)
        except TimeoutError:
            return False
        return True

    async def heard(self) -> Message:
        """The next message; an error where the process ended."""
        loop = asyncio.get_running_loop()
        try:
            while not await loop.run_in_executor(None, self.pipe.poll, LOOK):
                pass
            message: Message = self.pipe.recv()
        except (EOFError, OSError):
            self.end()
            problem = "the computation's process ended; change something to start it again"
            return Message("error", {"path": "", "problem": problem})
        return message

    async def stop(self) -> None:
        """Ask the job to end; end the process where it does not."""
        with suppress(OSError):
            self.pipe.send("stop")
        try:
            async with asyncio.timeout(GRACE):
                while not (await self.heard()).last:
                    pass
        except (TimeoutError, RuntimeError):  # the latter where the server's threads have ended
            self.end()
        self.lock.release()


def run_worker(pipe: Any, home: Home) -> None:
    """Do what comes through a pipe until it is closed: the life of the process."""
    begin_worker(home.folder)
    from hydroservo.app.jobs import JOBS

    for plugin in home.plugins:
        load_plugin(plugin)
    while True:
        try:
            asked = pipe.recv()
        except (EOFError, OSError):
            return
        if asked != "stop":  # one that came after the end of its job
            job, request = asked
            pipe.send(do_job(JOBS, job, request, home, pipe))


def do_job(jobs: Any, job: str, request: Mapping[str, Any], home: Home, pipe: Any) -> Message:
    """The last message of a job."""

    def report(done: float, what: str) -> None:
        if pipe.poll() and pipe.recv() == "stop":
            raise Stopped
        pipe.send(Message("progress", {"done": done, "what": what}))

    try:
        with commands_in(None):
            about, content = jobs[job](request, home, report)
    except Stopped:
        return Message("stopped", {})
    except Exception as error:
        return Message("error", failure_at_field(error, request, home))
    return Message("result", about, content)
