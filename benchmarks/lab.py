"""How many updates a second the lab's pages make: computed, sent to a viewer, and shown by a real browser."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.browser import Browser, Tab
from benchmarks.lab_client import LabClient
from surefoot.arrays import FloatArray
from surefoot.lab.cone import SCALE, ConePage
from surefoot.lab.page import Grip, Page
from surefoot.lab.server import LabServer
from surefoot.lab.session import Session
from surefoot.lab.stand import StandPage, start_state
from surefoot.robot import load_robot

RATE = 60.0
"""Moves of the mouse per second."""
WANTED = 30.0
"""Updates per second that a static page should make."""


@dataclass(frozen=True)
class Case:
    """A page with what is dragged in it.

    Attributes
    ----------
    name
        Of the page.
    make
        Returns a page.
    shape
        That is dragged, at a (3,) place `at` [m].
    reach
        How far it is dragged to either side [m].
    """

    name: str
    make: Callable[[], Page]
    shape: str
    at: FloatArray
    reach: float

    def aside(self, share: float) -> FloatArray:
        """Return the (3,) place at a share of the reach along x [m]."""
        return np.asarray(self.at + np.array([share * self.reach, 0.0, 0.0]))


@dataclass(frozen=True)
class Rates:
    """What a page reached.

    Attributes
    ----------
    name
        Of the page.
    computing
        CPU time of an update without any browser [s].
    sent
        Updates per second that reached a viewer over the wire while the mouse moved `RATE` times a second.
    handled
        CPU time of the server and that viewer together for one of those [s].
    browser
        Updates per second while Chromium's mouse moved; not a number without Chromium.
    frames
        Pictures that Chromium drew in a second meanwhile.
    """

    name: str
    computing: float
    sent: float
    handled: float
    browser: float = float("nan")
    frames: float = float("nan")


def cases() -> list[Case]:
    """Return the static pages."""
    state = start_state(load_robot("go2"))
    tip = SCALE * np.array([35.0, 20.0, 80.0])
    return [
        Case("stand", lambda: StandPage(state), "/com", state.com, 0.15),
        Case("cone", ConePage, "/tip", tip, 0.3),
    ]


def measure(case: Case, seconds: float, program: str | None = None) -> Rates:
    """Return the rates of a page, each measured for so many seconds [s]; `program` is a Chromium."""
    computing = time_computing(case, seconds)
    with LabServer(case.make, port=0) as server:
        sent, handled = over_the_wire(case, server, seconds)
    if program is None:
        return Rates(case.name, computing, sent, handled)
    with LabServer(case.make, port=0) as server, Browser(program) as browser:
        shown, frames = in_the_browser(case, server, browser.open(server.url), seconds)
    return Rates(case.name, computing, sent, handled, shown, frames)


def time_computing(case: Case, seconds: float) -> float:
    """Return the CPU time of a move of the mouse and the drawing after it [s]."""
    page, eye = case.make(), np.array([1.3, -1.3, 0.9])
    page.drawing()
    begin, count = time.process_time(), 0
    while time.process_time() - begin < seconds:
        point = case.aside(math.sin(0.1 * count))
        page.grip(Grip(case.shape, "update", point, point, eye))
        page.drawing()
        count += 1
    return (time.process_time() - begin) / count


def over_the_wire(case: Case, server: LabServer, seconds: float) -> tuple[float, float]:
    """Return updates per second that reach a viewer who moves the mouse, and the CPU time of each [s]."""
    with LabClient(server.url) as client:
        session = settled(server)
        client.drag(case.shape, "start", case.at, case.at)
        count, moves = session.draws, int(seconds * RATE)
        windows, begin, cpu = client.windows, time.monotonic(), time.process_time()
        for k in range(1, moves + 1):
            point = case.aside(math.sin(2.0 * math.pi * k / RATE))
            client.drag(case.shape, "update", case.at, point)
            time.sleep(max(0.0, begin + k / RATE - time.monotonic()))
        took = time.monotonic() - begin
        made = min(session.draws - count, client.windows - windows)
        return made / took, (time.process_time() - cpu) / max(made, 1)


def in_the_browser(case: Case, server: LabServer, tab: Tab, seconds: float) -> tuple[float, float]:
    """Return updates per second while Chromium's mouse drags, and the pictures per second that it drew."""
    session = settled(server, seconds=60.0)
    tab.wait_for("document.querySelector('canvas') !== null")
    time.sleep(1.0)
    middle = pixel(tab, session, case.at)
    side = pixel(tab, session, case.aside(1.0))
    wave = [math.sin(2.0 * math.pi * k / RATE) for k in range(int(seconds * RATE))]
    path = [(middle[0] + s * (side[0] - middle[0]), middle[1] + s * (side[1] - middle[1])) for s in wave]
    tab.ask("window.drawn = 0, (function count() { window.drawn++; requestAnimationFrame(count); })(), 0")
    count = session.draws
    took = tab.drag(path, RATE)
    return (session.draws - count) / took, float(tab.ask("window.drawn")) / took


def settled(server: LabServer, seconds: float = 20.0) -> Session:
    """Return the first viewer's session as soon as it has drawn."""
    patience = time.monotonic() + seconds
    while not (server.sessions and next(iter(server.sessions.values())).draws):
        if time.monotonic() > patience:
            raise TimeoutError("no viewer has come")
        time.sleep(0.02)
    return next(iter(server.sessions.values()))


def pixel(tab: Tab, session: Session, place: FloatArray) -> tuple[float, float]:
    """Return where a (3,) place [m] is in the window of the browser [pixels]."""
    camera = session.client.camera
    forward = np.asarray(camera.look_at) - camera.position
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, camera.up_direction)
    right = right / np.linalg.norm(right)
    ray = np.asarray(place) - camera.position
    ahead, across, up = float(ray @ forward), float(ray @ right), float(ray @ np.cross(right, forward))
    box = tab.ask(
        "(() => { const b = document.querySelector('canvas').getBoundingClientRect();"
        " return [b.left, b.top, b.width, b.height]; })()"
    )
    scale = 0.5 * box[3] / math.tan(0.5 * float(camera.fov)) / ahead
    return box[0] + 0.5 * box[2] + scale * across, box[1] + 0.5 * box[3] - scale * up
