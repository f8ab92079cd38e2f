"""The door of a page: requests from the page itself, by whoever has its address, and no others."""

from __future__ import annotations

import hmac
import ipaddress
import secrets
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

from surefoot.app.lab.front import dress_answer

LENGTH = 16
"""Bytes of a token."""
WORD = "token"
"""Of the token in the address."""
STRANGER = "This page wants its whole address, with the token that `surefoot lab` printed.\n"
ELSEWHERE = "This page is not served under that name, or to other pages.\n"


class Door:
    """Lets requests in by their Host, Origin and token.

    A name that leads here by somebody else's DNS, a foreign page that opens a websocket, and a program that
    has not seen the address stay outside.

    Parameters
    ----------
    host
        Where the page is served: this name, "localhost" and any number address may be asked for.
    """

    def __init__(self, host: str) -> None:
        self.host, self.token = host, secrets.token_urlsafe(LENGTH)

    def judge(self, path: str, headers: Any) -> tuple[HTTPStatus, str]:
        """Return how a request is answered, and what is said to one that is refused."""
        host, origin = headers.get("Host", ""), headers.get("Origin")
        if not self._named(host):
            return HTTPStatus.FORBIDDEN, ELSEWHERE
        if origin is not None and urlsplit(origin).netloc != host:
            return HTTPStatus.FORBIDDEN, ELSEWHERE
        opens = headers.get("Upgrade", "").lower() == "websocket" or urlsplit(path).path == "/"
        if opens and not (self.knows(path) or self._remembers(headers.get("Cookie", ""), host)):
            return HTTPStatus.FORBIDDEN, STRANGER
        return HTTPStatus.OK, ""

    def knows(self, path: str) -> bool:
        """Return whether the token is in the address."""
        return any(self._right(given) for given in parse_qs(urlsplit(path).query).get(WORD, []))

    def cookie(self, host: str) -> str:
        """Return what a browser keeps, for the page's own requests alone."""
        return f"{_cookie_name(host)}={self.token}; Path=/; HttpOnly; SameSite=Strict"

    def _named(self, host: str) -> bool:
        """Return whether this computer may be meant by a Host."""
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        if name in ("localhost", self.host.lower()):
            return True
        try:
            ipaddress.ip_address(name)
        except ValueError:
            return False
        return True

    def _remembers(self, cookies: str, host: str) -> bool:
        """Return whether the token is among a browser's cookies."""
        try:
            kept = SimpleCookie(cookies).get(_cookie_name(host))
        except CookieError:
            return False
        return kept is not None and self._right(kept.value)

    def _right(self, given: str) -> bool:
        """Return whether a token is this page's."""
        return hmac.compare_digest(given.encode(), self.token.encode())


def _cookie_name(host: str) -> str:
    """Return a name by port: browsers share cookies between the ports of a host."""
    return f"surefoot-{host.rpartition(':')[2] if ':' in host else '80'}"


@contextmanager
def guard_server(door: Door) -> Iterator[None]:
    """Let the server that viser starts inside ask a door before it answers: viser has no hook for that."""
    from websockets.asyncio import server
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    original: Any = server.serve

    def serve(*args: Any, process_request: Callable[..., Any] | None = None, **more: Any) -> Any:
        def ask(connection: Any, request: Any) -> Any:
            status, said = door.judge(request.path, request.headers)
            if status is not HTTPStatus.OK:
                body = said.encode()
                headers = Headers({"Content-Type": "text/plain", "Content-Length": str(len(body))})
                return Response(status, status.phrase, headers, body)
            answer = None if process_request is None else process_request(connection, request)
            if isinstance(answer, Response):
                dress_answer(answer)
            if isinstance(answer, Response) and door.knows(request.path):
                answer.headers["Set-Cookie"] = door.cookie(request.headers["Host"])
            return answer

        return original(*args, process_request=ask, **more)

    server.serve = serve
    try:
        yield
    finally:
        server.serve = original
