"""What simulates thrown bodies, and what is known of throws: an interface, and the package's own model."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from surefoot.base.arrays import FloatArray, IntArray, whole_number
from surefoot.base.cores import in_ranges
from surefoot.base.errors import check_name
from surefoot.records.identification import thrown_body_impact as layout
from surefoot.records.identification.ground_plane import GroundPlane
from surefoot.records.identification.thrown_body import ThrownBody, TossParameter
from surefoot.records.identification.thrown_body_step import throw

LONGEST_STEP = 2e-3
"""Of a simulation [s]."""
FRICTION = TossParameter("mu", 0.2, 0.01, 0.01, 2.0)
_RESTITUTION = TossParameter("restitution", 0.2, 0.03, 0.0, 0.95)
ROUNDING = TossParameter("rounding", 3e-3, 5e-4, 0.0, 0.02, "m")
LAWS: dict[str, dict[TossParameter, int | None]] = {
    "rigid": {FRICTION: layout.MU, _RESTITUTION: layout.POISSON, ROUNDING: None},
    "newton": {FRICTION: layout.MU, _RESTITUTION: layout.RESTITUTION, ROUNDING: None},
    "tangential": {
        FRICTION: layout.MU, _RESTITUTION: layout.POISSON, ROUNDING: None,
        TossParameter("tangential", 0.0, 0.05, -0.9, 0.9): layout.TANGENTIAL,
    },
    "growing-friction": {
        FRICTION: layout.MU, _RESTITUTION: layout.POISSON, ROUNDING: None,
        TossParameter("growth", 0.0, 0.01, -0.2, 0.5, "s/m"): layout.GROWTH,
    },
}  # fmt: skip
"""Contact laws by name: what each leaves open, and where `falling_impact` keeps it.

The rounding is the radius of edges and corners: a rigid body cannot let them go below the ground otherwise.
"""


class TossScene(NamedTuple):
    """What is known of tosses before a law of contact is fitted.

    Attributes
    ----------
    starts
        (B, nq + nv) first states in world axes: place, quaternion (x, y, z, w), joints, then velocity,
        angular velocity, joints' rates.
    frames
        (B,) frames of each toss.
    dt
        Time between them [s].
    plane
        The ground.
    gravity
        [m/s²], along -z of the world.
    body
        What was thrown, as it was identified.
    """

    starts: FloatArray
    frames: IntArray
    dt: float
    plane: GroundPlane
    gravity: float
    body: ThrownBody


class TossModel(Protocol):
    """A simulator of tosses."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def parameters(self) -> tuple[TossParameter, ...]:
        """What can be fitted."""

    def rollout(self, values: FloatArray, scene: TossScene) -> FloatArray:
        """Return (sum of frames, nq) poses, for (d,) values of the parameters."""


@dataclass(frozen=True)
class ThrownModel:
    """The package's own: exact Coulomb friction and a law of impact, see `identification.thrown_body_step`.

    Attributes
    ----------
    law
        A name of `LAWS`.
    steps
        Steps between frames; None for as many as keep a step within two milliseconds.
    threads
        Among which the tosses are shared; poses do not depend on it.

    Raises
    ------
    ProblemError
        If there is no such law, or a number is out of range.
    """

    law: str = "rigid"
    steps: int | None = None
    threads: int = 1

    def __post_init__(self) -> None:
        check_name("contact law", self.law, LAWS)
        whole_number("threads", self.threads, low=1)
        if self.steps is not None:
            whole_number("steps", self.steps, low=1)

    @property
    def name(self) -> str:
        """The law's."""
        return self.law

    @property
    def parameters(self) -> tuple[TossParameter, ...]:
        """Those of the law."""
        return tuple(LAWS[self.law])

    def rollout(self, values: FloatArray, scene: TossScene) -> FloatArray:
        """Return (sum of frames, nq) poses: positions [m], quaternions, joints [rad, m]."""
        law, rounding = np.zeros(layout.SIZE), 0.0
        for value, slot in zip(values, LAWS[self.law].values(), strict=True):
            if slot is None:
                rounding = float(value)
            else:
                law[slot] = value
        body = scene.body.bend_hinges(rounding)
        gravity, starts = in_plane(scene)
        starts = body.widen(starts)
        frames, ends = scene.frames, np.append(0, np.cumsum(scene.frames))
        poses = np.empty((int(ends[-1]), 6 + body.tree.masses.size))
        steps = self.steps or max(1, math.ceil(scene.dt / LONGEST_STEP - 1e-9))

        def work(a: int, b: int) -> None:
            own = poses[ends[a] : ends[b]]
            throw(body.tree, law, gravity, starts[a:b], frames[a:b], scene.dt, steps, own)

        in_ranges(work, len(starts), self.threads)
        return in_world(poses[:, body.columns], scene)


def in_plane(scene: TossScene) -> tuple[FloatArray, FloatArray]:
    """Return gravity (3,) [m/s²] and the first states (B, nq + nv) in the axes of the ground."""
    back, starts = scene.plane.rotation.inv(), scene.starts.copy()
    nq = (starts.shape[1] + 1) // 2
    starts[:, :3] = back.apply(starts[:, :3] - [0.0, 0.0, scene.plane.height])
    starts[:, 3:7] = (back * Rotation.from_quat(starts[:, 3:7])).as_quat()
    for at in (nq, nq + 3):
        starts[:, at : at + 3] = back.apply(starts[:, at : at + 3])
    return np.asarray(back.apply([0.0, 0.0, -scene.gravity])), starts


def in_world(poses: FloatArray, scene: TossScene) -> FloatArray:
    """Turn (N, nq) poses from the axes of the ground to the world's, in place; return them."""
    axes = scene.plane.rotation
    # a throw of a law that blows up has no place, and no turn that SciPy takes
    poses[~np.isfinite(poses).all(axis=1), :7] = [np.nan] * 3 + [0.0, 0.0, 0.0, 1.0]
    poses[:, :3] = axes.apply(poses[:, :3])
    poses[:, 2] += scene.plane.height
    poses[:, 3:7] = (axes * Rotation.from_quat(poses[:, 3:7])).as_quat()
    return poses
