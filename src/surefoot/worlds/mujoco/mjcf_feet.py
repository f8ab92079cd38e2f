"""The feet of an MJCF file: its own spheres, or spheres at the corners of the soles that its shapes are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.errors import ModelError
from surefoot.mechanics import Robot

MATCH = 1e-6
"""Distance between a contact point of the robot and the file's sphere for it [m]."""
SOFTNESS = ("solref", "solimp", "priority", "solmix")
"""What a sphere at a corner takes over from the shape that it stands for."""


def add_corners(mujoco: Any, spec: Any, raw: Any, robot: Robot) -> None:
    """Put spheres at the corners of soles that the file draws otherwise.

    Those feet's own shapes touch nothing any more: the corners carry all that a flat sole does. `raw` is the
    model of the MjSpec as it is; the spheres are as soft as the shapes.
    """
    data = _at_nominal(mujoco, raw, robot)
    centres, there = _centres(robot), _spheres(mujoco, raw, data, robot)
    missing = [k for k in range(len(centres)) if there[k] < 0]
    changed = dict.fromkeys(int(robot.contact_points.foot[k]) for k in missing)
    for foot in changed:
        number = _body_of(raw, robot, foot)
        body = spec.body(raw.body(number).name)
        shapes = [geom for geom in body.geoms if geom.contype or geom.conaffinity]
        for geom in shapes:
            geom.contype = geom.conaffinity = 0
        place, turn = data.xpos[number], data.xmat[number].reshape(3, 3)
        for k in np.flatnonzero(robot.contact_points.foot == foot):
            corner = body.add_geom(
                name=f"foot:{robot.contact_points.names[k]}", type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=[robot.contact_points.radii[k], 0.0, 0.0], pos=turn.T @ (centres[k] - place),
                contype=1, conaffinity=1, condim=3, mass=0.0,
            )  # fmt: skip
            for name in SOFTNESS if shapes else ():
                setattr(corner, name, getattr(shapes[0], name))


def foot_geoms(mujoco: Any, model: Any, robot: Robot, path: str | Path) -> IntArray:
    """Return the geoms (p,) of the robot's contact points, which are spheres there."""
    found = _spheres(mujoco, model, _at_nominal(mujoco, model, robot), robot)
    for k, geom in enumerate(found):
        if geom < 0:
            name = robot.contact_points.names[k].split(":")[0]
            raise ModelError(f"foot {name} of {path} is nowhere among what collides there")
        if model.geom_condim[geom] < 3:
            model.geom_condim[geom] = 3  # a foot without friction has no tangential force to read
    return found


def _at_nominal(mujoco: Any, model: Any, robot: Robot) -> Any:
    """Return data with all bodies where they are in the nominal configuration."""
    data, q = mujoco.MjData(model), robot.nominal
    data.qpos[:] = q
    data.qpos[3:7] = [q[6], q[3], q[4], q[5]]
    mujoco.mj_kinematics(model, data)
    return data


def _centres(robot: Robot) -> FloatArray:
    """Return the centres of the contact points (p, 3) in the nominal configuration, world axes [m]."""
    points = robot.contact_points
    robot.sphere_bottoms(robot.nominal)
    frames = (robot.data.oMf[points.frames[foot]] for foot in points.foot)
    return np.array([frame.act(centre) for frame, centre in zip(frames, points.centres, strict=True)])


def _spheres(mujoco: Any, model: Any, data: Any, robot: Robot) -> IntArray:
    """Return the geom that is each contact point (p,), -1 where there is none."""
    points, sphere = robot.contact_points, np.array(model.geom_type) == int(mujoco.mjtGeom.mjGEOM_SPHERE)
    usable = sphere & _solid(model)
    out = np.full(len(points), -1, dtype=np.int64)
    for k, centre in enumerate(_centres(robot)):
        near = np.linalg.norm(data.geom_xpos - centre, axis=1) < MATCH
        same = np.abs(model.geom_size[:, 0] - points.radii[k]) < MATCH
        found = np.flatnonzero(usable & near & same)
        out[k] = found[0] if found.size else -1
    return out


def _solid(model: Any) -> BoolArray:
    """Return which geoms (ngeom,) may touch anything."""
    return np.asarray((np.array(model.geom_contype) | np.array(model.geom_conaffinity)) > 0)


def _body_of(raw: Any, robot: Robot, foot: int) -> int:
    """Return the body that a foot is, or else that which its joint moves."""
    points = robot.contact_points
    names = [raw.body(b).name for b in range(raw.nbody)]
    frame = robot.model.frames[points.frames[foot]].name
    joint = int(points.joints[np.flatnonzero(points.foot == foot)[0]])
    return names.index(frame) if frame in names else int(raw.jnt_bodyid[joint - 1])
