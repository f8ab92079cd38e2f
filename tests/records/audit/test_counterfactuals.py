"""What would have been without a cause, recomputed: friction by linear programs, balance, torques."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.records import Log
from surefoot.records.audit.story.statics import least_friction

sys.path.insert(0, str(Path(__file__).parents[2] / "worlds" / "mujoco"))
from strangers import crate, quadruped

FEET = np.array([[0.2, 0.1, 0.0], [0.2, -0.1, 0.0], [-0.2, 0.1, 0.0], [-0.2, -0.1, 0.0]])
UP = np.array([0.0, 0.0, 1.0])


def on_ground(force: Any, moment: Any = (0.0, 0.0, 0.0), places: Any = FEET, normals: Any = None) -> float:
    normals = np.broadcast_to(UP, np.shape(places)) if normals is None else normals
    return least_friction(places, normals, np.zeros(3), np.concatenate([force, moment]))


@pytest.mark.parametrize("tangent", [0.0, 0.1, 0.5, 1.3])
@pytest.mark.parametrize("angle", [0.0, 0.4, 2.0])
def test_the_least_friction_of_a_force_is_its_slope(tangent: float, angle: float) -> None:
    force = 90.0 * np.array([tangent * np.cos(angle), tangent * np.sin(angle), 1.0])
    assert on_ground(force) == pytest.approx(tangent, abs=0.01 + 0.02 * tangent)
    assert on_ground(1e-4 * force) == on_ground(force)  # whatever the scale


def test_what_no_friction_gives_is_infinite() -> None:
    assert on_ground([0.0, 0.0, -90.0]) == np.inf  # the ground does not pull
    assert on_ground([0.0, 0.0, 90.0], [0.0, 90.0 * 0.3, 0.0]) == np.inf  # its middle is beyond the feet
    assert on_ground([0.0, 0.0, 90.0], [0.0, 90.0 * 0.15, 0.0]) < 0.02
    assert on_ground([0.0, 0.0, 90.0], places=np.zeros((0, 3)), normals=np.zeros((0, 3))) == np.inf


def test_walls_hold_a_weight_by_the_friction_of_any_squeeze() -> None:
    walls = np.array([[-0.2, 0.0, 0.0], [0.2, 0.0, 0.0]])
    inwards = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    assert on_ground([0.0, 0.0, 90.0], places=walls, normals=inwards) < 0.02
    assert on_ground([0.0, 0.0, 90.0], places=walls[:1], normals=inwards[:1]) == np.inf


def test_a_turn_about_the_normal_needs_friction() -> None:
    """Four points on a circle: m_z = mu f_z r, as in a clutch."""
    radius = float(np.hypot(0.2, 0.1))
    needs = on_ground([0.0, 0.0, 90.0], [0.0, 0.0, 0.3 * 90.0 * radius])
    assert needs == pytest.approx(0.3, abs=0.02)


def test_a_slope_says_how_much_friction_it_needs() -> None:
    cause = sf.audit_log(crate(mu=0.25, tilt=20.0)).first_cause
    assert cause is not None
    assert cause.name == "slope too steep"
    assert "here 0.36 of 0.25" in cause.without or "here 0.37 of 0.25" in cause.without
    assert cause.without in str(sf.audit_log(crate(mu=0.25, tilt=20.0)).story)


def shove(force: float, cut_at: int | None = None) -> Any:
    def press(model: Any, data: Any, step: int) -> None:
        data.xfrc_applied[1, 1] = force if 150 <= step < 175 else 0.0
        if cut_at is not None and step >= cut_at:
            data.ctrl[:6] = 0.0

    return press


def test_a_push_says_where_the_capture_point_would_be_without_it() -> None:
    report = sf.audit_log(quadruped(600, shove(800.0)))
    assert report.first_cause is not None
    assert report.first_cause.name == "push"
    assert "capture point" in report.first_cause.without


def test_a_push_that_was_survived_fells_nobody() -> None:
    report = sf.audit_log(quadruped(800, shove(100.0, cut_at=620)))
    assert report.story.failure is not None
    assert report.story.failure.time - 0.3 < 1.5  # a push has not faded yet
    assert report.first_cause is not None
    assert report.first_cause.name == "weak actuator"
    assert "push" not in {cause.name for cause in report.causes}
    assert "push" in {event.name for event in report.story.events}  # it happened all the same


@pytest.mark.long
def test_counterfactuals_of_logs_with_holes_raise_nothing() -> None:
    rng = np.random.default_rng(0)
    for log in (quadruped(500, shove(800.0)), crate(mu=0.25, tilt=20.0)):
        sf.audit_log(log.rows(slice(None, None, 10)))  # 50 rows a second
        for name in ("q", "v", "forces", "normals", "contact_positions", "momentum", "com", "wrench_applied"):
            if name in log:
                holes = np.where(rng.random(log[name].shape) < 0.3, np.nan, log[name])
                sf.audit_log(Log({**log.arrays, name: holes}, dict(log.facts)))
        facts = {k: v for k, v in log.facts.items() if not k.startswith("model_")}
        sf.audit_log(Log(dict(log.arrays), facts))
