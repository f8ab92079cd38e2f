"""What a recording keeps of the model it was made with: bodies, joints, geoms, actuators, and what changed.

Plain arrays and names, from which an audit tells feet from other links, torques that were asked for from
those that were given, and a world that changed under the robot from one that did not.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import entry_point
from surefoot.worlds.mujoco.record_capture import RawBlock
from surefoot.worlds.mujoco.record_copy import COPY_TYPES, MemoryTable, parts_differ
from surefoot.worlds.mujoco.record_hulls import hull_facts
from surefoot.worlds.mujoco.record_tree import BodyTree

LOWEST = 0.5
"""An end of a limb is a foot if it reaches at least this share as far below the root as the lowest."""
BESIDE = 0.1
"""Its geoms that are within this share of that depth of its lowest are the foot; others are its shank."""


class Change(NamedTuple):
    """A number of the model that its loop changed: when [s], of what, whose, and its factor on the old."""

    time: float
    kind: str
    name: str
    factor: float


WATCHED = (
    "body_mass", "body_inertia", "body_ipos", "body_iquat", "body_pos", "body_quat", "jnt_pos", "jnt_axis",
    "geom_pos", "geom_quat", "geom_size", "geom_friction", "dof_armature", "dof_damping",
    "actuator_gainprm", "actuator_forcerange",
)  # fmt: skip
"""Arrays of a model that a loop may change between steps and that forces or kinematics depend on."""


class ModelWatch:
    """Keeps which numbers of a model its loop changes from step to step.

    Attributes
    ----------
    versions
        First step and its time [s], and all watched numbers from it on.
    """

    def __init__(self, mujoco: Any, model: Any) -> None:
        self._mujoco, self._model = mujoco, model
        self._views = [*(getattr(model, name) for name in WATCHED), model.opt.gravity]
        self._table = MemoryTable(self._views)
        self._differ = entry_point(parts_differ, *COPY_TYPES)
        self._known = self._numbers()
        self.versions: list[tuple[int, float, FloatArray]] = [(0, 0.0, self._known)]

    def changed(self) -> bool:
        """Return whether a number is another than it was."""
        return self._differ(self._table.base, self._table.parts, self._known)

    def note(self, step: int, time: float) -> None:
        """Keep what changed before a step that began at a time [s]."""
        self._known = self._numbers()
        self.versions.append((step, time, self._known))

    def _numbers(self) -> FloatArray:
        """Return all watched numbers, gravity last."""
        return np.concatenate([view.reshape(-1) for view in self._views])

    def version(self, step: int) -> int:
        """Return which version of the model a step was made with."""
        return bisect_right(self.versions, step, key=lambda one: one[0]) - 1

    def restore(self, version: int, model: Any) -> None:
        """Write a version's numbers into a copy of the model."""
        numbers, at = self.versions[version][2], 0
        for name, view in zip((*WATCHED, ""), self._views, strict=True):
            target = getattr(model, name) if name else model.opt.gravity
            target[:] = numbers[at : at + view.size].reshape(view.shape)
            at += view.size

    def _changes(self) -> Iterator[tuple[int, Change]]:
        """Yield step and change of what a story tells of: masses, gains, limits of torques and friction."""
        kinds, model = self._mujoco.mjtObj, self._model
        told = {
            "body_mass": ("mass", kinds.mjOBJ_BODY, 0),
            "actuator_gainprm": ("gain", kinds.mjOBJ_ACTUATOR, 0),
            "actuator_forcerange": ("torque limit", kinds.mjOBJ_ACTUATOR, 1),
            "geom_friction": ("friction", kinds.mjOBJ_GEOM, 0),
        }
        starts = dict(
            zip(WATCHED, np.cumsum([0, *(view.size for view in self._views)]).tolist(), strict=False)
        )
        for (_, _, last), (step, time, now) in pairwise(self.versions):
            for array, (kind, owner, column) in told.items():
                view = getattr(model, array)
                width = view.shape[1] if view.ndim > 1 else 1
                part = slice(starts[array] + column, starts[array] + view.size, width)
                for k in np.flatnonzero(now[part] != last[part]).tolist():
                    name = self._mujoco.mj_id2name(model, owner, k) or f"{kind} {k}"
                    name = geom_name(model, k) if owner == kinds.mjOBJ_GEOM else name
                    factor = float(now[part][k] / last[part][k]) if last[part][k] else np.inf
                    yield step, Change(time, kind, name, factor)

    def facts(self) -> dict[str, Any]:
        """Return the changes as facts of a log; ``change_row`` is the first row of each."""
        found = list(self._changes())
        if not found:
            return {}
        time, kind, name, factor = zip(*(change for _, change in found), strict=True)
        return {
            "change_time": np.array(time), "change_kind": list(kind), "change_name": list(name),
            "change_factor": np.array(factor), "change_row": np.array([step for step, _ in found]),
        }  # fmt: skip


