"""Made-up tosses of a cube, with what is to be found known: recordings for tests, docs and trials."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from surefoot.arrays import FloatArray, finite_array, real_number, whole_number
from surefoot.estimation.cube_model import CubeModel
from surefoot.estimation.ground_plane import GroundPlane
from surefoot.estimation.toss_model import TossScene
from surefoot.estimation.tosses import Cube, Tosses
from surefoot.spatial import GRAVITY

POSITION_NOISE, ROTATION_NOISE = 7e-5, 5e-4
"""Of fiducials seen by a good camera: what the free flight of 428 recorded tosses leaves [m, rad]."""
SPEED, TUMBLE = 0.8, 2.4
"""Standard deviations of the velocity along the ground [m/s] and of each angular velocity [rad/s]."""
HEIGHT = (0.11, 0.16)
"""Of the centre at the start [m]: a tenth of a second of flight for a cube 0.1 m wide."""


def random_tosses(
    count: int, values: ArrayLike, *, law: str = "rigid",
    ground: tuple[float, float, float] = (0.0, 0.0, 0.0), seed: int = 0, frames: int = 110,
    dt: float = 1.0 / 148.0, noise: float = 1.0, steps: int | None = None,
) -> Tosses:  # fmt: skip
    """Return made-up tosses of a cube 0.105 m wide.

    Parameters
    ----------
    count
        Tosses.
    values
        (d,) parameters of the law, such as mu and restitution; see `CubeModel`.
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
    starts = np.zeros((count, 13))
    starts[:, :2] = random.uniform(-0.15, 0.15, (count, 2))
    starts[:, 2] = ground[0] + random.uniform(*HEIGHT, count)
    starts[:, 3:7] = random.normal(size=(count, 4))
    starts[:, 3:7] /= np.linalg.norm(starts[:, 3:7], axis=1, keepdims=True)
    starts[:, 7:9] = SPEED * random.normal(size=(count, 2))
    starts[:, 9] = 0.2 * SPEED * random.normal(size=count)
    starts[:, 10:] = TUMBLE * random.normal(size=(count, 3))
    cube, plane = Cube(), GroundPlane(ground[0], np.array(ground[1:]))
    scene = TossScene(starts, np.full(count, frames), dt, plane, GRAVITY, cube)
    model = CubeModel(law, steps=steps)
    poses = model.rollout(finite_array("values", values, (len(model.parameters),)), scene)
    poses[:, :3] += share * POSITION_NOISE * random.normal(size=(len(poses), 3))
    shaken = Rotation.from_rotvec(share * ROTATION_NOISE * random.normal(size=(len(poses), 3)))
    poses[:, 3:] = (shaken * Rotation.from_quat(poses[:, 3:])).as_quat()
    return Tosses(_with_velocities(poses, frames, dt), np.arange(count + 1) * frames, dt, cube=cube)


def _with_velocities(poses: FloatArray, frames: int, dt: float) -> FloatArray:
    """Return (N, 13) states: backward differences, as a recording has them, forward ones in first frames."""
    states = np.zeros((len(poses), 13))
    states[:, :7] = poses
    turns = Rotation.from_quat(poses[:, 3:])
    states[1:, 7:10] = np.diff(poses[:, :3], axis=0) / dt
    states[1:, 10:] = (turns[:-1].inv() * turns[1:]).as_rotvec() / dt
    first = np.arange(0, len(poses), frames)
    states[first, 7:] = states[first + 1, 7:]
    return states
