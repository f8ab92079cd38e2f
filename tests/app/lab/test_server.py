"""Pages over the wire: real events reach them, nothing that a browser sends ends them, viewers are apart."""

from __future__ import annotations

import threading
import time
import urllib.request
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser", reason="viser is not installed: pip install -e '.[lab]'")

import surefoot as sf
from surefoot.app.lab.cone import ConePage
from surefoot.app.lab.drawing import Drawing
from surefoot.app.lab.server import MOST_VIEWERS, LabServer
from surefoot.app.lab.session import LONGEST_QUEUE
from surefoot.app.lab.stand import StandPage, StandState, start_state
from tests.app.lab.lab_client import EYE, LabClient


@pytest.fixture(scope="module")
def state() -> StandState:
    return start_state(sf.load_robot("go2"))


@pytest.fixture
def server(state: StandState) -> Iterator[LabServer]:
    with LabServer(lambda: StandPage(state), port=0) as running:
        yield running


@pytest.fixture
def client(server: LabServer) -> Iterator[LabClient]:
    with LabClient(server.url) as viewer:
        viewer.wait(lambda: "It can stand" in viewer.text)
        yield viewer


def page_of(server: LabServer, k: int = 0) -> Any:
    return list(server.sessions.values())[k].page


def test_the_page_itself_comes_from_this_machine(server: LabServer) -> None:
    assert server._server._websock_server._host == "127.0.0.1"
    page = urllib.request.urlopen(server.url, timeout=10).read().decode()
    assert "<html" in page
    assert 'src="http' not in page
    assert 'href="http' not in page


def test_a_slider_changes_the_verdict(server: LabServer, client: LabClient) -> None:
    client.change("x [m]", 0.5)
    client.wait(lambda: "It cannot stand" in client.text)
    assert page_of(server).state.com[0] == 0.5
    client.change("begin anew", True)
    client.wait(lambda: "It can stand" in client.text)
    client.wait(lambda: abs(client.control("x [m]")["value"]) < 0.1, "the slider's way back")


def test_the_mouse_drags_the_centre_of_mass(server: LabServer, client: LabClient, state: StandState) -> None:
    eye = np.array(EYE)
    wanted = np.array([0.1, 0.05, state.com[2]])
    client.drag("/com", "start", state.com, state.com)
    client.drag("/com", "update", state.com, eye + 0.8 * (wanted - eye))
    client.wait(lambda: abs(client.control("x [m]")["value"] - 0.1) < 1e-6, "the slider that follows")
    np.testing.assert_allclose(page_of(server).state.com, wanted, atol=1e-9)
    client.drag("/feet/FL_foot", "update", wanted, [0.5, 0.4, 0.0])
    client.wait(lambda: abs(page_of(server).state.feet[0] - [0.5, 0.4]).max() < 1e-6)


@pytest.mark.parametrize("value", [float("nan"), -7.0, 1e300])
def test_a_value_that_cannot_be_is_told_and_taken_back(client: LabClient, value: float) -> None:
    client.change("friction", value)
    client.wait(lambda: "Refused: friction must be" in client.text)
    client.wait(lambda: client.control("friction")["value"] == 0.6, "the slider's way back")
    client.change("friction", 0.5)
    client.wait(lambda: "Refused" not in client.text)


HOSTILE: list[tuple[str, dict[str, Any]]] = [
    ("GuiUpdateMessage", {"uuid": "nobody", "updates": {"value": 1}}),
    ("GuiUpdateMessage", {"uuid": 3, "updates": []}),
    ("SceneNodeDragMessage", {"name": "/com"}),
    ("TransformControlsUpdateMessage", {"name": "/com", "wxyz": [], "position": []}),
    ("ViewerCameraMessage", {"position": "here"}),
    ("NoSuchMessage", {}),
    ("RunJavascriptMessage", {"source": "alert(1)"}),
    ("FileTransferStartUpload", {"source_component_uuid": "x", "transfer_uuid": "x"}),
]


