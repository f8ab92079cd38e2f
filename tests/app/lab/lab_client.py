"""A browser's part of the lab's wire, without a browser: it hears what pages send and speaks for a mouse.

It speaks viser's protocol: messages are msgpack, those from the server compressed by zstd in windows with
arrays behind them.
"""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

EYE = (1.3, -1.3, 0.9)
"""Where the camera is said to be [m]."""


class LabClient:
    """A viewer of a page.

    Parameters
    ----------
    url
        Of the page, http://...

    Attributes
    ----------
    controls
        The last message for each control, text and figure, by viser's identifier.
    nodes
        The last message that made each shape, by name.
    heard
        How many messages of each type came.
    windows
        How many windows of messages came.
    """

    def __init__(self, url: str) -> None:
        import viser
        from websockets.sync.client import connect
        from websockets.typing import Subprotocol

        self.controls: dict[str, dict[str, Any]] = {}
        self.nodes: dict[str, dict[str, Any]] = {}
        self.heard: Counter[str] = Counter()
        self.windows = 0
        protocol = Subprotocol(f"viser-v{viser.__version__}")
        self._socket = connect(
            url.replace("http", "ws", 1), subprotocols=[protocol], max_size=None, compression=None
        )
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()
        self.camera()

    def _listen(self) -> None:
        """Keep what the server says."""
        import msgspec
        import zstandard
        from websockets.exceptions import ConnectionClosed

        decompress = zstandard.ZstdDecompressor()
        while True:
            try:
                raw = self._socket.recv()
            except ConnectionClosed:
                return
            assert isinstance(raw, bytes)
            size, packed = int.from_bytes(raw[:8], "little"), int.from_bytes(raw[8:16], "little")
            said = msgspec.msgpack.decode(decompress.decompress(raw[16 : 16 + packed], max_output_size=size))
            for message in said["messages"]:
                self._take(message)
            self.windows += 1

    def _take(self, message: dict[str, Any]) -> None:
        """Keep one message."""
        kind = message["type"]
        self.heard[kind] += 1
        if kind == "GuiUpdateMessage":
            control = self.controls.get(message["uuid"])
            if control is not None:
                for name, value in message["updates"].items():
                    (control if name == "value" else control["props"])[name] = value
        elif kind.startswith("Gui") and "props" in message:
            self.controls[message["uuid"]] = message
        elif kind == "SceneNodeUpdateMessage" and message["name"] in self.nodes:
            self.nodes[message["name"]]["props"].update(message["updates"])
        elif "props" in message and "name" in message:
            self.nodes[message["name"]] = message

    def say(self, kind: str, **fields: Any) -> None:
        """Send a message."""
        import msgspec

        self.send(msgspec.msgpack.encode({"type": kind, **fields}))

    def send(self, raw: bytes | str) -> None:
        """Send whatever."""
        self._socket.send(raw)

    def camera(self, position: tuple[float, float, float] = EYE) -> None:
        """Tell where the camera is: the first time this makes a viewer of the connection."""
        self.say(
            "ViewerCameraMessage", wxyz=(1.0, 0.0, 0.0, 0.0), position=position, fov=0.8, near=0.01, far=1e3,
            image_height=720, image_width=1280, look_at=(0.0, 0.0, 0.15), up_direction=(0.0, 0.0, 1.0),
        )  # fmt: skip

    def control(self, label: str) -> dict[str, Any]:
        """Return the control with a label, as soon as it is there."""

        def found() -> Any:
            return next((c for c in list(self.controls.values()) if c["props"].get("label") == label), None)

        return dict(self.wait(found, f"the control {label!r}"))

    def change(self, label: str, value: Any) -> None:
        """Move a slider, choose, tick; press for a button with the value True."""
        self.say("GuiUpdateMessage", uuid=self.control(label)["uuid"], updates={"value": value})

    def drag(self, name: str, phase: str, start: Any, point: Any) -> None:
        """Take a shape with the mouse, move it, or let it go."""
        owner = self.wait(lambda: self.nodes.get(name), f"the shape {name}").get("owner", "")
        self.say(
            "SceneNodeDragMessage", phase=phase, name=name, instance_index=None, owner=owner,
            start_position=[float(x) for x in start], end_position=[float(x) for x in point],
            start_screen_pos=(0.5, 0.5), end_screen_pos=(0.5, 0.5), button="left", modifier=None,
        )  # fmt: skip

    @property
    def text(self) -> str:
        """All the texts of the page that can be seen, and its figures."""
        shown = [c["props"] for c in list(self.controls.values()) if c["props"].get("visible", True)]
        return "\n".join(p.get("_markdown") or p.get("content") or "" for p in shown)

    def wait(self, look: Callable[[], Any], what: str = "it", seconds: float = 60.0) -> Any:
        """Return what a function finds, as soon as it is truthy."""
        patience = time.monotonic() + seconds
        while not (found := look()):
            if time.monotonic() > patience:
                raise TimeoutError(f"{what} never came; the page says: {self.text[:500]}")
            time.sleep(0.01)
        return found

    def close(self) -> None:
        """Go away."""
        self._socket.close()
        self._thread.join(timeout=5.0)

    def __enter__(self) -> LabClient:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()
