"""The guard: the forces that it believes in, what it lets pass, and what it does on ice."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.robot.jacobians import contact_jacobian
from surefoot.motion.control.controller import Command, Controller, JointTargets, RobotState
from surefoot.motion.policy.guard import implied_forces

ON = np.ones(4, dtype=bool)


class Held(Controller):
    """Joint targets that never change."""

    facts = {"kind": "stand", "normal_min": 0.0, "normal_max": np.inf, "mu_controller": 0.6}  # noqa: RUF012

    def __init__(self, robot: Robot, goal: np.ndarray) -> None:
        none = np.zeros(robot.joints)
        self.robot, self.targets = robot, JointTargets(goal, none, none + 60.0, none + 2.0, none)

    def step(self, state: RobotState) -> Command:
        return Command(self.targets.torques(state.q[7:], state.v[6:]), joint_targets=self.targets)


def standing(robot: Robot, q: np.ndarray) -> np.ndarray:
    """Return torques with which every foot carries a quarter of the weight."""
    gravity = pinocchio.computeGeneralizedGravity(robot.model, robot.data, q)
    J = contact_jacobian(robot, q, robot.stance(q))
    return np.asarray((gravity - J.T @ np.tile([0.0, 0.0, robot.mass * 9.81 / 4.0], 4))[6:])


def implied(guard: sf.Guard, q: np.ndarray, v: np.ndarray, torques: np.ndarray) -> tuple[np.ndarray, ...]:
    body, points = guard._body, guard._points
    now, views = body.update(q, v), body._views
    return implied_forces(
        views.mass_matrix, views.bias, views.twists, points.foot_support, points.foot, body.foot_rotations,
        views.frame_places[guard._frame_of], points.centres, points.foot_radii, guard._frames(now.centres),
        now.drifts, v, torques, ON,
    )  # fmt: skip


def test_the_forces_are_those_of_a_step_of_the_rigid_world(go2: Robot) -> None:
    q, r = sf.place(go2), np.random.default_rng(3)
    calm, seen = standing(go2, q), 0
    for _ in range(5):
        torques = calm + 4.0 * r.normal(size=12)
        world = sf.RigidWorld(go2, mu=50.0, dt=1e-6)
        world.reset(q)
        world.step(torques)
        on, forces, _ = implied(sf.Guard(Held(go2, q[7:])), q, np.zeros(18), torques)
        measured = world.contacts().forces
        if (measured[:, 2] > 5.0).all():  # none leaves, none slides
            seen += 1
            assert on.all()
            assert forces == pytest.approx(measured, rel=1e-3, abs=0.05)
    assert seen >= 3


def test_what_is_lawful_passes_and_what_is_not_becomes_so(go2: Robot) -> None:
    q = sf.place(go2)
    held = standing(go2, q)
    straight = q[7:] + held / 60.0
    spread = straight.copy()
    spread[[0, 6]] += 0.6
    spread[[3, 9]] -= 0.6
    state = RobotState(q, np.zeros(18), contact=ON)
    for goal, changed in ((straight, False), (spread, True)):
        inner = Held(go2, goal)
        guard = sf.Guard(inner, mu=0.3)
        command = guard.step(state)
        assert guard.changed == changed
        assert (command.joint_targets is None) == changed
        if changed:
            assert np.hypot(*command.forces[:, :2].T) == pytest.approx(0.3 * command.forces[:, 2], rel=0.2)
            assert (np.abs(command.torques) <= go2.effort_limits).all()
            _, forces, _ = implied(guard, q, np.zeros(18), command.torques)
            assert (np.hypot(forces[:, 0], forces[:, 1]) <= 0.3 * forces[:, 2] + 0.1).all()
    assert guard.step(state._replace(q=np.full(19, np.nan))).joint_targets is not None  # as it came
    assert guard.step(state._replace(contact=~ON)).joint_targets is not None  # in the air


def test_feet_that_are_pulled_apart_stay_on_ice(go2: Robot) -> None:
    q = sf.place(go2)
    goal = q[7:] + standing(go2, q) / 60.0
    goal[[0, 6]] += 0.3
    goal[[3, 9]] -= 0.3
    slid = []
    for controller in (Held(go2, goal), sf.Guard(Held(go2, goal), mu=0.15)):
        log = sf.run(sf.RigidWorld(go2, mu=0.15), controller, sf.Scenario(0.4, mu=0.15, start=q))
        slid.append(float(np.linalg.norm(log["contact_velocities"][..., :2], axis=-1).sum()) * 1e-3)
    print(f"\nslid {slid[0]:.3f} m alone, {slid[1]:.3f} m with the guard")
    assert slid[1] < 0.2 * slid[0]


def test_a_guard_without_a_robot_is_refused() -> None:
    class Nobody(Controller):
        def step(self, state: RobotState) -> Command:
            return Command(np.zeros(12))

    with pytest.raises(ProblemError, match="needs a robot"):
        sf.Guard(Nobody())
