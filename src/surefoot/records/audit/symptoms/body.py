"""Symptoms of the robot as a whole."""

from __future__ import annotations

from functools import partial

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.continuity import levers, state_slips
from surefoot.records.audit.episode import Episode
from surefoot.records.audit.symptoms.symptom import Evidence, symptom

of_body = partial(symptom, body=True)


@of_body(
    "no forces",
    "idle",
    cause="the schedule says swing, the Jacobian's frame makes J^T f vanish, or the forces were never read",
    confirm="print the contact schedule and the force buffer while the robot stands",
    cure="read the forces after the step; check body names and the frame of the Jacobian",
)
def no_forces(e: Episode) -> Evidence | None:
    """Tell whether the ground gives nothing, and the robot does not fall."""
    if e.rows.has("gaps") and float(np.median(e.rows.gaps[e.rows.core].min(axis=1))) > e.limits.body.touching:
        return None
    return Evidence(e.limits.ranks.no_forces, "no contact carries anything though feet touch the ground")


@of_body(
    "infeasible",
    cause="the motion is not one that contacts can give: wrong mode, or gap and force demanded at once",
    confirm="look which contacts are closed while the body is held",
    cure="relax the complementarity step by step; check modes and the ground's height",
)
def infeasible(e: Episode) -> Evidence | None:
    """Tell whether the motion needs forces where nothing touches the ground."""
    if not (e.has("idle") or e.has("motion")) or not e.rows.has("gaps"):
        return None
    if float(np.median(e.rows.gaps[e.rows.core].min(axis=1))) <= e.limits.body.touching:
        return None
    rest, held = e.rows.unexplained, e.limits.body.held
    if rest is not None and float(np.nanmean(rest.force[e.rows.core, 2])) < held * e.weight:
        return None
    return Evidence(e.limits.ranks.infeasible, "the body is held up while every foot is off the ground")


@of_body(
    "outside force",
    cause="a push, a cable or a hand; compensated gravity; or a contact of another part of the robot",
    confirm="look at the robot at that time: what touches it? what does the simulator put on its root?",
    cure="log pushes; give every geom that may touch; leave gravity as it is",
)
def outside_force(e: Episode) -> Evidence | None:
    """Tell whether something pushes the body that the log does not know."""
    if e.has("balance"):
        rest = np.nanmedian(e.rows.left_over[e.rows.core], axis=0).round(6)
        modelled = "".join(f"; in the model {line}" for line in e.rows.log.facts.get("outside", ()))
        turns = f" and {_triple(rest[3:])} N m" if rest[3:].any() else ""
        text = f"{_triple(rest[:3])} N{turns} on the body that no contact gives{modelled}"
        return Evidence(e.limits.ranks.certain, text)
    missing = e.rows.unexplained
    if missing is None or not e.has("motion"):
        return None
    force = np.nanmedian(missing.force[e.rows.core], axis=0)
    return Evidence(e.limits.ranks.outside_force, f"about {_triple(force)} N on the body, world axes")


def _triple(force: FloatArray) -> str:
    return "({:.3g}, {:.3g}, {:.3g})".format(*(force + 0.0))


@of_body(
    "unconverged solver",
    "unconverged",
    cause="the contact solver stops before its law holds: too few iterations, or PGS on a hard problem",
    confirm="double the iterations: the forces change",
    cure="Newton's method with 50 iterations or more, a smaller tolerance",
)
def unconverged_solver(e: Episode) -> Evidence | None:
    """Tell whether the world's solver left forces that are not its own law's."""
    size = e.failed["unconverged"].value
    return Evidence(e.limits.ranks.unconverged_solver, f"forces up to {size:.3g} N off its law")


@of_body(
    "wrong mass",
    "motion",
    cause="a payload, another mass than the model's, or a constant vertical force on the body",
    confirm="weigh the robot; a force does not grow with the acceleration",
    cure="correct the mass; estimate the payload while standing",
)
def wrong_mass(e: Episode) -> Evidence | None:
    """Tell whether the robot weighs something else than the log says."""
    rest, limits = e.rows.unexplained, e.limits.body
    if rest is None or e.failed["motion"].rows * e.rows.setting.dt < limits.mass_time:
        return None
    if "momentum_rate" in e.rows.log:
        return None  # the log's mass is that of its momentum
    force = rest.force[e.rows.core]
    force = force[np.isfinite(force).all(axis=1)]
    mean, spread = force.mean(axis=0), force.std(axis=0)
    upright = abs(mean[2]) > limits.mass_upright * np.linalg.norm(mean)
    if not upright or np.linalg.norm(spread) > limits.mass_spread * abs(mean[2]):
        return None
    text = f"the forces carry {-mean[2] / GRAVITY:+.3g} kg against the log's mass"
    return Evidence(e.limits.ranks.wrong_mass, text)


