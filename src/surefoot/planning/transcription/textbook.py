"""Five small problems through contact: a falling ball, a sliding point, a hopper, a push and a kick."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from surefoot.planning.transcription.forms import import_casadi
from surefoot.planning.transcription.problem import CLOSE, SmallProblem
from surefoot.planning.transcription.systems import Touch, along_ground, point_masses


def falling_ball(height: float = 1.0, knots: int = 50, dt: float = 0.02) -> SmallProblem:
    """Return a ball of 1 kg that falls and stays where it lands: no input, the laws alone decide."""

    def place(q: Any) -> tuple[Any, Any]:
        return 0.0, q[0]

    system = point_masses("ball", ["z"], [], [(1.0, place)], [Touch("ball", along_ground(place))])
    return SmallProblem(
        "ball",
        f"falls from {height:g} m: fall, contact, rest",
        system,
        q=np.array([height]),
        v=np.zeros(1),
        knots=knots,
        dt=dt,
        done=lambda m: bool(max(abs(m.q[-1, 0]), abs(m.v[-1, 0])) < CLOSE),
        towards=np.zeros(1),
        spread=np.full(1, 0.3),
    )


def sliding_point(speed: float = 2.0, mu: float = 0.5, knots: int = 40, dt: float = 0.02) -> SmallProblem:
    """Return a point of 1 kg that slides over the ground until friction has stopped it."""

    def place(q: Any) -> tuple[Any, Any]:
        return q[0], q[1]

    system = point_masses("point", ["x", "z"], [], [(1.0, place)], [Touch("point", along_ground(place), mu)])
    return SmallProblem(
        "slide",
        f"slides with {speed:g} m/s, mu {mu:g}: slip, stick",
        system,
        q=np.zeros(2),
        v=np.array([speed, 0.0]),
        knots=knots,
        dt=dt,
        done=lambda m: bool(np.abs(m.v[-1]).max() < CLOSE and m.q[-1, 0] > 0.0),
        towards=np.array([0.5, 0.0]),
        spread=np.full(2, 0.1),
    )


BODY, FOOT, LEG = 3.0, 0.3, 0.5
"""The hopper's masses [kg] and its leg's length as it stands [m]."""
HOPPER_LIMIT = (40.0, 200.0)
"""Of the motors of its hip [N m] and leg [N]."""


def hopper(distance: float = 0.3, mu: float = 0.6, knots: int = 30, dt: float = 0.03) -> SmallProblem:
    """Return a planar hopper, an upright body on one leg, that is to stand `distance` [m] further on.

    Coordinates x, z of the body, the hip's angle (the leg leans back where it is positive) and the leg's
    length; motors turn the hip and push along the leg.
    """
    casadi = import_casadi()

    def foot(q: Any) -> tuple[Any, Any]:
        return q[0] - q[3] * casadi.sin(q[2]), q[1] - q[3] * casadi.cos(q[2])

    system = point_masses(
        "hopper",
        ["x", "z", "hip", "leg"],
        [2, 3],
        [(BODY, lambda q: (q[0], q[1])), (FOOT, foot)],
        [Touch("foot", along_ground(foot), mu)],
    )
    start, end = np.array([0.0, LEG, 0.0, LEG]), np.array([distance, LEG, 0.0, LEG])
    return SmallProblem(
        "hopper",
        f"from standing to standing {distance:g} m further on",
        system,
        q=start,
        v=np.zeros(4),
        knots=knots,
        dt=dt,
        towards=end,
        spread=np.array([0.1, 0.1, 0.3, 0.05]),
        goal=lambda q, v: casadi.vertcat(q - end, v),
        low=np.array([-np.inf, 0.2, -1.2, 0.25]),
        high=np.array([np.inf, np.inf, 1.2, 0.65]),
        limit=np.array(HOPPER_LIMIT),
        effort=1e-3,
    )


BLOCK_WIDTH, FOOT_RADIUS = 0.2, 0.02
"""Of the block and of the foot that pushes it [m]."""
BLOCK, PUSHER, PUSH_LIMIT = 2.0, 0.5, (40.0, 40.0)
"""Their masses [kg], and what moves the foot along x and z [N]."""


def pushed_block(distance: float = 0.3, mu: float = 0.4, knots: int = 25, dt: float = 0.04) -> SmallProblem:
    """Return a block of 2 kg that a foot, 10 cm away, is to push `distance` [m] on, where it rests.

    Coordinates x, z of the block, which does not tilt, and of the foot (0.5 kg), moved by forces in x and z.
    """

    def block(q: Any) -> tuple[Any, Any]:
        return q[0], q[1]

    def foot(q: Any) -> tuple[Any, Any]:
        return q[2], q[3]

    def face(q: Any) -> tuple[Any, Any]:
        return q[0] - 0.5 * BLOCK_WIDTH - FOOT_RADIUS - q[2], q[3] - q[1]

    touches = [
        Touch("block", along_ground(block), mu),
        Touch("foot on block", face, 0.3),
        Touch("foot", along_ground(foot, FOOT_RADIUS), mu),
    ]
    system = point_masses(
        "block and foot", ["block_x", "block_z", "foot_x", "foot_z"], [2, 3],
        [(BLOCK, block), (PUSHER, foot)], touches,
    )  # fmt: skip
    start = np.array([0.0, 0.0, -0.5 * BLOCK_WIDTH - FOOT_RADIUS - 0.1, 0.1])

    return SmallProblem(
        "push",
        f"a foot pushes a block {distance:g} m on, to rest",
        system,
        q=start,
        v=np.zeros(4),
        knots=knots,
        dt=dt,
        towards=start + np.array([distance, 0.0, distance + 0.1, 0.0]),
        spread=np.array([0.1, 0.02, 0.1, 0.02]),
        goal=lambda q, v: import_casadi().vertcat(q[0] - distance, v),
        low=np.array([-np.inf, -np.inf, -np.inf, FOOT_RADIUS]),
        high=np.array([np.inf, np.inf, np.inf, 0.18]),
        limit=np.array(PUSH_LIMIT),
        effort=1e-2,
    )


HIP_HEIGHT, LINK, BALL_RADIUS = 0.6, 0.28, 0.1
"""The kicker's hip over the ground, its links, and the ball [m]."""