class TorqueDemand:
    """What actuators of a model are asked for on its hinges and slides, before their limits cut it.

    By the model as it was at the start: an actuator whose gain is cut later gives less than is asked.
    Actuators with a memory, on tendons or by functions of the user's own are not known.

    Attributes
    ----------
    known
        Whether all that drives the robot's joints is.
    limits
        (joints,) largest torque that actuators can give there [N m, N], infinite where nothing limits them.
    """

    def __init__(self, mujoco: Any, model: Any, tree: BodyTree) -> None:
        self._model, place = model, {dof: k for k, dof in enumerate(tree.joint_dofs)}
        joint = int(mujoco.mjtTrn.mjTRN_JOINT)
        fixed, none = int(mujoco.mjtGain.mjGAIN_FIXED), int(mujoco.mjtDyn.mjDYN_NONE)
        affine, plain = int(mujoco.mjtBias.mjBIAS_AFFINE), int(mujoco.mjtBias.mjBIAS_NONE)
        rows: list[tuple[int, int, float, FloatArray]] = []
        self.known = model.nu > 0
        self.limits = np.full(tree.joints, np.inf)
        limits = np.zeros(tree.joints)
        for k in range(model.nu):
            dof = int(model.jnt_dofadr[model.actuator_trnid[k, 0]])
            if int(model.actuator_trntype[k]) != joint or dof not in place:
                self.known &= int(model.actuator_trntype[k]) == joint
                continue
            gear, at = float(model.actuator_gear[k, 0]), place[dof]
            bias = int(model.actuator_biastype[k])
            simple = int(model.actuator_gaintype[k]) == fixed and int(model.actuator_dyntype[k]) == none
            self.known &= simple and bias in (affine, plain)
            terms = np.zeros(4)
            terms[0] = model.actuator_gainprm[k, 0]
            if bias == affine:
                terms[1:] = model.actuator_biasprm[k, :3]
            rows.append((k, at, gear, terms))
            limits[at] += abs(gear) * self._largest(k, terms)
        self._actuators = np.array([k for k, *_ in rows], dtype=np.int64)
        self._places = np.array([at for _, at, _, _ in rows], dtype=np.int64)
        self._gears = np.array([gear for _, _, gear, _ in rows])
        self._terms = np.array([terms for *_, terms in rows]).reshape(-1, 4).T
        self.limits[self._places] = limits[self._places]
        own = np.array([int(model.dof_jntid[dof]) for dof in tree.joint_dofs], dtype=np.int64)
        bound = np.asarray(model.jnt_actfrclimited, dtype=bool)[own]
        self.limits[bound] = np.minimum(self.limits, model.jnt_actfrcrange[own, 1])[bound]

    def _largest(self, k: int, terms: FloatArray) -> float:
        """Return the largest force of an actuator [N m, N]."""
        model, most = self._model, np.inf
        if model.actuator_forcelimited[k]:
            most = float(np.abs(model.actuator_forcerange[k]).max())
        if model.actuator_ctrllimited[k] and not terms[1:].any():
            most = min(most, float(np.abs(terms[0] * model.actuator_ctrlrange[k]).max()))
        return most

    def read(self, raw: RawBlock) -> FloatArray:
        """Return what is asked for in steps: (n, joints) [N m, N]."""
        k, (gain, *bias) = self._actuators, self._terms
        length, rate = raw["actuator_length"][:, k], raw["actuator_velocity"][:, k]
        force = gain * raw["ctrl"][:, k] + bias[0] + bias[1] * length + bias[2] * rate
        out = np.zeros((len(raw), len(self.limits)))
        np.add.at(out.T, self._places, (self._gears * force).T)
        return out


