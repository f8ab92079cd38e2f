"""Who gets in: the page itself with its token; no foreign page or name, nobody without the address."""

from __future__ import annotations

import http.server
import socket
import threading
import time
from base64 import urlsafe_b64decode
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from types import SimpleNamespace
from typing import Any

import pytest

from surefoot.app.lab.cone import ConePage
from surefoot.app.lab.door import Door, guard_server
from surefoot.app.lab.server import LabServer
from tests.browser import Browser, find_chromium

pytest.importorskip("viser", reason="the lab is of surefoot[lab]")
UPGRADE = "Connection: Upgrade\r\nUpgrade: {}\r\nSec-WebSocket-Version: 13\r\n"
UPGRADE += "Sec-WebSocket-Key: MTIzNDU2Nzg5MDEyMzQ1Ng==\r\n"


def status_of(
    port: int, path: str = "/", *, host: str = "", upgrade: str = "websocket", **headers: str
) -> int:
    """Return the status of the answer to a request."""
    lines = "".join(f"{name}: {value}\r\n" for name, value in headers.items())
    asked = UPGRADE.format(upgrade) if upgrade else ""
    host = host or f"127.0.0.1:{port}"
    with socket.create_connection(("127.0.0.1", port), timeout=10) as wire:
        wire.sendall(f"GET {path} HTTP/1.1\r\nHost: {host}\r\n{asked}{lines}\r\n".encode())
        return int(wire.recv(4096).split()[1])


@pytest.fixture(scope="module")
def server() -> Iterator[LabServer]:
    """Return a server of a page."""
    with LabServer(ConePage, port=0) as one:
        yield one


def test_only_the_page_s_own_requests_with_its_token_open_a_websocket(server: LabServer) -> None:
    port, way = server.port, server.url.removeprefix(server.home)
    token, home = way.partition("=")[2], server.home
    assert status_of(port, way) == 101
    assert status_of(port, way, Origin=home) == 101
    assert status_of(port, Cookie=f"surefoot-{port}={token}", Origin=home) == 101
    assert status_of(port, way, host=f"localhost:{port}", Origin=f"http://localhost:{port}") == 101
    for origin in ("http://evil.example", f"http://127.0.0.1:{port + 1}", "null", f"http://localhost:{port}"):
        assert status_of(port, way, Origin=origin) == 403
        assert status_of(port, Cookie=f"surefoot-{port}={token}", Origin=origin) == 403
    for host in (
        f"evil.example:{port}",
        "evil.example",
        f"127.0.0.1.evil.example:{port}",
        "[",
        "127.0.0.1@evil.example",
    ):
        assert status_of(port, way, host=host) == 403
        assert status_of(port, way, host=host, Origin=f"http://{host}") == 403
    for way_in in ("/", "/?token=", f"/?token={token[:-1]}", f"/?other={token}"):
        for upgrade in ("websocket", "WebSocket", ""):
            assert status_of(port, way_in, upgrade=upgrade) == 403
    assert status_of(port, Cookie=f"surefoot-{port}=wrong", Origin=home) == 403
    assert status_of(port, Cookie="=;=,", Origin=home) == 403


def test_a_browser_is_given_the_token_once_and_another_server_has_another(server: LabServer) -> None:
    assert status_of(server.port, server.url.removeprefix(server.home), upgrade="") == 200
    with LabServer(ConePage, port=0) as other:
        assert other.url.partition("=")[2] != server.url.partition("=")[2]


def test_a_token_is_of_sixteen_random_bytes() -> None:
    one, other = Door("localhost").token, Door("localhost").token
    assert len(urlsafe_b64decode(one + "==")) == 16
    assert one != other
    assert Door("localhost").knows(f"/?token={one}") is False


def judge(door: Door, path: str = "/page.js", **headers: str) -> HTTPStatus:
    """Return how a request is answered that is no websocket's, by default to the door's own name."""
    return door.judge(path, {"Host": "Bench.Local:8080", **headers})[0]


def test_pages_are_served_under_the_door_s_name_and_numbers_alone() -> None:
    door = Door("Bench.Local")
    for host in ("bench.local:8080", "localhost", "LOCALHOST:1", "10.0.0.7:8080", "[::1]:8080"):
        assert judge(door, Host=host) is HTTPStatus.OK
    for host in ("", "bench.local.evil.example", "10.0.0.7.evil.example", "[::1"):
        assert judge(door, Host=host) is HTTPStatus.FORBIDDEN
    status, words = door.judge("/page.js", {})
    assert status is HTTPStatus.FORBIDDEN
    assert words.startswith("This page is not served under that name")


def test_a_page_of_another_origin_gets_nothing() -> None:
    door = Door("bench.local")
    assert judge(door, Origin="http://Bench.Local:8080") is HTTPStatus.OK
    for origin in ("", "null", "http://Bench.Local:8081", "http://evil.example"):
        assert judge(door, Origin=origin) is HTTPStatus.FORBIDDEN


