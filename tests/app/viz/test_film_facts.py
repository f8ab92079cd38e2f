"""What a film writes: the gait's bars, the speed, and whether the laws held so far."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.viz.film import Overlay
from surefoot.app.viz.film_facts import FilmFacts, film_facts
from surefoot.app.viz.video import LAG, Renderer, RenderError, follow

DT = 0.1


def facts(broken: tuple[tuple[float, str], ...] | None = ()) -> FilmFacts:
    loaded = np.array([[1, 0], [1, 0], [0, 1], [0, 1], [1, 1], [1, 1]], dtype=bool)
    return FilmFacts(("FL_foot", "FR_foot"), loaded, np.linspace(0.0, 0.5, 6), broken, DT)


def test_bars_show_the_last_seconds_with_now_at_the_right() -> None:
    spans = facts().spans(5, 0.4)
    assert spans[0] == [pytest.approx((0.5, 1.0))]
    assert spans[1] == [pytest.approx((0.0, 1.0))]
    early = facts().spans(1, 0.4)  # what was before the log is left empty
    assert early == [[pytest.approx((0.5, 1.0))], []]


def test_the_badge_names_what_was_broken_first_once_it_was() -> None:
    told = facts(((0.2, "friction"), (0.4, "pull")))
    assert told.badge(0.1) == ("the laws of contact hold", True)
    assert told.badge(0.5) == ("friction: broken", False)
    assert facts(None).badge(0.5) is None


def test_the_frame_shows_more_than_the_clock() -> None:
    pytest.importorskip("PIL")
    overlay, blank = Overlay(640, 360, "go2", []), np.full((360, 640, 3), 128, np.uint8)
    plain, full = overlay.over(blank, 0.5), overlay.over(blank, 0.5, facts(((0.2, "pull"),)), 5)
    changed = (plain != full).any(axis=2)
    assert changed[20:50, 500:].any()  # the badge
    assert changed[290:345, :200].any()  # the bars
    assert changed[345:, 400:].any()  # the speed
    assert not changed[100:250].any()


def test_camera_and_light_follow_with_a_lag() -> None:
    start, there = np.zeros(3), np.array([3.0, 0.0, 0.0])
    assert follow(start, there, LAG)[0] == pytest.approx(3.0 * (1.0 - np.exp(-1.0)))
    np.testing.assert_array_equal(follow(start, there, np.inf), there)
    halves = follow(follow(start, there, 0.5 * LAG), there, 0.5 * LAG)
    np.testing.assert_allclose(halves, follow(start, there, LAG))  # whatever the pictures' rate


def test_a_robot_far_from_the_start_is_as_light_as_at_the_start() -> None:
    robot = sf.load_robot("go2")
    try:
        renderer = Renderer(robot, sf.FlatTerrain(), 320, 180)
    except RenderError as error:
        pytest.skip(str(error))
    try:
        here = renderer.frame(robot.nominal, [])
        q = robot.nominal.copy()
        q[0] += 8.0  # where it is after 16 s; the checks of the ground are half a metre
        far = renderer.frame(q, [])
        lagging = renderer.frame(robot.nominal, [], (), 1.0 / 25.0)
    finally:
        renderer.close()
    assert abs(float(here.mean()) - float(far.mean())) < 2.0
    assert renderer.focus is not None
    assert 6.5 < renderer.focus[0] < 8.0
    assert lagging.std() > 0.0


def test_a_log_tells_them() -> None:
    steps = 30
    forces = np.zeros((steps, 2, 3))
    forces[:15, 0, 2], forces[15:, 1, 2] = 100.0, 100.0
    forces[15:, 0, 2] = 2.0  # 1.4 % of m g is no load, here as in an audit
    q = np.zeros((steps, 19))
    q[:, 0] = 0.05 * np.arange(steps)  # half a metre a second
    log = sf.Log({"time": DT * np.arange(steps), "forces": forces, "q": q}, {"dt": DT})
    told = film_facts(log, sf.load_robot("go2"))
    assert told.speed is not None
    assert told.speed[20] == pytest.approx(0.5)
    assert told.loaded.sum(axis=0).tolist() == [15, 15]
    assert told.names == ("contact 0", "contact 1")
