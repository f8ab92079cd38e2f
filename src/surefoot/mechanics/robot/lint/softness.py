"""Rules on the contacts of an MJCF file: how deep a robot that stands sinks into them.

At rest MuJoCo's normal contact presses with f = k(r) r d(r) / ((1 - d(r)) A), k(r) = K d(r), with d(r) the
impedance at depth r, K the stiffness of solref, and A the contact's inverse mass as MuJoCo estimates it
(body_invweight0 of its two bodies; MuJoCo's documentation, "Solver parameters"). n contacts that share the
weight m g have the depth at which f = m g / n.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from surefoot.base.errors import ProblemError
from surefoot.contact import MujocoLaw
from surefoot.mechanics.robot.lint.finding import Offence, Rule
from surefoot.mechanics.robot.lint.subject import Subject

LAWFUL = 1e-3
"""Deepest penetration that the audit takes for touching [m]; see `surefoot.records.audit.limits`."""
DEEP = 5e-3
"""Depth from which a swing's clearance and a foothold's height are wrong by a tenth [m]."""
FIRM = MujocoLaw((0.003, 1.0))
"""Contact of Surefoot's own ground in MuJoCo, of URDF files and of files without a floor."""
NEAR = 2e-3
"""Height over the lowest point of the robot at which a shape still stands on the ground [m]."""


class Sinking(NamedTuple):
    """How deep a robot sinks where it stands [m], and on firm ground; contacts, their load [N], softness."""

    depth: float
    firm_depth: float
    contacts: int
    load: float
    solref: tuple[float, float]
    solimp: tuple[float, ...]
    body: str
    own_floor: bool


def rest_depth(law: MujocoLaw, load: float, inverse_mass: float) -> float:
    """Return how deep one contact is at rest [m].

    Parameters
    ----------
    law
        Its solref and solimp.
    load
        What it bears [N].
    inverse_mass
        MuJoCo's estimate A for it [1/kg].
    """
    stiffness, _ = law.stiffness_and_damping

    def force(depth: float) -> float:
        d = float(law.impedance(np.array(depth))[0])
        return stiffness * d * depth * d / ((1.0 - d) * inverse_mass)

    low, high = 0.0, 1e-6
    while force(high) < load and high < 1e3:
        low, high = high, 2.0 * high
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if force(middle) < load else (low, middle)
    return high


def find_sinking(mujoco: Any, spec: Any, compiled: Any) -> Sinking | None:
    """Return how deep the robot of a file sinks, standing in its keyframe or first pose on its lowest shapes.

    A file without a floor is given one with MuJoCo's defaults. None for a robot without a free base, or
    without shapes that could stand.
    """
    own = _floor(mujoco, compiled) is not None
    model = compiled
    if not own:
        scene = copy.deepcopy(spec) if hasattr(spec, "__deepcopy__") else spec.copy()
        scene.worldbody.add_geom(name="", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1.0, 1.0, 1.0])
        model = scene.compile()
    data, floor = mujoco.MjData(model), _floor(mujoco, model)
    free = np.flatnonzero(np.array(model.jnt_type) == int(mujoco.mjtJoint.mjJNT_FREE))
    if floor is None or not free.size:
        return None
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    root = int(model.body_rootid[model.jnt_bodyid[free[0]]])
    mujoco.mj_kinematics(model, data)
    solid = [
        geom
        for geom in range(model.ngeom)
        if int(model.body_rootid[model.geom_bodyid[geom]]) == root and _touches(model, geom, floor)
    ]
    heights = [float(mujoco.mj_geomDistance(model, data, floor, geom, 100.0, None)) for geom in solid]
    if not heights or not np.isfinite(heights).all():
        return None
    data.qpos[int(model.jnt_qposadr[free[0]]) + 2] -= min(heights) + NEAR
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_collision(model, data)
    found = [c for c in data.contact[: data.ncon] if floor in c.geom and set(c.geom.tolist()) & set(solid)]
    return _deepest(model, found, float(model.body_subtreemass[root]), own)


def _deepest(model: Any, contacts: list[Any], mass: float, own: bool) -> Sinking | None:
    """Return the deepest of contacts that share the weight of a mass [kg]."""
    if not contacts:
        return None
    load = mass * float(np.linalg.norm(model.opt.gravity)) / len(contacts)
    out: list[Sinking] = []
    for contact in contacts:
        bodies = model.geom_bodyid[contact.geom]
        solref = (float(contact.solref[0]), float(contact.solref[1]))
        solimp = tuple(float(x) for x in contact.solimp)
        try:
            law = MujocoLaw(solref, solimp, dt=float(model.opt.timestep))
        except ProblemError:
            continue
        inverse_mass = max(float(model.body_invweight0[bodies, 0].sum()), 1e-12)
        depth, firm = (rest_depth(one, load, inverse_mass) for one in (law, FIRM))
        body = model.body(int(bodies.max())).name
        out.append(Sinking(depth, firm, len(contacts), load, solref, solimp, body, own))
    return max(out, key=lambda one: one.depth, default=None)


def _floor(mujoco: Any, model: Any) -> int | None:
    """Return the first plane that is fixed in the world, level and solid."""
    for geom in range(model.ngeom):
        fixed = int(model.body_weldid[model.geom_bodyid[geom]]) == 0
        plane = int(model.geom_type[geom]) == int(mujoco.mjtGeom.mjGEOM_PLANE)
        if fixed and plane and (model.geom_contype[geom] or model.geom_conaffinity[geom]):
            return geom
    return None


def _touches(model: Any, geom: int, floor: int) -> bool:
    types, answers = model.geom_contype, model.geom_conaffinity
    return bool((types[geom] & answers[floor]) or (types[floor] & answers[geom]))


def _soft_contacts(subject: Subject) -> Iterator[Offence]:
    sinking = subject.sinking
    if sinking is None or sinking.depth <= LAWFUL:
        return
    softness = "solref " + _list(sinking.solref) + ", solimp " + _list(sinking.solimp)
    value = f"sinks {1e3 * sinking.depth:.3g} mm"
    firm = f"{1e3 * sinking.firm_depth:.2g} mm"
    bears = f"{softness}; {sinking.contacts} contacts of {sinking.load:.3g} N"
    if sinking.own_floor:
        severity = "error" if sinking.depth > DEEP else ""
        detail = (
            f"{bears}. As a URDF the same robot is lawful: on Surefoot's ground it sinks {firm}; "
            f"here the audit counts what exceeds {1e3 * LAWFUL:g} mm as penetration"
        )
        yield Offence(f"foot body {sinking.body}", value, detail, severity)
    else:
        detail = (
            f"{bears}, on a floor of MuJoCo's defaults. On Surefoot's ground it sinks {firm}, as it does as "
            "a URDF; in a scene with such a floor the same robot breaks the audit's law of penetration"
        )
        soft = sinking.solref != (0.02, 1.0) or sinking.solimp[:3] != (0.9, 0.95, 0.001)
        severity = ("error" if sinking.depth > DEEP else "warning") if soft else "note"
        yield Offence(f"foot body {sinking.body}", value, detail, severity)


def _list(values: tuple[float, ...]) -> str:
    return " ".join(f"{x:.4g}" for x in values)


SOFTNESS_RULES = (
    Rule(
        "contact-sinks",
        "solref and solimp of what stands, the weight and the contacts that share it",
        "warning",
        "Take a shorter time constant, solref 0.005 1, or a solimp nearer to one, 0.99 0.999 0.001.",
        _soft_contacts,
    ),
)
"""The family."""
