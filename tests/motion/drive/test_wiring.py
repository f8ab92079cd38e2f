"""Between a controller and its motors: delays measured and made up for, joint targets, a watchdog."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.contact.solution import Status
from surefoot.motion.control.controller import Command, Controller, JointTargets, RobotState
from surefoot.motion.drive.joint_targets import MEMORY, STANCE_GAIN, JointTargetController
from surefoot.motion.drive.latency_compensation import LONGEST, DelayMeter, LatencyCompensation
from surefoot.motion.drive.watchdog import Watchdog

GO2 = sf.load_robot("go2")
DT = 1e-3


class Aim(Controller):
    """Asks for given accelerations, and remembers the states that it saw."""

    def __init__(self, accelerations: np.ndarray | None) -> None:
        self.accelerations = accelerations
        self.seen: list[RobotState] = []

    def step(self, state: RobotState) -> Command:
        self.seen.append(state)
        torques = np.full(12, float(len(self.seen)))
        nothing = np.zeros((4, 3))
        return Command(
            torques, nothing, np.ones(4, dtype=bool), True, Status.SOLVED, accelerations=self.accelerations
        )


def state(time: float = 0.0, **changes: np.ndarray) -> RobotState:
    return RobotState(GO2.nominal, np.zeros(18), time)._replace(**changes)


@pytest.mark.parametrize("steps", [0, 1, 5, 12])
def test_a_delay_is_measured_from_what_motors_report(steps: int) -> None:
    """Torques that wander, reported late, 3 % off and with noise."""
    rng = np.random.default_rng(steps)
    meter, asked = DelayMeter(12, DT), [np.zeros(12)]
    for _ in range(300):
        asked.append(0.9 * asked[-1] + rng.normal(size=12))
        meter.note_command(asked[-1])
        given = asked[max(len(asked) - 1 - steps, 0)]
        meter.compare_report(1.03 * given + 0.1 * rng.normal(size=12))
    assert meter.steps == steps
    meter.reset()
    assert meter.steps == 0


def test_noise_alone_is_no_delay() -> None:
    rng = np.random.default_rng(3)
    meter, still = DelayMeter(12, DT), np.full(12, 5.0)
    for _ in range(500):
        meter.note_command(still)
        assert meter.compare_report(still + 0.2 * rng.normal(size=12)) == 0


def test_the_state_to_come_is_that_of_the_accelerations_on_their_way() -> None:
    """Constant accelerations of the joints and of the base along its axes: Galilei's parabola."""
    a = np.array([2.0, -1.0, 0.5, 0.0, 0.0, 0.0, *np.linspace(-20.0, 20.0, 12)])
    v = np.array([0.3, 0.1, 0.0, 0.0, 0.0, 0.0, *np.linspace(1.0, 2.0, 12)])
    aim = Aim(a)
    controller = LatencyCompensation(aim, GO2, DT, 0.005)
    for k in range(20):
        controller.step(state(k * DT, v=v))
    late = aim.seen[-1]
    assert late.time == pytest.approx(0.019 + 0.005)
    np.testing.assert_allclose(late.v, v + 0.005 * a, atol=1e-15)
    moved = pinocchio.difference(GO2.model, GO2.nominal, late.q)
    np.testing.assert_allclose(moved, 0.005 * v + 0.5 * 0.005**2 * a, atol=1e-15)
    np.testing.assert_array_equal(aim.seen[0].v, v)  # nothing was on its way then


def test_without_a_delay_nothing_is_changed() -> None:
    aim = Aim(np.ones(18))
    controller = LatencyCompensation(aim, GO2, DT)
    for k in range(50):
        now = state(k * DT, torques=np.full(12, float(k)))
        controller.step(now)
        assert aim.seen[-1] is now


def test_old_states_are_carried_on_by_their_age_and_bad_ones_are_left() -> None:
    aim = Aim(np.zeros(18))
    controller = LatencyCompensation(aim, GO2, DT, 0.0)
    v = np.full(18, 0.1)
    for _ in range(5):
        controller.step(state(0.0, v=v))  # the same state, again and again
    assert aim.seen[-1].time == pytest.approx(0.004)
    controller.step(state(0.0, v=np.full(18, np.nan)))
    assert np.isnan(aim.seen[-1].v).all()
    with pytest.raises(ProblemError, match="delay"):
        LatencyCompensation(aim, GO2, DT, 2.0 * LONGEST)