def body_name(model: Any, body: int) -> str:
    """Return the name of a body, its number where it has none."""
    return str(model.body(body).name) or f"body {body}"


def geom_name(model: Any, geom: int) -> str:
    """Return the name of a geom, else its body's with its number."""
    body = str(model.body(int(model.geom_bodyid[geom])).name)
    return str(model.geom(geom).name) or f"{body or 'body'}:{geom}"


def foot_geoms(model: Any, data: Any, tree: BodyTree) -> set[int]:
    """Return the geoms that are feet: the lowest of the limbs' ends that reach down, in the pose of the data.

    So are geoms of the same shape at the ends of limbs of as many joints: a robot may be tilted, a leg up.
    Bodies that are welded to each other are one; of a robot of one body all its geoms are feet.
    """
    own, weld = set(tree.bodies.tolist()), np.asarray(model.body_weldid)
    inner = {int(weld[model.body_parentid[b]]) for b in own if weld[b] == b and b != tree.root}
    gravity = np.asarray(model.opt.gravity)
    down = gravity / max(float(np.linalg.norm(gravity)), 1e-12)
    depth: dict[int, dict[int, float]] = {}
    for geom in np.flatnonzero(np.isin(model.geom_bodyid, list(own))).tolist():
        body = int(weld[model.geom_bodyid[geom]])
        if body not in inner and (model.geom_contype[geom] or model.geom_conaffinity[geom]):
            at = _lowest(model, data, geom, down) - float(down @ data.xpos[tree.root])
            depth.setdefault(body, {})[geom] = at
    if len(depth) < 2:
        return {geom for geoms in depth.values() for geom in geoms}
    lowest = max(max(geoms.values()) for geoms in depth.values())
    low = {
        geom
        for geoms in depth.values()
        for geom, at in geoms.items()
        if at >= max(LOWEST * lowest, max(geoms.values()) - BESIDE * abs(lowest))
    }
    kinds = {_limb_end(model, geom, tree.root) for geom in low}
    return {geom for geoms in depth.values() for geom in geoms if _limb_end(model, geom, tree.root) in kinds}


def _limb_end(model: Any, geom: int, root: int) -> tuple[float, ...]:
    """Return what a geom at the end of a limb shares with its likes: joints to the root, shape and sizes."""
    body, joints = int(model.geom_bodyid[geom]), 0
    while body not in (root, 0):
        joints += int(model.body_jntnum[body])
        body = int(model.body_parentid[body])
    return (joints, int(model.geom_type[geom]), *np.round(model.geom_size[geom], 6).tolist())


def _lowest(model: Any, data: Any, geom: int, down: FloatArray) -> float:
    """Return how far a geom's box reaches along (3,) `down` [m]."""
    middle, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    along = data.geom_xmat[geom].reshape(3, 3).T @ down
    return float(down @ data.geom_xpos[geom] + along @ middle + np.abs(along) @ half)