@pytest.mark.parametrize(
    ("kind", "fields"), HOSTILE, ids=[f"{k}. {kind}" for k, (kind, _) in enumerate(HOSTILE)]
)
def test_messages_that_are_none_end_nothing(server: LabServer, kind: str, fields: dict[str, Any]) -> None:
    with LabClient(server.url) as hostile:
        hostile.wait(lambda: "It can stand" in hostile.text)
        hostile.say(kind, **fields)
        time.sleep(0.1)
    with LabClient(server.url) as other:
        other.wait(lambda: "It can stand" in other.text)
        other.change("x [m]", 0.5)
        other.wait(lambda: "It cannot stand" in other.text)


@pytest.mark.parametrize("raw", [b"", b"\x93", b"\xff" * 1000, "text", b"\x81\xa4type\x01"])
def test_bytes_that_are_no_message_end_nothing(server: LabServer, raw: bytes | str) -> None:
    with LabClient(server.url) as hostile:
        hostile.send(raw)
    with LabClient(server.url) as other:
        other.wait(lambda: "It can stand" in other.text)


@pytest.mark.parametrize("value", ["0.4", [1, 2], None, {"a": 1}, True])
def test_values_of_another_kind_end_nothing(client: LabClient, value: Any) -> None:
    client.change("friction", value)
    client.change("x [m]", 0.5)
    client.wait(lambda: "It cannot stand" in client.text)


def test_two_viewers_have_their_own_pages(server: LabServer, client: LabClient) -> None:
    with LabClient(server.url) as other:
        other.wait(lambda: "It can stand" in other.text)
        other.change("x [m]", 0.5)
        other.wait(lambda: "It cannot stand" in other.text)
        client.change("y [m]", 0.01)
        client.wait(lambda: page_of(server).state.com[1] == 0.01)
        assert "It can stand" in client.text
        assert page_of(server).state.com[0] < 0.1
        assert page_of(server, 1).state.com[0] == 0.5


def test_a_viewer_who_goes_is_forgotten(server: LabServer) -> None:
    with LabClient(server.url) as viewer:
        viewer.wait(lambda: "It can stand" in viewer.text)
        (session,) = server.sessions.values()
    patience = time.monotonic() + 10.0
    while server.sessions or session._thread.is_alive():
        assert time.monotonic() < patience
        time.sleep(0.02)


def test_no_page_can_open_a_tunnel_to_the_internet(
    server: LabServer, client: LabClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = threading.Event()
    monkeypatch.setattr(type(server._server), "request_share_url", lambda *_, **__: asked.set())
    client.say("ShareUrlRequest")
    assert not asked.wait(0.5)


def test_moves_that_come_faster_than_drawings_are_taken_together(
    server: LabServer, client: LabClient
) -> None:
    (session,) = server.sessions.values()
    before = session.draws
    for k in range(2000):
        client.change("x [m]", round(-0.1 + 1e-4 * k, 4))
    client.wait(lambda: page_of(server).state.com[0] == pytest.approx(0.0999))
    assert session.draws - before < 1000
    assert len(session._queue) <= LONGEST_QUEUE


class BrokenPage(ConePage):
    """A page with a mistake in it."""

    def press(self, name: str) -> None:
        raise ZeroDivisionError("a mistake")

    def drawing(self) -> Drawing:
        if self.values["mu"] > 1.0:
            raise RuntimeError("two\nlines with <b>markup</b>")
        return super().drawing()


def test_a_mistake_in_a_page_is_one_line_and_no_end(capfd: pytest.CaptureFixture[str]) -> None:
    with LabServer(BrokenPage, port=0) as server, LabClient(server.url) as viewer:
        viewer.wait(lambda: "Sticks" in viewer.text)
        viewer.change("friction", 1.2)
        viewer.wait(lambda: "RuntimeError: two lines with &lt;b&gt;markup" in viewer.text)
        viewer.change("friction", 0.1)
        viewer.wait(lambda: "Slides" in viewer.text and "Refused" not in viewer.text)
    said = capfd.readouterr().err
    assert said == "surefoot lab: RuntimeError: two lines with <b>markup</b>\n"


def test_there_is_room_for_so_many_viewers() -> None:
    with LabServer(ConePage, port=0) as server:
        viewers = [LabClient(server.url) for _ in range(MOST_VIEWERS + 1)]
        for viewer in viewers:
            viewer.wait(lambda v=viewer: "Sticks" in v.text or "viewers are here already" in v.text)
        full = [viewer for viewer in viewers if "viewers are here already" in viewer.text]
        assert len(full) == 1
        for viewer in viewers:
            viewer.close()