def kicker(distance: float = 0.8, knots: int = 25, dt: float = 0.03) -> SmallProblem:
    """Return a leg of two links on a fixed hip that is to kick a ball so that it arrives `distance` [m] on.

    Coordinates hip, knee, and x, z of the ball, which slides without friction; the leg ends at rest.
    """
    casadi = import_casadi()

    def knee(q: Any) -> tuple[Any, Any]:
        return LINK * casadi.sin(q[0]), HIP_HEIGHT - LINK * casadi.cos(q[0])

    def foot(q: Any) -> tuple[Any, Any]:
        x, z = knee(q)
        return x + LINK * casadi.sin(q[0] + q[1]), z - LINK * casadi.cos(q[0] + q[1])

    def ball(q: Any) -> tuple[Any, Any]:
        return q[2], q[3]

    def strike(q: Any) -> tuple[Any, Any]:
        (x, z), (bx, bz) = foot(q), ball(q)
        return casadi.hypot(bx - x, bz - z) - BALL_RADIUS - FOOT_RADIUS, casadi.SX(0.0)

    system = point_masses(
        "kicker",
        ["hip", "knee", "ball_x", "ball_z"],
        [0, 1],
        [(1.0, knee), (0.5, foot), (0.4, ball)],
        [
            Touch("ball", along_ground(ball, BALL_RADIUS)),
            Touch("foot on ball", strike),
            Touch("foot", along_ground(foot, FOOT_RADIUS)),
        ],
    )
    start = np.array([0.0, -0.6, 0.25, BALL_RADIUS])
    end = start[2] + distance

    return SmallProblem(
        "kicker",
        f"a leg kicks a ball, which arrives {distance:g} m on",
        system,
        q=start,
        v=np.zeros(4),
        knots=knots,
        dt=dt,
        towards=np.array([0.5, -0.2, end, BALL_RADIUS]),
        spread=np.array([0.3, 0.3, 0.1, 0.05]),
        goal=lambda q, v: casadi.vertcat(q[2] - end, v[0], v[1]),
        low=np.array([-1.5, -2.0, -np.inf, -np.inf]),
        high=np.array([1.5, 0.0, np.inf, np.inf]),
        limit=np.array([30.0, 30.0]),
        effort=1e-2,
    )


PROBLEMS: dict[str, Callable[[], SmallProblem]] = {
    "ball": falling_ball,
    "slide": sliding_point,
    "hopper": hopper,
    "push": pushed_block,
    "kicker": kicker,
}
"""The problems by name."""
