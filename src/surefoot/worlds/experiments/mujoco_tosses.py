"""MuJoCo as a rival of our own thrown body, its words of contact to fit."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from surefoot.base.arrays import FloatArray, whole_number
from surefoot.base.cores import in_ranges
from surefoot.base.spatial import quaternion_wxyz, quaternion_xyzw
from surefoot.mechanics import Solid
from surefoot.records import FRICTION, ThrownBody, TossParameter, TossScene
from surefoot.worlds.experiments.thrown_links import steps_between
from surefoot.worlds.mujoco.engine_warnings import engine_warnings
from surefoot.worlds.mujoco.spec import import_mujoco

_MODEL = """
<mujoco>
  <compiler autolimits="false" angle="radian"/>
  <option timestep="{dt}" gravity="0 0 {gravity}" cone="elliptic" tolerance="1e-10"/>
  <default><geom contype="1" conaffinity="0" priority="1" condim="3" friction="{mu} 0 0"
    solref="{time} {ratio}" solimp="{least} {most} 0.001 0.5 2"/></default>
  <worldbody>
    <geom name="ground" type="plane" size="10 10 1" pos="0 0 {height}" quat="{tilt}" contype="0"
      conaffinity="1" priority="0"/>
    {links}
  </worldbody>
</mujoco>"""


class MujocoBody:
    """MuJoCo's soft contact: elliptic cones, Newton's method, steps of a millisecond.

    Parameters
    ----------
    threads
        Among which the tosses are shared; poses do not depend on it.

    Raises
    ------
    MissingExtra
        If MuJoCo is not installed.
    """

    name = "mujoco"
    parameters = (
        FRICTION,
        TossParameter("solref_time", 0.01, 5e-4, 0.002, 0.1, "s"),
        TossParameter("solref_ratio", 0.5, 0.03, 0.05, 5.0),
        TossParameter("solimp_least", 0.8, 0.02, 0.05, 0.98),
        TossParameter("solimp_most", 0.95, 0.01, 0.05, 0.999),
    )

    def __init__(self, threads: int = 1) -> None:
        self._mujoco: Any = import_mujoco()
        self._threads = whole_number("threads", threads, low=1)

    def __reduce__(self) -> tuple[Any, ...]:
        return MujocoBody, (self._threads,)

    def rollout(self, values: FloatArray, scene: TossScene) -> FloatArray:
        """Return (sum of frames, nq) positions [m], quaternions and joints; NaN where a toss blew up."""
        steps = steps_between(scene.dt)
        model = self._mujoco.MjModel.from_xml_string(_MODEL.format(**_settings(values, scene, steps)))
        nq, ends = int(model.nq), np.append(0, np.cumsum(scene.frames))
        body = scene.body.bend_hinges()  # MuJoCo's coordinates come in its order
        poses, starts = np.empty((int(ends[-1]), nq)), body.widen(scene.starts)
        turns, rates = starts[:, 3:7], starts[:, nq + 3 : nq + 6]
        rates[:] = Rotation.from_quat(turns).inv().apply(rates)
        turns[:] = quaternion_wxyz(turns)

        kinds = self._mujoco.mjtWarning
        blown = [int(kind) for kind in (kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC)]

        def work(a: int, b: int) -> None:
            data = self._mujoco.MjData(model)
            for i in range(a, b):
                self._mujoco.mj_resetData(model, data)
                data.qpos[:], data.qvel[:] = starts[i, :nq], starts[i, nq:]
                poses[ends[i]] = data.qpos
                for k in range(ends[i] + 1, ends[i + 1]):
                    self._mujoco.mj_step(model, data, steps)
                    if data.warning.number[blown].any():  # MuJoCo has begun anew, from the origin
                        poses[k : ends[i + 1]] = np.nan
                        break
                    poses[k] = data.qpos

        with engine_warnings():
            in_ranges(work, len(starts), self._threads)
        poses[:, 3:7] = quaternion_xyzw(poses[:, 3:7])
        return poses[:, body.columns]


def _settings(values: FloatArray, scene: TossScene, steps: int) -> dict[str, Any]:
    """Return what the model's text leaves open."""
    mu, time, ratio, least, most = (float(v) for v in values)
    return {
        "dt": scene.dt / steps, "gravity": -scene.gravity, "links": _link(scene.body, 0),
        "tilt": _text(quaternion_wxyz(scene.plane.rotation.as_quat())), "height": scene.plane.height,
        "mu": mu, "time": time, "ratio": ratio, "least": least, "most": max(most, least),
    }  # fmt: skip


def _text(values: FloatArray) -> str:
    return " ".join(map(repr, np.asarray(values, dtype=np.float64).tolist()))


def _turn(rotation: FloatArray) -> str:
    return _text(quaternion_wxyz(Rotation.from_matrix(rotation).as_quat()))


def _link(body: ThrownBody, i: int) -> str:
    """Return a link, and those that hang on it, as MJCF."""
    tree, about = body.tree, body.tree.inertias[i]
    joint = "<freejoint/>" if i == 0 else _joints(body, i)
    inertia = _text(np.array([*np.diag(about), about[0, 1], about[0, 2], about[1, 2]]))
    shapes = "".join(_geom(solid, body.scale) for solid in body.solids if solid.joint == i + 1)
    others = "".join(_link(body, int(k)) for k in np.flatnonzero(tree.parents == i))
    return (
        f'<body pos="{_text(tree.places[i])}" quat="{_turn(tree.turns[i])}">{joint}'
        f'<inertial pos="{_text(tree.centres[i])}" mass="{tree.masses[i]}" fullinertia="{inertia}"/>'
        f"{shapes}{others}</body>"
    )


def _joints(body: ThrownBody, i: int) -> str:
    """Return what a link hangs on as MJCF: its joint, and the springs across a hinge that gives."""
    bent = body.bend_hinges()
    tree = bent.tree
    return "".join(
        f'<joint type="{"slide" if tree.sliding[k] else "hinge"}" axis="{_text(tree.axes[k])}" '
        f'frictionloss="{tree.friction[k]}" damping="{tree.damping[k]}" stiffness="{tree.stiffness[k]}"/>'
        for k in bent.joints(i)
    )


def _geom(solid: Solid, scale: float) -> str:
    """Return a shape as MJCF."""
    core, radius = scale * solid.shape.core, scale * solid.shape.radius
    kind, size = "box", core
    if radius > 0.0:
        kind, size = (
            ("capsule", np.array([radius, core[2]])) if core[2] > 0.0 else ("sphere", np.array([radius]))
        )
    place = _text(scale * solid.position)
    return f'<geom type="{kind}" size="{_text(size)}" pos="{place}" quat="{_turn(solid.rotation)}"/>'
