"""Who is answered by the page's server, and with what."""

import json
import struct

import pytest
from starlette.testclient import TestClient

from hydroservo.app.guard import LARGEST_REQUEST, Door
from hydroservo.app.routes import application
from hydroservo.app.source import Home

HERE = "http://127.0.0.1:8642"
TOKEN = "a-token"  # noqa: S105, for it opens nothing


@pytest.fixture
def folder(tmp_path):
    return tmp_path


def client(folder, door, base=HERE):
    home = Home("rig/1khz-pi-sine", (), folder)
    return TestClient(application(home, door, []), base_url=base, follow_redirects=False)


@pytest.fixture
def asked(folder):
    return client(folder, Door("127.0.0.1", 8642))


def messages(content):
    """What a stream of messages says."""
    while content:
        text, size = struct.unpack("<II", content[:8])
        yield json.loads(content[8 : 8 + text])
        content = content[8 + text + size :]


def test_the_page_is_there_and_keeps_to_itself(asked):
    answer = asked.get("/")
    assert answer.status_code == 200
    assert "<title>hydroservo</title>" in answer.text
    assert "default-src 'self'" in answer.headers["content-security-policy"]
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert asked.get("/static/main.js").status_code == 200
    assert "//" not in asked.get("/static/style.css").text  # nothing from elsewhere


@pytest.mark.parametrize(
    "host", ["evil.test:8642", "127.0.0.1:80", "127.0.0.1", "", "localhost.evil.test:8642", "0.0.0.0:8642"]
)
def test_a_foreign_host_is_refused(asked, host):
    for path in ("/", "/api/begin", "/static/main.js"):
        assert asked.get(path, headers={"host": host}).status_code == 421


@pytest.mark.parametrize("host", ["127.0.0.1:8642", "localhost:8642", "[::1]:8642", "LOCALHOST:8642"])
def test_this_machine_is_answered(asked, host):
    assert asked.get("/api/begin", headers={"host": host}).status_code == 200


@pytest.mark.parametrize(
    "origin", [None, "null", "http://evil.test", "http://127.0.0.1:9999", "https://127.0.0.1:8642"]
)
def test_a_foreign_origin_is_refused(asked, origin):
    headers = {} if origin is None else {"origin": origin}
    assert asked.post("/api/job/run", json={}, headers=headers).status_code == 403
    assert asked.post("/api/log?ending=.csv", content=b"x", headers=headers).status_code == 403


def test_another_site_gets_nothing_but_the_page_itself(asked):
    foreign = {"sec-fetch-site": "cross-site"}
    assert asked.get("/api/begin", headers=foreign).status_code == 403
    assert asked.get("/static/main.js", headers=foreign).status_code == 403
    assert asked.get("/", headers={**foreign, "sec-fetch-mode": "navigate"}).status_code == 200


def test_beyond_this_machine_the_token_opens(folder):
    door = Door("192.0.2.1", 8642, TOKEN)
    with_token = client(folder, door, "http://192.0.2.1:8642")
    assert with_token.get("/").status_code == 403
    assert with_token.get("/api/begin").status_code == 403
    assert with_token.get("/?token=another").status_code == 403
    assert with_token.get(f"/api/begin?token={TOKEN}").status_code == 403
    answer = with_token.get(f"/?token={TOKEN}")
    assert answer.status_code == 303
    assert {"HttpOnly", "SameSite=Strict"} <= set(answer.headers["set-cookie"].split("; "))
    assert with_token.get("/api/begin").status_code == 200
    assert with_token.get("/api/begin", headers={"host": "evil.test:8642"}).status_code == 421


def test_uploads_are_limited(asked, monkeypatch):
    origin = {"origin": HERE}
    large = b" " * (LARGEST_REQUEST + 1)
    assert asked.post("/api/job/run", content=large, headers=origin).status_code == 413

    def parts():
        for _ in range(3):
            yield b" " * (LARGEST_REQUEST // 2)

    assert asked.post("/api/job/run", content=parts(), headers=origin).status_code == 413
    monkeypatch.setattr("hydroservo.app.guard.LARGEST_LOG", 100)
    assert asked.post("/api/log?ending=.csv", content=b"x" * 101, headers=origin).status_code == 413


def test_a_log_lies_under_a_name_of_the_servers_own(asked, folder):
    origin = {"origin": HERE}
    for ending in (".py", "/../x.csv", "", ".csv/../../x"):
        assert asked.post(f"/api/log?ending={ending}", content=b"x", headers=origin).status_code == 415
    for _ in range(10):
        key = asked.post("/api/log?ending=.CSV", content=b"x", headers=origin).json()["log"]
    assert (folder / f"{key}.csv").read_bytes() == b"x"
    assert len(list(folder.iterdir())) == 8  # the oldest go


@pytest.mark.parametrize("path", ["/static/../guard.py", "/static/%2e%2e/guard.py", "/static/..%2fguard.py"])
def test_no_file_but_the_pages_own_is_read(asked, path):
    assert asked.get(path).status_code == 404


def test_what_is_no_request_is_said(asked):
    origin = {"origin": HERE}
    assert asked.post("/api/job/run", content=b"{", headers=origin).status_code == 400
    assert asked.post("/api/job/nothing", json={}, headers=origin).status_code == 404
    assert asked.post("/api/job/run", json=[], headers=origin).status_code == 404


def test_a_job_is_done_in_its_process(asked):
    with asked:
        request = {"name": "rig/1khz-pi-sine", "changes": {"plant.mas": "1 kg"}}
        answer = asked.post("/api/job/toml", json=request, headers={"origin": HERE})
        (said,) = messages(answer.content)
        assert said["kind"] == "error"
        assert said["path"] == "plant.mas"
        assert "did you mean mass" in said["problem"]
