"""Arrays for `audit_batch` from the contacts of MJX or MuJoCo Warp, where they are on the host."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ProblemError
from surefoot.mechanics import frames_on
from surefoot.records import host_array
from surefoot.worlds.mujoco.record_contact_rows import decoded_forces, relative_velocities
from surefoot.worlds.mujoco.record_tree import BodyTree
from surefoot.worlds.mujoco.spec import import_mujoco

FIELDS = {"dist": 0, "pos": 1, "frame": 2, "geom": 1, "friction": 1, "dim": 0, "efc_address": 0}
"""Fields of MuJoCo's contacts that are read, and how many sizes each contact's has."""
OPEN = 1.0
"""Gap of contact points that a row says nothing of [m]."""


class _Constraints:
    """Contacts (c,) and their forces as `decoded_forces` reads them, out of (rows, nefc)."""

    def __init__(self, told: Mapping[str, Any], forces: FloatArray, row: IntArray) -> None:
        kinds = np.dtype([("dim", np.int32), ("friction", np.float64, (5,))])
        self.contacts = np.zeros(len(row), dtype=kinds)
        self.contacts["dim"] = told["dim"]
        self.contacts["friction"][:, : told["friction"].shape[1]] = told["friction"][:, :5]
        self._forces, self._row, self._at = forces, row, told["efc_address"]

    def constraint(self, number: int) -> tuple[FloatArray, FloatArray]:
        """Return the force (c,) of every contact's constraint of a number; zero for contacts without."""
        at = np.clip(self._at + number, 0, self._forces.shape[1] - 1)
        return np.where(self._at >= 0, self._forces[self._row, at], 0.0), np.zeros(0)


def contact_arrays(
    model: Any, contact: Any, efc_force: Any, qpos: Any, qvel: Any, robot: str | None = None
) -> dict[str, FloatArray]:
    """Return the arrays (T, N, points, ...) that `audit_batch` takes, from arrays of MuJoCo's contacts.

    Of MJX ``contact_arrays(model, data.contact, data.efc_force, qpos, qvel)``, stacked over T steps of N
    environments; of Warp its packed contacts, sorted into environments. Contact points are pairs of geoms,
    and of a pair its first, second, ... contact. Contacts of the robot with itself are left out.

    Parameters
    ----------
    model
        The MjModel on the host.
    contact
        Mapping, or value with attributes: ``dist`` (T, N, c), ``pos`` (T, N, c, 3), ``frame`` (T, N, c, 3, 3)
        or (T, N, c, 9), ``geom`` (T, N, c, 2), ``friction`` (T, N, c, 5), ``dim`` and ``efc_address``
        (T, N, c), or without T and N where they are those of all. Geoms of -1 are no contact, an address of
        -1 is no force.
    efc_force
        (T, N, nefc) forces of the constraints.
    qpos, qvel
        (T, N, nq) and (T, N, nv): before the step that the contacts are of, since MuJoCo's step moves on.
    robot
        Name of the body at the robot's root, see `surefoot.record`.

    Returns
    -------
    dict
        ``forces`` [N], ``gaps`` [m], ``contact_velocities`` [m/s], ``contact_friction``: contact axes.

    Raises
    ------
    ProblemError
        For fields that are missing, and shapes that do not fit.
    MissingExtra
        If MuJoCo is not installed.
    """
    mujoco = import_mujoco()
    if not isinstance(model, mujoco.MjModel):
        raise ProblemError(f"contact_arrays takes an MjModel, got {type(model).__name__}")
    force, q = _of_rows("efc_force", efc_force), _of_rows("qpos", qpos, model.nq)
    v, size = _of_rows("qvel", qvel, model.nv), force.shape[:2]
    for name, array in (("qpos", q), ("qvel", v)):
        if array.shape[:2] != size:
            raise ProblemError(f"{name} is of {array.shape[:2]} steps and environments, efc_force of {size}")
    row, pair, second, mine = _of_robot(model, BodyTree(mujoco, model, robot), _fields(contact, size))
    point, points = _points(row, pair)
    out = np.zeros((size[0] * size[1], points, 8))
    out[..., 6] = OPEN
    if len(row):
        flat = _Constraints(mine, force.reshape(-1, force.shape[2]), row)
        local = decoded_forces(flat, bool(model.opt.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL))[:, :3]
        sign, axes = np.where(second, 1.0, -1.0), mine["frame"]
        frames = frames_on(sign[:, None] * axes[:, 0])
        world = sign[:, None] * np.einsum("cji,cj->ci", axes, local)
        moves = _Motion(mujoco, model, q.reshape(-1, model.nq), v.reshape(-1, model.nv), row)
        velocity = relative_velocities(model, moves, moves.row, pair, mine["pos"])
        out[row, point, :3] = np.einsum("cji,cj->ci", frames, world)
        out[row, point, 3:6] = np.einsum("cji,cj->ci", frames, velocity)
        out[row, point, 6] = mine["dist"]
        out[row, point, 7] = np.where(mine["dim"] > 1, mine["friction"][:, 0], 0.0)
    table = out.reshape(*size, points, 8)
    return {
        "forces": table[..., :3], "contact_velocities": table[..., 3:6], "gaps": table[..., 6],
        "contact_friction": table[..., 7],
    }  # fmt: skip


