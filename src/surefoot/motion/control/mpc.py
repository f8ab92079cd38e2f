"""Convex model-predictive control of a legged body on exact friction cones.

`ConvexMpc` chooses the contact forces of the next steps of a gait so that a single rigid body follows a
reference. Friction is the exact cone in each foot's own contact frame; a foot in swing has no force
because it is not an unknown. The model is in `mpc_model`, the algorithm in `dual_newton.horizon`.
"""

from __future__ import annotations

import math
from dataclasses import InitVar, dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import (
    FloatArray,
    finite_array,
    numbers,
    of_kind,
    per_contact,
    real_array,
    real_number,
    whole_number,
)
from surefoot.base.errors import ProblemError, shown
from surefoot.base.memory import Remembering
from surefoot.base.settings import Settings, setting
from surefoot.base.spatial import GRAVITY
from surefoot.contact import Status
from surefoot.motion.control import mpc_model
from surefoot.motion.control.body_motion import BodyReference, BodyState


@dataclass(frozen=True)
class MpcWeights(Settings):
    """What deviations cost, per step; the axes are the heading's (forward, left, up).

    The body's errors are in m, rad, m/s, rad/s; `force` is the weight on the squared deviation of every
    force [N²] from its share of the body's weight. Velocity weights must be positive.
    """

    position: tuple[float, float, float] = setting(
        (10.0, 10.0, 100.0), "1/m²", "weight on places",
        tuned="`surefoot bench ablation --vary MpcWeights.position --factor 20 "
        "--task laden --seeds 3`, 2026-11-26: as good from 0.5, 0.5, 5 to 10, 10, 100; "
        "a twentieth takes less work on `fast`",
    )  # fmt: skip
    orientation: tuple[float, float, float] = setting((50.0, 50.0, 30.0), "1/rad²", "weight on orientation")
    linear_velocity: tuple[float, float, float] = setting((2.0, 2.0, 1.0), "s²/m²", "weight on velocity")
    angular_velocity: tuple[float, float, float] = setting(
        (0.3, 0.3, 0.3), "s²/rad²", "weight on angular velocity"
    )
    force: float = setting(
        1e-5, "1/N²", "weight on a force's deviation from its share of the weight",
        tuned="`surefoot bench ablation --vary MpcWeights.force --factor 20 "
        "--task fast --seeds 3`, 2026-11-25: as good from 1e-05 to 0.0002",
    )  # fmt: skip
    terminal: float = setting(
        1.0, "-", "weight of the last step over that of the others",
        tuned="`surefoot bench ablation --vary MpcWeights.terminal --factor 20 "
        "--task fast --seeds 6`, 2026-11-26: as good from 0.05 to 1",
    )  # fmt: skip

    def matrix(self) -> FloatArray:
        """Return the (2, 6) weights on [position; orientation] and on their rates, in one unit of cost.

        Raises
        ------
        ProblemError
            For a negative or infinite weight, or a velocity weight that is not positive.
        """
        place = [finite_array(n, getattr(self, n), (3,)) for n in ("position", "orientation")]
        rate = [finite_array(n, getattr(self, n), (3,)) for n in ("linear_velocity", "angular_velocity")]
        out = np.vstack([np.concatenate(place), np.concatenate(rate)])
        if (out[0] < 0.0).any():
            raise ProblemError(f"MPC weights must be >= 0, got position and orientation {out[0]}")
        if (out[1] <= 0.0).any():
            raise ProblemError(f"MPC weights on velocities must be > 0, got {out[1]}")
        real_number("force weight", self.force, low=1e-12, high=1e12)
        real_number("terminal weight", self.terminal, low=1e-6, high=1e6)
        return out


