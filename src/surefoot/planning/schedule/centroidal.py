"""The start of a whole body's search: the motion of its centre of mass over the schedule, by Ipopt.

The robot is its mass and an inertia that turns with it; forces are constant over a knot, so that its motion
under them is known exactly::

    c⁺ = c + dt v + dt²/2 a        v⁺ = v + dt a        a = Σ f / m + g
    h⁺ = h + dt Σ (p - c̄) x f      c̄ = c + dt v / 2 + dt² a / 6, the mean of c over the knot
    R⁺ = R exp(dt I⁻¹ R̄ᵀ h̄)        h̄ = (h + h⁺) / 2, R̄ half-way: of second order

Feet that stand have a foothold on the ground that stays while they do and is within a box about its place
below the hip, and forces inside the exact friction cone. Angular momentum is a cost: nothing forces it to
zero. `limbs` puts the legs under the motion that is found.

References
----------
.. [1] D. Orin, A. Goswami, S.-H. Lee, "Centroidal dynamics of a humanoid robot", Autonomous Robots 35, 2013.
.. [2] H. Dai, A. Valenzuela, R. Tedrake, "Whole-body motion planning with centroidal dynamics and full
   kinematics", Humanoids 2014.
.. [3] A. Winkler, C. Bellicoso, M. Hutter, J. Buchli, "Gait and trajectory optimization for legged systems
   through phase-based end-effector parameterization", RA-L 3, 2018.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.planning.schedule.limbs import soles
from surefoot.planning.schedule.problem import ScheduleProblem
from surefoot.planning.schedule.search import ACCEPTED, solve_scheduled
from surefoot.planning.transcription.knot import stacked
from surefoot.planning.transcription.nlp import Block, Iterate, OnIteration, Sides, pack, unpack
from surefoot.planning.transcription.window import StateWindow
from surefoot.robot.libraries import import_casadi
from surefoot.robot.symbolic_rotations import turn_matrix
from surefoot.spatial import GRAVITY, rotation_from_quaternion

POSITION, ORIENTATION, VELOCITY, MOMENTUM, FORCE, FOOTHOLD = 2.0, 10.0, 0.01, 1.0, 1.0, 1.0
"""What a second costs: squared distances from the reference [1/m², 1], velocity [s²/m²], angular momentum
over mass [s²/m⁴], forces as shares of m g, and distance of footholds from below the hips [1/m²]."""
REACH, REACH_TURNING = np.array([0.45, 0.3, 0.36]), np.array([0.9, 0.3, 0.6])
"""Half size of the box about its place below the hip in which a foot stands, over the base's height; and of a
body that is to turn: it pushes off and lands with its feet far from below the hips."""
ROUND = 1e-3
"""Rounds the cone's tip from inside, as a share of m g: sqrt(f_t² + ROUND²) <= mu f_n."""
STATE = 13
"""Numbers of a state before the footholds: c (3), quaternion (4), velocity (3), momentum / mass (3)."""
LATE = 0.8
"""Share of the time from the first foot's lift-off to the last one's after which a reference begins to turn:
an inertia that stays as it is turns no faster in the air than when it leaves."""


@dataclass(frozen=True, eq=False)
class CentroidalMotion:
    """What the optimiser found: T = N + 1 times under forces of N knots.

    Attributes
    ----------
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
    iterate
        Ipopt's last one.
    """

    com: FloatArray
    velocity: FloatArray
    momentum: FloatArray
    quaternion: FloatArray
    forces: FloatArray
    footholds: FloatArray
    stance: BoolArray
    iterate: Iterate

    @property
    def found(self) -> bool:
        """Whether all rows and bounds hold to `ACCEPTED` of their scale."""
        return bool(self.iterate.violation <= ACCEPTED)


