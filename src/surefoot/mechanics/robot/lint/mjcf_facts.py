"""Facts of an MJCF file through MuJoCo's MjSpec: parsed, with its defaults and includes, but not compiled."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import quaternion_xyzw, rotation_from_quaternion
from surefoot.mechanics.robot.lint.facts import (
    ActuatorFacts,
    Fault,
    JointFacts,
    LinkFacts,
    ModelFacts,
    ShapeFacts,
)


def mjcf_facts(mujoco: Any, path: Path, spec: Any, compiled: Any) -> ModelFacts:
    """Return the facts of an MJCF file.

    Parameters
    ----------
    mujoco
        The module.
    path, spec
        The file, and MuJoCo's MjSpec of it.
    compiled
        Its MjModel, which knows masses that come from shapes; None where MuJoCo refuses it.
    """
    facts = ModelFacts(path, "mjcf")
    meshes = {mesh.name or Path(mesh.file).stem: mesh for mesh in spec.meshes}
    for body in spec.bodies:
        if body.parent is None:
            continue
        name = _name(body, "body", facts)
        facts.links.append(_link(body, name, compiled, facts))
        facts.joints += _joints(mujoco, spec, body, name, facts)
        facts.shapes += [shape for geom in body.geoms if (shape := _shape(spec, meshes, path, name, geom))]
    facts.actuators = [_actuator(mujoco, actuator, k) for k, actuator in enumerate(spec.actuators)]
    return facts


def _name(item: Any, kind: str, facts: ModelFacts) -> str:
    """Return the name of an element, or its number among the links where it has none."""
    return item.name or f"{kind}_{len(facts.links) + 1}"


def _finite(facts: ModelFacts, place: str, key: str, values: Any) -> FloatArray:
    """Return an attribute's numbers; those that are not finite are a fault."""
    out = np.array(values, dtype=np.float64).reshape(-1)
    if not np.isfinite(out).all():
        facts.faults.append(Fault("not-a-number", f"{place}, {key}", " ".join(f"{x:g}" for x in out)))
    return out


def _link(body: Any, name: str, compiled: Any, facts: ModelFacts) -> LinkFacts:
    """Return a body's mass and inertia: as the file gives them, else as MuJoCo computed them from shapes."""
    if body.explicitinertial:
        mass, com = float(body.mass), _finite(facts, f"body {name}", "inertial pos", body.ipos)
        full = np.array(body.fullinertia)
        if np.isfinite(full[0]):
            a, b, c, d, e, f = full
            return LinkFacts(name, mass, com, np.array([[a, d, e], [d, b, f], [e, f, c]]), True)
        turn = _unit_rotation(body.iquat)
        moments = np.diag(_finite(facts, f"body {name}", "inertial diaginertia", body.inertia))
        if not math.isfinite(mass):
            facts.faults.append(Fault("not-a-number", f"body {name}, inertial mass", f"{mass:g}"))
        return LinkFacts(name, mass, com, turn @ moments @ turn.T, True)
    if compiled is None:
        return LinkFacts(name)
    k, turn = int(body.id), _unit_rotation(compiled.body_iquat[int(body.id)])
    moments = np.diag(np.array(compiled.body_inertia[k]))
    mass = float(compiled.body_mass[k])
    return LinkFacts(name, mass, np.array(compiled.body_ipos[k]), turn @ moments @ turn.T, mass > 0.0)


def _unit_rotation(wxyz: Any) -> FloatArray:
    """Return the rotation (3, 3) of MuJoCo's quaternion, which need not be of length one."""
    q = np.array(wxyz, dtype=np.float64)
    length = float(np.linalg.norm(q))
    unit = q / length if math.isfinite(length) and length > 0.0 else np.array([1.0, 0.0, 0.0, 0.0])
    return np.asarray(rotation_from_quaternion(quaternion_xyzw(unit)))


