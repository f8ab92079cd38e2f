"""A tossed cube in MuJoCo: its own box on its own plane, friction, solref and solimp to be fitted."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from surefoot.arrays import FloatArray
from surefoot.estimation.cube_model import FRICTION, LONGEST_STEP
from surefoot.estimation.toss_model import TossParameter, TossScene
from surefoot.simulation.mujoco_robot import import_mujoco
from surefoot.spatial import quaternion_wxyz, quaternion_xyzw

_MODEL = """
<mujoco>
  <option timestep="{dt}" gravity="0 0 {gravity}" cone="elliptic" tolerance="1e-10"/>
  <worldbody>
    <geom name="ground" type="plane" size="10 10 1" pos="0 0 {height}" quat="{tilt}"/>
    <body name="cube">
      <freejoint/>
      <inertial pos="0 0 0" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>
      <geom name="box" type="box" size="{half} {half} {half}" priority="1" condim="3"
            friction="{mu} 0 0" solref="{time} {ratio}" solimp="{least} {most} {width} 0.5 2"/>
    </body>
  </worldbody>
</mujoco>"""


class MujocoCube:
    """MuJoCo's soft contact: elliptic cones, Newton's method, steps of a millisecond.

    Raises
    ------
    MissingExtra
        If MuJoCo is not installed.
    """

    name = "mujoco"
    parameters = (
        FRICTION,
        TossParameter("solref_time", 0.002, 0.1, "s", logarithmic=True),
        TossParameter("solref_ratio", 0.05, 5.0, logarithmic=True),
        TossParameter("solimp_least", 0.05, 0.98),
        TossParameter("solimp_most", 0.6, 0.999),
    )

    def __init__(self) -> None:
        self._mujoco: Any = import_mujoco()

    def rollout(self, values: FloatArray, scene: TossScene) -> FloatArray:
        """Return (sum of frames, 7) positions [m] and quaternions."""
        steps = max(1, math.ceil(scene.dt / LONGEST_STEP - 1e-9))
        model = self._mujoco.MjModel.from_xml_string(_MODEL.format(**_settings(values, scene, steps)))
        data = self._mujoco.MjData(model)
        poses, row = np.empty((int(scene.frames.sum()), 7)), 0
        to_body = Rotation.from_quat(scene.starts[:, 3:7]).inv().apply(scene.starts[:, 10:])
        for start, rate, frames in zip(scene.starts, to_body, scene.frames, strict=True):
            self._mujoco.mj_resetData(model, data)
            data.qpos[:3], data.qpos[3:] = start[:3], quaternion_wxyz(start[3:7])
            data.qvel[:3], data.qvel[3:] = start[7:10], rate
            poses[row] = data.qpos
            for k in range(row + 1, row + frames):
                self._mujoco.mj_step(model, data, steps)
                poses[k] = data.qpos
            row += frames
        poses[:, 3:] = quaternion_xyzw(poses[:, 3:])
        return poses


def _settings(values: FloatArray, scene: TossScene, steps: int) -> dict[str, Any]:
    """Return what the model's text leaves open."""
    mu, time, ratio, least, most = (float(v) for v in values)
    most = max(most, least)
    tilt = quaternion_wxyz(scene.plane.rotation.as_quat())
    return {
        "dt": scene.dt / steps, "gravity": -scene.gravity, "tilt": " ".join(map(repr, tilt.tolist())),
        "height": scene.plane.height, "mass": scene.cube.mass, "inertia": scene.cube.inertia,
        "half": scene.cube.half_side, "mu": mu, "time": time, "ratio": ratio, "least": least, "most": most,
        "width": 0.001,
    }  # fmt: skip