def joint_kinds(mujoco: Any, model: Any, tree: BodyTree) -> list[str]:
    """Return what kind each joint of the robot is, the root's first: "free", "hinge", "slide" or "other".

    Other are balls, and joints that do not begin at zero.
    """
    kinds = mujoco.mjtJoint
    names = {int(kinds.mjJNT_FREE): "free", int(kinds.mjJNT_HINGE): "hinge", int(kinds.mjJNT_SLIDE): "slide"}
    own = [j for j in range(model.njnt) if int(model.jnt_bodyid[j]) in tree.place]
    out = [names.get(int(model.jnt_type[j]), "other") for j in own]
    return [
        "other" if kind != "free" and model.qpos0[model.jnt_qposadr[j]] != 0.0 else kind
        for kind, j in zip(out, own, strict=True)
    ]


def model_facts(mujoco: Any, model: Any, tree: BodyTree, geom_names: Sequence[str]) -> dict[str, Any]:
    """Return the robot's bodies, joints and geoms as plain facts of a log.

    Bodies in the order of `tree.bodies`, parents as places in it (-1 for the world), joints in the log's
    order, but their kinds with that of the root before them.
    """
    bodies = tree.bodies.tolist()
    place = {body: k for k, body in enumerate(bodies)}
    own = [int(model.dof_jntid[dof]) for dof in tree.joint_dofs]
    geoms = np.flatnonzero(np.isin(model.geom_bodyid, tree.bodies))
    free = ~np.asarray(model.jnt_limited, dtype=bool)[own]
    ranges = np.where(free[:, None], [-np.inf, np.inf], np.asarray(model.jnt_range)[own])
    root = _place_on_mount(mujoco, model, int(bodies[0]))
    return {
        "model_bodies": [body_name(model, b) for b in bodies],
        "model_parents": np.array([place.get(int(model.body_parentid[b]), -1) for b in bodies]),
        "model_masses": np.array(model.body_mass[bodies]),
        "model_inertias": np.array(model.body_inertia[bodies]),
        "model_centres": np.array(model.body_ipos[bodies]),
        "model_inertia_axes": np.array(model.body_iquat[bodies]),
        "model_positions": np.vstack([root[0], model.body_pos[bodies[1:]]]),
        "model_orientations": np.vstack([root[1], model.body_quat[bodies[1:]]]),
        "model_joint_kinds": joint_kinds(mujoco, model, tree),
        "model_joint_bodies": np.array([place[int(model.jnt_bodyid[j])] for j in own]),
        "model_joint_axes": np.array(model.jnt_axis[own]).reshape(-1, 3),
        "model_joint_places": np.array(model.jnt_pos[own]).reshape(-1, 3),
        "model_joint_ranges": ranges.reshape(-1, 2),
        "model_geoms": [geom_names[int(g)] for g in geoms],
        "model_geom_bodies": np.array([place[int(model.geom_bodyid[g])] for g in geoms]),
        "model_geom_types": np.array(model.geom_type[geoms]),
        "model_geom_sizes": np.array(model.geom_size[geoms]),
        "model_geom_positions": np.array(model.geom_pos[geoms]),
        "model_geom_orientations": np.array(model.geom_quat[geoms]),
        **hull_facts(mujoco, model, geoms.tolist()),
        "model_actuators": [str(model.actuator(k).name) or f"actuator {k}" for k in range(model.nu)],
    }


def _place_on_mount(mujoco: Any, model: Any, root: int) -> tuple[FloatArray, FloatArray]:
    """Return the (3,) place and (4,) quaternion w, x, y, z of a root before its joints move it."""
    place, turn = np.array(model.body_pos[root]), np.array(model.body_quat[root])
    body = int(model.body_parentid[root])
    while body != 0:  # what it is bolted to
        moved, turned = np.empty(3), np.empty(4)
        mujoco.mju_rotVecQuat(moved, place, model.body_quat[body])
        mujoco.mju_mulQuat(turned, model.body_quat[body], turn)
        place, turn = model.body_pos[body] + moved, turned
        body = int(model.body_parentid[body])
    return place, turn
