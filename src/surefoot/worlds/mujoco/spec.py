"""MuJoCo's module, and a robot's Pinocchio model and a terrain as an MjSpec."""

from __future__ import annotations

import ctypes.util
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeAlias, TypedDict

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array
from surefoot.base.errors import MissingExtra, ModelError, ProblemError, mujoco_line
from surefoot.base.spatial import quaternion_from_rotation, quaternion_wxyz
from surefoot.contact import MujocoLaw
from surefoot.mechanics import DEPTH, EXTENT, Grid, GroundBox, Plane, Robot, Terrain
from surefoot.worlds.interface.engine_world import joint_kind

FRICTION_RATIO = 100.0
"""MuJoCo's impratio: friction much stiffer than the normal, so that a sticking foot hardly creeps."""
TOUCHING: dict[str, Any] = {"contype": 0, "conaffinity": 1, "condim": 3, "density": 0.0}
"""What a robot's geom says of its contacts: with the ground alone, and without a mass of its own."""


Softness: TypeAlias = Sequence[float] | None
"""MuJoCo's solref or solimp; None for close to rigid."""


class GroundLaw(TypedDict, total=False):
    """How contacts give way, if they do; see `MujocoWorld`."""

    solref: Softness
    solimp: Softness
    exact: bool
    restitution: float


def import_mujoco() -> Any:
    """Return the mujoco module.

    MuJoCo fixes how it draws when it is first imported. Without a screen, and unless MUJOCO_GL says
    otherwise, it draws through EGL or OSMesa if the system has one of them.

    Raises
    ------
    MissingExtra
        If it is not installed.
    ModelError
        If it does not load with the MUJOCO_GL of the environment.
    """
    if "mujoco" not in sys.modules and not {"MUJOCO_GL", "DISPLAY"} & os.environ.keys():
        for name, library in (("egl", "EGL"), ("osmesa", "OSMesa")):
            if ctypes.util.find_library(library):
                os.environ["MUJOCO_GL"] = name
                break
    try:
        import mujoco
    except ModuleNotFoundError as error:
        raise MissingExtra("mujoco", "sim") from error
    except (ImportError, AttributeError, RuntimeError) as error:
        wanted = os.environ.get("MUJOCO_GL", "")
        raise ModelError(f"MuJoCo does not load with MUJOCO_GL={wanted!r}: {error}") from error
    return mujoco


def robot_spec(robot: Robot, payload: float = 0.0, payload_position: FloatArray | None = None) -> Any:
    """Return an MjSpec with the robot's joints, inertias and foot spheres, and nothing else.

    Bodies are named ``base:0`` for the floating base and ``joint:NAME``, geoms ``foot:NAME:k``. The payload
    [kg] sits at (3,) base axes [m].

    Raises
    ------
    ModelError
        If the robot has a joint that is neither revolute nor prismatic.
    """
    mujoco = import_mujoco()
    spec, model = mujoco.MjSpec(), robot.model
    spec.modelname = robot.name
    spec.compiler.degree = False
    option = spec.option
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    option.iterations, option.tolerance, option.impratio = 50, 1e-10, FRICTION_RATIO
    option.gravity = np.array(model.gravity.linear)
    bodies = {0: spec.worldbody}
    for index in range(1, model.njoints):
        name = str(model.names[index])
        pose = model.jointPlacements[index]
        body = bodies[int(model.parents[index])].add_body(
            name="base:0" if robot.floating and index == 1 else f"joint:{name}",
            pos=pose.translation,
            quat=quaternion_wxyz(quaternion_from_rotation(pose.rotation)),
        )
        bodies[index] = body
        _add_joint(mujoco, body, model, index, name)
        _check_inertia(robot.name, name, model.inertias[index])
        _set_inertia(body, model.inertias[index])
    if payload > 0.0:
        add_payload(bodies[1], payload, np.zeros(3) if payload_position is None else payload_position)
    points = robot.contact_points
    for name, joint, place, radius in zip(
        points.names, points.joints, points.places, points.radii, strict=True
    ):
        bodies[int(joint)].add_geom(
            name=f"foot:{name}",
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[radius, 0.0, 0.0],
            pos=place,
            **TOUCHING,
        )
    return spec


