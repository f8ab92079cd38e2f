"""Centroidal motions over a mode schedule: centre of mass, angular momentum, contact forces, footholds.

The robot is its mass and an inertia that turns with it; forces are constant over a knot, so that its motion
under them is known exactly::

    c⁺ = c + dt v + dt²/2 a        v⁺ = v + dt a        a = Σ f / m + g
    h⁺ = h + dt Σ (p - c̄) x f      c̄ = c + dt v / 2 + dt² a / 6, the mean of c over the knot
    R⁺ = R exp(dt I⁻¹ R̄ᵀ h̄)        h̄ = (h + h⁺) / 2, R̄ half-way: of second order

Feet that stand have a foothold on the ground that stays while they do and is within a box about its place
below the hip, and forces inside the exact friction cone. Angular momentum is a cost, and within a bound if
one is given; nothing forces it to zero.

References
----------
.. [1] D. Orin, A. Goswami, S.-H. Lee, "Centroidal dynamics of a humanoid robot", Autonomous Robots 35, 2013.
.. [2] H. Dai, A. Valenzuela, R. Tedrake, "Whole-body motion planning with centroidal dynamics and full
   kinematics", Humanoids 2014.
.. [3] A. Winkler, C. Bellicoso, M. Hutter, J. Buchli, "Gait and trajectory optimization for legged systems
   through phase-based end-effector parameterization", RA-L 3, 2018.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, finite_array, real_number, whole_number
from surefoot.control.gait import ContactSchedule
from surefoot.errors import ProblemError
from surefoot.planning.direct.blocks import Block
from surefoot.planning.direct.problem import Window
from surefoot.planning.schedule.search import ACCEPTED, Found, Search, Sides, Tell, solve_blocks
from surefoot.planning.transcription.forms import import_casadi
from surefoot.spatial import GRAVITY
from surefoot.terrain import FlatTerrain, Terrain

ROUND = 1e-3
"""Rounds the cone's tip from inside, as a share of m g: sqrt(f_t² + ROUND²) <= mu f_n."""
STATE = 13
"""Numbers of a state before the footholds: c (3), quaternion (4), velocity (3), momentum / mass (3)."""


@dataclass(frozen=True)
class CentroidalWeights:
    """What a second of motion costs.

    Attributes
    ----------
    position, orientation
        Of the distance from the reference, squared [1/m², 1 per quaternion entry squared].
    velocity
        Of the centre's velocity, squared [s²/m²].
    momentum
        Of the angular momentum's distance from its reference per mass, squared [s²/m⁴].
    force
        Of forces as shares of m g, squared [-].
    foothold
        Of the distance of footholds that stand from their places below the hips, squared [1/m²].
    """

    position: float = 2.0
    orientation: float = 10.0
    velocity: float = 0.01
    momentum: float = 1.0
    force: float = 1.0
    foothold: float = 1.0

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            real_number(name, getattr(self, name), low=0.0)


