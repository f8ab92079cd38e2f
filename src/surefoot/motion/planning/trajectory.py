"""A motion of a robot as knots that exact first-order steps link: what every plan is in the end.

Whatever found a plan (a softened problem, a shooting solver, a mode schedule), its torques are run through
the same step again (`dynamics.MomentumKnot`): rigid contact, exact Coulomb friction, every contact
problem solved to 1e-8, momentum changed by impulses and gravity alone. The laws' residual of a plan is the
residual of these problems and of nothing else.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, finite_array, of_kind, real_number
from surefoot.base.errors import ProblemError
from surefoot.mechanics import MomentumKnot, Robot, StepOptions, Stepper, Terrain, velocity_of_way

TOLERANCE = 1e-8
"""Of the contact problems of a plan, see `surefoot.contact.problem.Residuals`."""
TorquePolicy = Callable[[int, FloatArray, FloatArray], FloatArray]
"""Torques (joints,) of a knot, its number and state: (k, q, v)."""


@dataclass(frozen=True)
class Trajectory:
    """States, torques and impulses of N knots.

    Attributes
    ----------
    dt
        Length of a knot [s].
    mu
        Friction of the ground [-].
    q, v
        (N + 1, nq), (N + 1, nv) configurations [m, -, rad] and velocities [m/s, rad/s], Pinocchio's order;
        the velocities at the knots have the momentum of the way there (`MomentumKnot.velocity_at_end`).
    ways
        (N + 1, nv) velocities of the ways to the knots, which steps and programs take.
    torques
        (N, joints) [N m].
    impulses
        (N, p, 3) of the ground on the contact points, contact axes [N s].
    gaps
        (N + 1, p) distances of the contact points to the ground [m].
    positions
        (N + 1, p, 3) of the contact points, world axes [m].
    speeds
        (N, p, 3) velocities of the contact points that go with the impulses, contact axes [m/s].
    residuals
        (N,) velocity error of each knot's contact problem [-], NaN where the motion was lost.
    solved
        (N,) whether it is solved to `TOLERANCE`.
    touch_impulses
        (N, t, 3) of touches beside feet on the ground [N s]; None for none.
    """

    dt: float
    mu: float
    q: FloatArray
    v: FloatArray
    ways: FloatArray
    torques: FloatArray
    impulses: FloatArray
    gaps: FloatArray
    positions: FloatArray
    speeds: FloatArray
    residuals: FloatArray
    solved: BoolArray
    touch_impulses: FloatArray | None = None

    @classmethod
    def blank(cls, robot: Robot, count: int, dt: float, mu: float) -> Trajectory:
        """Return a trajectory of `count` knots whose states are not known yet: NaN."""
        model, p = robot.model, len(robot.contact_points)
        speeds = np.full((count + 1, model.nv), np.nan)
        return cls(
            dt, mu, np.full((count + 1, model.nq), np.nan), speeds, speeds.copy(),
            np.zeros((count, robot.joints)), np.zeros((count, p, 3)), np.full((count + 1, p), np.nan),
            np.full((count + 1, p, 3), np.nan), np.full((count, p, 3), np.nan), np.full(count, np.nan),
            np.zeros(count, dtype=bool),
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.torques)

    @property
    def times(self) -> FloatArray:
        """(N + 1,) of the states [s]."""
        return np.asarray(self.dt * np.arange(len(self) + 1), dtype=np.float64)

    @property
    def lawful(self) -> bool:
        """Whether every contact problem is solved and everything is finite."""
        return bool(self.solved.all() and np.isfinite(self.q).all() and np.isfinite(self.v).all())

    @property
    def law_residual(self) -> float:
        """Largest velocity error of a contact problem, relative to its scale; infinite where one failed."""
        worst = float(np.max(self.residuals, initial=0.0))
        return worst if self.lawful and np.isfinite(worst) else np.inf

    def locate(self, stepper: Stepper) -> None:
        """Fill in where the contact points are, and how they move on the way to the knot's end."""
        for k, q in enumerate(self.q):
            if not np.isfinite(q).all():
                return
            seen = stepper.contacts(stepper.start(q))
            self.gaps[k], self.positions[k] = seen.gaps, seen.positions
            if k < len(self):
                self.speeds[k] = seen.velocities(self.ways[k + 1])


def rollout(
    robot: Robot,
    q: FloatArray,
    v: FloatArray,
    torques: FloatArray | TorquePolicy,
    *,
    dt: float,
    mu: float = 0.6,
    terrain: Terrain | None = None,
    steps: int | None = None,
) -> Trajectory:
    """Return where torques lead from a state, by exact first-order steps.

    Parameters
    ----------
    robot
        Whose feet touch the ground.
    q, v
        (nq,), (nv,) the first state [m, -, rad] and [m/s, rad/s], Pinocchio's order.
    torques
        (N, joints) [N m], or a policy that is asked at every knot; the torques that it gives become those of
        the trajectory.
    dt
        Length of a knot [s].
    mu
        Friction of the ground [-].
    terrain
        None for flat ground.
    steps
        Number of knots for a policy.

    Returns
    -------
    Trajectory
        Where the motion is lost, all that follows is NaN and not solved.

    Raises
    ------
    ProblemError
        For states or torques of the wrong shape, or not finite, and a policy without `steps`.

    Examples
    --------
    >>> from surefoot.mechanics.robot import load_robot, place
    >>> robot = load_robot("go2")
    >>> falling = rollout(robot, place(robot), np.zeros(18), np.zeros((10, 12)), dt=0.01)
    >>> falling.q.shape, falling.lawful, falling.law_residual < 1e-8
    ((11, 19), True, True)
    """
    of_kind("robot", robot, Robot)
    model = robot.model
    q, v = finite_array("q", q, (model.nq,)), finite_array("v", v, (model.nv,))
    mu, (policy, count) = real_number("mu", mu, low=0.0), _policy(robot, torques, steps)
    knot = MomentumKnot(Stepper(robot, terrain, StepOptions(dt=dt, order=1, solver_tol=TOLERANCE)))
    out = Trajectory.blank(robot, count, knot.stepper.options.dt, mu)
    out.q[0], out.v[0] = q, v
    out.ways[0] = velocity_of_way(model, q, v, dt)
    for k in range(count):
        out.torques[k] = policy(k, out.q[k], out.ways[k])
        step = knot.step(out.q[k], out.ways[k], out.torques[k], mu)
        if not np.isfinite(step.v).all():
            break
        out.q[k + 1], out.v[k + 1], out.impulses[k] = step.q, knot.velocity_at_end(step), step.impulses
        out.ways[k + 1], out.residuals[k], out.solved[k] = step.v, step.residual, step.solved
    out.locate(knot.stepper)
    return out


def _policy(robot: Robot, torques: FloatArray | TorquePolicy, steps: int | None) -> tuple[TorquePolicy, int]:
    """Return who gives the torques, and for how many knots."""
    if callable(torques):
        if steps is None or steps < 1:
            raise ProblemError(f"a rollout of a policy needs steps >= 1, got {steps!r}")
        return torques, steps
    given = finite_array("torques", torques, (None, robot.joints))
    return (lambda k, q, v: given[k]), len(given)
