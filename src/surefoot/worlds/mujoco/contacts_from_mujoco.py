"""The contacts of anybody's MuJoCo data as a contact problem, to be solved in place of MuJoCo's own.

One step of Euler's method with momentum balanced, as MuJoCo's own takes it: with M̂ = M + h D (D the joints'
damping) the velocity without contacts is v + h M̂⁻¹ (τ_smooth + τ_other), and

    G = J M̂⁻¹ Jᵀ,    g = J v_free + (0, 0, gap / h)

where the gap of a contact that is still open may be used up in the step, and a share of a penetration is
undone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, IntArray, finite_array, real_number
from surefoot.base.errors import ProblemError
from surefoot.contact import ContactProblem
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
    jacobian
        (3n, nv) from MuJoCo's velocities to those of the contacts in their frames.
    response
        (nv, 3n) from impulses to the change of velocity, M̂⁻¹ Jᵀ.
    """

    problem: ContactProblem
    frames: FloatArray
    positions: FloatArray
    gaps: FloatArray
    geoms: IntArray
    free: FloatArray
    jacobian: FloatArray
    response: FloatArray

    def velocity(self, impulses: ArrayLike) -> FloatArray:
        """Return the velocity (nv,) after the step, MuJoCo's order, for (n, 3) impulses [N s]."""
        given = finite_array("impulses", impulses, (len(self.gaps), 3))
        return np.asarray(self.free + self.response @ given.ravel())


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
    n, nv = len(touching), model.nv
    frames, geoms = np.zeros((n, 3, 3)), np.zeros((n, 2), dtype=np.int64)
    jacobian = np.zeros((n, 3, nv))
    for k, contact in enumerate(touching):
        frames[k], geoms[k] = _orient_contact(model, contact)
        relative = _material_jacobian(mujoco, model, data, geoms[k, 1], contact.pos)
        relative = relative - _material_jacobian(mujoco, model, data, geoms[k, 0], contact.pos)
        # Of the second geom's material against the first's at one place: the normal leads from the first to
        # the second, and pushes count on the second.
        jacobian[k] = frames[k].T @ relative
    J = jacobian.reshape(3 * n, nv)
    mass = np.zeros((nv, nv))
    mujoco.mj_fullM(model, data, mass)
    # Damping is implicit in MuJoCo's Euler step, so impulses meet M + h D, not M.
    mass[np.diag_indices(nv)] += h * model.dof_damping
    push = data.qfrc_smooth + _other(mujoco, model, data)
    answer = np.linalg.solve(mass, np.column_stack([h * push, J.T])) if nv else np.zeros((0, 1 + 3 * n))
    free, response = data.qvel + answer[:, 0], np.ascontiguousarray(answer[:, 1:])
    gaps = np.array([c.dist for c in touching])
    # One mu for a cone that MuJoCo lets be an ellipse: the lesser lies inside it. condim 1 has no friction at
    # all.
    mu = np.array([min(c.friction[:2]) if c.dim > 1 else 0.0 for c in touching])
    G, g = J @ response, J @ free
    # The normal row is gap / h + velocity, so that a contact still open may close within the step but not
    # cross; MuJoCo's soft contacts rest in the ground, and a penetration undone at once would leave with gap
    # / h: a share of it is.
    g[2::3] += np.where(gaps > 0.0, gaps, share * gaps) / h
    places = np.array([c.pos for c in touching]).reshape(n, 3)
    # Symmetric but for the solve's rounding.
    problem = ContactProblem(0.5 * (G + G.T), g, mu)
    return MujocoContacts(problem, frames, places, gaps, geoms, free, J, response)


def _orient_contact(model: Any, contact: Any) -> tuple[FloatArray, IntArray]:
    """Return a contact's rotation (3, 3) and its geoms (2,), the normal towards the one that can move."""
    normal, first, second = contact.frame.reshape(3, 3)
    pair = np.array(contact.geom, dtype=np.int64)
    if model.body_weldid[model.geom_bodyid[pair[1]]] == 0:
        return np.column_stack([second, first, -normal]), pair[::-1]
    return np.column_stack([first, second, normal]), pair


def _material_jacobian(mujoco: Any, model: Any, data: Any, geom: int, place: FloatArray) -> FloatArray:
    """Return how a geom's material at a place moves with MuJoCo's velocities: (3, nv), world axes."""
    out = np.zeros((3, model.nv))
    mujoco.mj_jac(model, data, out, None, place, int(model.geom_bodyid[geom]))
    return out


def _other(mujoco: Any, model: Any, data: Any) -> FloatArray:
    """Return what constraints other than contacts put on the joints (nv,), as MuJoCo solved them."""
    contact = np.array(data.efc_type) >= int(mujoco.mjtConstraint.mjCNSTR_CONTACT_FRICTIONLESS)
    out = np.zeros(model.nv)
    if len(contact) and not contact.all():
        mujoco.mj_mulJacTVec(model, data, out, np.where(contact, 0.0, data.efc_force))
    return out