@of_body(
    "held rows",
    "state",
    cause="rows are repeated: the state was read less often than the log was written",
    confirm="count rows that are equal to the one before",
    cure="log only what is new, with its own time",
)
def held_rows(e: Episode) -> Evidence | None:
    """Tell whether the same state is logged again and again while it moves."""
    q, v = e.rows.numbers("q")[e.rows.core], e.rows.numbers("v")[e.rows.core]
    same = (q[1:] == q[:-1]).all(axis=1) & (v[1:] == v[:-1]).all(axis=1) & (np.abs(v[1:]) > 0.0).any(axis=1)
    if same.sum() < e.limits.body.held_rows:
        return None
    text = f"{int(same.sum())} rows repeat the one before, with velocities that are not zero"
    return Evidence(e.limits.ranks.held_rows, text)


@of_body(
    "teleport",
    "state",
    cause="a reset, a loop closure of the estimator, or a state written into the simulator",
    confirm="compare the step of q with dt v at that row",
    cure="mark resets; correct estimates slowly",
)
def teleport(e: Episode) -> Evidence | None:
    """Tell whether positions jump in a row or two."""
    size, share = np.sort(_slips(e)), e.limits.body.teleport_share
    jump = float(size[-2:].sum())
    if float((size[-2:] ** 2).sum()) < share * float((size**2).sum()):
        return None
    text = f"positions jump by {1e3 * jump:.3g} mm (angles on a lever of {_lever(e):g} m)"
    return Evidence(e.limits.ranks.teleport, text)


@of_body(
    "other velocities",
    "state",
    cause="velocities are zeroed, late, in another unit or frame, or filtered",
    confirm="add up v dt and compare with the change of q",
    cure="log q and v of one instant; base velocities in base axes",
)
def other_velocities(e: Episode) -> Evidence | None:
    """Tell whether positions and velocities are not those of one motion."""
    way = 1e3 * e.failed["state"].value
    text = f"positions go {way:.3g} mm beside their velocities in 50 ms"
    return Evidence(e.limits.ranks.other_velocities, text)


@of_body(
    "velocity jump",
    "motion",
    cause="an impulse that no contact gave: a velocity written into the simulator, a reset, an estimator",
    confirm="compare m dv with the forces at that row",
    cure="mark resets; log pushes",
)
def velocity_jump(e: Episode) -> Evidence | None:
    """Tell whether the velocity changes in a row or two by what no force explains."""
    rest, limits = e.rows.unexplained, e.limits.body
    if rest is None:
        return None
    force = np.nan_to_num(rest.force)[e.rows.core]
    size = np.linalg.norm(force, axis=1)
    top = np.argsort(size)[-2:]
    alone = float((size[top] ** 2).sum()) >= limits.jump_share * float((size**2).sum())
    if size[top].max() < limits.jump_force * e.weight or not alone:
        return None
    logged = np.linalg.norm(e.rows.forces[e.rows.core], axis=(1, 2))
    if float(np.abs(logged[top] - np.median(logged)).max()) > limits.jump_logged * float(size[top].max()):
        return None  # a force of one row, which is a foot's matter
    change = float((size[top] * e.dt[top]).max()) * GRAVITY / e.weight
    return Evidence(e.limits.ranks.velocity_jump, f"the body's velocity jumps by {change:.3g} m/s")


def _lever(e: Episode) -> float:
    return e.limits.continuity.lever


def _slips(e: Episode) -> FloatArray:
    """Return how far each row's step of the state is from its velocity (m,) [m], angles on a lever."""
    q, v = e.rows.numbers("q"), e.rows.numbers("v")
    slips = state_slips(q, v, e.rows.dt, e.limits.records.unit_quaternion)
    if slips is None:
        return np.zeros(len(v))
    return np.asarray(np.linalg.norm(slips * levers(q, v, _lever(e)), axis=1))