@dataclass(frozen=True, eq=False)
class CentroidalProblem:
    """A motion that is asked for; poses are centre of mass and quaternion (x, y, z, w), as in Pinocchio.

    Attributes
    ----------
    mass, inertia
        [kg], and (3, 3) about the centre of mass, body axes [kg m²].
    stand
        (n, 3) where the feet are below the hips, from the centre of mass, body axes [m].
    schedule
        When each foot stands.
    dt, knots
        Length of a knot [s], and number of knots.
    pose, velocity
        (7,) at the start [m, -], (6,) velocity and angular momentum there [m/s, N m s].
    feet
        (n, 3) where the feet stand at the start [m]; those in the air do not matter.
    reference
        (knots + 1, 7) poses that cost nothing [m, -]; the quaternions of a full turn change their sign.
    momentum
        (3,) angular momentum that costs nothing, world axes [N m s].
    windows
        Bounds on poses (7,) and velocities with momenta (6,) of some knots, by their number.
    weights
        See `CentroidalWeights`.
    mu
        Friction that may be used [-].
    terrain
        A plane.
    reach
        (3,) half size of the box about `stand` in which a foot may stand, body axes [m].
    force_min, force_max
        Normal force of a foot that stands [N].
    momentum_bound
        (3,) largest size of the angular momentum at all knots but the first, world axes [N m s].

    Raises
    ------
    ProblemError
        For arrays that do not fit, numbers out of range, ground that is no plane, and a momentum bound that
        is not positive.
    """

    mass: float
    inertia: FloatArray
    stand: FloatArray
    schedule: ContactSchedule
    dt: float
    knots: int
    pose: FloatArray
    velocity: FloatArray
    feet: FloatArray
    reference: FloatArray
    momentum: FloatArray = field(default_factory=lambda: np.zeros(3))
    windows: Mapping[int, Window] = field(default_factory=dict)
    weights: CentroidalWeights = field(default_factory=CentroidalWeights)
    mu: float = 0.5
    terrain: Terrain = field(default_factory=FlatTerrain)
    reach: FloatArray = field(default_factory=lambda: np.array([0.15, 0.1, 0.12]))
    force_min: float = 0.0
    force_max: float = math.inf
    momentum_bound: FloatArray = field(default_factory=lambda: np.full(3, math.inf))

    def __post_init__(self) -> None:
        n = self.schedule.feet
        real_number("mass", self.mass, low=1e-6, high=1e9)
        real_number("dt", self.dt, low=1e-4, high=0.5)
        whole_number("knots", self.knots, low=2)
        real_number("mu", self.mu, low=1e-3, high=1e6)
        real_number("force_min", self.force_min, low=0.0, high=1e9)
        real_number("force_max", self.force_max, low=self.force_min)
        if not self.terrain.planar:
            raise ProblemError(f"a centroidal motion takes a plane for ground, got {self.terrain!r}")
        shapes = {
            "inertia": (3, 3), "stand": (n, 3), "pose": (7,), "velocity": (6,), "feet": (n, 3),
            "reference": (self.knots + 1, 7), "momentum": (3,), "reach": (3,),
        }  # fmt: skip
        for name, shape in shapes.items():
            object.__setattr__(self, name, finite_array(name, getattr(self, name), shape))
        even = np.allclose(self.inertia, self.inertia.T, rtol=1e-6)
        if not even or np.linalg.eigvalsh(self.inertia)[0] <= 0.0:
            raise ProblemError("inertia must be symmetric and positive definite")
        if (self.reach < 0.0).any():
            raise ProblemError(f"reach must be >= 0, got {self.reach}")
        bound = np.broadcast_to(np.asarray(self.momentum_bound, dtype=np.float64), (3,))
        if not (bound > 0.0).all():
            told = "a body that may have no angular momentum cannot turn"
            raise ProblemError(f"momentum_bound must be > 0 [N m s], got {bound}: {told}")
        object.__setattr__(self, "momentum_bound", bound)
        for k in self.windows:
            if not 0 < k <= self.knots:
                raise ProblemError(f"windows are of knots 1 to {self.knots}, got {k}")

    @property
    def weight(self) -> float:
        """M g [N]."""
        return self.mass * GRAVITY

    @property
    def stance(self) -> BoolArray:
        """(knots, n) which feet stand in each knot."""
        return self.schedule.horizon(0.0, self.dt, self.knots)

    @property
    def frame(self) -> FloatArray:
        """(3, 3) axes of the ground, the normal last."""
        return np.asarray(self.terrain.frame([0.0, 0.0]))

    @property
    def origin(self) -> FloatArray:
        """(3,) the point of the ground that footholds are measured from [m]."""
        return np.array([0.0, 0.0, float(self.terrain.height([0.0, 0.0]))])


@dataclass(frozen=True, eq=False)
class CentroidalMotion:
    """What the optimiser found; motion of T = N + 1 times under forces of N knots.

    Attributes
    ----------
    times
        (T,) [s].
    com, velocity, momentum
        (T, 3) centre of mass [m], its velocity [m/s], angular momentum about it [N m s]; world axes.
    quaternion
        (T, 4) orientation (x, y, z, w).
    forces
        (N, n, 3) in world axes [N].
    footholds
        (N, n, 3) where the feet stand [m], NaN in the air.
    stance
        (N, n) which feet stand.
    cost, violation
        Objective, and the largest violation of a row or bound in its own scale [-].
    found
        Whether the violation is within `search.ACCEPTED`.
    iterations
        Ipopt's.
    said
        Its return status.
    """

    times: FloatArray
    com: FloatArray
    velocity: FloatArray
    momentum: FloatArray
    quaternion: FloatArray
    forces: FloatArray
    footholds: FloatArray
    stance: BoolArray
    cost: float
    violation: float
    found: bool
    iterations: int
    said: str


def optimise_centroidal(
    problem: CentroidalProblem, max_iterations: int = 500, tell: Tell | None = None, **options: Any
) -> CentroidalMotion:
    """Return the best centroidal motion that Ipopt finds over a problem's schedule, from its reference.

    Parameters
    ----------
    problem
        See `CentroidalProblem`.
    max_iterations
        Of Ipopt.
    tell
        Called with the number of every iteration, cost and violation.
    options
        Ipopt's, without their prefix.

    Raises
    ------
    MissingExtra
        If CasADi is not installed.
    """
    begin, search = _start(problem), Search(max_iterations, tell, options)
    data = np.hstack([problem.reference[1:], problem.stance])
    found = solve_blocks(_block(problem), data, _rows(problem), _variables(problem), begin, search)
    return _read(problem, found)


