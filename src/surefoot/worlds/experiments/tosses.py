"""Rivals of our own thrown body: other simulators with their own words of contact to fit."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from surefoot.base.arrays import FloatArray, whole_number
from surefoot.base.cores import in_ranges
from surefoot.base.errors import check_name
from surefoot.base.spatial import quaternion_wxyz, quaternion_xyzw
from surefoot.mechanics import Solid
from surefoot.records import (
    FRICTION,
    ROUNDING,
    ThrownBody,
    TossModel,
    TossParameter,
    TossScene,
    in_plane,
    in_world,
)
from surefoot.worlds.bullet.bullet_world import GROUND, import_bullet, urdf_of
from surefoot.worlds.drake.drake_python import Worker
from surefoot.worlds.drake.drake_world import STICTION, WORKER
from surefoot.worlds.mujoco.spec import import_mujoco

LONGEST_STEP = 1e-3
"""Of a simulation [s]."""
SHARPEST = 1e-4
"""Least radius of a corner in Bullet [m]."""
FASTEST = 1e6
"""Rate of a joint that Bullet does not cut [rad/s, m/s]: its own limit is 100."""
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
        TossParameter("solimp_most", 0.95, 0.01, 0.6, 0.999),
    )

    def __init__(self, threads: int = 1) -> None:
        self._mujoco: Any = import_mujoco()
        self._threads = whole_number("threads", threads, low=1)

    def __reduce__(self) -> tuple[Any, ...]:
        return MujocoBody, (self._threads,)

    def rollout(self, values: FloatArray, scene: TossScene) -> FloatArray:
        """Return (sum of frames, nq) positions [m], quaternions and joints."""
        steps = max(1, math.ceil(scene.dt / LONGEST_STEP - 1e-9))
        model = self._mujoco.MjModel.from_xml_string(_MODEL.format(**_settings(values, scene, steps)))
        nq, ends = int(model.nq), np.append(0, np.cumsum(scene.frames))
        poses, starts = np.empty((int(ends[-1]), nq)), scene.starts.copy()
        turns, rates = starts[:, 3:7], starts[:, nq + 3 : nq + 6]
        rates[:] = Rotation.from_quat(turns).inv().apply(rates)
        turns[:] = quaternion_wxyz(turns)

        def work(a: int, b: int) -> None:
            data = self._mujoco.MjData(model)
            for i in range(a, b):
                self._mujoco.mj_resetData(model, data)
                data.qpos[:], data.qvel[:] = starts[i, :nq], starts[i, nq:]
                poses[ends[i]] = data.qpos
                for k in range(ends[i] + 1, ends[i + 1]):
                    self._mujoco.mj_step(model, data, steps)
                    poses[k] = data.qpos

        in_ranges(work, len(starts), self._threads)
        poses[:, 3:7] = quaternion_xyzw(poses[:, 3:7])
        return poses


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
    kind = "slide" if tree.sliding[i] else "hinge"
    joint = "<freejoint/>" if i == 0 else (
        f'<joint type="{kind}" axis="{_text(tree.axes[i])}" frictionloss="{tree.friction[i]}" '
        f'damping="{tree.damping[i]}"/>'
    )  # fmt: skip
    inertia = _text(np.array([*np.diag(about), about[0, 1], about[0, 2], about[1, 2]]))
    shapes = "".join(_geom(solid, body.scale) for solid in body.solids if solid.joint == i + 1)
    others = "".join(_link(body, int(k)) for k in np.flatnonzero(tree.parents == i))
    return (
        f'<body pos="{_text(tree.places[i])}" quat="{_turn(tree.turns[i])}">{joint}'
        f'<inertial pos="{_text(tree.centres[i])}" mass="{tree.masses[i]}" fullinertia="{inertia}"/>'
        f"{shapes}{others}</body>"
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


class DrakeBody:
    """Drake's point contact at rounded corners, with Hunt and Crossley's dissipation, steps of a millisecond.

    Of a joint's losses it has the damping; it lives in an interpreter of its own, see `drake_python`.

    Parameters
    ----------
    approximation
        "similar", convex; "lagged", Drake's default, takes the last step's normal force, and corners chatter.

    Raises
    ------
    MissingExtra
        If Drake is not installed, and no other interpreter is named.
    """

    name = "drake"
    parameters = (
        FRICTION,
        TossParameter("stiffness_log10", 4.5, 0.1, 3.0, 7.0, "log N/m"),
        TossParameter("dissipation", 1.0, 0.1, 0.0, 50.0, "s/m"),
        ROUNDING,
    )

    def __init__(self, approximation: str = "similar") -> None:
        self._worker, self._approximation = Worker(WORKER), approximation

    def __reduce__(self) -> tuple[Any, ...]:
        return DrakeBody, (self._approximation,)

    def rollout(self, values: FloatArray, scene: TossScene) -> FloatArray:
        """Return (sum of frames, nq) positions [m], quaternions and joints."""
        mu, stiffness, dissipation, rounding = (float(v) for v in values)
        tree, steps = scene.body.rounded(rounding), max(1, math.ceil(scene.dt / LONGEST_STEP - 1e-9))
        gravity, starts = in_plane(scene)
        nq = 6 + tree.masses.size
        # quaternions (w, x, y, z) before places, angular velocities before the others
        order = [6, 3, 4, 5, 0, 1, 2, *range(7, nq)]
        order += [*range(nq + 3, nq + 6), *range(nq, nq + 3), *range(nq + 6, 2 * nq - 1)]
        spheres = zip((tree.links + 1).tolist(), tree.points.tolist(), tree.radii.tolist(), strict=True)
        material = {"point_contact_stiffness": 10.0**stiffness, "hunt_crossley_dissipation": dissipation}
        level = {"rotation": np.eye(3).tolist(), "place": [0.0] * 3}
        words = {
            "dt": scene.dt / steps, "mu": mu, "gravity": gravity.tolist(), "material": material,
            "approximation": self._approximation, "near_rigid": None, "stiction": STICTION, "ground": [level],
            "spheres": list(spheres), "joints": [_joint(scene.body, i) for i in range(nq - 6)],
        }  # fmt: skip
        self._worker.ask(["scene", words])
        thrown = self._worker.ask(["throw", starts[:, order].tolist(), scene.frames.tolist(), steps])
        poses = np.empty((len(thrown["q"]), nq))
        poses[:, order[:nq]] = thrown["q"]
        return in_world(poses, scene)


def _joint(body: ThrownBody, i: int) -> dict[str, Any]:
    """Return a link, and the joint that it hangs on, as Drake's worker and Bullet's URDF take it."""
    tree = body.tree
    kind = "free" if i == 0 else ("prismatic" if tree.sliding[i] else "revolute")
    arrays = {
        "rotation": tree.turns[i], "place": tree.places[i], "axis": tree.axes[i], "com": tree.centres[i],
        "inertia": tree.inertias[i],
    }  # fmt: skip
    return {
        "kind": kind, "parent": int(tree.parents[i]) + 1, "low": -math.inf, "high": math.inf,
        "mass": float(tree.masses[i]), "damping": float(tree.damping[i]),
        **{name: value.tolist() for name, value in arrays.items()},
    }  # fmt: skip


class BulletBody:
    """Bullet's springs and dampers at rounded corners, steps of a millisecond.

    Raises
    ------
    MissingExtra
        If PyBullet is not installed.
    """

    name = "bullet"
    parameters = (
        FRICTION,
        TossParameter("restitution", 0.2, 0.03, 0.0, 0.95),
        TossParameter("stiffness_log10", 4.5, 0.1, 3.0, 7.0, "log N/m"),
        TossParameter("damping_log10", 1.5, 0.1, -1.0, 4.0, "log N s/m"),
        ROUNDING,
    )

    def __init__(self) -> None:
        self._bullet: Any = import_bullet()

    def __reduce__(self) -> tuple[Any, ...]:
        return BulletBody, ()

    def rollout(self, values: FloatArray, scene: TossScene) -> FloatArray:
        """Return (sum of frames, nq) positions [m], quaternions and joints."""
        steps = max(1, math.ceil(scene.dt / LONGEST_STEP - 1e-9))
        gravity, starts = in_plane(scene)
        nq = (starts.shape[1] + 1) // 2
        at, axes = scene.body.tree.centres[0], Rotation.from_quat(starts[:, 3:7])
        poses: list[FloatArray] = []
        served = _bullet_scene(self._bullet, values, scene, steps, gravity)
        with served as (engine, body, principal):
            # Bullet's base is where its centre of mass is, in its principal axes
            turns = (axes * principal).as_quat()
            places = starts[:, :3] + axes.apply(at)
            speeds = starts[:, nq : nq + 3] + np.cross(starts[:, nq + 3 : nq + 6], axes.apply(at))
            for i, start in enumerate(starts):
                engine.resetBasePositionAndOrientation(body, places[i], turns[i])
                engine.resetBaseVelocity(body, speeds[i], start[nq + 3 : nq + 6])
                for k in range(nq - 7):
                    engine.resetJointState(body, k, start[7 + k], start[nq + 6 + k])
                poses.extend(_bullet_frames(engine, body, int(scene.frames[i]), nq - 7))
        out = np.array(poses).reshape(-1, nq)
        turned = Rotation.from_quat(out[:, 3:7]) * principal.inv()
        out[:, :3] -= turned.apply(at)
        out[:, 3:7] = turned.as_quat()
        return in_world(out, scene)


class _Client:
    """PyBullet's functions, asked of a server of its own."""

    def __init__(self, bullet: Any) -> None:
        self._bullet, self._server = bullet, bullet.connect(bullet.DIRECT)

    def __getattr__(self, name: str) -> Any:
        call = partial(getattr(self._bullet, name), physicsClientId=self._server)
        setattr(self, name, call)
        return call