@dataclass(frozen=True)
class MpcPlan:
    """The forces of a horizon and what they should lead to.

    Attributes
    ----------
    forces
        (N, n, 3) in the contact frames [N], always inside their cones and bounds; zero in swing.
    forces_world
        (N, n, 3) the same in world axes.
    position, linear_velocity, angular_velocity
        (N + 1, 3) predicted motion, world axes; row 0 is the state.
    orientation_error
        (N + 1, 3) predicted rotation vector from the reference to the body, world axes [rad].
    status
        SOLVED when `error` is within the tolerance, ALMOST within a thousand times of it,
        MAX_ITERATIONS above that, INVALID for a state or reference that is not finite (the forces then
        share the body's weight).
    error
        Bound on the distance of all forces together to the optimum [N].
    iterations
        Newton steps taken.
    """

    forces: FloatArray
    forces_world: FloatArray
    position: FloatArray
    linear_velocity: FloatArray
    angular_velocity: FloatArray
    orientation_error: FloatArray
    status: Status
    error: float
    iterations: int

    @property
    def first(self) -> FloatArray:
        """(n, 3) forces of the first step, contact frames [N]."""
        return np.asarray(self.forces[0])

    @property
    def solved(self) -> bool:
        """Whether the status is SOLVED."""
        return self.status is Status.SOLVED


__all__ = ["BodyReference", "BodyState", "ConvexMpc", "MpcPlan", "MpcWeights"]

NO_ROTATION = "frames of contacts must be right-handed rotations (3, 3)"
ALMOST_FACTOR = 1e3
"""Forces whose error bound is within this factor of the tolerance are ALMOST solved [-]: 10 N by default."""

PATIENCE = 16
"""Full Newton steps that may go too far before the force weight is lowered in stages [-], see
`contact.solvers.dual_newton.horizon`."""


