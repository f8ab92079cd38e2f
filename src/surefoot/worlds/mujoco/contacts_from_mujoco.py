"""The contacts of anybody's MuJoCo data as a contact problem, to be solved in place of MuJoCo's own.

One step of Euler's method with momentum balanced, as MuJoCo's own takes it: with M̂ = M + h D (D the joints'
damping) the velocity without contacts is v + h M̂⁻¹ (τ_smooth + τ_other), and

    G = J M̂⁻¹ Jᵀ,    g = J v_free + (0, 0, gap / h)

where the gap of a contact that is still open may be used up in the step, and a share of a penetration is
undone. Bodies that no joint ties together are trees of their own: M̂ = L Lᵀ falls into their blocks, and
Y = J L⁻ᵀ, with G = Y Yᵀ, has entries for the two trees of a contact alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, IntArray, finite_array, real_number
from surefoot.base.errors import ProblemError
from surefoot.contact import COMPILED_CONTACTS, ContactProblem
from surefoot.worlds.mujoco.mujoco_world import import_mujoco

PUSHED_OUT = 0.1
"""Share of a penetration that is undone in a step: MuJoCo's own contacts rest in the ground."""


@dataclass(frozen=True, eq=False)
class MujocoContacts:
    """The n contacts of an instant, and the step that they decide.

    Attributes
    ----------
    problem
        Impulses [N s] and velocities [m/s] in contact frames (tangent, tangent, normal).
    frames
        (n, 3, 3) rotation_world_contact; the normal, the last column, points from the ground to the robot, of
        two moving bodies from the first of `geoms` to the second.
    positions
        (n, 3) in world axes [m].
    gaps
        (n,) distances of the surfaces [m], negative in penetration.
    geoms
        (n, 2) MuJoCo's geoms: what pushes, and what is pushed along the normal.
    free
        (nv,) velocity after the step without contacts, MuJoCo's order [m/s, rad/s].
    rows
        (3n, nv) map from MuJoCo's velocities to those of the contacts in their frames; of many contacts a
        SciPy sparse matrix.
    root
        (nv, nv) L⁻ᵀ with M̂ = L Lᵀ, a block for each tree of bodies [kg^-1/2]; as the rows.
    """

    problem: ContactProblem
    frames: FloatArray
    positions: FloatArray
    gaps: FloatArray
    geoms: IntArray
    free: FloatArray
    rows: Any
    root: Any

    @cached_property
    def jacobian(self) -> FloatArray:
        """The rows as an array (3n, nv), however many."""
        return _dense(self.rows)

    @cached_property
    def response(self) -> FloatArray:
        """The array (nv, 3n) from impulses to the change of velocity, M̂⁻¹ Jᵀ."""
        return _dense(self.root @ (self.root.T @ self.rows.T))

    def velocity(self, impulses: ArrayLike) -> FloatArray:
        """Return the velocity (nv,) after the step, MuJoCo's order, for (n, 3) impulses [N s]."""
        given = finite_array("impulses", impulses, (len(self.gaps), 3))
        return np.asarray(self.free + self.root @ (self.root.T @ (self.rows.T @ given.ravel())))


def contacts_from_mujoco(model: Any, data: Any, pushed_out: float = PUSHED_OUT) -> MujocoContacts:
    """Return the contact problem of the next step of a MuJoCo simulation.

    Call ``mujoco.mj_forward(model, data)`` before; nothing in `data` is changed. Contacts are points with
    Coulomb friction (the lesser of a contact's two sliding coefficients): torsional and rolling friction, and
    the contacts' softness, are left out. Joint limits, equalities and dry friction act as MuJoCo solved them.

    Parameters
    ----------
    model, data
        MuJoCo's MjModel and MjData.
    pushed_out
        Share of a penetration that a step undoes, 0 to 1.

    Raises
    ------
    ProblemError
        For what is not a model and its data, or a state that is not finite.

    Examples
    --------
    >>> import mujoco
    >>> import surefoot as sf
    >>> ball = '<body pos="0 0 0.099999999"><freejoint/><geom size="0.1" mass="2"/></body>'
    >>> text = f'<mujoco><worldbody><geom type="plane" size="1 1 1"/>{ball}</worldbody></mujoco>'
    >>> model = mujoco.MjModel.from_xml_string(text)
    >>> data = mujoco.MjData(model)
    >>> mujoco.mj_forward(model, data)
    >>> contacts = contacts_from_mujoco(model, data)
    >>> round(float(sf.solve(contacts.problem).forces[0, 2]), 5)  # m g h
    0.03924
    """
    mujoco = import_mujoco()
    if not isinstance(model, mujoco.MjModel) or not isinstance(data, mujoco.MjData):
        kinds = f"{type(model).__name__} and {type(data).__name__}"
        raise ProblemError(f"contacts_from_mujoco takes an MjModel and its MjData, got {kinds}")
    if (data.qpos.size, data.qvel.size) != (model.nq, model.nv):
        raise ProblemError("the MjData is of another model")
    finite_array("qpos", data.qpos)
    finite_array("qvel", data.qvel)
    share, h = real_number("pushed_out", pushed_out, low=0.0, high=1.0), float(model.opt.timestep)
    touching = [c for c in data.contact if not c.exclude and min(c.geom) >= 0]
    n = len(touching)
    many, moves = n > COMPILED_CONTACTS, _Moves(mujoco, model, data)
    frames, geoms = np.zeros((n, 3, 3)), np.zeros((n, 2), dtype=np.int64)
    for k, contact in enumerate(touching):
        frames[k], geoms[k] = _orient_contact(model, contact)
        # Of the second geom's material against the first's at one place: the normal leads from the first to
        # the second, and pushes count on the second.
        moves.add(k, frames[k], contact.pos, geoms[k])
    # Damping is implicit in MuJoCo's Euler step, so impulses meet M + h D, not M.
    rows, root = moves.rows(n, many), _root(mujoco, model, data, h * np.array(model.dof_damping), many)
    push = data.qfrc_smooth + _other(mujoco, model, data)
    free = data.qvel + root @ (root.T @ (h * push))
    gaps = np.array([c.dist for c in touching])
    # One mu for a cone that MuJoCo lets be an ellipse: the lesser lies inside it. condim 1 has no friction at
    # all.
    mu = np.array([min(c.friction[:2]) if c.dim > 1 else 0.0 for c in touching])
    Y, g = rows @ root, rows @ free
    # The normal row is gap / h + velocity, so that a contact still open may close within the step but not
    # cross; MuJoCo's soft contacts rest in the ground, and a penetration undone at once would leave with gap
    # / h: a share of it is.
    g[2::3] += np.where(gaps > 0.0, gaps, share * gaps) / h
    places = np.array([c.pos for c in touching]).reshape(n, 3)
    problem = ContactProblem.of_factor(Y, g, mu) if many else ContactProblem(Y @ Y.T, g, mu)
    return MujocoContacts(problem, frames, places, gaps, geoms, free, rows, root)