def _block(problem: CentroidalProblem) -> Block:
    """Return the block of a problem's knots: x = (c, quaternion, v, h / m, footholds), u = forces / m g."""
    ca, n, dt, mass = import_casadi(), problem.schedule.feet, problem.dt, problem.mass
    x, after = (ca.SX.sym(name, STATE + 2 * n) for name in ("x", "after"))
    u = ca.SX.sym("u", 3 * n)
    c, turn, v, h = x[:3], x[3:7], x[7:10], x[10:13]
    c_after, turn_after, v_after, h_after = after[:3], after[3:7], after[7:10], after[10:13]
    frame, origin = ca.DM(problem.frame), ca.DM(problem.origin)
    shares = ca.reshape(u, 3, n)
    forces = GRAVITY * ca.mtimes(frame, shares)  # per mass
    places = ca.mtimes(frame[:, :2], ca.reshape(x[STATE:], 2, n)) + ca.repmat(origin, 1, n)
    a = ca.sum2(forces) - ca.DM([0.0, 0.0, GRAVITY])
    mean = c + 0.5 * dt * v + dt * dt / 6.0 * a
    torque = ca.SX.zeros(3)
    for i in range(n):
        torque += ca.cross(places[:, i] - mean, forces[:, i])
    inverse = ca.DM(np.linalg.inv(problem.inertia / mass))
    middle = 0.5 * (h + h_after)
    halfway = _turned(turn, 0.5 * dt * ca.mtimes(inverse, ca.mtimes(_matrix(turn).T, middle)))
    spin = ca.mtimes(inverse, ca.mtimes(_matrix(halfway).T, middle))
    below = [
        ca.mtimes(_matrix(t).T, places - ca.repmat(centre, 1, n)) - ca.DM(problem.stand.T)
        for t, centre in ((turn, c), (turn_after, c_after))
    ]
    size = ca.sqrt(shares[0, :] ** 2 + shares[1, :] ** 2 + ROUND**2)
    rows = ca.vertcat(
        (c_after - c) / dt - v - 0.5 * dt * a, turn_after - _turned(turn, dt * spin), v_after - v - dt * a,
        h_after - h - dt * torque, after[STATE:] - x[STATE:], (problem.mu * shares[2, :] - size).T,
        ca.reshape(below[0], 3 * n, 1), ca.reshape(below[1], 3 * n, 1),
    )  # fmt: skip
    w, data, nothing = problem.weights, ca.SX.sym("data", 7 + n), ca.SX.sym("nothing", 0)
    reference, stands = data[:7], data[7:]
    cost = w.position * ca.sumsqr(c_after - reference[:3])
    cost += w.orientation * ca.sumsqr(turn_after - reference[3:])
    cost += w.velocity * ca.sumsqr(v_after) + w.force * ca.sumsqr(u)
    cost += w.momentum * ca.sumsqr(h_after - ca.DM(problem.momentum / mass))
    cost += w.foothold * ca.dot(stands, ca.sum1(below[0][:2, :] ** 2).T)
    return Block(x, u, after, nothing, rows, dt * cost, data)


def _rows(problem: CentroidalProblem) -> Sides:
    """Return the bounds (knots, m) of the rows; infinite where a row does not matter."""
    n, stance = problem.schedule.feet, problem.stance
    least = np.zeros((problem.knots, STATE + 9 * n))
    most = least.copy()
    stays = np.vstack([stance[:-1] & stance[1:], np.zeros((1, n), dtype=bool)])
    moves = ~np.repeat(stays, 2, axis=1)
    at, cone, box = STATE, STATE + 2 * n, STATE + 3 * n
    least[:, at:cone][moves], most[:, at:cone][moves] = -np.inf, np.inf
    least[:, cone:box][~stance] = -np.inf
    most[:, cone:box] = np.inf
    inside = np.tile(np.where(stance[:, :, None], problem.reach, np.inf).reshape(problem.knots, -1), 2)
    inside[0, : 3 * n] = np.inf  # the start is given
    least[:, box:], most[:, box:] = -inside, inside
    return least, most


