"""Bullet as a rival of our own thrown body, its words of contact to fit.

Its base is where its centre of mass is, in its principal axes: that stops in this file.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from surefoot.base.arrays import FloatArray
from surefoot.records import FRICTION, ROUNDING, TossParameter, TossScene, in_plane, in_world
from surefoot.worlds.bullet.bullet_world import GROUND, import_bullet, urdf_of
from surefoot.worlds.experiments.thrown_links import joint_words, steps_between

SHARPEST = 1e-4
"""Least radius of a corner in Bullet [m]."""
FASTEST = 1e6
"""Rate of a joint that Bullet does not cut [rad/s, m/s]: its own limit is 100."""


class BulletBody:
    """Bullet's springs and dampers at rounded corners, steps of a millisecond; hinges do not give.

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
        steps = steps_between(scene.dt)
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
    joints = [joint_words(scene.body, i) for i in range(tree.masses.size)]
    words = {"spheres": list(spheres), "joints": joints}
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