def _of_robot(
    model: Any, tree: BodyTree, told: dict[str, Any]
) -> tuple[IntArray, IntArray, Any, dict[str, Any]]:
    """Return row, geoms, whether the second is the robot's, and fields of its (k,) contacts with others."""
    parts = np.zeros(model.ngeom, dtype=np.int64)
    parts[np.isin(model.geom_bodyid, tree.bodies)] = 1
    parts[np.isin(model.geom_bodyid, tree.mount)] = 2
    geom = told["geom"]
    if geom.max(initial=-1) >= model.ngeom:
        raise ProblemError(f"contact's geom must be below {model.ngeom}, got {geom.max()}")
    one, two = np.moveaxis(np.where(geom >= 0, parts[geom], -1), 2, 0)
    row, which = np.nonzero(((one == 1) & (two == 0)) | ((one == 0) & (two == 1)))
    mine, second = {name: array[row, which] for name, array in told.items()}, two[row, which] == 1
    return row, np.where(second[:, None], mine["geom"][:, ::-1], mine["geom"]), second, mine


class _Motion:
    """Velocities of bodies as MuJoCo has them, in the rows that have contacts; `row` (c,) is that of each."""

    def __init__(self, mujoco: Any, model: Any, qpos: FloatArray, qvel: FloatArray, row: IntArray) -> None:
        rows, self.row = np.unique(row, return_inverse=True)
        self.cvel = np.zeros((len(rows), model.nbody, 6))
        self.subtree_com = np.zeros((len(rows), model.nbody, 3))
        data = mujoco.MjData(model)
        for k, t in enumerate(rows.tolist()):
            data.qpos[:], data.qvel[:] = qpos[t], qvel[t]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_comVel(model, data)
            self.cvel[k], self.subtree_com[k] = data.cvel, data.subtree_com


def _of_rows(name: str, array: Any, last: int | None = None) -> FloatArray:
    """Return an array (T, N, n) as doubles."""
    found = np.asarray(host_array(name, array), dtype=np.float64)
    if found.ndim != 3 or (last is not None and found.shape[2] != last):
        raise ProblemError(
            f"{name} must have shape (T, N, {'n' if last is None else last}), got {found.shape}"
        )
    return found


def _fields(contact: Any, size: tuple[int, int]) -> dict[str, Any]:
    """Return the fields of contacts, each (T N, c, ...)."""
    out: dict[str, Any] = {}
    for name, sizes in FIELDS.items():
        given = contact.get(name) if isinstance(contact, Mapping) else getattr(contact, name, None)
        if given is None:
            raise ProblemError(f"contact has no {name}; it needs {', '.join(FIELDS)}")
        array = np.asarray(host_array(name, given))
        if name == "frame" and array.shape[-1] == 9:
            array = array.reshape(*array.shape[:-1], 3, 3)
        if array.ndim == 1 + sizes:
            array = np.broadcast_to(array, (*size, *array.shape))
        if array.ndim != 3 + sizes or array.shape[:2] != size:
            shape = ", ".join([*map(str, size), "c", *("n",) * sizes])
            raise ProblemError(f"contact's {name} must have shape ({shape}), got {array.shape}")
        if name in ("geom", "dim", "efc_address"):
            array = array.astype(np.int64)
        out[name] = array.reshape(size[0] * size[1], *array.shape[2:])
    counts = {name: array.shape[1] for name, array in out.items()}
    if len(set(counts.values())) != 1:
        raise ProblemError(f"contact's fields must be of the same number of contacts, got {counts}")
    return out


def _points(row: IntArray, pair: IntArray) -> tuple[IntArray, int]:
    """Return the contact point (c,) of every contact, and how many points there are.

    Of a pair of geoms its first, second, ... contact of a row.
    """
    order = np.lexsort((np.arange(len(row)), pair[:, 1], pair[:, 0], row))
    keys = np.column_stack([row, pair])[order]
    first = np.ones(len(order), dtype=bool)
    first[1:] = (keys[1:] != keys[:-1]).any(axis=1)
    start = np.maximum.accumulate(np.where(first, np.arange(len(order)), 0))
    nth = np.zeros(len(row), dtype=np.int64)
    nth[order] = np.arange(len(order)) - start
    found, point = np.unique(np.column_stack([pair, nth]), axis=0, return_inverse=True)
    return point.reshape(-1), len(found)
