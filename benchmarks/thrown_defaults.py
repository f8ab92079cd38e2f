"""Engines at their defaults against real throws of a cube: a table of docs/reports/.

Run: python -m benchmarks.thrown_defaults TOSSES.npz [--mu 0.18] [--json]. The body is the file's, not one
that was fitted; first states and the ground are found as `identify` finds them; every other toss is
simulated.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.table import Table

from benchmarks.printing import show, table
from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.records.identification.ground_plane import GroundPlane, ground_points
from surefoot.records.identification.thrown_body import cube_body
from surefoot.records.identification.thrown_body_tree import sphere_places
from surefoot.records.identification.toss_errors import toss_errors
from surefoot.records.identification.toss_model import ThrownModel, TossScene
from surefoot.records.identification.toss_start import TossFlight, flying_frames
from surefoot.records.identification.tosses import Tosses, read_tosses
from surefoot.worlds.bullet.bullet_world import import_bullet
from surefoot.worlds.drake import drake_python
from surefoot.worlds.experiments.drake_tosses import DrakeBody
from surefoot.worlds.experiments.mujoco_tosses import MujocoBody

MUJOCO = (0.02, 1.0, 0.9, 0.95)
"""Its solref and the first two of its solimp."""
DRAKE = (6.0, 50.0, 1e-4)
"""Its stiffness [log N/m] and dissipation [s/m]; its corners are spheres this small [m]."""
BULLET_STEP = 1.0 / 240.0
"""[s]."""


def scene_of(tosses: Tosses) -> tuple[TossScene, Any]:
    """Return what is known of the tosses of a nominal cube, and the frames before their first touch."""
    body = cube_body(tosses.cube)
    corners = sphere_places(body.tree, tosses.poses)
    height, *slope = ground_points(tosses, corners, body.width).planes(np.ones((1, len(tosses))))[0].tolist()
    plane = GroundPlane(height, np.array(slope))
    before = flying_frames(tosses, corners, plane, body.width)
    starts = TossFlight(tosses, before, body.tree, GRAVITY).starts
    return TossScene(starts, tosses.frames, tosses.dt, plane, GRAVITY, body), before


def bullet(mu: float, tosses: Tosses, scene: TossScene) -> FloatArray:
    """Return the poses that Bullet's box comes to: (sum of frames, 7)."""
    engine, cube, steps = import_bullet(), tosses.cube, int(np.ceil(tosses.dt / BULLET_STEP))
    client = engine.connect(engine.DIRECT)
    engine.setGravity(0.0, 0.0, -GRAVITY)
    engine.setTimeStep(tosses.dt / steps)
    turn = scene.plane.rotation.as_quat()
    ground = engine.createMultiBody(
        0.0, engine.createCollisionShape(engine.GEOM_PLANE), -1, [0, 0, scene.plane.height], turn
    )
    box = engine.createCollisionShape(engine.GEOM_BOX, halfExtents=[cube.half_side] * 3)
    body = engine.createMultiBody(cube.mass, box)
    engine.changeDynamics(body, -1, lateralFriction=mu, localInertiaDiagonal=[cube.inertia] * 3)
    engine.changeDynamics(ground, -1, lateralFriction=1.0)  # they are multiplied
    poses = []
    for start, frames in zip(scene.starts, scene.frames, strict=True):
        engine.resetBasePositionAndOrientation(body, start[:3], start[3:7])
        engine.resetBaseVelocity(body, start[7:10], start[10:13])
        for k in range(frames):
            for _ in range(steps if k else 0):
                engine.stepSimulation()
            place, turned = engine.getBasePositionAndOrientation(body)
            poses.append([*place, *turned])
    engine.disconnect(client)
    return np.array(poses)


def errors(tosses: Tosses, mu: float) -> Table:
    """Return the table: mean errors of each engine."""
    scene, before = scene_of(tosses)
    width = scene.body.width
    found = {
        "MuJoCo": MujocoBody().rollout(np.array([mu, *MUJOCO]), scene),
        "PyBullet": bullet(mu, tosses, scene),
        "rigid, no restitution": ThrownModel().rollout(np.array([mu, 0.0, 0.0]), scene),
    }
    if drake_python.present():
        for kind in ("lagged", "similar"):
            found[f"Drake, {kind}"] = DrakeBody(kind).rollout(np.array([mu, *DRAKE]), scene)
    rows = []
    for name, poses in found.items():
        e = toss_errors(tosses, poses, width, before)
        rows.append((name, f"{e.position.mean():.4f}", f"{e.rotation.mean():.1f}", f"{e.early.mean():.4f}"))
    columns = ("engine", "position [width]", "rotation [deg]", "after 34 ms")
    return table(columns, rows, f"{len(tosses)} throws, mu {mu:g}, everything else as the engine has it")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tosses", help="an .npz file of tosses")
    parser.add_argument("--mu", type=float, default=0.18)
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args(arguments)
    recorded = read_tosses(given.tosses)
    show([errors(recorded.subset(np.arange(1, len(recorded), 2)), given.mu)], given.json)


if __name__ == "__main__":
    main()