@dataclass
class ConvexMpc(Remembering):
    """Model-predictive control of a single rigid body on exact friction cones.

    Every step of the horizon, every foot in contact carries one force; together they minimise the weighted
    squared errors of the body's motion against its reference, plus a small weight on the forces, within
    ||f_t|| <= mu f_n and the normal bounds. Each answer carries a bound on its distance to that optimum, and
    starts from the previous one; call `shift` when time has passed in between.

    Parameters
    ----------
    mass
        Of the robot [kg].
    inertia
        (3, 3) about the centre of mass, body axes [kg m²].
    feet
        Number of feet n.
    horizon, dt
        Number of steps N, and length of a step [s].
    mu
        Friction coefficient [-], a number or (n,); may be replaced in `solve`.
    normal_min, normal_max
        Bounds on the normal force of a foot in contact [N], numbers or (n,).
    weights
        See `MpcWeights`.
    tol
        Wanted bound on the error of all forces together [N].
    max_iterations
        Bound on the Newton steps of a plan.

    Attributes
    ----------
    outside
        (6,) force and moment about the centre of mass beside the contacts' and gravity's, world axes, now
        [N, N m]; it fades over the horizon with the time constant `fading` [s], infinite
        for no such thing.

    Raises
    ------
    ProblemError
        For numbers that describe no robot or horizon.

    Examples
    --------
    >>> mpc = ConvexMpc(mass=15.0, inertia=np.diag([0.1, 0.25, 0.3]), horizon=4)
    >>> reference = BodyReference.cruise([0, 0, 0.3], yaw=0.0, horizon=4)
    >>> state = BodyState(np.eye(3), np.array([0, 0, 0.3]), np.zeros(3), np.zeros(3))
    >>> feet = [[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.15, 0], [-0.2, -0.15, 0]]
    >>> plan = mpc.solve(state, reference, feet, np.ones((4, 4), dtype=bool))
    >>> bool(abs(plan.first[:, 2].sum() - 15.0 * 9.81) < 1e-3), plan.solved
    (True, True)
    """

    MEMORY = ("mass", "inertia", "dt", "outside", "fading", "_points", "_mobility")

    mass: float
    inertia: ArrayLike
    feet: int = 4
    horizon: int = 10
    dt: float = 0.03
    mu: InitVar[ArrayLike] = 0.6
    normal_min: InitVar[ArrayLike] = 0.0
    normal_max: InitVar[ArrayLike] = math.inf
    weights: MpcWeights = field(default_factory=MpcWeights)
    tol: float = 1e-2
    max_iterations: int = 100

    def __post_init__(self, mu: ArrayLike, normal_min: ArrayLike, normal_max: ArrayLike) -> None:
        real_number("mass", self.mass, low=1e-6, high=1e9)
        real_number("tol", self.tol, low=0.0, high=1e9)
        for name in ("horizon", "feet", "max_iterations"):
            setattr(self, name, whole_number(name, getattr(self, name), low=1))
        of_kind("weights", self.weights, MpcWeights)
        inertia = finite_array("inertia", self.inertia, (3, 3))
        if not np.allclose(inertia, inertia.T, rtol=1e-6, atol=0.0) or np.linalg.eigvalsh(inertia)[0] <= 0.0:
            raise ProblemError("inertia must be symmetric and positive definite")
        given = {"mu": mu, "normal_min": normal_min, "normal_max": normal_max}
        limits = [per_contact(name, value, self.feet) for name, value in given.items()]
        if not np.isfinite(limits[:2]).all():
            raise ProblemError("mu and normal_min must be finite")
        if (limits[1] > limits[2]).any():
            raise ProblemError("normal_min must not be above normal_max")
        self._bounds = np.tile(np.stack(limits, axis=1), (self.horizon, 1, 1))
        self._weights = self.weights.matrix()
        self.carry(self.mass, inertia)
        self.pace(self.dt)
        self.outside, self.fading = np.zeros(6), math.inf

    def pace(self, dt: float) -> None:
        """Take another length of a step [s]; the previous plan is forgotten."""
        self.dt = real_number("dt", dt, low=1e-6, high=10.0)
        self._points = np.full((self.horizon, self.feet, 3), np.nan)

    def carry(self, mass: float, inertia: FloatArray) -> None:
        """Take another mass [kg] and (3, 3) inertia about the centre of mass, body axes [kg m²]."""
        self.mass, self.inertia = mass, inertia
        self._mobility: FloatArray = np.linalg.inv(np.asarray(inertia, dtype=np.float64)).astype(np.float64)

    def expect(self, outside: FloatArray, fading: float | None = None) -> None:
        """Count on a (6,) wrench [N, N m] that fades [s], see `outside`; None leaves how it fades."""
        self.outside = outside
        if fading is not None:
            self.fading = fading

    def reset(self) -> None:
        """Forget the previous plan."""
        self._points[:] = np.nan

    def shift(self, elapsed: float) -> None:
        """Move the remembered plan on by the steps of the time since it was made [s]: a warm start."""
        steps = real_number("elapsed", elapsed, low=-1e9, high=1e9) / self.dt
        # The last step is repeated for those that come into the horizon: as a warm start it only tells which
        # contacts stick, slide or lift.
        ahead = np.arange(self.horizon) + round(max(steps, 0.0))
        self._points = self._points[np.minimum(ahead, self.horizon - 1)]

    def solve(
        self,
        state: BodyState,
        reference: BodyReference,
        foot_positions: ArrayLike,
        contacts: ArrayLike,
        frames: ArrayLike | None = None,
        *,
        mu: ArrayLike | None = None,
    ) -> MpcPlan:
        """Plan the forces of the horizon.

        Parameters
        ----------
        state, reference
            The body now, and where it should be.
        foot_positions
            (n, 3) or (N, n, 3) contact points, world axes [m]; those of feet in swing do not matter.
        contacts
            (N, n) mask: whether each foot carries force during each step.
        frames
            (n, 3, 3) or (N, n, 3, 3) rotations rotation_world_contact; None for level ground.
        mu
            Friction [-], (n,) or (N, n), in place of the one given at construction.

        Returns
        -------
        MpcPlan
            Also for an instance that could not be solved: look at its status.

        Raises
        ------
        ProblemError
            For arrays of the wrong shape, negative friction, or frames that are no rotations.
        """
        given = self.given(state, reference, foot_positions, contacts, frames, mu)
        verdict, total, error, forces, world, motion, turn = mpc_model.plan_forces(
            given, self.body(), self._points, self.tol, PATIENCE, self.max_iterations
        )
        if verdict == mpc_model.NOT_ROTATION:
            raise ProblemError(NO_ROTATION)
        if verdict == mpc_model.NOT_FINITE:
            return self._share_weight(given)
        status = Status.SOLVED if error <= self.tol else Status.MAX_ITERATIONS
        if self.tol < error <= ALMOST_FACTOR * self.tol:
            status = Status.ALMOST
        return MpcPlan(forces, world, motion[:, 0], motion[:, 1], motion[:, 2], turn, status, error, total)

    def body(self) -> mpc_model.SingleBody:
        """Return what is moved, as of now."""
        weights = self.weights
        return mpc_model.SingleBody(
            float(self.mass), self._mobility, self._weights, float(weights.terminal), float(self.dt),
            float(weights.force), self.outside, float(self.fading),
        )  # fmt: skip

    def given(
        self,
        state: BodyState,
        reference: BodyReference,
        foot_positions: ArrayLike,
        contacts: ArrayLike,
        frames: ArrayLike | None,
        mu: ArrayLike | None,
    ) -> mpc_model.Given:
        """Return the input as full, contiguous arrays; parameters, units and errors are those of `solve`."""
        N, n = self.horizon, self.feet
        known = isinstance(contacts, np.ndarray) and contacts.dtype == np.bool_
        schedule = np.ascontiguousarray(contacts if known else real_array("contacts", contacts) != 0.0)
        if schedule.shape != (N, n):
            raise ProblemError(f"contacts must have shape ({N}, {n}), got {schedule.shape}")
        feet = _over_horizon("foot_positions", foot_positions, (N, n, 3))
        if frames is None:
            frames = np.tile(np.eye(3), (n, 1, 1))
        turned = _over_horizon("frames", frames, (N, n, 3, 3))
        bounds = self._bounds if mu is None else self._with_friction(mu)
        motion, ref_motion = np.empty((3, 3)), np.empty((N + 1, 3, 3))
        try:
            rotation = np.ascontiguousarray(state.rotation, dtype=np.float64).reshape(3, 3)
            ref_rotation = np.ascontiguousarray(reference.rotation, dtype=np.float64).reshape(N + 1, 3, 3)
            motion[0], motion[1], motion[2] = state.position, state.linear_velocity, state.angular_velocity
            ref_motion[:, 0] = reference.position
            ref_motion[:, 1] = reference.linear_velocity
            ref_motion[:, 2] = reference.angular_velocity
        except (ValueError, TypeError, AttributeError) as error:
            raise ProblemError(f"state or reference does not fit a horizon of {N} steps: {error}") from error
        return mpc_model.Given(schedule, feet, turned, bounds, rotation, motion, ref_rotation, ref_motion)

    def _with_friction(self, mu: ArrayLike) -> FloatArray:
        """Return the (N, n, 3) bounds with another friction."""
        N, n = self.horizon, self.feet
        friction = finite_array("mu", mu)
        if friction.shape not in ((), (n,), (N, n)) or (friction < 0.0).any():
            raise ProblemError(f"mu must be >= 0 with shape ({n},) or ({N}, {n}), got {shown(mu)}")
        bounds = self._bounds.copy()
        bounds[:, :, 0] = friction
        return bounds

    def _share_weight(self, given: mpc_model.Given) -> MpcPlan:
        """Return the plan of last resort: the weight shared by the feet in contact, flagged INVALID."""
        N, n = given.contacts.shape
        self.reset()
        standing = np.maximum(given.contacts.sum(axis=1, keepdims=True), 1)
        normal = np.clip(self.mass * GRAVITY / standing, given.bounds[..., 1], given.bounds[..., 2])
        forces = np.zeros((N, n, 3))
        forces[:, :, 2] = given.contacts * normal
        a, b, c, d = np.zeros((4, N + 1, 3))
        return MpcPlan(forces, forces.copy(), a, b, c, d, Status.INVALID, math.inf, 0)


def _over_horizon(name: str, value: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    """Return a value of one step, or of every step, at the full shape."""
    array = numbers(name, value)
    if array.shape not in (shape[1:], shape):
        raise ProblemError(f"{name} must have shape {shape[1:]} or {shape}, got {array.shape}")
    return np.array(np.broadcast_to(array, shape), order="C")
