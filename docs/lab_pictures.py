"""Pictures of the lab's pages, as docs/lab.md and the README show them, by a Chromium without a screen.

Run: python -m docs.lab_pictures [NAME...] [--out docs/images] [--width 1280] [--height 777]. Without names
all are drawn; `lab-stand` is docs/images/lab-stand.png. The extra `lab` and a Chromium are needed.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

import surefoot as sf
from benchmarks.problems.logged_runs import CleanRun
from surefoot.app.lab.cone import ConePage
from surefoot.app.lab.page import Page
from surefoot.app.lab.push import PushPage
from surefoot.app.lab.push_run import WalkRun
from surefoot.app.lab.recording import RecordedMotion, audit_page
from surefoot.app.lab.server import LabServer
from surefoot.app.lab.stand import StandPage, start_state
from surefoot.app.lab.standing_pose import StandingPose
from surefoot.records.audit import audit_log
from tests.browser import Browser, find_chromium

IMAGES = Path(__file__).resolve().parent / "images"
PATIENCE = 300.0
"""How long a loaded machine may take to draw in software [s]."""
TROT = 4.3
"""How long the robot of lab-push has walked [s]."""
FADED = 150
"""Least range of greys of a scene that is there."""


def stand_page() -> Page:
    """Return a stance that holds."""
    robot = sf.load_robot("go2")
    return StandPage(start_state(robot), StandingPose(robot).shapes)


def tipped_page() -> Page:
    """Return the same stance with its centre of mass beyond the front feet."""
    robot = sf.load_robot("go2")
    state = start_state(robot)
    state.com[:2] = 0.25, 0.05
    return StandPage(state, StandingPose(robot).shapes)


def push_page() -> Page:
    """Return a robot that has trotted forwards for a while, at a standstill: it would outrun the browser."""
    run = WalkRun(sf.load_robot("go2"))
    page = PushPage(run)
    page.change("forward", 0.3)
    while run.time < TROT:
        page.drawing()
    page.live = False
    return page


def broken_page() -> Page:
    """Return a log with a force beyond friction, at its first violation."""
    motion = CleanRun(duration=0.3).make()
    forces = np.array(motion["forces"])
    forces[100:140, 0, 0] += 80.0
    log = sf.Log({**motion.arrays, "forces": forces}, motion.facts, channels=motion.channels)
    report = audit_log(log)
    page = audit_page(RecordedMotion(log), report)
    page.values.within("time", log["time"][120])
    return page


PICTURES: dict[str, Callable[[], Page]] = {
    "lab-stand": stand_page,
    "lab-stand-tipped": tipped_page,
    "lab-cone": ConePage,
    "lab-push": push_page,
    "lab-audit": broken_page,
}
"""Name of a picture to what makes its page."""


def draw(name: str, path: Path, width: int, height: int) -> Path:
    """Write the picture of a page as it stands once the browser has drawn it.

    Raises
    ------
    TimeoutError
        If nobody draws it within PATIENCE.
    """
    program = find_chromium()
    if program is None:
        raise SystemExit("no Chromium: apt-get install chromium, or set SUREFOOT_CHROMIUM")
    page = PICTURES[name]()  # what is missing is said here, not in the browser
    with LabServer(lambda: page, port=0) as server, Browser(program, width, height) as browser:
        tab = browser.open("about:blank")
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        tab.call("Emulation.setDeviceMetricsOverride", **size)
        tab.call("Page.navigate", url=server.url)
        tab.wait_for("document.querySelector('canvas') !== null", PATIENCE)
        deadline = time.monotonic() + PATIENCE
        while not (server.sessions and next(iter(server.sessions.values())).draws):
            if time.monotonic() > deadline:
                raise TimeoutError(f"{name}: no viewer has come; {tab.errors}")
            tab.ask("document.title")  # what the browser says is read, or it waits
            time.sleep(0.1)
        while _contrast(tab.screenshot(path), width // 2) < FADED:
            if time.monotonic() > deadline:
                raise TimeoutError(f"{name}: nothing is drawn")
            time.sleep(1.0)
        last = b""
        while last != (now := tab.screenshot(path).read_bytes()):  # meshes come one by one
            if time.monotonic() > deadline:
                raise TimeoutError(f"{name}: it never comes to rest")
            last = now
            time.sleep(4.0)
        return tab.screenshot(path)


def _contrast(picture: Path, width: int) -> int:
    """Return the range of the greys in the left of a picture: the scene fades in."""
    import imageio.v3 as imageio

    return int(np.ptp(np.asarray(imageio.imread(picture))[:, :width, :3].astype(int).mean(axis=2)))


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw the pictures that are named, and print their paths."""
    parser = argparse.ArgumentParser(description="Pictures of the lab's pages.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(PICTURES)}; all without")
    parser.add_argument("--out", type=Path, default=IMAGES)
    parser.add_argument("--width", type=int, default=1280)
    parser.add_argument("--height", type=int, default=777)
    told = parser.parse_args(arguments)
    for name in told.names:
        if name not in PICTURES:
            parser.error(f"no picture {name!r}: {', '.join(PICTURES)}")
    told.out.mkdir(parents=True, exist_ok=True)
    for name in told.names or PICTURES:
        print(draw(name, told.out / f"{name}.png", told.width, told.height), flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
