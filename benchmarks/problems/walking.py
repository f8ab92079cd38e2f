"""Recorded walks for measuring model-predictive control: a rigid body, gaits, slopes and pushes.

Each scene is a sequence of inputs to `ConvexMpc.solve` a hundredth of a second apart, taken from a full
(nonlinear, gyroscopic) rigid body that our own controller drives, so that warm starts mean what they mean on
a robot. Every method is then given the same inputs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.errors import ProblemError, unknown_name
from surefoot.base.spatial import GRAVITY, rotation_about, rotation_from_normal
from surefoot.motion.control.mpc import BodyReference, BodyState, ConvexMpc, MpcWeights

TICK = 0.01
"""Time between two calls [s]."""
MASS, INERTIA = 15.2, np.diag([0.11, 0.25, 0.29])
HIPS = np.array([[0.19, 0.14, 0.0], [0.19, -0.14, 0.0], [-0.19, 0.14, 0.0], [-0.19, -0.14, 0.0]])
HEIGHT = 0.3


class MpcInput(NamedTuple):
    """Arguments of `ConvexMpc.solve`."""

    state: BodyState
    reference: BodyReference
    foot_positions: FloatArray
    contacts: BoolArray
    frames: FloatArray


@dataclass(frozen=True)
class MpcScene:
    """A walk to record.

    Attributes
    ----------
    name, title
        Key, and what a table says.
    offsets, duty, period
        The gait: phase of every foot, share of the period on the ground, period [s].
    velocity, yaw_rate
        Commanded, heading axes [m/s], [rad/s].
    slope
        Of the ground [deg], uphill along (1, 1).
    tilt, spread
        Random tilt of each foothold's normal [rad], and its distance from the planned place [m].
    kick, kick_period
        Sudden change of velocity [m/s] in a random horizontal direction, and time between two [s].
    mu
        Friction.
    """

    name: str
    title: str
    offsets: tuple[float, float, float, float] = (0.0, 0.5, 0.5, 0.0)
    duty: float = 0.5
    period: float = 0.36
    velocity: tuple[float, float] = (0.0, 0.0)
    yaw_rate: float = 0.0
    slope: float = 0.0
    tilt: float = 0.0
    spread: float = 0.0
    kick: float = 0.0
    kick_period: float = 0.4
    mu: float = 0.6

    @property
    def normal(self) -> FloatArray:
        """(3,) unit normal of the ground."""
        a = math.radians(self.slope)
        return np.array([-math.sin(a) / math.sqrt(2.0), -math.sin(a) / math.sqrt(2.0), math.cos(a)])


SCENES = (
    MpcScene("stand", "four feet, kicks of 0.3 m/s", duty=1.0, kick=0.3),
    MpcScene("trot", "trot at 1 m/s, turning", velocity=(1.0, 0.0), yaw_rate=0.5, kick=0.1),
    MpcScene("walk", "walk at 0.4 m/s", (0.0, 0.5, 0.75, 0.25), 0.75, 0.6, (0.4, 0.1), kick=0.1),
    MpcScene("slope", "trot on a 15 deg slope, mu 0.5", velocity=(0.5, 0.0), slope=15.0, mu=0.5, kick=0.1),
    MpcScene(
        "rough", "trot on tilted footholds, kicks", velocity=(0.5, 0.2), tilt=0.15, spread=0.02, kick=0.3
    ),
    MpcScene("flying", "flying trot at 1.5 m/s", duty=0.42, period=0.3, velocity=(1.5, 0.0), kick=0.1),
    MpcScene("limit", "trot at its friction limit, mu 0.3", velocity=(0.8, 0.0), kick=0.5, mu=0.3),
)


def choose_scenes(names: Sequence[str] | None) -> tuple[MpcScene, ...]:
    """Return scenes by name; all of them for None.

    Raises
    ------
    ProblemError
        For an unknown name.
    """
    by_name = {scene.name: scene for scene in SCENES}
    for name in names or ():
        if name not in by_name:
            raise ProblemError(unknown_name("scene", name, by_name))
    return SCENES if names is None else tuple(by_name[name] for name in names)


def controller(
    scene: MpcScene, horizon: int = 10, tol: float = 1e-2, weights: MpcWeights | None = None
) -> ConvexMpc:
    """Return the controller of a scene, for forces within `tol` of their optimum [N]."""
    return ConvexMpc(
        MASS, INERTIA, horizon=horizon, mu=scene.mu, normal_min=2.0, normal_max=300.0,
        weights=weights or MpcWeights(), tol=tol,
    )  # fmt: skip


def record(
    scene: MpcScene, count: int, horizon: int = 10, seed: int = 0, weights: MpcWeights | None = None
) -> list[MpcInput]:
    """Return `count` successive inputs of a scene, with other weights for its controller if given.

    The body is pulled back to its reference if it strays by more than 0.3 m or 0.6 rad, as it may where
    the scene asks for more than friction gives.
    """
    rng = np.random.default_rng(seed)
    mpc = controller(scene, horizon, weights=weights)
    path = _Path(scene, rng)
    state = path.at(0.0)
    inputs = []
    kicks = max(round(scene.kick_period / TICK), 1)
    for tick in range(count):
        time = tick * TICK
        if scene.kick > 0.0 and tick % kicks == kicks // 2:
            angle = rng.uniform(0.0, 2.0 * math.pi)
            push = scene.kick * np.array([math.cos(angle), math.sin(angle), 0.0])
            state = BodyState(
                state.rotation, state.position, state.linear_velocity + push, state.angular_velocity
            )
        given = path.input(state, time, horizon, mpc.dt)
        inputs.append(given)
        mpc.shift(TICK)
        plan = mpc.solve(*given)
        state = _fall(state, plan.forces_world[0], given.foot_positions[0], TICK)
        wanted = path.at(time + TICK)
        strayed = np.linalg.norm(state.position - wanted.position) > 0.3
        if strayed or np.trace(state.rotation.T @ wanted.rotation) < 1.0 + 2.0 * math.cos(0.6):
            state = wanted
            mpc.reset()
    return inputs


def _fall(state: BodyState, forces: FloatArray, feet: FloatArray, time: float) -> BodyState:
    """Return the state of the free rigid body after `time` under constant world forces (five small steps)."""
    R, p = state.rotation, state.position
    v, w = state.linear_velocity, state.angular_velocity
    dt = time / 5.0
    for _ in range(5):
        inertia = R @ INERTIA @ R.T
        moment = np.cross(feet - p, forces).sum(axis=0)
        turn = np.linalg.solve(inertia, moment - np.cross(w, inertia @ w))
        pull = forces.sum(axis=0) / MASS - np.array([0.0, 0.0, GRAVITY])
        p = p + dt * v + 0.5 * dt * dt * pull
        half = w + 0.5 * dt * turn
        v, w = v + dt * pull, w + dt * turn
        angle = float(np.linalg.norm(half))
        if angle > 0.0:
            R = rotation_about(half / angle, angle * dt) @ R
    return BodyState(R, p, v, w)


class _Path:
    """The commanded motion of a scene and its footholds, functions of time."""

    def __init__(self, scene: MpcScene, rng: np.random.Generator) -> None:
        self.scene = scene
        self.noise = rng.normal(size=(4, 512, 4))

    def reference(self, time: float, horizon: int, dt: float) -> BodyReference:
        """Return the commanded motion from `time` on, by steps of dt."""
        s = self.scene
        turn, v = s.yaw_rate * time, np.array(s.velocity)
        yaw = np.array([math.cos(turn), math.sin(turn)])
        if s.yaw_rate == 0.0:
            arc = v * time
        else:  # integral of the turning velocity
            a, b = math.sin(turn) / s.yaw_rate, (1.0 - math.cos(turn)) / s.yaw_rate
            arc = np.array([a * v[0] - b * v[1], b * v[0] + a * v[1]])
        level = rotation_from_normal(s.normal)
        start = level[:, :2] @ arc + HEIGHT * np.array([0.0, 0.0, 1.0])
        heading = level[:, :2] @ yaw
        return BodyReference.cruise(
            start, math.atan2(heading[1], heading[0]), v, s.yaw_rate, horizon=horizon, dt=dt, normal=s.normal
        )

    def at(self, time: float) -> BodyState:
        """Return the commanded motion at a time."""
        r = self.reference(time, 1, TICK)
        return BodyState(r.rotation[0], r.position[0], r.linear_velocity[0], r.angular_velocity[0])

    def input(self, state: BodyState, time: float, horizon: int, dt: float) -> MpcInput:
        """Return the controller's input at a time."""
        s = self.scene
        contacts = np.empty((horizon, 4), dtype=np.bool_)
        feet, frames = np.empty((horizon, 4, 3)), np.empty((horizon, 4, 3, 3))
        for i in range(4):
            last = -1
            for k in range(horizon):
                cycle = (time + (k + 0.5) * dt) / s.period + s.offsets[i]
                stride = 0 if s.duty >= 1.0 else math.floor(cycle)
                contacts[k, i] = s.duty >= 1.0 or cycle - stride < s.duty
                if stride != last or k == 0:
                    place, frame = self._foothold(i, stride)
                feet[k, i], frames[k, i] = place, frame
                last = stride
        return MpcInput(state, self.reference(time, horizon, dt), feet, contacts, frames)

    def _foothold(self, foot: int, stride: int) -> tuple[FloatArray, FloatArray]:
        """Return place and frame of a foot's stance number `stride`: below the hip at its middle."""
        s = self.scene
        middle = 0.0 if s.duty >= 1.0 else (stride - s.offsets[foot] + 0.5 * s.duty) * s.period
        body = self.at(middle)
        a, b, c, d = self.noise[foot, stride % 512]
        hip = body.position + body.rotation @ (HIPS[foot] + s.spread * np.array([a, b, 0.0]))
        place = hip - np.array([0.0, 0.0, HEIGHT])
        n = s.normal + s.tilt * np.array([c, d, 0.0])
        return place, rotation_from_normal(n / np.linalg.norm(n), body.rotation[:, 0])
