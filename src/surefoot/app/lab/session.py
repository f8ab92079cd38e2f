"""One viewer's page at work: what the browser sends goes to the page, its drawing goes to the browser.

Viser calls back from threads of its own. A callback only puts what came into a queue; one thread per
viewer empties the queue, asks the page for a drawing and shows it. So a page needs no locks, moves of the
mouse that come faster than drawings are taken together, and no error reaches viser.
"""

from __future__ import annotations

import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any

import numpy as np

from surefoot.app.lab.canvas import Canvas
from surefoot.app.lab.controls import Button, Checkbox, Choice, Control, Slider
from surefoot.app.lab.html_text import paragraph, refusal, text
from surefoot.app.lab.page import Grip, Page
from surefoot.base.errors import SurefootError, one_line

RATE = 60.0
"""Most drawings per second."""
LIVE_RATE = 30.0
"""Drawings per second of a page that changes by itself."""
LONGEST_QUEUE = 1000
"""What a browser sends beyond this is dropped."""
LOWEST_EYE = 0.05
"""Of the viewer's eye [m]."""
STARTING = "Starting: on a first run it compiles, about 20 s."
LONGEST_LINE = 300
"""Characters of a message."""

_Event = tuple[str, str, Any]
"""What the browser sent: "change", "press" or "grip"; the name; the value."""


