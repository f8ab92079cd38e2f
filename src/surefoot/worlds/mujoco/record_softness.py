"""How soft a MuJoCo model declares its contacts: how deep they sink, how fast they creep, by its own law.

For one contact with the inverse effective mass A, MuJoCo's program says (depth r, load L; see
`surefoot.contact.laws.soft.mujoco` for k, b and d(r))

    (A + R) f = b r' + k d r + A L,   r'' = A (L - f),   R = c (1 - d) / d Â

where Â, MuJoCo's own guess of A, is a constant of the model (`body_invweight0`); c is 1 for elliptic cones,
mu² (1 + mu²) / (impratio (dim - 1)) for pyramids. At rest r = c (1 - d) Â L / (k d²); a contact that lands
sinks deeper. A sticking contact creeps at c_t (1 - d) / d Â f_t / b with c_t = 1 / impratio, (1 + mu²) /
impratio for pyramids, and a sliding one is stopped in 1 / b. Nothing here looks at how deep a contact
did sink: what is deeper than this is no softness.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ProblemError
from surefoot.contact import MujocoLaw
from surefoot.records import Log
from surefoot.worlds.mujoco.landing import impedance_at, landing_depth, recoil_rate, rest_depth
from surefoot.worlds.mujoco.stepper.stepper import REACH

SWING = 5.0
"""Time constants of a critically damped contact after which a touchdown has died away: to one per cent."""
PARTS = 20
"""Parts of a step in which a landing is followed that Runge and Kutta integrate: close to its true motion."""
DEPTHS = (1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
"""From which contacts come out of the ground, and at which they creep [m]: impedance changes with depth."""
ROUNDED = 1.0 + 1e-9
"""A contact on its own lands as deep as its law says, to the last bits."""


@dataclass(frozen=True)
class HardestLanding:
    """The hardest touchdown of a log: fastest along and across the normal, of the contact with the most mass.

    Attributes
    ----------
    speed, slide
        Along and across the normal [m/s].
    depth
        At the first closed row [m].
    inverse_mass
        A [1/kg].
    """

    speed: float
    slide: float
    depth: float
    inverse_mass: float


@dataclass(frozen=True)
class SoftContact:
    """One contact's softness as the model declares it.

    Attributes
    ----------
    law
        Its k, b and d(r), `refsafe` included.
    guess
        Â [1/kg].
    normal_factor, friction_factor
        c and c_t.
    friction_damping
        b of the friction rows [1/s].
    mu
        Friction; zero where the contact has none.
    step
        In which a landing is followed: the model's, a part of it for Runge and Kutta [s].
    """

    law: MujocoLaw
    guess: float
    normal_factor: float
    friction_factor: float
    friction_damping: float
    mu: float
    step: float

    @property
    def rebounds(self) -> bool:
        """Whether the contact swings: its damping is less than critical, b² < 4 k d(0)."""
        stiff, damp = self.law.stiffness_and_damping
        return damp**2 < 4.0 * stiff * float(self.law.impedance(np.array(0.0))[0])

    def _regularisation(self, depth: float) -> tuple[float, float]:
        """Return d(r) and (1 - d) / d Â."""
        d = impedance_at(self._numbers, depth)
        return d, (1.0 - d) / d * self.guess

    def sinking(self, load: float, landing: HardestLanding | None = None) -> float:
        """Return the greatest depth under a load [N] after a landing, at least that at rest [m].

        A run of MuJoCo's own steps (speed first, then place), to where the contact turns back: a damped
        motion's first swing is its widest.
        """
        worst = self._rest(load)
        if landing is None or not landing.speed > 0.0:
            return worst
        deepest = landing_depth(
            self._numbers, self.step, landing.inverse_mass, load, landing.depth, landing.speed
        )
        return max(worst, deepest)

    def _rest(self, load: float) -> float:
        """Return the depth at rest [m]."""
        known = self._rests.get(load)
        if known is None:
            known = self._rests[load] = rest_depth(self._numbers, load)
        return known

    @cached_property
    def _rests(self) -> dict[float, float]:
        """Load [N] to the depth at rest under it [m], as far as it was asked for."""
        return {}

    @cached_property
    def _numbers(self) -> FloatArray:
        """(9,) for compiled code, see `landing`."""
        stiff, damp = self.law.stiffness_and_damping
        return np.array([stiff, damp, *self.law.bounded_solimp, self.guess, self.normal_factor])

    def stopping(self, load: float, slide: float) -> float:
        """Return the way [m] on which regularised friction stops a speed [m/s] inside its cone."""
        if self.friction_damping <= 0.0:
            return 0.0
        _, R = self._regularisation(self._rest(load))
        return slide * (1.0 + self.friction_factor * R / self.guess) / self.friction_damping

    @property
    def settling(self) -> float:
        """Time in which the swing of a touchdown dies away [s]; zero without damping."""
        damping = self.law.stiffness_and_damping[1]
        return SWING * 2.0 / damping if damping > 0.0 else 0.0

    @cached_property
    def recoil(self) -> float:
        """Speed at which a loaded contact comes out of the ground, over the depth that it was at most [1/s].

        A loaded contact accelerates outwards by no more than k d r + b r', whatever presses on it: it is
        fastest where it comes from rest under no load at all.
        """
        return max(recoil_rate(self._numbers, self.step, depth) for depth in DEPTHS)

    @cached_property
    def creep_slope(self) -> float:
        """Speed of a sticking contact over its tangential force [m/s/N], at most: under hardly any load."""
        if self.friction_damping <= 0.0:
            return 0.0
        deepest = max(self._regularisation(depth)[1] for depth in (0.0, *DEPTHS))
        return self.friction_factor * deepest / self.friction_damping

    def creep(self, load: float) -> float:
        """Return the speed of a contact that sticks with all its friction under a load [N]: [m/s]."""
        if self.friction_damping <= 0.0:
            return 0.0
        _, R = self._regularisation(self._rest(load))
        return self.friction_factor * R * self.mu * load / self.friction_damping


def soft_contact(mujoco: Any, model: Any, bodies: Iterable[int], contact: Any) -> SoftContact | None:
    """Return the softness of a contact between two bodies; None for numbers that are no softness.

    Parameters
    ----------
    mujoco, model
        The module and the MjModel.
    bodies
        Of the two geoms.
    contact
        Whatever has ``solref``, ``solimp``, ``solreffriction``, ``friction`` and ``dim`` as MjContact has.
    """
    option, guess = model.opt, float(sum(model.body_invweight0[b, 0] for b in bodies))
    safe = not option.disableflags & mujoco.mjtDisableBit.mjDSBL_REFSAFE
    dt, dim = (float(option.timestep) if safe else 0.0), int(contact.dim)
    try:
        law = MujocoLaw(tuple(contact.solref), tuple(contact.solimp), dt=dt)
        own = contact.solreffriction
        slip = MujocoLaw((float(own[0]), float(own[1])), law.solimp, dt=dt) if any(own) else law
        damp = slip.stiffness_and_damping[1]
    except ProblemError:
        return None  # signs that MuJoCo itself replaces
    mu, ratio = (float(contact.friction[0]) if dim > 1 else 0.0), float(option.impratio)
    normal, friction = 1.0, 1.0 / ratio
    if option.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL and dim > 1:
        normal = mu**2 * (1.0 + mu**2) / (ratio * (dim - 1))
        friction = (1.0 + mu**2) / ratio
    if not guess > 0.0:
        return None
    fine = PARTS if option.integrator == mujoco.mjtIntegrator.mjINT_RK4 else 1
    return SoftContact(law, guess, normal, friction, damp, mu, float(option.timestep) / fine)


def declare_softness(
    contacts: Sequence[SoftContact], load: float, landing: HardestLanding | None, energy: float = 0.0
) -> dict[str, float]:
    """Return the facts `sinking`, `creep`, `stopping` and `settling` of contacts; empty without any.

    With an energy, `sinking_at_most` as well: what falls may drive one contact deeper than that landed, with
    all of its motion.

    Parameters
    ----------
    contacts
        All of a model that closed.
    load
        M g of the robot, all of it on one contact point [N].
    landing
        The hardest one; None where no contact landed.
    energy
        The most kinetic energy that there was [J].
    """
    if not contacts:
        return {}
    slide = 0.0 if landing is None else landing.slide
    most = {}
    if landing is not None and energy > 0.0:
        speed = float(np.sqrt(2.0 * energy * landing.inverse_mass))
        driven = replace(landing, speed=max(landing.speed, speed))
        most = {"sinking_at_most": ROUNDED * max(c.sinking(load, driven) for c in contacts)}
    return most | {
        "sinking": ROUNDED * max(c.sinking(load, landing) for c in contacts),
        "creep": max(c.creep(load) for c in contacts),
        "stopping": max(c.stopping(load, slide) for c in contacts),
        "settling": max(c.settling for c in contacts),
    }


class DeclaredSoftness(NamedTuple):
    """What contacts declare under a load [N] whatever lands: `sinking` at rest, and the rest of the facts.

    `stopping` is for each m/s of a slide [s].
    """

    contacts: Sequence[SoftContact]
    load: float
    resting: float
    creep: float
    stopping: float
    settling: float


def declare_at_rest(contacts: Sequence[SoftContact], load: float) -> DeclaredSoftness:
    """Return what contacts declare under a load [N]."""
    parts = [(c.sinking(load), c.creep(load), c.stopping(load, 1.0), c.settling) for c in contacts]
    return DeclaredSoftness(contacts, load, *(max(part) for part in zip((0.0,) * 4, *parts, strict=True)))


def declare_response(contacts: Sequence[SoftContact], load: float) -> dict[str, float]:
    """Return the facts `recoil`, and `creep_slope` for forces in shares of a load [N]; empty without any."""
    if not contacts:
        return {}
    return {
        "recoil": ROUNDED * max(c.recoil for c in contacts),
        "creep_slope": ROUNDED * load * max(c.creep_slope for c in contacts),
    }


def hardest_landing(
    mujoco: Any, model: Any, bodies: Sequence[tuple[int, int]], qpos: FloatArray, points: Mapping[str, Any],
    data: Any = None,
) -> HardestLanding | None:  # fmt: skip
    """Return the hardest touchdown of a log, None without any.

    Where contacts land one after the other on one body, those that landed feel the next: so the parts of a
    `HardestLanding` are the worst of all, not of one.

    Parameters
    ----------
    mujoco, model
        The module and the MjModel.
    bodies
        Of each contact point: its own, and what it touches.
    qpos
        (T, nq) in MuJoCo's order [m, -, rad].
    points
        (T, p) `gaps`, (T, p, 3) `contact_velocities`, `contact_positions` and `normals`.
    data
        To work in; None for one of its own.
    """
    gaps, velocities = np.asarray(points["gaps"]), np.asarray(points["contact_velocities"])
    if not gaps.size:
        return None
    # Rows in which a contact closes: it was open in the row before, or the log begins with it.
    first = gaps <= 0.0
    first[1:] &= gaps[:-1] > 0.0
    down, aside = -velocities[..., 2], np.hypot(velocities[..., 0], velocities[..., 1])
    if model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:  # a row's are means while it is stopped
        down[1:], aside[1:] = (np.fmax(part[1:], part[:-1]) for part in (down, aside))
    speed, across = (np.nan_to_num(np.where(first, part, 0.0)) for part in (down, aside))
    masses, fastest = list[float](), float(speed.max())
    if data is None:
        data = mujoco.MjData(model)
    for k, row in enumerate(speed.argmax(axis=0).tolist()):
        place, normal = points["contact_positions"][row, k], points["normals"][row, k]
        if speed[row, k] > 0.0 and np.isfinite([*qpos[row], *place, *normal]).all():
            data.qpos[:] = qpos[row]
            masses.append(inverse_mass(mujoco, model, data, bodies[k], place, normal))
    if not masses:
        return None
    # what a step from above can reach, and no more
    depth = min(float(np.max(-gaps[first], initial=0.0)), fastest * float(model.opt.timestep))
    return HardestLanding(fastest, float(across.max()), depth, min(masses))


def inverse_mass(
    mujoco: Any, model: Any, data: Any, bodies: Iterable[int], place: FloatArray, normal: FloatArray
) -> float:
    """Return A = J M⁻¹ Jᵀ of two bodies at a (3,) place along a (3,) normal, at the data's qpos [1/kg]."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_crb(model, data)
    mujoco.mj_factorM(model, data)
    row, jacobian, sign = np.zeros((1, model.nv)), np.zeros((3, model.nv)), 1.0
    for body in bodies:
        mujoco.mj_jac(model, data, jacobian, None, place, body)
        row += sign * (normal @ jacobian)
        sign = -1.0
    solved = np.zeros_like(row)
    mujoco.mj_solveM(model, data, solved, row)
    return float(row[0] @ solved[0])


