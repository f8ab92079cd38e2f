"""Plans made over two steps of the controller, and the arrays that they need."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.control.mpc import BodyReference, BodyState, ConvexMpc
from surefoot.control.walking import WalkingController
from surefoot.control.walking_body import VelocityCommand
from surefoot.errors import ProblemError
from surefoot.robot import load_robot
from surefoot.simulation.mujoco import MujocoWorld
from surefoot.simulation.run import run
from surefoot.simulation.scenario import Scenario

FEET = [[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.15, 0], [-0.2, -0.15, 0]]


def test_no_step_sets_up_a_horizon_and_solves_it_but_the_first() -> None:
    robot = load_robot("go2")
    walker = WalkingController(robot, VelocityCommand.constant(0.5))
    planner, steps = walker.planner, []
    set_up, solve, step = planner.set_up, planner.solve, walker.step

    def told(name, call):  # type: ignore[no-untyped-def]
        def inner(*args):  # type: ignore[no-untyped-def]
            steps[-1].append(name)
            return call(*args)

        return inner

    planner.set_up = told("set up", set_up)  # type: ignore[method-assign]
    planner.solve = told("solve", solve)  # type: ignore[method-assign]

    def counted(state):  # type: ignore[no-untyped-def]
        steps.append([])
        return step(state)

    walker.step = counted  # type: ignore[method-assign]
    run(MujocoWorld(robot), walker, Scenario(1.0, 0.6, start=robot.nominal))
    begun = [i for i, done in enumerate(steps) if done == ["set up", "solve"]]
    for i in begun:  # a walk begins with both: the one that warms up, and the real one
        assert i <= 3
    for i, done in enumerate(steps):
        if done == ["solve"]:
            assert steps[i - 1] == ["set up"]
        if done == ["set up"] and i + 1 < len(
            steps
        ):  # solved at once, or set up again for a foot that changed
            assert steps[i + 1] in (["solve"], ["set up"])
    assert sum(done == ["solve"] for done in steps) > 40


def test_another_step_length_is_that_of_a_fresh_controller() -> None:
    inertia = np.diag([0.1, 0.25, 0.3])
    state = BodyState(np.eye(3), np.array([0.0, 0.02, 0.3]), np.array([0.1, 0, 0]), np.array([0, 0.1, 0]))
    paced, fresh = (ConvexMpc(15.0, inertia, horizon=6, dt=dt) for dt in (0.03, 0.05))
    paced.solve(
        state,
        BodyReference.cruise([0, 0, 0.3], yaw=0.0, horizon=6, dt=0.03),
        FEET,
        np.ones((6, 4), dtype=bool),
    )
    paced.pace(0.05)
    reference = BodyReference.cruise([0, 0, 0.3], yaw=0.0, horizon=6, dt=0.05)
    a, b = (mpc.solve(state, reference, FEET, np.ones((6, 4), dtype=bool)) for mpc in (paced, fresh))
    np.testing.assert_allclose(a.forces, b.forces, rtol=0.0, atol=0.05)
    with pytest.raises(ProblemError, match="dt"):
        paced.pace(0.0)


def test_shares_of_another_shape_are_refused() -> None:
    mpc = ConvexMpc(15.0, np.diag([0.1, 0.25, 0.3]), horizon=4)
    state = BodyState(np.eye(3), np.array([0, 0, 0.3]), np.zeros(3), np.zeros(3))
    reference = BodyReference.cruise([0, 0, 0.3], yaw=0.0, horizon=4)
    with pytest.raises(ProblemError, match="normal_share"):
        mpc.solve(state, reference, FEET, np.ones((4, 4), dtype=bool), normal_share=np.ones((3, 4)))
