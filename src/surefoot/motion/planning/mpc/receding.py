"""Moving a plan on in time, and reading it between its knots."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics import Robot
from surefoot.motion.planning.shooting.horizon import FeedbackPolicy
from surefoot.motion.planning.shooting.state_space import feedback


def move_on(robot: Robot, q: FloatArray, v: FloatArray, torques: FloatArray, share: float, dt: float) -> None:
    """Let a plan begin a share of a knot later, in place: states and torques between those of the knots.

    The last state goes on at its velocity, the last torques stay.

    Parameters
    ----------
    robot
        Who moves.
    q, v, torques
        (N + 1, nq), (N + 1, nv) and (N, m).
    share
        0 to 1.
    dt
        Length of a knot [s].
    """
    import pinocchio

    for k in range(len(torques)):
        q[k] = pinocchio.interpolate(robot.model, q[k], q[k + 1], share)
    q[-1] = pinocchio.integrate(robot.model, q[-1], share * dt * v[-1])
    v[:-1] += share * np.diff(v, axis=0)
    torques[:-1] += share * np.diff(torques, axis=0)


def torques_between(
    robot: Robot, here: tuple[FloatArray, FloatArray], plan: FeedbackPolicy, knot: int, share: float,
    limits: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return a knot's torques (m,) and its feedback on the state planned for now, within limits.

    Parameters
    ----------
    robot
        Who moves.
    here
        (nq,) and (nv,) of the state.
    plan
        Motion and gains; its steps are not taken.
    knot, share
        Which one, and how much of its time has passed.
    limits
        (2, m) lower and upper bounds [N m].
    """
    import pinocchio

    place = pinocchio.interpolate(robot.model, plan.q[knot], plan.q[knot + 1], share)
    speed = plan.v[knot] + share * (plan.v[knot + 1] - plan.v[knot])
    planned, torques = (place, speed), plan.torques[knot]
    return feedback(robot.floating, here, planned, torques, torques, 0.0, plan.gains[knot], limits)