class CentroidalModel:
    """A whole-body problem seen as its mass: the same schedule, start, reference and windows.

    Mass, inertia and the feet's places are those of the start. The windows of the base's pose become those of
    the centre of mass by the reference's rotation; those of its velocity are kept as for an upright body.
    Bounds on turning are kept where they mean rest: in the air legs that are drawn in or stretched change how
    fast a body turns, and the inertia of this model is constant.

    Attributes
    ----------
    mass, inertia
        [kg], and (3, 3) about the centre of mass, body axes [kg m²].
    stand
        (n, 3) where the feet are below the hips, from the centre of mass, body axes [m].
    pose, velocity
        (7,) centre of mass and quaternion at the start, (6,) velocity and angular momentum there.
    feet
        (n, 3) where the feet stand at the start [m].
    reference
        (knots + 1, 7) poses that cost nothing.
    reach
        (3,) half size of the box about `stand` in which a foot may stand, body axes [m].
    """

    def __init__(self, problem: ScheduleProblem) -> None:
        import pinocchio

        self.problem, robot, q = problem, problem.robot, problem.q
        data = robot.model.createData()
        pinocchio.ccrba(robot.model, data, q, problem.v)
        turned = rotation_from_quaternion(q[3:7])
        com = np.array(data.com[0])
        self.mass, self.inertia = robot.mass, turned.T @ np.array(data.Ig.inertia) @ turned
        self.velocity = np.concatenate([np.array(data.hg.linear) / robot.mass, np.array(data.hg.angular)])
        self.feet = soles(problem, data, q)
        self.stand, self.pose = (self.feet - com) @ turned, np.concatenate([com, q[3:7]])
        self.stance = problem.schedule.horizon(0.0, problem.dt, problem.knots)
        self.frame = np.asarray(problem.terrain.frame([0.0, 0.0]))
        self.origin = np.array([0.0, 0.0, float(problem.terrain.height([0.0, 0.0]))])
        lever = turned.T @ (com - q[:3])
        reference = problem.reference[:, :7].copy()
        shift = np.array([rotation_from_quaternion(t) @ lever for t in reference[:, 3:]])
        reference[:, :3] += shift
        turns = bool((np.abs(np.diff(reference[:, 3:], axis=0)) > 1e-12).any())
        self.reach = (REACH_TURNING if turns else REACH) * float(robot.nominal[2])
        reference[:, 3:] = _turning_late(reference[:, 3:], self.stance)
        self.reference = reference
        self.windows = {k: _window(w, shift[k]) for k, w in problem.windows.items()}

    def block(self) -> tuple[Block, Sides]:
        """Return the block of a knot, and the bounds (knots, m) of its rows.

        Variables: x = (c, quaternion, v, h / m, footholds), u = forces / m g.
        """
        ca, n, dt = import_casadi(), len(self.stand), self.problem.dt
        x, after = (ca.SX.sym(name, STATE + 2 * n) for name in ("x", "after"))
        u = ca.SX.sym("u", 3 * n)
        c, turn, v, h = x[:3], x[3:7], x[7:10], x[10:13]
        c_after, turn_after, v_after, h_after = after[:3], after[3:7], after[7:10], after[10:13]
        frame, origin = ca.DM(self.frame), ca.DM(self.origin)
        shares = ca.reshape(u, 3, n)
        forces = GRAVITY * ca.mtimes(frame, shares)  # per mass
        places = ca.mtimes(frame[:, :2], ca.reshape(x[STATE:], 2, n)) + ca.repmat(origin, 1, n)
        a = ca.sum2(forces) - ca.DM([0.0, 0.0, GRAVITY])
        mean = c + 0.5 * dt * v + dt * dt / 6.0 * a
        torque = ca.SX.zeros(3)
        for i in range(n):
            torque += ca.cross(places[:, i] - mean, forces[:, i])
        inverse = ca.DM(np.linalg.inv(self.inertia / self.mass))
        middle = 0.5 * (h + h_after)
        halfway = _turned(turn, 0.5 * dt * ca.mtimes(inverse, ca.mtimes(turn_matrix(turn).T, middle)))
        spin = ca.mtimes(inverse, ca.mtimes(turn_matrix(halfway).T, middle))
        below = [
            ca.mtimes(turn_matrix(t).T, places - ca.repmat(centre, 1, n)) - ca.DM(self.stand.T)
            for t, centre in ((turn, c), (turn_after, c_after))
        ]
        size = ca.sqrt(shares[0, :] ** 2 + shares[1, :] ** 2 + ROUND**2)
        moved = ca.vertcat(
            (c_after - c) / dt - v - 0.5 * dt * a, turn_after - _turned(turn, dt * spin),
            v_after - v - dt * a, h_after - h - dt * torque,
        )  # fmt: skip
        stays = np.vstack([self.stance[:-1] & self.stance[1:], np.zeros((1, n), dtype=bool)])
        held = np.where(np.repeat(stays, 2, axis=1), 0.0, np.inf)
        inside = np.where(self.stance[:, :, None], self.reach, np.inf).reshape(len(self.stance), -1)
        begins = inside.copy()
        begins[0] = np.inf  # the start is given
        rows, bounds = stacked([
            (moved, 0.0, 0.0), (after[STATE:] - x[STATE:], -held, held),
            ((self.problem.mu * shares[2, :] - size).T, np.where(self.stance, 0.0, -np.inf), np.inf),
            (ca.reshape(below[0], 3 * n, 1), -begins, begins),
            (ca.reshape(below[1], 3 * n, 1), -inside, inside),
        ], len(self.stance))  # fmt: skip
        data, nothing = ca.SX.sym("data", 7 + n), ca.SX.sym("nothing", 0)
        cost = POSITION * ca.sumsqr(c_after - data[:3]) + ORIENTATION * ca.sumsqr(turn_after - data[3:7])
        cost += VELOCITY * ca.sumsqr(v_after) + FORCE * ca.sumsqr(u) + MOMENTUM * ca.sumsqr(h_after)
        cost += FOOTHOLD * ca.dot(data[7:], ca.sum1(below[0][:2, :] ** 2).T)
        return Block(x, u, after, nothing, rows, dt * cost, data), bounds

    def variable_bounds(self) -> Sides:
        """Return the bounds of all variables (V,), in the order of the NLP."""
        knots, n = self.stance.shape
        low = np.full((knots + 1, STATE + 2 * n), -np.inf)
        high = -low
        scale = np.concatenate([np.ones(3), np.full(3, self.mass)])
        for k, window in self.windows.items():
            window.narrow(low[k, :STATE], high[k, :STATE], 7, k, scale)
        low[0, :STATE] = high[0, :STATE] = np.concatenate([self.pose, self.velocity / scale])
        feet = ((self.feet - self.origin) @ self.frame[:, :2]).ravel()
        standing = np.repeat(self.stance[0], 2)
        low[0, STATE:][standing] = high[0, STATE:][standing] = feet[standing]
        most = np.where(np.repeat(self.stance, 3, axis=1), np.inf, 0.0)
        least = -most
        least[:, 2::3] = self.stance * (self.problem.force_min / self.problem.weight)
        return pack(low, least), pack(high, most)

    def start(self) -> FloatArray:
        """Return variables (V,): the reference, the weight on the feet that stand, footholds below hips."""
        knots, n = self.stance.shape
        com, quaternion = self.reference[:, :3], self.reference[:, 3:]
        speed = np.vstack([self.velocity[:3], np.diff(com, axis=0) / self.problem.dt])
        turned = np.array([rotation_from_quaternion(t) for t in quaternion])
        places = com[:, None] + np.einsum("kij,nj->kni", turned, self.stand)
        flat = ((places - self.origin) @ self.frame[:, :2]).reshape(knots + 1, 2 * n)
        states = np.hstack([com, quaternion, speed, np.zeros((knots + 1, 3)), flat])
        forces = np.zeros((knots, n, 3))
        forces[:, :, 2] = self.stance / np.maximum(self.stance.sum(axis=1, keepdims=True), 1)
        return pack(states, forces.reshape(knots, -1))


