"""The processes that compute for a page: what ends, and what goes on."""

import asyncio

import pytest

from hydroservo.app.source import Home
from hydroservo.app.worker import PageWorker

pytestmark = pytest.mark.slow  # it runs and draws

RIG = "rig/1khz-pi-sine"
LONG = {"changes": {"simulation.duration": "2000 s", "simulation.record_period": "1 s"}}
SLEEPING = "import time\ntime.sleep(3600)\n"


@pytest.fixture
def home(tmp_path):
    return Home(RIG, (), tmp_path)


async def said(worker, job, **request):
    """The messages of a job."""
    return [message async for message in worker.do(job, request)]


def run(home, steps):
    """What some steps with a worker come to."""

    async def whole():
        worker = PageWorker(home)
        try:
            async with asyncio.timeout(40):
                return await steps(worker)
        finally:
            worker.end()

    return asyncio.run(whole())


def test_a_job_has_one_last_message(home):
    async def steps(worker):
        return await said(worker, "toml"), await said(worker, "toml", name="nothing")

    (result,), (error,) = run(home, steps)
    assert result.kind == "result"
    assert result.about["text"].startswith(f'base = "{RIG}"')
    assert (error.kind, error.about["path"]) == ("error", "")


def test_a_second_tab_is_told_that_it_waits(home, monkeypatch):
    monkeypatch.setattr("hydroservo.app.worker.PATIENCE", 0.01)

    async def steps(worker):
        first = worker.do("run", LONG)
        await anext(first)
        second = worker.do("toml", {})
        waiting = await anext(second)
        await first.aclose()
        return waiting, [message async for message in second]

    waiting, rest = run(home, steps)
    assert (waiting.kind, waiting.about["what"]) == ("progress", "waiting for another tab")
    assert [message.kind for message in rest] == ["result"]


def test_a_tab_that_stops_waiting_leaves_the_other_alone(home, monkeypatch):
    monkeypatch.setattr("hydroservo.app.worker.PATIENCE", 0.01)

    async def steps(worker):
        first = worker.do("run", LONG)
        await anext(first)
        second = worker.do("toml", {})
        await anext(second)
        await second.aclose()
        message = await anext(first)
        await first.aclose()
        return message

    assert run(home, steps).kind == "progress"


def test_a_process_that_died_is_said_and_another_goes_on(home):
    async def steps(worker):
        listening = worker.do("run", LONG)
        await anext(listening)
        worker.process.kill()
        died = [message async for message in listening]
        return died, await said(worker, "toml")

    died, (again,) = run(home, steps)
    assert died[-1].kind == "error"
    assert "process ended" in died[-1].about["problem"]
    assert again.kind == "result"


def test_who_stops_listening_ends_the_job(home):
    async def steps(worker):
        listening = worker.do("run", LONG)
        await anext(listening)
        await listening.aclose()
        return await said(worker, "toml")

    (after,) = run(home, steps)
    assert after.kind == "result"


def test_what_does_not_answer_is_ended(tmp_path):
    plugin = tmp_path / "slow.py"
    plugin.write_text(SLEEPING)

    async def steps(worker):
        waiting = asyncio.ensure_future(anext(worker.do("toml", {})))
        await asyncio.sleep(1.0)
        waiting.cancel()
        await asyncio.gather(waiting, return_exceptions=True)
        async with worker.lock:
            return worker.process

    assert run(Home(RIG, (str(plugin),), tmp_path), steps) is None