def _variables(problem: CentroidalProblem) -> Sides:
    """Return the bounds of all variables, in the order of the NLP."""
    n, N, stance = problem.schedule.feet, problem.knots, problem.stance
    bound = problem.momentum_bound / problem.mass
    low = np.full((N + 1, STATE + 2 * n), -np.inf)
    high = -low
    low[1:, 10:13], high[1:, 10:13] = -bound, bound
    scale = np.concatenate([np.ones(3), np.full(3, problem.mass)])
    for k, window in problem.windows.items():
        for part, least, most, by in (
            (slice(0, 7), window.q_low, window.q_high, 1.0),
            (slice(7, STATE), window.v_low, window.v_high, scale),
        ):
            if least is not None:
                low[k, part] = np.maximum(low[k, part], least / by)
            if most is not None:
                high[k, part] = np.minimum(high[k, part], most / by)
    low[0, :STATE] = high[0, :STATE] = np.concatenate([problem.pose, problem.velocity / scale])
    feet = ((problem.feet - problem.origin) @ problem.frame[:, :2]).ravel()
    standing = np.repeat(stance[0], 2)
    low[0, STATE:][standing] = high[0, STATE:][standing] = feet[standing]
    force = np.where(np.repeat(stance, 3, axis=1), np.inf, 0.0)
    least, most = -force, force
    least[:, 2::3] = stance * (problem.force_min / problem.weight)
    most[:, 2::3] = np.where(stance, problem.force_max / problem.weight, 0.0)
    sides = [
        np.concatenate([np.hstack([state[:-1], u]).ravel(), state[-1]])
        for state, u in ((low, least), (high, most))
    ]
    return sides[0], sides[1]


def _start(problem: CentroidalProblem) -> FloatArray:
    """Return variables to start from: the reference, the weight on the feet that stand, below their hips."""
    n, N, stance = problem.schedule.feet, problem.knots, problem.stance
    com, quaternion = problem.reference[:, :3], problem.reference[:, 3:]
    speed = np.vstack([problem.velocity[:3], np.diff(com, axis=0) / problem.dt])
    turned = np.array([_rotation(t) for t in quaternion])
    places = com[:, None] + np.einsum("kij,nj->kni", turned, problem.stand)
    flat = ((places - problem.origin) @ problem.frame[:, :2]).reshape(N + 1, 2 * n)
    momentum = np.zeros((N + 1, 3))
    states = np.hstack([com, quaternion, speed, momentum, flat])
    forces = np.zeros((N, n, 3))
    forces[:, :, 2] = stance / np.maximum(stance.sum(axis=1, keepdims=True), 1)
    return np.concatenate([np.hstack([states[:-1], forces.reshape(N, -1)]).ravel(), states[-1]])


def _read(problem: CentroidalProblem, found: Found) -> CentroidalMotion:
    """Return the motion that variables mean."""
    n, N, stance = problem.schedule.feet, problem.knots, problem.stance
    size = STATE + 2 * n
    table = found.variables[:-size].reshape(N, -1)
    states = np.vstack([table[:, :size], found.variables[-size:]])
    forces = problem.weight * table[:, size:].reshape(N, n, 3) @ problem.frame.T
    places = problem.origin + states[:-1, STATE:].reshape(N, n, 2) @ problem.frame[:, :2].T
    places[~stance] = np.nan
    times = np.asarray(problem.dt * np.arange(N + 1), dtype=np.float64)
    return CentroidalMotion(
        times, states[:, :3], states[:, 7:10], problem.mass * states[:, 10:13],
        states[:, 3:7], forces, places, stance, found.cost, found.violation,
        bool(found.violation <= ACCEPTED), found.iterations, found.said,
    )  # fmt: skip


def _rotation(quaternion: FloatArray) -> FloatArray:
    """Return the (3, 3) rotation of a quaternion (4,)."""
    x, y, z, w = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def _matrix(quaternion: Any) -> Any:
    """Return the rotation of a quaternion in symbols."""
    ca = import_casadi()
    x, y, z, w = (quaternion[k] for k in range(4))
    return ca.vertcat(
        ca.horzcat(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        ca.horzcat(2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        ca.horzcat(2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )


def _turned(quaternion: Any, rotation: Any) -> Any:
    """Return a quaternion after a turn by a rotation vector in body axes, in symbols."""
    ca = import_casadi()
    square = ca.sumsqr(rotation) + 1e-16  # the root has a slope at zero
    angle = ca.sqrt(square)
    s, c = ca.sin(0.5 * angle) / angle * rotation, ca.cos(0.5 * angle)
    v, w = quaternion[:3], quaternion[3]
    return ca.vertcat(w * s + c * v + ca.cross(v, s), w * c - ca.dot(v, s))