def optimise_centroidal(
    problem: ScheduleProblem, max_iterations: int = 200, tell: OnIteration | None = None
) -> CentroidalMotion:
    """Return the best centroidal motion that Ipopt finds over a problem's schedule, from its reference.

    Parameters
    ----------
    problem
        Of the whole body.
    max_iterations
        Of Ipopt.
    tell
        Called with the number of every iteration, cost and violation.

    Raises
    ------
    MissingExtra
        If CasADi is not installed.
    """
    model = CentroidalModel(problem)
    knots, n = model.stance.shape
    data = np.hstack([model.reference[1:], model.stance])
    block, rows = model.block()
    found = solve_scheduled(block, data, model.variable_bounds(), rows, model.start(), max_iterations, tell)
    states, inputs = unpack(found.variables, STATE + 2 * n, knots)
    forces = problem.weight * inputs.reshape(knots, n, 3) @ model.frame.T
    places = model.origin + states[:-1, STATE:].reshape(knots, n, 2) @ model.frame[:, :2].T
    places[~model.stance] = np.nan
    return CentroidalMotion(
        states[:, :3], states[:, 7:10], model.mass * states[:, 10:13], states[:, 3:7], forces, places,
        model.stance, found,
    )  # fmt: skip


def _turning_late(quaternions: FloatArray, stance: BoolArray) -> FloatArray:
    """Return a reference's (T, 4) orientations, passed through between `LATE` and the end of the flight."""
    changes = np.flatnonzero(np.abs(np.diff(quaternions, axis=0)).max(axis=1) > 1e-12)
    air = np.flatnonzero(~stance.any(axis=1))
    if not (changes.size and air.size):
        return quaternions
    lift = int(np.flatnonzero(~stance.all(axis=1))[0])
    begin = lift + LATE * (air[0] - lift)
    share = np.clip((np.arange(len(quaternions)) - begin) / (air[-1] + 1 - begin), 0.0, 1.0)
    at = changes[0] + share * (changes[-1] + 1 - changes[0])
    rows = np.arange(len(quaternions))
    out = np.column_stack([np.interp(at, rows, part) for part in quaternions.T])
    return np.asarray(out / np.linalg.norm(out, axis=1, keepdims=True))


def _window(window: StateWindow, shift: FloatArray) -> StateWindow:
    """Return a window of the base as one of the centre of mass, `shift` [m] away."""
    moved = np.concatenate([shift, np.zeros(4)])
    q = [None if side is None else side[:7] + moved for side in (window.q_low, window.q_high)]
    if window.v_low is None or window.v_high is None:
        return StateWindow(q[0], q[1])
    turning = (window.v_low[3:6] != 0.0) | (window.v_high[3:6] != 0.0)
    free = np.concatenate([np.zeros(3, dtype=bool), turning])
    return StateWindow(
        q[0], q[1], np.where(free, -np.inf, window.v_low[:6]), np.where(free, np.inf, window.v_high[:6])
    )


def _turned(quaternion: Any, rotation: Any) -> Any:
    """Return a quaternion after a turn by a rotation vector in body axes, in symbols."""
    ca = import_casadi()
    square = ca.sumsqr(rotation) + 1e-16  # the root has a slope at zero
    angle = ca.sqrt(square)
    s, c = ca.sin(0.5 * angle) / angle * rotation, ca.cos(0.5 * angle)
    v, w = quaternion[:3], quaternion[3]
    return ca.vertcat(w * s + c * v + ca.cross(v, s), w * c - ca.dot(v, s))
