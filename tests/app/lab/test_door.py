"""Who gets in: the page itself with its token; no foreign page or name, nobody without the address."""

from __future__ import annotations

import http.server
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from surefoot.app.lab.cone import ConePage
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
