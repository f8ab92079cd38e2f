"""What a log lacks and its robot, its ground or its user know: positions from angles, gaps from positions."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.mechanics import Robot, Terrain, frames_on, read_terrain
from surefoot.records.log.log import Log
from surefoot.records.log.mapping import mapping_from_yaml

LEVEL = "as on level ground"
"""How the doubt ends that forces were taken to be in contact axes without their ground."""


def complete(
    log: Log,
    robot: Robot | None = None,
    terrain: Terrain | None = None,
    mu: float | None = None,
    mass: float | None = None,
) -> Log:
    """Return a log with all that follows from it, its robot and its ground; the fact ``computed`` says what.

    Parameters
    ----------
    log
        Not changed. Joints and feet of a log by a mapping are brought into the robot's order, by name.
    robot
        With ``q`` (or angles and the base's pose) it gives the contacts' positions, and with ``v`` their
        velocities.
    terrain
        None for the fact ``terrain``; with positions it gives gaps and normals.
    mu, mass
        Friction of the ground [-] and mass of all that moves [kg] for a log that tells none.

    Raises
    ------
    ProblemError
        If the log has friction, another mass or gaps of its own, or other joints or feet than the robot.
    """
    arrays, facts = dict(log.arrays), dict(log.facts)
    computed: list[str] = []
    if "gaps" in arrays and terrain is not None:
        raise ProblemError("the log has gaps: a terrain is for a log without")
    if terrain is None and "terrain" in facts:
        terrain = read_terrain(str(facts["terrain"]))
    if mass is not None:
        known = float(facts.setdefault("mass", mass))
        if known != mass:
            raise ProblemError(f"the log tells mass = {known:g} kg, not {mass:g}")
    if mu is not None:
        if "mu" in arrays or "contact_friction" in arrays:
            raise ProblemError("the log tells its friction: mu is for a log without")
        arrays["mu"] = np.full(len(log), mu)
    if robot is not None and "mapping" in facts:
        arrays, facts = _order_as_robot(log, arrays, facts, robot)
    if terrain is not None:
        facts.setdefault("terrain", terrain.text)
    if "gaps" not in arrays and terrain is not None:
        _place(arrays, robot, terrain, computed)
        if "normals" in arrays and "forces" in arrays and _in_world_axes(facts):
            arrays["forces"] = _in_contact_axes(arrays["forces"], arrays["normals"])
            facts["doubts"] = [line for line in log.doubts if not line.endswith(LEVEL)]
    if computed:
        ground = f" on {terrain.text}" if terrain is not None else ""
        facts["computed"] = [f"{', '.join(computed)}: from the log's {_from(log, robot)}{ground}"]
    return Log(arrays, facts, channels=log.channels)


def _from(log: Log, robot: Robot | None) -> str:
    return "contact_positions" if "contact_positions" in log or robot is None else f"q and {robot.name}"


def _order_as_robot(
    log: Log, arrays: dict[str, Any], facts: dict[str, Any], robot: Robot
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return arrays and facts with joints and feet in the robot's order, where the log names them."""
    joints = tuple(map(str, facts.get("joints", ())))
    if sorted(joints) == sorted(robot.joint_names) and joints != robot.joint_names:
        order = np.array([joints.index(name) for name in robot.joint_names])
        composed = "joint_positions" in log  # q and v were put together from the parts, in their order
        for name, channel in log.channels.items():
            if channel.shape == ("joints",):
                arrays[name] = arrays[name][:, order]
            elif name in ("q", "v") and composed:
                base = arrays[name].shape[1] - len(order)
                arrays[name] = np.hstack([arrays[name][:, :base], arrays[name][:, base:][:, order]])
        facts["joints"] = list(robot.joint_names)
    elif log.sizes.get("joints", robot.joints) != robot.joints:
        raise ProblemError(f"the log has {log.sizes['joints']} joints, {robot.name} has {robot.joints}")
    feet = tuple(robot.foot(str(name)).name for name in facts.get("feet", ()))
    points = robot.contact_points
    if log.sizes.get("p", len(points)) != len(points):
        raise ProblemError(f"the log has {log.sizes['p']} contact points, {robot.name} has {len(points)}")
    if feet and sorted(feet) == sorted(robot.foot_names) and len(points) == len(feet):
        order = np.array([feet.index(name) for name in robot.foot_names])
        for name in log.arrays:
            if log.channels[name].shape[:1] in (("p",), ("n",)):
                arrays[name] = arrays[name][:, order]
        facts |= {"feet": list(robot.foot_names), "contact_foot": points.foot.tolist()}
    return arrays, facts


def _place(arrays: dict[str, Any], robot: Robot | None, terrain: Terrain, computed: list[str]) -> None:
    """Add positions, velocities, normals and gaps of the contacts, as far as they follow."""
    if "contact_positions" in arrays:
        gaps, normals = terrain.nearest(np.asarray(arrays["contact_positions"]))
        arrays |= {"gaps": gaps, "normals": normals}
        computed += ["gaps", "normals"]
    elif robot is not None and "q" in arrays:
        if arrays["q"].shape[1] != robot.model.nq:
            raise ProblemError(
                f"q of the log has {arrays['q'].shape[1]} numbers, {robot.name} has {robot.model.nq}"
            )
        radii = robot.contact_points.radii
        v = arrays["v"] if "v" in arrays and "contact_velocities" not in arrays else None
        centres, twists = _centres(robot, np.asarray(arrays["q"]), v)
        gaps, normals = terrain.nearest(centres)
        below = radii[:, None] * normals
        found = {"contact_positions": centres - below, "gaps": gaps - radii, "normals": normals}
        if v is not None:
            velocity = twists[..., :3] - np.cross(twists[..., 3:], below)
            found["contact_velocities"] = _in_contact_axes(velocity, normals)
        arrays |= found
        computed += found


def _centres(robot: Robot, q: FloatArray, v: Any) -> tuple[FloatArray, FloatArray]:
    """Return the contact spheres' centres (T, p, 3) [m] and twists (T, p, 6) [m/s, rad/s], world axes.

    The twist is of the sphere's centre; NaN where q is not finite.
    """
    import pinocchio

    points, model, data = robot.contact_points, robot.model, robot.model.createData()
    centres = np.full((len(q), len(points), 3), np.nan)
    twists = np.full((len(q), len(points), 6), np.nan)
    still = np.zeros(model.nv)
    for t in np.flatnonzero(np.isfinite(q).all(axis=1)).tolist():
        pinocchio.forwardKinematics(model, data, np.array(q[t]), still if v is None else np.array(v[t]))
        for k, (joint, place) in enumerate(zip(points.joints.tolist(), points.places, strict=True)):
            pose, twist = data.oMi[joint], data.v[joint]
            centres[t, k] = pose.act(place)
            twists[t, k, :3] = pose.rotation @ (twist.linear + np.cross(twist.angular, place))
            twists[t, k, 3:] = pose.rotation @ twist.angular
    return centres, twists


def _in_world_axes(facts: dict[str, Any]) -> bool:
    """Return whether a log's forces are in the world's axes: they were given in others than the contacts'."""
    take = mapping_from_yaml(facts["mapping"]).channels.get("forces") if "mapping" in facts else None
    return take is not None and take.frame in ("world", "base")


def _in_contact_axes(vectors: FloatArray, normals: FloatArray) -> FloatArray:
    """Return vectors (T, p, 3) in world axes, in those of contacts with normals (T, p, 3)."""
    frames = frames_on(np.reshape(normals, (-1, 3)))
    turned = np.einsum("kji,kj->ki", frames, np.asarray(vectors).reshape(-1, 3))
    return np.asarray(turned.reshape(np.shape(vectors)))