def test_targets_follow_the_accelerations() -> None:
    """Joints that do follow: targets are the motion itself, in the middle of the step."""
    rate = np.array([*np.zeros(6), *np.linspace(-30.0, 30.0, 12)])
    controller = JointTargetController(Aim(rate), GO2, DT, every=4)
    a, dt = rate[6:], 4.0 * DT
    for k in range(40):
        t = k * DT
        q = GO2.nominal.copy()
        q[7:] += 0.5 * a * t * t
        command = controller.step(state(t, q=q, v=np.concatenate([np.zeros(6), a * t])))
        targets = command.joint_targets
        assert targets is not None
        middle = dt * (k // 4) + 0.5 * dt
        np.testing.assert_allclose(targets.velocities, a * middle, atol=1e-12)
        np.testing.assert_allclose(targets.positions, GO2.nominal[7:] + 0.5 * a * middle**2, atol=1e-12)
        np.testing.assert_array_equal(targets.feedforward, command.torques)
        np.testing.assert_array_equal(targets.torques(targets.positions, targets.velocities), command.torques)


def test_targets_do_not_run_away_from_joints_that_are_held() -> None:
    rate = np.full(18, 50.0)
    controller = JointTargetController(Aim(rate), GO2, DT)
    for k in range(400):
        command = controller.step(state(k * DT))
    targets = command.joint_targets
    assert targets is not None
    # fixed points of the recursion: x = (1 - dt / T) (x + what a step adds)
    speed = 50.0 * (MEMORY - DT)
    way = (MEMORY / DT - 1.0) * (DT * speed + 0.5 * DT * DT * 50.0)
    np.testing.assert_allclose(targets.velocities, speed + 0.5 * DT * 50.0, rtol=1e-9)
    middle = way + 0.5 * DT * speed + 0.125 * DT * DT * 50.0
    np.testing.assert_allclose(targets.positions - GO2.nominal[7:], middle, rtol=1e-9)


def test_legs_that_carry_have_lower_gains() -> None:
    class Lifts(Aim):
        def step(self, state: RobotState) -> Command:
            return replace(super().step(state), active=np.array([True, False, True, True]))

    controller = JointTargetController(Lifts(np.zeros(18)), GO2, DT)
    targets = controller.step(state()).joint_targets
    assert targets is not None
    share = np.where(np.arange(12) // 3 == 1, 1.0, STANCE_GAIN)
    np.testing.assert_allclose(targets.stiffness, share * controller.stiffness)
    np.testing.assert_allclose(targets.damping, share * controller.damping)


def test_a_command_that_aims_at_nothing_stays_torques() -> None:
    controller = JointTargetController(Aim(None), GO2, DT)
    assert controller.step(state()).joint_targets is None
    with pytest.raises(ProblemError, match="every"):
        JointTargetController(Aim(None), GO2, DT, every=0)


def test_a_watchdog_damps_joints_without_a_fresh_state() -> None:
    aim = Aim(np.zeros(18))
    watchdog = Watchdog(aim, GO2, DT, patience=0.02)
    for k in range(100):
        time = k * DT
        heard = time if not 0.03 <= time < 0.08 else 0.029
        command = watchdog.step(state(heard))
        old = round((time - heard) / DT)
        assert command.stale == (old > 20)
        assert command.attained == (not command.stale)
        assert command.rows() == {"stale": command.stale}
        if command.stale:
            targets = command.joint_targets
            assert targets is not None
            braking = targets.torques(np.full(12, 9.0), np.linspace(-5.0, 5.0, 12))
            np.testing.assert_allclose(braking, -targets.damping * np.linspace(-5.0, 5.0, 12))
            assert (targets.damping > 0.0).all()
    assert len(aim.seen) == 100 - 30  # not asked while the state is older than 20 steps


def test_joint_targets_are_the_drives_law() -> None:
    one = np.ones(2)
    targets = JointTargets(2.0 * one, 3.0 * one, 10.0 * one, 0.5 * one, 4.0 * one)
    np.testing.assert_allclose(targets.torques(one, one), 4.0 + 10.0 + 1.0)
