"""The pages in a real Chromium without a screen: drawn, their controls moved, without a network.

Set SUREFOOT_CHROMIUM to its path where it is not on the PATH. With SUREFOOT_SCREENSHOTS a folder, the
pictures stay there to be looked at.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("viser", reason="viser is not installed: pip install -e '.[lab]'")

import surefoot as sf
from benchmarks.problems.logged_runs import CleanRun
from surefoot.app.lab.cone import ConePage
from surefoot.app.lab.controls import Button, Checkbox, Choice, Control, Slider
from surefoot.app.lab.page import Page
from surefoot.app.lab.push import PushPage
from surefoot.app.lab.push_run import WalkRun
from surefoot.app.lab.recording import RecordedMotion, audit_page, plan_page
from surefoot.app.lab.server import LabServer
from surefoot.app.lab.session import Session
from surefoot.app.lab.stand import StandPage, start_state
from surefoot.records.audit import audit_log
from tests.browser import Browser, Tab, find_chromium

CHROMIUM = find_chromium()
pytestmark = pytest.mark.skipif(
    CHROMIUM is None, reason="no Chromium: apt-get install chromium, or set SUREFOOT_CHROMIUM"
)
PATIENCE = 180.0
"""How long a loaded machine may take to draw in software [s]."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    wanted = os.environ.get("SUREFOOT_SCREENSHOTS")
    return Path(wanted) if wanted else tmp_path


def settled(server: LabServer, seconds: float = 20.0) -> Session:
    """Return the first viewer's session as soon as it has drawn."""
    patience = time.monotonic() + seconds
    while not (server.sessions and next(iter(server.sessions.values())).draws):
        if time.monotonic() > patience:
            raise TimeoutError("no viewer has come")
        time.sleep(0.02)
    return next(iter(server.sessions.values()))


@pytest.fixture
def pages() -> dict[str, Callable[[], Page]]:
    """Return what makes each page of the lab."""
    motion = CleanRun(duration=0.3).make()
    forces = np.array(motion["forces"])
    forces[100:140, 0, 0] += 80.0
    log = sf.Log({**motion.arrays, "forces": forces}, motion.facts, channels=motion.channels)
    ball, report = sf.plan(None, "ball"), audit_log(log)
    return {
        "cone": ConePage,
        "plan": lambda: plan_page(RecordedMotion(ball, ball.robot, ball.terrain), ball),
        "audit": lambda: audit_page(RecordedMotion(log), report),
        "stand": lambda: StandPage(start_state(sf.load_robot("go2"))),
        "push": lambda: PushPage(WalkRun(sf.load_robot("go2"))),
    }


BROWSERS = {
    Slider: ("[role=slider]", ["ArrowRight"]),
    Choice: ("input.mantine-Select-input", ["ArrowDown", "ArrowDown", "Enter"]),
    Checkbox: ("input.mantine-Checkbox-input", []),
}
"""Kind of control to what it is in the browser, and the keys that move it."""


def move(tab: Tab, session: Session, control: Control) -> None:
    """Move a control in the browser, and wait until the page has heard of it."""
    values, controls = session.page.values, session.page.values.controls
    if isinstance(control, Button):
        named = f"b => b.innerText.trim() === {control.label!r}"
        assert (
            tab.ask(f"[...document.querySelectorAll('button')].filter({named}).map(b => b.click()).length")
            == 1
        )
        return
    alike = [one for one in controls if type(one) is type(control)]
    (where, keys), before = BROWSERS[type(control)], values[control.name]
    found = (
        f"[...document.querySelectorAll({where!r})].at({alike.index(control) - len(alike)})"  # ours are last
    )
    if isinstance(control, Slider) and before > control.high - control.step:
        keys = ["ArrowLeft"]
    tab.ask(f"{found}.focus()" if keys else f"{found}.click()")
    for key in keys:
        tab.press(key)
    deadline, tries = time.monotonic() + PATIENCE, 0
    while values[control.name] == before and len(getattr(control, "options", "ab")) > 1:
        assert time.monotonic() < deadline, f"{control.name} does not move"
        tries += 1
        time.sleep(3.0 if keys else 0.1)
        if values[control.name] != before:
            break
        if keys:  # drawn anew, a control loses the focus
            tab.ask(f"{found}.focus()")
        for key in keys:  # one was too early; a closed list needs all, its first only opens it
            tab.press(key)
        if not keys and tries % 200 == 0:  # a page too busy to hear a click
            tab.ask(f"{found}.click()")


@pytest.mark.long
@pytest.mark.parametrize("name", ["cone", "plan", "audit", "stand", "push"])
def test_every_control_is_moved(name: str, pages: dict[str, Callable[[], Page]], folder: Path) -> None:
    """In a window of 1300 x 850 pixels, below whose fold nothing is at first."""
    assert CHROMIUM is not None
    with Browser(CHROMIUM, 1300, 993) as browser, LabServer(pages[name], port=0) as server:
        tab = browser.open(server.url)
        session = settled(server, PATIENCE)
        tab.ask("document.querySelector('.mantine-Notification-closeButton')?.click()")
        scene, file = (
            int(tab.ask("document.querySelector('canvas').getBoundingClientRect().width")),
            folder / name,
        )
        deadline = time.monotonic() + PATIENCE
        while (
            np.ptp((first := picture(tab, file.with_suffix(".first.png")))[200:, :scene], axis=(0, 1)).min()
            < 60
        ):
            assert time.monotonic() < deadline, "nothing is drawn"
            time.sleep(0.5)
        views = "[...document.querySelectorAll('.mantine-ScrollArea-viewport')]"
        below = tab.ask(f"{views}.map(v => v.scrollHeight - v.clientHeight)")
        assert max(below, default=0) <= 0, f"{below} pixels are below the fold"
        controls = session.page.values.controls
        for title in [*dict.fromkeys(control.folder for control in controls if control.folder)][1:]:
            named = f"e => e.innerText?.trim() === {title!r}"
            tab.ask(f"[...document.querySelectorAll('div, span, p')].filter({named}).at(-1).click()")
        time.sleep(1.0)  # they open
        for control in controls:
            move(tab, session, control)
        deadline, moved = time.monotonic() + PATIENCE, file.with_suffix(".moved.png")
        while (first[:, :scene] != picture(tab, moved)[:, :scene]).any(axis=2).sum() <= 500:
            assert time.monotonic() < deadline, "the scene does not change"
            time.sleep(1.0)
        assert tab.errors == []
        assert all(address.startswith(server.home) for address in tab.requests)


def picture(tab: Tab, path: Path) -> np.ndarray:
    """Return what the window shows."""
    imageio = pytest.importorskip("imageio.v3", reason="imageio is not installed")
    return np.asarray(imageio.imread(tab.screenshot(path)))[..., :3].astype(int)