class Session:
    """Connects one viewer with one page.

    Parameters
    ----------
    client
        Viser's handle of the viewer.
    make_page
        Makes the page that it sees; until it is made, which may take a compiler's time, the browser says so.

    Attributes
    ----------
    draws
        How many drawings have been shown.
    message
        The last thing that was refused; empty if nothing was since.
    """

    page: Page

    def __init__(self, client: Any, make_page: Callable[[], Page]) -> None:
        self.client, self._make_page = client, make_page
        self.draws, self.message = 0, ""
        self._queue: deque[_Event] = deque()
        self._lock, self._wake, self._ended = threading.Lock(), threading.Event(), threading.Event()
        self._handles: dict[str, Any] = {}
        self._canvas = Canvas(client.scene, self._hold)
        self._message = client.gui.add_html(text(paragraph(STARTING)))
        self._thread = threading.Thread(target=self._work, name=f"lab-{client.client_id}", daemon=True)
        self._thread.start()

    def queue(self, kind: str, name: str, value: Any = None) -> None:
        """Take what the browser sent: a change of a control, a press or a grip; any thread may call."""
        event = kind, name, value
        with self._lock:
            last = self._queue[-1] if self._queue else None
            if last is not None and last[:2] == event[:2] and _is_move(last) and _is_move(event):
                self._queue[-1] = event
            elif len(self._queue) < LONGEST_QUEUE:
                self._queue.append(event)
        self._wake.set()

    def close(self) -> None:
        """End the session: the viewer has gone."""
        self._ended.set()
        self._wake.set()
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout=2.0)

    # the panel

    def _add_panel(self) -> None:
        """Add text, figure, message and controls."""
        gui = self.client.gui
        gui.add_markdown(f"## {self.page.title}\n{self.page.about}")
        self._message.remove()
        self._message = gui.add_html("", visible=False)
        self._text = gui.add_html("")
        self._figure = gui.add_html("", visible=False)
        folders: dict[str, Any] = {}
        for control in self.page.values.controls:
            if control.folder and control.folder not in folders:
                folders[control.folder] = gui.add_folder(control.folder, expand_by_default=not folders)
            with folders[control.folder] if control.folder else nullcontext():
                self._handles[control.name] = self._add_control(gui, control)

    def _add_control(self, gui: Any, control: Control) -> Any:
        """Add one control and listen to it."""
        handle = _ADDERS[type(control)](gui, control)
        if isinstance(control, Button):
            handle.on_click(self._listener("press", control.name, lambda event: None))
        else:
            handle.on_update(self._listener("change", control.name, lambda event: event.target.value))
        return handle

    def _listener(self, kind: str, name: str, value: Callable[[Any], Any]) -> Callable[[Any], Any]:
        """Return a callback for viser that queues an event; those of our own making are left out."""

        async def listen(event: Any) -> None:
            if event.client is None:
                return
            try:
                self.queue(kind, name, value(event))
            except SurefootError as error:
                self._refuse(error)

        return listen

    def _hold(self, name: str, handle: Any) -> None:
        """Listen to the mouse on a shape."""

        def moved(event: Any) -> Grip:
            start, point = np.array(event.start_position), np.array(event.end_position)
            return Grip(name, event.phase, start, point, np.array(event.client.camera.position))

        def clicked(event: Any) -> Grip:
            eye, way = np.array(event.ray_origin), np.array(event.ray_direction)
            return Grip(name, "click", eye + way, eye + way, eye)

        handle.on_drag("left")(self._listener("grip", name, moved))
        handle.on_click(self._listener("grip", name, clicked))

    # the work

    def _begin(self) -> bool:
        """Make the page, its panel and its view; tell whether that went well."""
        try:
            self.page = self._make_page()
        except Exception as error:
            self._refuse(error)
            return False
        camera = self.client.camera
        camera.position, camera.look_at = self.page.eye, self.page.look_at
        camera.on_update(_stay_above)
        self._add_panel()
        return True

    def _work(self) -> None:
        """Take what came, draw, show; until the viewer goes."""
        if not self._begin():
            return
        while not self._ended.is_set():
            begin = time.perf_counter()
            self._wake.clear()
            self._guard(self._take_all)
            self._guard(self._draw)
            live = self.page.live
            self._ended.wait(max(0.0, begin + 1.0 / (LIVE_RATE if live else RATE) - time.perf_counter()))
            if not live:
                self._wake.wait()

    def _take_all(self) -> None:
        """Hand the page what came, one by one."""
        while True:
            with self._lock:
                if not self._queue:
                    return
                kind, name, value = self._queue.popleft()
            self._guard(lambda: self._take(kind, name, value))  # noqa: B023 - called at once

    def _take(self, kind: str, name: str, value: Any) -> None:
        """Hand the page one thing."""
        self._say("")
        arguments = {"change": (name, value), "press": (name,), "grip": (value,)}[kind]
        getattr(self.page, kind)(*arguments)

    def _draw(self) -> None:
        """Show what the page says now."""
        drawing = self.page.drawing()
        if self._ended.is_set():
            return
        with self.client.atomic():
            self._canvas.show(drawing.shapes)
            self._text.content = drawing.text
            if drawing.figure:
                self._figure.content = drawing.figure
            self._figure.visible = bool(drawing.figure)
            self._show_values()
        self.client.flush()
        self.draws += 1

    def _show_values(self) -> None:
        """Set the controls to what the page holds, and back from what it refused."""
        with self._lock:
            waiting = {name for kind, name, _ in self._queue if kind == "change"}
        for name in self.page.values:
            handle = self._handles[name]
            if name not in waiting and handle.value != self.page.values[name]:
                handle.value = self.page.values[name]

    def _guard(self, action: Callable[[], None]) -> None:
        """Carry out an action; what goes wrong is one line on the page."""
        try:
            action()
        except Exception as error:  # whatever a browser provokes must not end the session
            self._refuse(error)

    def _refuse(self, error: Exception) -> None:
        """Show an error; one that is no user's goes to the terminal, too."""
        line = one_line(error)[:LONGEST_LINE]
        if not isinstance(error, SurefootError):
            line = f"{type(error).__name__}: {line}"
            if not self._ended.is_set():
                print(f"surefoot lab: {line}", file=sys.stderr)
        self._say(line)

    def _say(self, line: str) -> None:
        """Show a line above the text; nothing for an empty one."""
        if line == self.message or self._ended.is_set():
            return
        self.message = line
        self._message.content = refusal(line)
        self._message.visible = bool(line)


async def _stay_above(camera: Any) -> None:
    """Keep a viewer's eye above the ground."""
    x, y, z = (float(part) for part in camera.position)
    if z < LOWEST_EYE:
        camera.position = (x, y, LOWEST_EYE)


def _is_move(event: _Event) -> bool:
    """Tell whether the next event of this kind and name stands for this one, too."""
    return event[0] == "change" or (event[0] == "grip" and event[2].phase == "update")


_ADDERS: dict[type[Control], Callable[[Any, Any], Any]] = {
    Slider: lambda gui, c: gui.add_slider(c.label, c.low, c.high, c.step, c.value, hint=c.hint or None),
    Choice: lambda gui, c: gui.add_dropdown(c.label, c.options, initial_value=c.value),
    Checkbox: lambda gui, c: gui.add_checkbox(c.label, c.value),
    Button: lambda gui, c: gui.add_button(c.label),
}
