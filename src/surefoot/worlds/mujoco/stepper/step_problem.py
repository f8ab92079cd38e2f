"""The contact problem of a step as a value, for other solvers, files and certificates; written in NumPy.

Every block of rows is a contact of three rows, (tangent, tangent, normal), so that any file format of
problems holds it: what has fewer rows is filled up with rows of zeros. A limit is a contact without friction,
three rows of equalities are one that holds, and dry friction of a joint is that of a contact whose normal
impulse is given. Friction rows are scaled, as MuJoCo's elliptic cone with two coefficients is round in scaled
ones.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.contact import ContactProblem, Status, contact_sets
from surefoot.worlds.mujoco.spec import import_mujoco
from surefoot.worlds.mujoco.stepper.private_model import PrivateModel
from surefoot.worlds.mujoco.stepper.rollouts import RolloutStepper

EQUALITY, DRY, LIMITS, SLIDING = (0,), (1, 2), (3, 4), 7
"""MuJoCo's mjtConstraint: equalities, dry joints and tendons, limits, and contacts with elliptic friction."""
RESTS = 4.0
"""Steps of gravity's own speed below which a contact does not bounce: it rests."""
SYMMETRIC = 1e-9
"""Share by which an inertia may be off its transpose: that of the integrator `implicit` is."""


class StepProblem(NamedTuple):
    """The contact problem of one step, and what the stepper makes of it.

    Attributes
    ----------
    problem
        Of impulses [N s] and velocities after the step [m/s].
    impulses
        (n, 3), or flat for contacts with torsional friction: the stepper's own [N s].
    status
        Of the stepper: where it is STALLED, the impulses are those of MuJoCo's soft step.
    names
        What each contact of the problem is.
    """

    problem: ContactProblem
    impulses: FloatArray
    status: Status
    names: tuple[str, ...]


class _Rows(NamedTuple):
    """Rows of a step: Jacobian (m, nv), velocities (m,), gaps (m,) [m], kinds, numbers, bounds and forces."""

    J: FloatArray
    speed: FloatArray
    gap: FloatArray
    kind: list[int]
    number: list[int]
    bound: FloatArray


class ProblemStepper(RolloutStepper):
    """What tells the contact problem of a step: a base of `MujocoStepper`."""

    restitution: float
    certificate: Any

    def problem(self, data: Any) -> StepProblem:
        """Return the contact problem of the step that `step` would take from a data, which stays as it is.

        What undoes penetrations is another problem, of positions, and no part of it.

        Raises
        ------
        ProblemError
            For a step without constraints, with rolling friction (condim 6) or soft contacts, which no kind
            of contact here has, or with the integrator implicit where its inertia is not symmetric.
        """
        mujoco, other, here = import_mujoco(), self.twin(), copy.copy(data)
        other.resume(here, self.last_impulses())  # type: ignore[attr-defined]
        other.step_first(here)
        mujoco.mj_fwdActuation(other.model, here)
        mujoco.mj_fwdAcceleration(other.model, here)
        if here.nefc == 0:
            raise ProblemError("there is nothing to solve: no constraint is active in this step")
        h, model = float(other.model.opt.timestep), other.model
        damping, dense = other._inertia(here)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, here, mass)
        mass = dense.copy() if dense.size else mass + h * np.diag(damping if damping.size else 0.0 * mass[0])
        if np.abs(mass - mass.T).max() > SYMMETRIC * np.abs(mass).max():
            raise ProblemError("the integrator implicit has an inertia that is not symmetric here")
        rows, velocity = _read_rows(here, model, other._private), np.array(here.qvel)
        rests = RESTS * h * float(np.linalg.norm(model.opt.gravity))
        bias = _closing(rows, rows.J @ velocity, h, self.restitution, rests)
        blocks = _Blocks(model, here, rows, h, other._soft)
        other._constrain(here)
        impulses = blocks.impulses(np.array(here.efc_force) * h, other.certificate.status)
        free = velocity + np.linalg.solve(mass, h * np.array(here.qfrc_smooth))
        J = blocks.pick @ rows.J
        G = J @ np.linalg.solve(mass, J.T)
        problem = ContactProblem(0.5 * (G + G.T), J @ free + blocks.pick @ bias, contacts=blocks.contacts)
        return StepProblem(
            problem, impulses.reshape(problem.shape), other.certificate.status, tuple(blocks.names)
        )


def _read_rows(data: Any, model: Any, private: PrivateModel) -> _Rows:
    """Return the rows of a data as they are before the constraint stage, of a private model."""
    count = int(data.nefc)
    kind, number = np.array(data.efc_type).tolist(), np.array(data.efc_id).tolist()
    margin = np.array(data.efc_margin)
    first = np.zeros(count, dtype=bool)
    at = np.array(data.contact.efc_address)
    first[at[at >= 0]] = True
    margin[first] -= private.reach
    margin[np.isin(kind, LIMITS)] -= private.limit_reach
    return _Rows(
        np.array(data.efc_J).reshape(count, model.nv), np.array(data.efc_vel),
        np.array(data.efc_pos) - margin, kind, number, np.array(data.efc_frictionloss),
    )  # fmt: skip