def add_payload(body: Any, mass: float, place: FloatArray) -> None:
    """Hang a load [kg] on a body of an MjSpec, at a place (3,) in its axes [m]."""
    load = body.add_body(name="payload", pos=place)
    load.explicitinertial, load.mass, load.ipos = True, mass, np.zeros(3)
    load.inertia = np.full(3, 1e-3 * mass)


def compile_spec(spec: Any, name: str | Path) -> Any:
    """Return the model of an MjSpec; `name` says in errors whose it is."""
    try:
        return spec.compile()
    except ValueError as error:
        raise ModelError(f"MuJoCo cannot simulate {name}: {mujoco_line(error)}") from error


def _check_inertia(robot: str, joint: str, inertia: Any) -> None:
    """Refuse what MuJoCo refuses of a link, in words: no mass, and moments of inertia that no mass has."""
    if not inertia.mass > 1e-15:
        raise ModelError(
            f"MuJoCo cannot simulate {robot}: the link that hangs on joint {joint} has no mass. Give it some "
            "in the file, or take --world rigid, which takes it as it is"
        )
    low, middle, high = np.maximum(np.linalg.eigvalsh(inertia.inertia), 1e-12)
    if low + middle < high * (1.0 - 1e-12):
        raise ModelError(
            f"MuJoCo cannot simulate {robot}: what hangs on joint {joint} has the moments of inertia "
            f"{low:.3g}, {middle:.3g} and {high:.3g} kg m², and in no body one is larger than the other two "
            "together. Mend the inertia in the file, or take --world rigid, which takes it as it is"
        )


def _set_inertia(body: Any, inertia: Any) -> None:
    """Give an MjSpec body a Pinocchio inertia, through its principal axes."""
    if inertia.mass <= 0.0:
        return
    moments, axes = np.linalg.eigh(inertia.inertia)
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] *= -1.0
    body.explicitinertial, body.mass = True, inertia.mass
    body.ipos = inertia.lever
    body.iquat = quaternion_wxyz(quaternion_from_rotation(axes))
    body.inertia = np.maximum(moments, 1e-12)


def _add_joint(mujoco: Any, body: Any, model: Any, index: int, name: str) -> None:
    """Add the joint of a Pinocchio model to its MjSpec body."""
    joint = model.joints[index]
    kind, axis = joint_kind(joint, name)
    if kind == "free":
        body.add_freejoint(name=name)
        return
    low, high = float(model.lowerPositionLimit[joint.idx_q]), float(model.upperPositionLimit[joint.idx_q])
    limited = np.isfinite([low, high]).all() and low < high
    body.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_HINGE if kind == "revolute" else mujoco.mjtJoint.mjJNT_SLIDE,
        axis=axis,
        limited=mujoco.mjtLimited.mjLIMITED_TRUE if limited else mujoco.mjtLimited.mjLIMITED_FALSE,
        range=[low, high] if limited else [0.0, 0.0],
    )


CELL = 0.0125
"""Largest cell of a height field [m]: MuJoCo's surface is flat within it, the terrain's is smooth."""
MOST_CELLS = 4_000_000
CONTACT_TIME = 0.003
"""Time constant of MuJoCo's soft contact [s]: three steps of 1 ms, where it takes two at least.

Divided by `MujocoWorld.substeps`: the ground gets harder as the steps get shorter.
"""
IMPEDANCE = (0.9, 0.95, 0.001, 0.5, 2.0)
"""MuJoCo's contact impedance (d_min, d_max, width, midpoint, power).

Not closer to one: a foot that turns with its shank at a rate w leaves the ground by itself, since MuJoCo's
constraint leaves out the acceleration w² r at which its surface turns away. The force presses it back by
its share 1 - d: at d = 0.97 a fast foot hops every 20 ms, with 170 N after nothing.
"""


