"""The body in step with stairs takes the place in which its feet fall between edges."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from surefoot.mechanics.terrain import FlatTerrain, StairsTerrain, Terrain
from surefoot.motion.gaits.adaptive_gait import AdaptiveGait, Pace, Stride
from surefoot.motion.walking.feet_settings import FOOTHOLDS
from surefoot.motion.walking.foothold import step_windows
from surefoot.motion.walking.pace_settings import STAIR_PHASE
from surefoot.motion.walking.stair_gait import OFFSETS as STAIR_OFFSETS
from surefoot.motion.walking.stair_gait import stair_gait
from surefoot.motion.walking.stair_phase import StepPhase
from surefoot.motion.walking.walking_body import BodyPlan, VelocityCommand

OFFSETS = np.array([[0.19, 0.14], [0.19, -0.14], [-0.19, 0.14], [-0.19, -0.14]])
MARGIN, SPEED, DT = 0.045, 0.4, 1e-3


def _phase(terrain: Terrain, about: Terrain | None = None) -> StepPhase:
    gait = stair_gait(about or terrain, VelocityCommand.constant(SPEED), 0.3, 0.4, 4)
    assert gait is not None
    return StepPhase(terrain, gait, OFFSETS, MARGIN)


def _walk(phase: StepPhase, start: float, until: float, speed: float = SPEED) -> BodyPlan:
    """Let a body that does what it should walk for a time."""
    body = BodyPlan(0.3, np.array([start, 0.0, 0.3]), 0.0)
    for k in range(round(until / DT)):
        if k % 25 == 0:
            phase.look(body, k * DT)
        body.advance(np.array([speed * phase.pace(speed, DT), 0.0, 0.0]), body.position.copy(), DT)
    return body


def _worst_move(phase: StepPhase, body: BodyPlan, clock: float) -> float:
    """Return the largest move that a foot needs to stand between edges, by the height of the ground alone."""
    gait, worst = phase.schedule, 0.0
    for k, arm in enumerate(OFFSETS):
        times = clock + np.arange(0.0, gait.period, 1e-3)
        down = gait.contacts(times)[:, k]
        touch = times[np.flatnonzero(down & ~np.roll(down, 1))[0]] - clock
        x = body.position[0] + arm[0] + (touch + 0.5 * gait.stance_time) * SPEED
        moves = np.arange(-0.15, 0.15, 1e-3)
        level = phase.terrain.height(np.column_stack([x + moves, 0.0 * moves]))
        free = np.ones(len(moves), dtype=bool)
        for ahead in np.arange(-FOOTHOLDS.shin, MARGIN, 1e-3):
            near = phase.terrain.height(np.column_stack([x + moves + ahead, 0.0 * moves]))
            free &= ~((near - level > 0.03) if ahead < -MARGIN else (np.abs(near - level) > 0.03))
        worst = max(worst, float(np.abs(moves[free]).min()))
    return worst


@pytest.mark.parametrize("start", np.linspace(-1.5, -1.2, 6))
@pytest.mark.parametrize("rise", [0.12, -0.12])
def test_feet_have_to_be_moved_little_wherever_the_walk_began(rise: float, start: float) -> None:
    phase = _phase(StairsTerrain(rise, 0.3))
    body = _walk(phase, start, 7.5)
    assert body.position[0] == pytest.approx(start + 7.2 * SPEED, abs=0.25)
    assert abs(phase.lead) < 0.02  # it has come to rest
    assert _worst_move(phase, body, 7.5) < (0.02 if rise > 0.0 else 0.05)


def test_out_of_step_and_without_edges_the_pace_is_the_commands() -> None:
    stairs = StairsTerrain(-0.12, 0.3)
    for phase, speed in (
        (_phase(FlatTerrain(), stairs), SPEED),
        (_phase(stairs), 0.7 * SPEED),
        (_phase(stairs), 0.0),
    ):
        body = _walk(phase, -0.5, 3.0, speed)
        assert phase.lead == 0.0
        assert phase.pace(speed, DT) == 1.0
        assert body.velocity[0] == pytest.approx(speed)


def test_the_pace_is_bounded_and_takes_up_the_lead() -> None:
    phase = _phase(StairsTerrain(-0.12, 0.3))
    for lead, share in ((1.0, 1.0 + STAIR_PHASE.most_change), (-1.0, 1.0 - STAIR_PHASE.most_change)):
        phase.lead = lead
        assert phase.pace(SPEED, DT) == pytest.approx(share)
        assert abs(phase.lead) == pytest.approx(1.0 - STAIR_PHASE.most_change * SPEED * DT)
    phase.reset()
    assert phase.lead == 0.0
    assert phase.pace(SPEED, DT) == 1.0


def test_windows_keep_from_edges_and_more_from_those_come_down_over() -> None:
    down, up = StairsTerrain(-0.12, 0.3), StairsTerrain(0.12, 0.3)
    for stairs, behind in ((down, FOOTHOLDS.shin), (up, MARGIN)):
        windows = step_windows(stairs, np.array([0.75, 0.1]), np.array([1.0, 0.0]), MARGIN)
        assert windows is not None
        np.testing.assert_allclose(windows[0], [-np.inf, -0.15 + behind, 0.15 + behind], atol=0.004)
        np.testing.assert_allclose(windows[1], [-0.15 - MARGIN, 0.15 - MARGIN, np.inf], atol=0.004)
    assert step_windows(FlatTerrain(), np.zeros(2), np.array([1.0, 0.0]), MARGIN) is None
    turned = step_windows(up, np.array([0.75, 0.1]), np.array([-1.0, 0.0]), MARGIN)  # down backwards
    assert turned is not None
    np.testing.assert_allclose(
        turned[0], [-np.inf, -0.15 + FOOTHOLDS.shin, 0.15 + FOOTHOLDS.shin], atol=0.004
    )


@pytest.mark.parametrize("start", np.linspace(-0.75, -0.6, 4))
def test_a_slow_body_sets_off_when_its_feet_will_fall_well(start: float) -> None:
    stairs = _Learnt(-0.12, 0.3)
    stride = Stride("trot", Pace(0.75, 0.6, 0.07), np.array(STAIR_OFFSETS), in_step=True)
    gait = AdaptiveGait("trot", lambda velocity, name: stride, stride)
    phase = StepPhase(stairs, gait, OFFSETS, MARGIN)
    body = BodyPlan(0.3, np.array([start, 0.0, 0.3]), 0.0)
    waited, slowest = 0.0, 1.0
    for k in range(4000):
        clock = k * DT
        if k % 20 == 0:
            gait.follow(clock, np.array([SPEED, 0.0, 0.0]))
            phase.look(body, clock)
        waited += DT * phase.waiting
        speed = (0.1 if phase.waiting else 1.0) * SPEED
        share = phase.pace(speed, DT)
        slowest = min(slowest, share)
        body.advance(np.array([speed * share, 0.0, 0.0]), body.position.copy(), DT)
    assert waited < 0.75
    assert slowest > 0.9  # there was nothing to take up
    assert body.velocity[0] == pytest.approx(SPEED, rel=0.1)
    assert _worst_move(phase, body, 4.0) < 0.05
    gait.wanted = replace(stride, in_step=False)  # off the stairs
    phase.look(body, 4.0)
    assert not phase.waiting


class _Learnt(StairsTerrain):
    """Stairs that a robot has found out about."""

    learns = True


def test_strides_suit_the_command_while_only_the_pace_differs() -> None:
    stride = Stride("trot", Pace(0.75, 0.6, 0.07), np.array(STAIR_OFFSETS), in_step=True)
    gait = AdaptiveGait("trot", lambda velocity, name: stride, stride)
    phase, asked = StepPhase(_Learnt(-0.12, 0.3), gait, OFFSETS, MARGIN), np.array([SPEED, 0.0, 0.1])
    phase.share = 0.9
    assert phase.unhurried(np.array([1.1 * SPEED, 0.0, 0.0]), asked).tolist() == asked.tolist()
    fast = np.array([1.3 * SPEED, 0.0, 0.2])
    np.testing.assert_allclose(phase.unhurried(fast, asked), [1.3 * SPEED / 0.9, 0.0, 0.2])
    gait.wanted = replace(stride, in_step=False)
    np.testing.assert_allclose(phase.unhurried(asked, asked), [SPEED / 0.9, 0.0, 0.1])