def _closing(rows: _Rows, moved: FloatArray, h: float, restitution: float, slowest: float) -> FloatArray:
    """Return what is added to J v (m,) in the laws: surfaces' own motion, gaps that may close, bounces."""
    out = rows.speed - moved
    for i, kind in enumerate(rows.kind):
        if kind in EQUALITY or kind in DRY:
            continue
        bounces = rows.speed[i] < -slowest and rows.gap[i] + h * rows.speed[i] <= 0.0
        if restitution > 0.0 and bounces:
            out[i] += restitution * rows.speed[i]
        else:
            out[i] += max(rows.gap[i], 0.0) / h
    return out


class _Blocks:
    """Contacts of a problem: which rows each has (k, m), what they are, and how their impulses stand."""

    def __init__(self, model: Any, data: Any, rows: _Rows, h: float, soft: FloatArray) -> None:
        self._model, self._data, self._soft = model, data, soft
        self.contacts: list[Any] = []
        self.names: list[str] = []
        self._lines: list[tuple[int, float]] = []  # row and scale; row -1 for zeros
        held: list[int] = []
        i = 0
        while i < len(rows.kind):
            kind, dim = rows.kind[i], 1
            if kind in EQUALITY:
                held.append(i)
            elif kind in DRY:
                bound = h * float(rows.bound[i])
                point = contact_sets.Point(1.0, normal_min=bound, normal_max=bound)
                self._add(point, [(i, 1.0), (-1, 0.0), (-1, bound)], self._name("dry", rows.number[i], kind))
            elif kind in LIMITS:
                stop = contact_sets.Point(0.0)
                self._add(stop, [(-1, 0.0), (-1, 0.0), (i, 1.0)], self._name("stop", rows.number[i], kind))
            else:
                dim = self._add_contact(i, rows)
            i += dim
        for k in range(0, len(held), 3):
            part = [(row, 1.0) for row in held[k : k + 3]]
            part += [(-1, 0.0)] * (3 - len(part))
            self._add(contact_sets.Bilateral(3), part, "equality")
        self.pick = np.zeros((len(self._lines), len(rows.kind)))
        for k, (row, scale) in enumerate(self._lines):
            if row >= 0:
                self.pick[k, row] = scale

    def _add(self, contact: Any, lines: Sequence[tuple[int, float]], name: str) -> None:
        self.contacts.append(contact)
        self._lines += lines
        self.names.append(name)

    def _add_contact(self, i: int, rows: _Rows) -> int:
        """Add the contact whose first row is i; return how many rows it has."""
        contact = self._data.contact[rows.number[i]]
        geoms = [int(g) for g in contact.geom]
        name = " on ".join(self._model.geom(g).name or f"geom {g}" for g in geoms)
        if self._soft.size and self._soft[geoms].any():
            raise ProblemError(f"the contact {name} is soft: a problem of exact contacts has none")
        if rows.kind[i] != SLIDING:
            self._add(contact_sets.Point(0.0), [(-1, 0.0), (-1, 0.0), (i, 1.0)], name)
            return 1
        dim, own = int(contact.dim), np.array(contact.friction)
        if dim > 4:
            raise ProblemError(f"the contact {name} has rolling friction (condim 6), which no problem holds")
        mu = float(own[0])
        lines = [(i + 1, 1.0), (i + 2, float(own[1]) / mu), (i, 1.0)]
        if dim == 3:
            self._add(contact_sets.Point(mu), lines, name)
        else:
            self._add(contact_sets.SoftFinger(mu, 1.0), [*lines, (i + 3, float(own[2]) / mu)], name)
        return dim

    def _name(self, what: str, number: int, kind: int) -> str:
        """Return what a joint's or a tendon's row is called."""
        joint = kind in (1, 3)
        if joint and kind == 1:
            number = int(self._model.dof_jntid[number])
        part = self._model.joint(number) if joint else self._model.tendon(number)
        return f"{what} of {part.name or number}"

    def impulses(self, forces: FloatArray, status: Status) -> FloatArray:
        """Return impulses (k,) of MuJoCo's rows (m,), each over its scale; of dry joints the bound, too."""
        if len(forces) != self.pick.shape[1]:  # MuJoCo made its own rows where the step was not solved
            return np.full(len(self._lines), np.nan)
        out = [scale if row < 0 else forces[row] / (scale or 1.0) for row, scale in self._lines]
        return np.array(out)