@contextmanager
def _bullet_scene(
    bullet: Any, values: FloatArray, scene: TossScene, steps: int, gravity: FloatArray
) -> Iterator[tuple[Any, int, Rotation]]:
    """Yield Bullet with level ground and the body of a scene, the body, and its principal axes."""
    mu, restitution, stiffness, damping, rounding = (float(v) for v in values)
    tree, engine = scene.body.rounded(max(rounding, SHARPEST)), _Client(bullet)
    spheres = zip((tree.links + 1).tolist(), tree.points.tolist(), tree.radii.tolist(), strict=True)
    words = {"spheres": list(spheres), "joints": [_joint(scene.body, i) for i in range(tree.masses.size)]}
    contact = {"contactStiffness": 10.0**stiffness, "contactDamping": 10.0**damping}
    try:
        engine.setPhysicsEngineParameter(fixedTimeStep=scene.dt, numSubSteps=steps, contactSlop=0.0)
        engine.setGravity(*gravity)
        ground = engine.createMultiBody(0.0, engine.createCollisionShape(bullet.GEOM_PLANE))
        engine.changeDynamics(ground, -1, lateralFriction=mu, **GROUND)  # multiplied with the body's
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "body.urdf"
            path.write_text(urdf_of(words), encoding="utf8")
            flags = bullet.URDF_USE_INERTIA_FROM_FILE | bullet.URDF_MAINTAIN_LINK_ORDER
            body = engine.loadURDF(str(path), flags=flags)
        for link in range(-1, tree.masses.size - 1):
            free = {"linearDamping": 0.0, "angularDamping": 0.0, "maxJointVelocity": FASTEST}
            engine.changeDynamics(body, link, **free)
            engine.changeDynamics(body, link, jointDamping=float(tree.damping[link + 1]))
            engine.changeDynamics(body, link, restitution=restitution, lateralFriction=1.0, **contact)
            if link >= 0:  # a motor that holds still, with no more than the joint's dry friction
                friction = float(tree.friction[link + 1])
                engine.setJointMotorControl2(body, link, bullet.VELOCITY_CONTROL, force=friction)
        yield engine, body, Rotation.from_quat(engine.getDynamicsInfo(body, -1)[4])
    finally:
        engine.disconnect()


def _bullet_frames(engine: Any, body: int, frames: int, joints: int) -> Iterator[FloatArray]:
    """Yield the body's pose in Bullet (7 + joints,) at each frame."""
    for frame in range(frames):
        if frame:
            engine.stepSimulation()
        place, turn = engine.getBasePositionAndOrientation(body)
        yield np.array([*place, *turn, *(engine.getJointState(body, k)[0] for k in range(joints))])


RIVALS: dict[str, Any] = {one.name: one for one in (MujocoBody, DrakeBody, BulletBody)}
"""Rivals by name: what `--rivals` chooses from."""


def rival(name: str, threads: int = 1) -> TossModel:
    """Return a rival; MuJoCo's shares tosses among threads, Drake's and Bullet's do one after the other."""
    check_name("rival", name, RIVALS)
    made: TossModel = MujocoBody(threads) if name == MujocoBody.name else RIVALS[name]()
    return made
