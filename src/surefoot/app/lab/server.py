"""The server of a page: viser on one port, a session for every viewer, and no way out to the internet."""

from __future__ import annotations

import contextlib
import errno
import io
import logging
import socket
import sys
import threading
import warnings
from collections.abc import Callable
from typing import Any

from surefoot.app.lab.door import WORD, Door, guard_server
from surefoot.app.lab.page import Page
from surefoot.app.lab.session import Session
from surefoot.base.errors import ProblemError, needs

LOCAL = "127.0.0.1"
"""Where the page is served unless a host is given: to this machine alone."""
MOST_VIEWERS = 16
"""Viewers at a time; each is a thread."""
GOODBYE = 5.0
"""How long the server may take to say goodbye to its viewers [s]."""


class LabServer:
    """Serves a page until it is stopped.

    Parameters
    ----------
    make_page
        Called for every viewer: each has a page, and so a state, of its own.
    host, port
        Where; port 0 takes a free one.

    Attributes
    ----------
    url, home
        For the browser, with the token that lets it in; and without.
    port
        That it has.
    sessions
        By viser's number of the viewer.

    Raises
    ------
    MissingExtra
        If viser is not installed.
    ProblemError
        For a host or a port that cannot be had.
    """

    def __init__(self, make_page: Callable[[], Page], host: str = LOCAL, port: int = 8080) -> None:
        with needs("viser", "lab"):
            import viser
        check_free(host, port)
        self._make_page = make_page
        self.sessions: dict[int, Session] = {}
        self._lock = threading.Lock()
        self._silence = contextlib.ExitStack()
        self._silence.enter_context(warnings.catch_warnings())
        warnings.filterwarnings("ignore", message="Queued a .* on a closed connection")
        door = Door(host)
        # viser greets and has no switch for that
        with contextlib.redirect_stdout(io.StringIO()), guard_server(door):
            self._server = viser.ViserServer(host=host, port=port, verbose=False)
        self.port = int(self._server.get_port())
        if port not in (0, self.port):  # taken between our look and viser's; it moves on silently
            self.stop()
            raise ProblemError(_in_use(host, port))
        self.home = f"http://{f'[{host}]' if ':' in host else host}:{self.port}"
        self.url = f"{self.home}/?{WORD}={door.token}"
        self._set_up()

    def _set_up(self) -> None:
        """Prepare scene and panel, close viser's door to the internet, and let viewers in."""
        server = self._server
        _keep_local(server)
        server.get_event_loop().set_exception_handler(_one_line)
        logging.getLogger("websockets.server").setLevel(logging.CRITICAL)
        server.gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        server.gui.main_panel.dock_right()  # beside the scene
        server.gui.set_panel_label("Surefoot lab")
        server.scene.world_axes.visible = False
        server.scene.configure_default_lights(cast_shadow=False)
        server.initial_camera.fov = 0.8
        server.on_client_connect(self._enter)
        server.on_client_disconnect(self._leave)

    def _enter(self, client: Any) -> None:
        """Begin a viewer's session."""
        with self._lock:
            if len(self.sessions) >= MOST_VIEWERS:
                client.gui.add_markdown(
                    f"**{MOST_VIEWERS} viewers are here already.** Close a page elsewhere."
                )
                return
            self.sessions[client.client_id] = Session(client, self._make_page)

    def _leave(self, client: Any) -> None:
        """End a viewer's session."""
        with self._lock:
            session = self.sessions.pop(client.client_id, None)
        if session is not None:
            session.close()

    def wait(self, seconds: float | None = None) -> None:
        """Return after so many seconds; None for never, until Ctrl-C."""
        threading.Event().wait(seconds)

    def stop(self) -> None:
        """End all sessions and the server."""
        with self._lock:
            sessions, self.sessions = list(self.sessions.values()), {}
        for session in sessions:
            session.close()
        with contextlib.redirect_stdout(io.StringIO()):
            self._server.stop()
            self._server._websock_server._server_thread.join(timeout=GOODBYE)
        self._silence.close()

    def __enter__(self) -> LabServer:
        return self

    def __exit__(self, *error: object) -> None:
        self.stop()


def check_free(host: str, port: int) -> None:
    """Raise `ProblemError` unless a server can listen there.

    Viser would take the next free port without a word, and wait for ever where a host is none of this
    machine's.
    """
    if not 0 <= port <= 65535:
        raise ProblemError(f"--port must be from 0 to 65535, got {port}")
    try:
        family, kind, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, kind) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(address)
    except (OSError, UnicodeError) as error:
        number = getattr(error, "errno", None)
        if number == errno.EADDRINUSE:
            raise ProblemError(_in_use(host, port)) from error
        if number == errno.EACCES:
            raise ProblemError(
                f"port {port} needs rights that you do not have; take one above 1023"
            ) from error
        raise ProblemError(f"--host {host!r} is no address of this machine") from error


def _in_use(host: str, port: int) -> str:
    return f"port {port} of {host} is in use; choose another with --port, or 0 for any"


def _keep_local(server: Any) -> None:
    """Let no page ask viser to open its tunnel to the internet."""
    from viser import _messages

    handlers = server._websock_server._incoming_handlers
    for name in ("ShareUrlRequest", "ShareUrlDisconnect"):
        handlers.pop(getattr(_messages, name, None), None)


def _one_line(loop: Any, context: dict[str, Any]) -> None:
    """Print a message that viser could not take, as one line."""
    error = context.get("exception")
    said = " ".join(str(error or context.get("message", "")).split())[:200]
    print(f"surefoot lab: dropped what a browser sent: {type(error).__name__}: {said}", file=sys.stderr)