def world_softness(
    mujoco: Any, model: Any, ground: int, bodies: IntArray, log: Log, load: float
) -> dict[str, Any]:
    """Return what recordings say of soft contacts, for feet on a ground geom whose priority decides.

    That is `declare_softness`, the fact `critically_damped` (p,), and `recoil`.

    Parameters
    ----------
    mujoco, model
        The module and the MjModel, whose floating base comes first if it has one.
    ground
        Number of the geom.
    bodies
        (p,) body of every contact point.
    log
        Of a run in it: says how fast the ground was hit.
    load
        M g of what moves [N].
    """
    contact = SimpleNamespace(
        solref=model.geom_solref[ground], solimp=model.geom_solimp[ground], solreffriction=(0.0, 0.0),
        friction=(float(np.max(log["mu"], initial=0.0)),), dim=3,
    )  # fmt: skip
    pairs = [(int(body), 0) for body in bodies]
    soft = [soft_contact(mujoco, model, pair, contact) for pair in pairs]
    qpos = np.array(log["q"])
    if model.njnt and model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE:
        qpos[:, 3:7] = qpos[:, [6, 3, 4, 5]]  # x, y, z, w in the log
    landing = hardest_landing(mujoco, model, pairs, qpos, log.arrays)
    known = [s for s in soft if s is not None]
    out: dict[str, Any] = dict(declare_softness(known, load, landing))
    out["critically_damped"] = np.array([float(s is not None and not s.rebounds) for s in soft])
    if known:
        out["recoil"] = declare_response(known, load)["recoil"]
    return out


def exact_softness(dt: float, unsolved: int, log: Log) -> dict[str, float]:
    """Return what exact contacts leave of a run: the facts `unsolved_steps`, and `step_depth` [m] if any.

    A contact that comes nearer than `REACH` is found before it touches. The fastest goes on for a step of
    `dt` [s], by its velocity in the row before: deeper than this is no step.
    """
    out = {"unsolved_steps": float(unsolved)}
    gaps, velocities = np.asarray(log["gaps"]), np.asarray(log["contact_velocities"])
    closing = np.zeros(gaps.shape, dtype=bool)
    closing[1:] = (gaps[1:] <= 0.0) & (gaps[:-1] > 0.0)
    down = np.maximum(-velocities[..., 2], 0.0)
    down[1:] = np.maximum(down[1:], down[:-1])
    way = ROUNDED * dt * float(np.nan_to_num(np.where(closing, down, 0.0)).max(initial=0.0))
    return out | {"step_depth": way} if way > REACH else out