def _joints(mujoco: Any, spec: Any, body: Any, name: str, facts: ModelFacts) -> list[JointFacts]:
    """Return a body's joints; a body without one is welded to its parent."""
    parent, origin = body.parent.name or "world", _finite(facts, f"body {name}", "pos", body.pos)
    if not body.joints:
        return [JointFacts(f"{name} (welded)", "fixed", parent, name, origin)]
    kinds = {
        mujoco.mjtJoint.mjJNT_HINGE: "revolute", mujoco.mjtJoint.mjJNT_SLIDE: "prismatic",
        mujoco.mjtJoint.mjJNT_FREE: "floating", mujoco.mjtJoint.mjJNT_BALL: "ball",
    }  # fmt: skip
    out = []
    for k, joint in enumerate(body.joints):
        title, kind = joint.name or f"joint {k + 1} of {name}", kinds[joint.type]
        place = f"joint {title}"
        low, high = _finite(facts, place, "range", joint.range)
        hinge = kind == "revolute" and spec.compiler.degree
        scale = math.pi / 180.0 if hinge else 1.0
        auto = joint.limited == mujoco.mjtLimited.mjLIMITED_AUTO
        limited = (low != 0.0 or high != 0.0) if auto else joint.limited == mujoco.mjtLimited.mjLIMITED_TRUE
        least, most = _finite(facts, place, "actuatorfrcrange", joint.actfrcrange)
        effort = max(abs(least), abs(most)) if (least, most) != (0.0, 0.0) else math.nan
        out.append(
            JointFacts(
                title, kind, parent, name, origin, _finite(facts, place, "axis", joint.axis),
                low * scale if limited else math.nan, high * scale if limited else math.nan, effort,
                damping=float(np.reshape(_finite(facts, place, "damping", joint.damping), -1)[0]),
                armature=float(_finite(facts, place, "armature", joint.armature)[0]), limited=limited,
            )
        )  # fmt: skip
    return out


def _shape(spec: Any, meshes: dict[str, Any], path: Path, body: str, geom: Any) -> ShapeFacts | None:
    """Return a geom; of a mesh, the file that it is drawn from."""
    kind = geom.type.name.removeprefix("mjGEOM_").lower()
    collides = bool(geom.contype or geom.conaffinity)
    if kind != "mesh":
        count = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}.get(kind)
        if count is None:
            return None
        given = count if math.isnan(float(geom.fromto[0])) else 1
        return ShapeFacts(body, kind, tuple(float(x) for x in geom.size[:given]), collides)
    mesh = meshes.get(geom.meshname)
    if mesh is None:
        return ShapeFacts(body, "mesh", (1.0, 1.0, 1.0), collides, geom.meshname)
    scale = tuple(float(x) for x in mesh.scale)
    if not mesh.file:
        return ShapeFacts(body, "mesh", scale, collides)
    places = [path.parent / spec.meshdir / mesh.file, path.parent / mesh.file, Path(spec.meshdir) / mesh.file]
    places += [path.parent / spec.meshdir / Path(mesh.file).name]
    return ShapeFacts(
        body, "mesh", scale, collides, mesh.file, next((p for p in places if p.is_file()), None)
    )


def _actuator(mujoco: Any, actuator: Any, k: int) -> ActuatorFacts:
    """Return an actuator with its ranges, and the gains of a servo."""
    kinds = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    force, command = (tuple(float(x) for x in r) for r in (actuator.forcerange, actuator.ctrlrange))
    bias = np.array(actuator.biasprm, dtype=np.float64)
    servo = actuator.biastype == mujoco.mjtBias.mjBIAS_AFFINE
    gear = float(actuator.gear[0])
    return ActuatorFacts(
        actuator.name or f"actuator {k + 1}", actuator.target, gear,
        force if force != (0.0, 0.0) else None,  # type: ignore[arg-type]
        command if command != (0.0, 0.0) else None,  # type: ignore[arg-type]
        actuator.trntype in kinds,
        stiffness=-float(bias[1]) * gear**2 if servo else 0.0,
        damping=-float(bias[2]) * gear**2 if servo else 0.0,
    )  # fmt: skip
