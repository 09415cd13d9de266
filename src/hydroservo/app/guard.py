"""Who may ask the server: its own page, from this machine or with the token."""

import hmac
import ipaddress
import json
from collections.abc import Awaitable, Callable, MutableMapping
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from typing import Any, NamedTuple
from urllib.parse import parse_qs

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
Application = Callable[[Scope, Receive, Send], Awaitable[None]]

LARGEST_REQUEST = 2**20  # bytes
LARGEST_LOG = 2**26  # bytes
COOKIE = "hydroservo"
READS = ("GET", "HEAD")
LOOPBACK = ("localhost", "127.0.0.1", "::1")
HEADERS = {
    "content-security-policy": "default-src 'self'; img-src 'self' blob: data:; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'; object-src 'none'",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}


class Door(NamedTuple):
    """Where the server listens, and what opens it."""

    host: str  # an address or a name; loopback asks for no token
    port: int  # its port
    token: str = ""  # without which nobody else is answered; "" on loopback

    def takes(self, host: str) -> bool:
        """Whether a request's ``Host`` is one under which this server is meant to be asked.

        A name that an attacker's DNS points to this address is none.
        """
        name, _, port = host.rpartition(":")
        if port != str(self.port):
            return False
        name = name.removeprefix("[").removesuffix("]").lower()
        return name in (*LOOPBACK, self.host.lower()) or (bool(self.token) and is_address(name))


def is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


class Refusal(Exception):  # noqa: N818, for it is an answer
    """A request that is not answered."""

    def __init__(self, status: HTTPStatus, problem: str) -> None:
        super().__init__(problem)
        self.status, self.problem = status, problem


class RequestGuard:
    """Checks host, origin, token and size of each request before the application sees it."""

    def __init__(self, application: Application, door: Door) -> None:
        self.application, self.door = application, door

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self.application(scope, receive, send)
            return
        if scope["type"] != "http":
            return  # there are no sockets here; the server then closes the connection
        headers = headers_of(scope)
        try:
            self.check(scope, headers)
            if self.door.token and not self.known(headers):
                await self.let_in(scope, with_headers(send))
                return
            most = LARGEST_LOG if scope["path"] == "/api/log" else LARGEST_REQUEST
            await SizeLimit(self.application, most)(scope, receive, with_headers(send), headers)
        except Refusal as refusal:
            await send_short_answer(with_headers(send), refusal.status, refusal.problem)

    def check(self, scope: Scope, headers: dict[str, str]) -> None:
        """Refuse what another site asks for."""
        host = headers.get("host", "")
        if not self.door.takes(host):
            raise Refusal(HTTPStatus.MISDIRECTED_REQUEST, "the request is for another host")
        origin = headers.get("origin")
        reads = scope["method"] in READS
        if origin is None and not reads:
            raise Refusal(HTTPStatus.FORBIDDEN, "the request names no origin")
        if origin is not None and origin != f"http://{host}":
            raise Refusal(HTTPStatus.FORBIDDEN, "the request comes from another site")
        opened = scope["path"] == "/" and headers.get("sec-fetch-mode") == "navigate"
        if headers.get("sec-fetch-site", "none") not in ("same-origin", "none") and not opened:
            raise Refusal(HTTPStatus.FORBIDDEN, "the request comes from another site")

    def known(self, headers: dict[str, str]) -> bool:
        """Whether a request brings the token."""
        try:
            cookies = SimpleCookie(headers.get("cookie", ""))
        except CookieError:
            return False
        given = cookies[COOKIE].value if COOKIE in cookies else ""
        return hmac.compare_digest(given.encode(), self.door.token.encode())

    async def let_in(self, scope: Scope, send: Send) -> None:
        """Exchange a token in the address for a cookie."""
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        if scope["path"] != "/" or not hmac.compare_digest(given.encode(), self.door.token.encode()):
            raise Refusal(HTTPStatus.FORBIDDEN, "open the address with the token that the terminal shows")
        cookie = f"{COOKIE}={self.door.token}; Path=/; HttpOnly; SameSite=Strict"
        await send_short_answer(send, HTTPStatus.SEE_OTHER, "", {"location": "/", "set-cookie": cookie})


def headers_of(scope: Scope) -> dict[str, str]:
    """The headers of a request; one that comes twice counts as none."""
    found: dict[str, str] = {}
    for name, value in scope["headers"]:
        key = name.decode("latin-1").lower()
        found[key] = "" if key in found else value.decode("latin-1")
    return found


class SizeLimit:
    """An application that is given bodies of no more than so many bytes, said or found as they come."""

    def __init__(self, application: Application, most: int) -> None:
        self.application, self.most = application, most

    async def __call__(self, scope: Scope, receive: Receive, send: Send, headers: dict[str, str]) -> None:
        taken, begun = 0, False

        async def part() -> MutableMapping[str, Any]:
            nonlocal taken
            message = await receive()
            taken += len(message.get("body", b""))
            return {"type": "http.disconnect"} if taken > self.most else message

        async def reply(message: MutableMapping[str, Any]) -> None:
            nonlocal begun
            if taken <= self.most:
                await send(message)
            elif not begun:
                begun = True
                await send_short_answer(send, HTTPStatus.REQUEST_ENTITY_TOO_LARGE, self.problem)

        length = headers.get("content-length", "0")
        if not length.isdigit() or int(length) > self.most:
            raise Refusal(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, self.problem)
        try:
            await self.application(scope, part, reply)
        except Exception:
            if taken <= self.most:  # else the application complains of the end that it was told of
                raise

    @property
    def problem(self) -> str:
        return f"at most {self.most >> 20} MiB are accepted"


def with_headers(send: Send) -> Send:
    """Answers with the headers that keep the page to itself."""

    async def one(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            ours = [(name.encode(), value.encode()) for name, value in HEADERS.items()]
            message = {**message, "headers": [*message.get("headers", []), *ours]}
        await send(message)

    return one


async def send_short_answer(
    send: Send, status: HTTPStatus, problem: str, headers: dict[str, str] | None = None
) -> None:
    """A short answer of the guard's own."""
    about = [(b"content-type", b"application/json")]
    about += [(name.encode(), value.encode()) for name, value in (headers or {}).items()]
    await send({"type": "http.response.start", "status": int(status), "headers": about})
    await send({"type": "http.response.body", "body": json.dumps({"problem": problem}).encode()})
