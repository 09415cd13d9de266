"""Who may ask the server: its own page, from this machine or with the token."""

import hmac
import ipaddress
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from typing import NamedTuple
from urllib.parse import parse_qs

from starlette.datastructures import MutableHeaders
from starlette.exceptions import HTTPException
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

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


class RequestGuard:
    """Checks host, origin, token and size of each request before the application sees it."""

    def __init__(self, application: ASGIApp, door: Door) -> None:
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
                await self.cookie_answer(scope)(scope, receive, with_headers(send))
                return
            most = LARGEST_LOG if scope["path"] == "/api/log" else LARGEST_REQUEST
            await SizeLimit(self.application, most)(scope, receive, with_headers(send), headers)
        except HTTPException as refusal:
            await short_answer(refusal)(scope, receive, with_headers(send))

    def check(self, scope: Scope, headers: dict[str, str]) -> None:
        """Refuse what another site asks for."""
        host = headers.get("host", "")
        if not self.door.takes(host):
            raise HTTPException(HTTPStatus.MISDIRECTED_REQUEST, "the request is for another host")
        origin = headers.get("origin")
        reads = scope["method"] in READS
        if origin is None and not reads:
            raise HTTPException(HTTPStatus.FORBIDDEN, "the request names no origin")
        if origin is not None and origin != f"http://{host}":
            raise HTTPException(HTTPStatus.FORBIDDEN, "the request comes from another site")
        opened = scope["path"] == "/" and headers.get("sec-fetch-mode") == "navigate"
        if headers.get("sec-fetch-site", "none") not in ("same-origin", "none") and not opened:
            raise HTTPException(HTTPStatus.FORBIDDEN, "the request comes from another site")

    def known(self, headers: dict[str, str]) -> bool:
        """Whether a request brings the token."""
        try:
            cookies = SimpleCookie(headers.get("cookie", ""))
        except CookieError:
            return False
        given = cookies[COOKIE].value if COOKIE in cookies else ""
        return hmac.compare_digest(given.encode(), self.door.token.encode())

    def cookie_answer(self, scope: Scope) -> JSONResponse:
        """The answer that exchanges a token in the address for a cookie."""
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        if scope["path"] != "/" or not hmac.compare_digest(given.encode(), self.door.token.encode()):
            raise HTTPException(
                HTTPStatus.FORBIDDEN, "open the address with the token that the terminal shows"
            )
        cookie = f"{COOKIE}={self.door.token}; Path=/; HttpOnly; SameSite=Strict"
        headers = {"location": "/", "set-cookie": cookie}
        return short_answer(HTTPException(HTTPStatus.SEE_OTHER, "", headers))


def headers_of(scope: Scope) -> dict[str, str]:
    """The headers of a request; one that comes twice counts as none."""
    found: dict[str, str] = {}
    for name, value in scope["headers"]:
        key = name.decode("latin-1").lower()
        found[key] = "" if key in found else value.decode("latin-1")
    return found


class SizeLimit:
    """An application that is given bodies of no more than so many bytes, said or found as they come."""

    def __init__(self, application: ASGIApp, most: int) -> None:
        self.application, self.most = application, most

    async def __call__(self, scope: Scope, receive: Receive, send: Send, headers: dict[str, str]) -> None:
        taken, begun = 0, False

        async def part() -> Message:
            nonlocal taken
            message = await receive()
            taken += len(message.get("body", b""))
            return {"type": "http.disconnect"} if taken > self.most else message

        async def reply(message: Message) -> None:
            nonlocal begun
            if taken <= self.most:
                await send(message)
            elif not begun:
                begun = True
                await short_answer(self.refusal)(scope, receive, send)

        length = headers.get("content-length", "0")
        if not length.isdigit() or int(length) > self.most:
            raise self.refusal
        try:
            await self.application(scope, part, reply)
        except Exception:
            if taken <= self.most:  # else the application complains of the end that it was told of
                raise

    @property
    def refusal(self) -> HTTPException:
        problem = f"at most {self.most >> 20} MiB are accepted"
        return HTTPException(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, problem)


def with_headers(send: Send) -> Send:
    """Answers with the headers that keep the page to itself."""

    async def one(message: Message) -> None:
        if message["type"] == "http.response.start":
            MutableHeaders(scope=message).update(HEADERS)
        await send(message)

    return one


def short_answer(said: HTTPException) -> JSONResponse:
    """A short answer of the guard's own."""
    return JSONResponse({"problem": said.detail}, said.status_code, said.headers)