def _orient_contact(model: Any, contact: Any) -> tuple[FloatArray, IntArray]:
    """Return a contact's rotation (3, 3) and its geoms (2,), the normal towards the one that can move."""
    normal, first, second = contact.frame.reshape(3, 3)
    pair = np.array(contact.geom, dtype=np.int64)
    if model.body_weldid[model.geom_bodyid[pair[1]]] == 0:
        return np.column_stack([second, first, -normal]), pair[::-1]
    return np.column_stack([first, second, normal]), pair


class _Moves:
    """How the material at contacts moves with MuJoCo's velocities: blocks (3, tree's velocities)."""

    def __init__(self, mujoco: Any, model: Any, data: Any) -> None:
        self._here = mujoco, model, data
        self._body, self._tree = model.geom_bodyid.tolist(), model.body_treeid.tolist()
        self._first, self._count = model.tree_dofadr.tolist(), model.tree_dofnum.tolist()
        self._all = np.zeros((3, model.nv))
        self._blocks: list[tuple[int, int, FloatArray]] = []

    def add(self, k: int, frame: FloatArray, place: FloatArray, geoms: IntArray) -> None:
        """Add contact k at a place (3,), in world axes, of the second geom on the first."""
        mujoco, model, data = self._here
        for sign, geom in ((-1.0, geoms[0]), (1.0, geoms[1])):
            body = self._body[geom]
            tree = self._tree[body]
            if tree < 0:  # part of the world
                continue
            mujoco.mj_jac(model, data, self._all, None, place, body)
            first = self._first[tree]
            own = self._all[:, first : first + self._count[tree]]
            self._blocks.append((3 * k, first, sign * frame.T @ own))

    def rows(self, contacts: int, sparse: bool) -> Any:
        """Return the (3n, nv) matrix of all contacts."""
        shape = 3 * contacts, self._all.shape[1]
        if not sparse:  # sparse matrices of a few contacts take twice as long to make
            out = np.zeros(shape)
            for at, first, block in self._blocks:
                out[at : at + 3, first : first + block.shape[1]] += block
            return out
        parts = []
        for at, first, block in self._blocks:
            columns = np.arange(first, first + block.shape[1])
            parts.append((np.repeat(at + np.arange(3), len(columns)), np.tile(columns, 3), block.ravel()))
        if not parts:
            return sp.csr_matrix(shape)
        i, j, values = (np.concatenate(part) for part in zip(*parts, strict=True))
        return sp.csr_matrix((values, (i, j)), shape=shape)


def _root(mujoco: Any, model: Any, data: Any, damping: FloatArray, sparse: bool) -> Any:
    """Return the (nv, nv) L⁻ᵀ of the inertia with a (nv,) damping on its diagonal, M + D = L Lᵀ."""
    starts, sizes = np.array(model.tree_dofadr), np.array(model.tree_dofnum)
    largest = int(sizes.max(initial=0))
    columns, ones = np.zeros((largest, model.nv)), np.zeros(model.nv)
    # a vector with one entry in each tree asks for a column of all their blocks at once
    for j in range(largest):
        ones[:] = 0.0
        ones[starts[sizes > j] + j] = 1.0
        mujoco.mj_mulM(model, data, columns[j], ones)
    blocks, out = [], np.zeros((0 if sparse else model.nv, model.nv))
    for start, size in zip(starts.tolist(), sizes.tolist(), strict=True):
        own = slice(start, start + size)
        block = np.linalg.inv(np.linalg.cholesky(columns[:size, own] + np.diag(damping[own]))).T
        if sparse:
            blocks.append(block)
        else:
            out[own, own] = block
    return sp.csr_matrix(sp.block_diag(blocks, format="csr")) if blocks else out


def _dense(matrix: Any) -> FloatArray:
    """Return a matrix, dense or sparse, as an array (rows, columns)."""
    return np.asarray(matrix if isinstance(matrix, np.ndarray) else matrix.toarray())


def _other(mujoco: Any, model: Any, data: Any) -> FloatArray:
    """Return what constraints other than contacts put on the joints (nv,), as MuJoCo solved them."""
    contact = np.array(data.efc_type) >= int(mujoco.mjtConstraint.mjCNSTR_CONTACT_FRICTIONLESS)
    out = np.zeros(model.nv)
    if len(contact) and not contact.all():
        mujoco.mj_mulJacTVec(model, data, out, np.where(contact, 0.0, data.efc_force))
    return out