def add_ground(
    spec: Any,
    terrain: Terrain,
    mu: float,
    solref: Sequence[float] | None = None,
    solimp: Sequence[float] | None = None,
) -> None:
    """Add the terrain to an MjSpec as geoms named ``ground...``; see `MujocoWorld` for the softness.

    Raises
    ------
    ProblemError
        If this world has no shape for the terrain, a grid is too large, or for numbers that are no softness.
    """
    common: dict[str, Any] = {
        "contype": 1,
        "conaffinity": 0,
        "condim": 3,
        "priority": 1,
        "rgba": [0.91, 0.89, 0.85, 1.0],
    }
    common |= surface_of(mu, solref, solimp)
    mujoco, shapes = import_mujoco(), terrain.shapes()
    for k, shape in enumerate(shapes):
        name = f"ground:{k}" if len(shapes) > 1 else "ground"
        if type(shape) not in _GEOMS:
            raise ProblemError(
                f"the MuJoCo world takes planes, boxes and grids, a {type(terrain).__name__} is made of a "
                f"{type(shape).__name__}"
            )
        geom = _GEOMS[type(shape)](mujoco, spec, name, shape)
        spec.worldbody.add_geom(name=name, **geom, **common)


def surface_of(mu: float, solref: Sequence[float] | None, solimp: Sequence[float] | None) -> dict[str, Any]:
    """Return the attributes of a geom that say its friction and its softness."""
    softness = MujocoLaw(
        (CONTACT_TIME, 1.0) if solref is None else tuple(solref),  # type: ignore[arg-type]
        IMPEDANCE if solimp is None else tuple(solimp),
    )
    return {
        "friction": [max(mu, 1e-5), 0.0, 0.0],
        "solref": list(softness.solref),
        "solimp": list(softness.solimp),
    }


def _plane(mujoco: Any, spec: Any, name: str, plane: Plane) -> dict[str, Any]:
    half = 0.5 * EXTENT
    return {
        "type": mujoco.mjtGeom.mjGEOM_PLANE,
        "size": [half, half, 1.0],
        "pos": plane.point,
        "quat": quaternion_wxyz(quaternion_from_rotation(plane.rotation)),
    }


def _box(mujoco: Any, spec: Any, name: str, box: GroundBox) -> dict[str, Any]:
    return {"type": mujoco.mjtGeom.mjGEOM_BOX, "size": 0.5 * box.size, "pos": box.centre}


def _grid(mujoco: Any, spec: Any, name: str, grid: Grid) -> dict[str, Any]:
    """Sample the surface finely into a height field of the same name."""
    nx, ny = (int(n) for n in grid.counts(CELL))
    if nx * ny > MOST_CELLS:
        raise ProblemError(
            f"the MuJoCo world takes height fields of up to {MOST_CELLS * CELL**2:.0f} m², "
            f"got {grid.size[0]:g} x {grid.size[1]:g} m"
        )
    heights = grid.heights(CELL).T  # MuJoCo's rows go along y
    low, high = float(heights.min()), float(heights.max())
    rise = max(high - low, 1e-6)
    half = 0.5 * grid.size
    spec.add_hfield(
        name=name,
        nrow=ny,
        ncol=nx,
        size=[*half, rise, DEPTH],
        userdata=((heights - low) / rise).astype(np.float32).ravel(),
    )
    middle = grid.origin + half
    return {"type": mujoco.mjtGeom.mjGEOM_HFIELD, "hfieldname": name, "pos": [*middle, low]}


_GEOMS: dict[type, Any] = {Plane: _plane, GroundBox: _box, Grid: _grid}


def set_point_friction(world: Any, mu: FloatArray) -> None:
    """Change the friction [-] under each of a MuJoCo world's (p,) contact points, from the next step on.

    What else touches the ground has the friction of `set_friction`.
    """
    model, ground = world.model, world.ground_geoms[0]
    feet = [int(model.geom(f"foot:{name}").id) for name in world.robot.contact_points.names]
    if model.geom_priority[feet[0]] <= model.geom_priority[ground]:  # from now on the feet's own counts
        model.geom_priority[feet] = model.geom_priority[ground] + 1
        model.geom_solref[feet], model.geom_solimp[feet] = (
            model.geom_solref[ground],
            model.geom_solimp[ground],
        )
    model.geom_friction[feet, 0] = np.maximum(finite_array("mu", mu, (len(feet),)), 1e-5)