def test_the_page_and_websockets_need_the_token_files_do_not() -> None:
    door = Door("bench.local")
    assert judge(door) is HTTPStatus.OK
    assert door.judge("/page.js", {"Host": "localhost"}) == (HTTPStatus.OK, "")
    for path, upgrade in (
        ("/", ""),
        ("/?other=1", ""),
        ("/page.js", "WebSocket"),
        ("/page.js?token=", "websocket"),
    ):
        status, words = door.judge(path, {"Host": "localhost", "Upgrade": upgrade})
        assert status is HTTPStatus.FORBIDDEN
        assert words.startswith("This page wants its whole address")
    assert judge(door, f"/?token={door.token}") is HTTPStatus.OK
    assert judge(door, f"/?token=x&token={door.token}", Upgrade="websocket") is HTTPStatus.OK


def test_a_browser_keeps_the_token_for_the_port_that_gave_it() -> None:
    door = Door("bench.local")
    assert door.cookie("bench.local:81") == f"surefoot-81={door.token}; Path=/; HttpOnly; SameSite=Strict"
    assert door.cookie("bench.local").startswith(f"surefoot-80={door.token};")
    right, other = f"surefoot-8080={door.token}", f"surefoot-80={door.token}"
    assert judge(door, "/", Cookie=right) is HTTPStatus.OK
    assert judge(door, "/", Cookie=f"theme=dark; {right}") is HTTPStatus.OK
    for cookie in (other, "surefoot-8080=x", "surefoot-8080=", "=;=,"):
        assert judge(door, "/", Cookie=cookie) is HTTPStatus.FORBIDDEN
    assert judge(door, "/", Cookie=other, Host="bench.local") is HTTPStatus.OK


def ask_through(door: Door, path: str, answer: Any, monkeypatch: pytest.MonkeyPatch, **headers: str) -> Any:
    """Return what a server that starts inside the guard answers; `answer` None for one without answers."""
    from websockets.asyncio import server

    started: dict[str, Any] = {}
    monkeypatch.setattr(server, "serve", lambda *given, **more: started.update(more, given=given))
    with guard_server(door):
        more = {} if answer is None else {"process_request": lambda wire, request: answer}
        server.serve("handler", "host", port=7, **more)
    assert (started["given"], started["port"]) == (("handler", "host"), 7)
    request = SimpleNamespace(path=path, headers={"Host": "localhost", **headers})
    return started["process_request"](None, request)


def page_of(kind: str = "text/html") -> Any:
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    return Response(200, "OK", Headers({"Content-Type": kind}), b"<title>Viser</title>")


def test_the_guard_answers_strangers_itself_and_dresses_pages(monkeypatch: pytest.MonkeyPatch) -> None:
    door = Door("localhost")
    refused = ask_through(door, "/", page_of(), monkeypatch)
    assert (refused.status_code, refused.reason_phrase) == (403, "Forbidden")
    assert refused.headers["Content-Type"] == "text/plain"
    assert refused.headers["Content-Length"] == str(len(refused.body))
    assert refused.body.startswith(b"This page wants its whole address")
    page = ask_through(door, f"/?token={door.token}", page_of(), monkeypatch)
    assert b"<title>Surefoot lab</title>" in page.body
    assert page.headers["Set-Cookie"] == door.cookie("localhost")
    file = ask_through(door, "/page.html", page_of(), monkeypatch)
    assert b"<title>Surefoot lab</title>" in file.body
    assert "Set-Cookie" not in file.headers
    assert ask_through(door, f"/?token={door.token}", None, monkeypatch) is None
    assert ask_through(door, f"/?token={door.token}", "other", monkeypatch) == "other"


def test_the_guard_leaves_the_server_as_it_was() -> None:
    from websockets.asyncio import server

    before = server.serve

    def fail_inside() -> None:
        with guard_server(Door("localhost")):
            assert server.serve is not before
            raise RuntimeError("no page")

    with pytest.raises(RuntimeError, match="no page"):
        fail_inside()
    assert server.serve is before


HOSTILE = """<script>
const wire = new WebSocket("ws://127.0.0.1:%d/", "viser-v1.1.0");
window.said = "";
wire.onopen = () => window.said = "open"; wire.onerror = () => window.said = "refused";
</script>"""


@contextmanager
def hostile_page(port: int) -> Iterator[str]:
    """Serve a page that opens a websocket to another port."""

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write((HOSTILE % port).encode())

        def log_message(self, *_: object) -> None:
            """Say nothing."""

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as page:
        threading.Thread(target=page.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{page.server_port}/"
        page.shutdown()


@pytest.mark.long
@pytest.mark.skipif(find_chromium() is None, reason="no Chromium is installed")
def test_a_hostile_page_in_the_same_browser_is_refused(server: LabServer) -> None:
    program = find_chromium()
    assert program is not None
    with Browser(program) as browser, hostile_page(server.port) as address:
        own = browser.open(server.url)
        own.wait_for("document.querySelectorAll('canvas').length > 0")
        end = time.monotonic() + 30.0
        while not server.sessions and time.monotonic() < end:  # its canvas is there before its websocket
            time.sleep(0.05)
        assert server.sessions
        before = len(server.sessions)
        tab = browser.open(address)
        assert tab.wait_for("window.said") == "refused"
        assert len(server.sessions) <= before  # a page that is hidden may leave
