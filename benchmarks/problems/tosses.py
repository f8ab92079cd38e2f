"""Made-up tosses of a cube or another body, with what is to be found known: for tests, docs and trials."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from surefoot.base.arrays import FloatArray, finite_array, real_number, whole_number
from surefoot.base.spatial import GRAVITY
from surefoot.records.identification.ground_plane import GroundPlane
from surefoot.records.identification.thrown_body import ThrownBody, cube_body
from surefoot.records.identification.toss_model import ThrownModel, TossScene
from surefoot.records.identification.tosses import Cube, Tosses

POSITION_NOISE, ROTATION_NOISE = 7e-5, 5e-4
"""Of fiducials seen by a good camera: what the free flight of 428 recorded tosses leaves [m, rad]."""
SPEED, TUMBLE = 0.8, 2.4
"""Standard deviations of the velocity along the ground [m/s] and of each angular velocity [rad/s]."""
HEIGHT = (0.11, 0.16)
"""Of the centre at the start [m]: a tenth of a second of flight for a cube 0.1 m wide."""
_LINK = """<link name="{name}"><inertial><origin xyz="{x} 0 0"/><mass value="0.37"/>
<inertia ixx="0.0006" ixy="0" ixz="0" iyy="0.0006" iyz="0" izz="0.0006"/></inertial>
<collision><origin xyz="{x} 0 0"/><geometry><box size="0.1 0.05 0.05"/></geometry></collision></link>"""
ELBOW = f"""<robot name="elbow">{_LINK.format(name="one", x=0)}{_LINK.format(name="two", x=0.035)}
<joint name="hinge" type="continuous"><parent link="one"/><child link="two"/>
<origin xyz="-0.035 0.06 0"/><axis xyz="0 1 0"/></joint></robot>"""
"""Two bars on a hinge, as a URDF file."""


def random_tosses(
    count: int, values: ArrayLike, *, law: str = "rigid",
    ground: tuple[float, float, float] = (0.0, 0.0, 0.0), seed: int = 0, frames: int = 110,
    dt: float = 1.0 / 148.0, noise: float = 1.0, steps: int | None = None,
    body: ThrownBody | None = None,
) -> Tosses:  # fmt: skip
    """Return made-up tosses of a cube 0.105 m wide, or of a `body` about as wide.

    Parameters
    ----------
    count
        Tosses.
    values
        (d,) parameters of the law, such as mu and restitution; see `ThrownModel`.
    law
        The contact law.
    ground
        Height [m] and slopes along x and y of the ground.
    seed
        Of the throws and the noise.
    frames, dt
        Of each toss, and the time between them [s].
    noise
        Noise of the recording, as a share of a good camera's.
    steps
        Steps of the simulation between frames.
    """
    random = np.random.default_rng(whole_number("seed", seed))
    count, share = whole_number("count", count, low=1), real_number("noise", noise, low=0.0)
    scene = random_scene(random, count, ground, frames, dt, cube_body(Cube()) if body is None else body)
    model = ThrownModel(law, steps=steps)
    poses = model.rollout(finite_array("values", values, (len(model.parameters),)), scene)
    poses[:, :3] += share * POSITION_NOISE * random.normal(size=(len(poses), 3))
    shaken = Rotation.from_rotvec(share * ROTATION_NOISE * random.normal(size=(len(poses), 3)))
    poses[:, 3:7] = (shaken * Rotation.from_quat(poses[:, 3:7])).as_quat()
    poses[:, 7:] += share * ROTATION_NOISE * random.normal(size=poses[:, 7:].shape)
    return Tosses(_with_velocities(poses, frames, dt), np.arange(count + 1) * frames, dt)


def random_scene(
    random: np.random.Generator, count: int, ground: tuple[float, float, float], frames: int, dt: float,
    body: ThrownBody,
) -> TossScene:  # fmt: skip
    """Return throws of a body above a ground of height [m] and slopes along x and y, `frames` of each."""
    joints = len(body.joints)
    starts = np.zeros((count, 13 + 2 * joints))
    starts[:, :2] = random.uniform(-0.15, 0.15, (count, 2))
    starts[:, 2] = ground[0] + random.uniform(*HEIGHT, count)
    starts[:, 3:7] = random.normal(size=(count, 4))
    starts[:, 3:7] /= np.linalg.norm(starts[:, 3:7], axis=1, keepdims=True)
    nq = 7 + joints
    starts[:, 7:nq] = random.uniform(-1.0, 1.0, (count, joints))
    starts[:, nq : nq + 2] = SPEED * random.normal(size=(count, 2))
    starts[:, nq + 2] = 0.2 * SPEED * random.normal(size=count)
    starts[:, nq + 3 :] = TUMBLE * random.normal(size=(count, 3 + joints))
    plane = GroundPlane(ground[0], np.array(ground[1:]))
    return TossScene(starts, np.full(count, frames), dt, plane, GRAVITY, body)


def _with_velocities(poses: FloatArray, frames: int, dt: float) -> FloatArray:
    """Return (N, 13 + 2j) states: backward differences, as recordings have them, forward in first frames."""
    nq = poses.shape[1]
    states = np.zeros((len(poses), 2 * nq - 1))
    states[:, :nq] = poses
    turns = Rotation.from_quat(poses[:, 3:7])
    states[1:, nq : nq + 3] = np.diff(poses[:, :3], axis=0) / dt
    states[1:, nq + 3 : nq + 6] = (turns[:-1].inv() * turns[1:]).as_rotvec() / dt
    states[1:, nq + 6 :] = np.diff(poses[:, 7:], axis=0) / dt
    first = np.arange(0, len(poses), frames)
    states[first, nq:] = states[first + 1, nq:]
    return states


def write_tosses(tosses: Tosses, path: Path) -> Path:
    """Write tosses to a new file."""
    cube = tosses.cube
    np.savez(
        path, states=tosses.states, starts=tosses.starts, dt=tosses.dt, ids=tosses.ids,
        half_side=cube.half_side, mass=cube.mass, inertia=cube.inertia,
    )  # fmt: skip
    return path
