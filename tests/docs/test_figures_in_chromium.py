"""Figures that are dragged, in a real Chromium: what they say meanwhile is what the package says.

With SUREFOOT_SCREENSHOTS a folder, their pictures stay there to be looked at.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import surefoot as sf
from docs.site.figures import ASKED, COLOURS, FIGURES, with_figure
from tests.browser import Browser, Tab, find_chromium

CHROMIUM = find_chromium()
pytestmark = pytest.mark.long
in_chromium = pytest.mark.skipif(
    CHROMIUM is None, reason="no Chromium: apt install chromium, or set SUREFOOT_CHROMIUM"
)
STYLE = Path(__file__).resolve().parents[2] / "docs" / "site" / "style" / "figures"
COURSE = Path(__file__).resolve().parents[2] / "course"
GRAVITY = 9.81
PHONE = {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True}
PHONES = '<meta name="viewport" content="width=device-width, initial-scale=1">'


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    assert CHROMIUM is not None
    with Browser(CHROMIUM, 800, 850) as browser:
        yield browser


class Figure:
    """A figure on a page of its own, and the mouse that drags it."""

    def __init__(self, browser: Browser, folder: Path, name: str, language: str = "en") -> None:
        scripts = "".join(
            f'<script src="{(STYLE / f).as_uri()}"></script>' for f in ("stage.js", f"{name}.js")
        )
        page = folder / f"{name}-{language}.html"
        colours = "".join(f"--{key}: {value};" for key, value in COLOURS.items())
        style = f"<style>:root {{{colours}}}</style>"
        style += f'<link rel="stylesheet" href="{(STYLE / "figures.css").as_uri()}">'
        page.write_text(
            f'<!doctype html><html lang="{language}"><meta charset="utf-8">{PHONES}{style}{scripts}'
            f'<div data-figure="{name}"></div></html>'
        )
        self.tab: Tab = browser.open("about:blank")
        self.tab.call("Page.navigate", url=page.as_uri())
        self.tab.wait_for(
            f"location.href === {page.as_uri()!r} && document.querySelector('[data-result]') !== null"
        )

    @property
    def result(self) -> dict[str, Any]:
        """What it has computed."""
        assert self.tab.errors == []
        found: dict[str, Any] = json.loads(
            self.tab.ask("document.querySelector('[data-figure]').dataset.result")
        )
        return found

    @property
    def sentence(self) -> str:
        return str(self.tab.ask("document.querySelector('[data-figure] p').textContent"))

    def middle(self, number: int) -> tuple[float, float]:
        """Return where a handle is [pixels]."""
        x, y = self.tab.ask(
            f"(() => {{ const b = document.querySelectorAll('.handle')[{number}].getBoundingClientRect();"
            "return [b.x + b.width / 2, b.y + b.height / 2]; })()"
        )
        return x, y

    def drag(self, number: int, *ways: tuple[float, float]) -> None:
        """Take a handle and move it by steps [pixels]."""
        x, y = self.middle(number)
        self._mouse("mousePressed", x, y)
        for dx, dy in ways:
            x, y = x + dx, y + dy
            self._mouse("mouseMoved", x, y)
        self._mouse("mouseReleased", x, y)

    def _mouse(self, kind: str, x: float, y: float) -> None:
        told = {"button": "left", "buttons": 1, "clickCount": 1}
        self.tab.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **told)

    def touch(self, x: float, y: float, dx: float, dy: float) -> None:
        """Put a finger down and move it [pixels]."""
        self.tab.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x, "y": y}])
        for share in (0.5, 1.0):
            at = [{"x": x + share * dx, "y": y + share * dy}]
            self.tab.call("Input.dispatchTouchEvent", type="touchMove", touchPoints=at)
        self.tab.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])

    def slide(self, number: int, value: float) -> None:
        self.tab.ask(
            f"(() => {{ const s = document.querySelectorAll('input')[{number}]; s.value = {value};"
            "s.dispatchEvent(new Event('input')); })()"
        )

    def picture(self, name: str) -> None:
        if "SUREFOOT_SCREENSHOTS" in os.environ:
            self.tab.screenshot(Path(os.environ["SUREFOOT_SCREENSHOTS"]) / f"{name}.png")


@in_chromium
def test_the_cone_and_its_pyramids(browser: Browser, tmp_path: Path) -> None:
    figure, rng, seen = Figure(browser, tmp_path, "cone"), np.random.default_rng(0), set()
    for k in (4, 5, 8, 4, 7, 4, 4, 6, 4, 5):
        figure.slide(1, k)
        aim = rng.uniform(-0.75, 0.75, 2) - figure.result["force"]
        figure.drag(0, (100 * aim[0], -100 * aim[1]), (113 * aim[0], -113 * aim[1]))
        found = figure.result
        force, cone = np.array([*found["force"], 1.0]), sf.FrictionCone(found["mu"])
        assert found["sides"] == k
        assert found["used"] == pytest.approx(float(cone.use(force)))
        inner, outer = cone.polyhedral(k, "inner"), cone.polyhedral(k, "outer", phase=np.pi / k)
        answers = [bool(one.margin(force) >= 0.0) for one in (inner, cone, outer)]
        assert answers == [found["inner"], found["circle"], found["outer"]]
        assert inner.fit_error.radial == pytest.approx(found["gives_up"])
        assert outer.fit_error.radial == pytest.approx(found["overshoots"])
        seen.add(tuple(answers))
    assert len(seen) >= 3
    figure.picture("figure-cone")


@in_chromium
def test_the_region_of_two_feet(browser: Browser, tmp_path: Path) -> None:
    figure, rng, seen = Figure(browser, tmp_path, "region"), np.random.default_rng(1), set()
    for left, right in ((0, 0), (20, -20), (-45, 45), (60, -60), (80, -80), (-30, -30), (40, 10), (90, -90)):
        figure.slide(0, left)
        figure.slide(1, right)
        for foot in range(3):
            figure.drag(foot, tuple(rng.uniform(-30, 30, 2)))
        found = figure.result
        contacts = [
            sf.PointContact([x, 0.0, z], mu=found["mu"], normal=[-np.sin(a), 0.0, np.cos(a)])
            for (x, z), a in zip(found["feet"], found["angles"], strict=True)
        ]
        low, high = float(found["low"]), float(found["high"])
        ends = [end for end in (low, high) if np.isfinite(end)]
        for x in (found["centre"][0], *(end + s for end in ends for s in (-1e-3, 1e-3)), -5.0, 5.0):
            verdict = sf.can_stand(sf.Stance(contacts), com=[x, 0.0, found["centre"][1]], mass=1.0)
            assert bool(verdict) == bool(low <= x <= high), (found, x)
        assert found["stands"] == bool(low <= found["centre"][0] <= high)
        seen.add((np.isnan(low), np.isinf(low), np.isinf(high)))
    assert len(seen) >= 2
    figure.picture("figure-region")


@in_chromium
def test_the_pushed_block(browser: Browser, tmp_path: Path) -> None:
    figure, seen = Figure(browser, tmp_path, "block"), set()
    ways = [(0, (0, -9)), (1, (60, -80)), (1, (0, -130)), (1, (-150, 190)), (0, (0, -120)), (1, (20, 60))]
    for number, way in ways:
        figure.slide(0, 0.3 if number else 0.5)
        figure.drag(number, way)
        found = figure.result
        t, n = found["load"]
        angle, push = found["angle"], found["push"]
        weighed = np.array([push[0], push[1] - GRAVITY])
        axes = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        assert axes @ weighed == pytest.approx([t, n])
        # one second of rest: with a mass of 1 kg impulses are forces, and velocities accelerations
        solution = sf.solve(sf.ContactProblem(np.eye(3), np.array([t, 0.0, n]), found["mu"]))
        assert solution.forces[0, [0, 2]] == pytest.approx(found["force"], abs=1e-6)
        moves = np.array([t, n]) + solution.forces[0, [0, 2]]
        assert moves == pytest.approx(found["acceleration"], abs=1e-6)
        seen.add(found["mode"])
    assert seen == {"sticks", "slides", "lifts"}
    figure.picture("figure-block")


@in_chromium
def test_two_contacts_and_their_modes(browser: Browser, tmp_path: Path) -> None:
    figure, rng, seen = Figure(browser, tmp_path, "lcp"), np.random.default_rng(2), set()
    for k in range(14):
        figure.drag(2, tuple(rng.uniform(-160, 160, 2)))
        if k > 4:
            figure.drag(k % 2, tuple(rng.uniform(-120, 120, 2)))
        found = figure.result
        A, q = np.array(found["A"]), np.array(found["q"])
        for one in found["solutions"]:
            z, w = np.array(one["z"]), np.array(one["w"])
            assert w == pytest.approx(A @ z + q, abs=1e-9)
            assert min(z.min(), w.min()) >= -1e-12
            assert z @ w == 0.0
        count = len(found["solutions"])
        ours = sf.solve_lcp(sf.LCP(A, q))
        if ours.status is sf.Status.SOLVED:
            assert any(np.allclose(one["z"], ours.z, atol=1e-6) for one in found["solutions"])
        elif ours.status is sf.Status.INFEASIBLE:
            assert count == 0
        if found["always"]:
            assert count == 1
        seen.add(count)
    assert len(seen) >= 2
    figure.picture("figure-lcp")


def three_rods() -> pin.Model:
    """The cat of the figure: a floating rod of 0.6 m and 1 kg, and one at each of its ends."""
    model, inertia = pin.Model(), 1.0 * 0.6**2 / 12.0
    spin = np.diag([0.0, inertia, inertia])
    body = model.addJoint(0, pin.JointModelPlanar(), pin.SE3.Identity(), "body")
    model.appendBodyToJoint(body, pin.Inertia(1.0, np.zeros(3), spin), pin.SE3.Identity())
    for side, name in ((-1.0, "front"), (1.0, "back")):
        place = pin.SE3(np.eye(3), np.array([side * 0.3, 0.0, 0.0]))
        joint = model.addJoint(body, pin.JointModelRZ(), place, name)
        model.appendBodyToJoint(
            joint, pin.Inertia(1.0, np.array([side * 0.3, 0.0, 0.0]), spin), pin.SE3.Identity()
        )
    return model


@in_chromium
def test_the_cat_turns_as_its_momentum_says(browser: Browser, tmp_path: Path) -> None:
    figure, model = Figure(browser, tmp_path, "cat"), three_rods()
    data = model.createData()
    angles = np.linspace(0.0, 2.0 * np.pi, 41)
    loop = [(70 * np.cos(a) - 70, 70 * np.sin(a)) for a in angles]
    steps = [(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(loop)]
    figure.drag(0, *steps)
    found = figure.result
    turn = 0.0
    for a, b in pairwise(found["path"]):
        a, b = np.array(a), np.array(b)
        for s in (np.arange(20) + 0.5) / 20:
            q = np.r_[0.0, 0.0, 1.0, 0.0, a + s * (b - a)]
            momentum = pin.computeCentroidalMap(model, data, q)
            # no linear momentum, no turn: the three rates of the body for those of the joints
            rows = momentum[[0, 1, 5]]
            turn += np.linalg.solve(rows[:, :3], -rows[:, 3:] @ (b - a) / 20)[2]
    assert found["turn"] == pytest.approx(turn, rel=1e-3)
    assert abs(turn) > 0.1
    figure.picture("figure-cat")
    figure.drag(0, *[(-x, -y) for x, y in reversed(steps)])
    assert figure.result["turn"] == pytest.approx(0.0, abs=0.05 * abs(turn))
    figure.tab.ask("document.querySelector('button').click()")
    assert figure.result["path"] == [[0, 0]]


@in_chromium
@pytest.mark.parametrize("name", sorted(FIGURES.values()))
def test_keys_move_it_and_it_speaks_chinese(browser: Browser, tmp_path: Path, name: str) -> None:
    figure = Figure(browser, tmp_path, name, "zh-CN")
    assert any("\u4e00" <= letter <= "\u9fff" for letter in figure.sentence)
    before = figure.result
    figure.tab.ask("document.querySelector('.handle').focus()")
    figure.tab.press("ArrowLeft")
    assert figure.result != before


@in_chromium
@pytest.mark.parametrize("language", ["en", "zh-CN"])
@pytest.mark.parametrize("name", sorted(FIGURES.values()))
def test_a_finger_drags_it_on_a_phone(browser: Browser, tmp_path: Path, name: str, language: str) -> None:
    figure = Figure(browser, tmp_path, name, language)
    figure.tab.call("Emulation.setDeviceMetricsOverride", **PHONE)
    figure.tab.call("Emulation.setTouchEmulationEnabled", enabled=True)
    assert figure.tab.ask("document.documentElement.scrollWidth") <= PHONE["width"]
    before, (x, y) = figure.result, figure.middle(0)
    figure.touch(x + 12, y - 12, -20, 16)  # beside what is drawn, as fingers are
    figure.tab.wait_for(f"document.querySelector('[data-figure]').dataset.result !== {json.dumps(before)!r}")
    assert figure.result != before
    assert figure.tab.ask("window.scrollY") == 0
    figure.picture(f"phone-{name}-{language}")


@pytest.mark.parametrize("language", ["en", "zh"])
def test_figures_stand_on_pages_that_are_there(language: str) -> None:
    for page, figure in FIGURES.items():
        assert (STYLE / f"{figure}.js").is_file()
        book = json.loads((COURSE / language / f"{page}.ipynb").read_text(encoding="utf-8"))
        text = "".join(book["cells"][0]["source"])
        shown = with_figure(page, text, language)
        assert f'<div data-figure="{figure}"></div>' in shown
        assert ASKED[figure][language] in shown
        assert shown.index("data-figure") < shown.rindex("\n## ")
        assert (
            shown.replace(
                shown[shown.index("## " + ("Drag" if language == "en" else "拖动")) : shown.rindex("## ")], ""
            )
            == text
        )
    assert with_figure("errata", "# A\n\n## B\n", language) == "# A\n\n## B\n"
