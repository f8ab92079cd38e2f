"""Symptoms of the robot as a whole."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, symptom
from surefoot.spatial import GRAVITY


@symptom(
    "no forces",
    "idle",
    cause="the schedule says swing, the Jacobian's frame makes J^T f vanish, or the forces were never read",
    confirm="print the contact schedule and the force buffer while the robot stands",
    cure="read the forces after the step; check body names and the frame of the Jacobian",
    body=True,
)
def no_forces(e: Episode) -> Evidence | None:
    """Tell whether the ground gives nothing, and the robot does not fall."""
    if e.rows.has("gaps") and float(np.median(e.rows.gaps[e.rows.core].min(axis=1))) > 1e-3:
        return None
    return Evidence(1.0, "no contact carries anything though feet touch the ground")


@symptom(
    "infeasible",
    cause="the motion is not one that contacts can give: wrong mode, or gap and force demanded at once",
    confirm="look which contacts are closed while the body is held",
    cure="relax the complementarity step by step; check modes and the ground's height",
    body=True,
)
def infeasible(e: Episode) -> Evidence | None:
    """Tell whether the motion needs forces where nothing touches the ground."""
    if not (e.has("idle") or e.has("motion")) or not e.rows.has("gaps"):
        return None
    if float(np.median(e.rows.gaps[e.rows.core].min(axis=1))) <= 1e-3:
        return None
    return Evidence(0.99, "the body is held up while every foot is off the ground")


@symptom(
    "outside force",
    "motion",
    cause="a push, a cable or a hand; or a contact of another part of the robot",
    confirm="look at the robot at that time: what touches it?",
    cure="log pushes; give every geom that may touch",
    body=True,
)
def outside_force(e: Episode) -> Evidence | None:
    """Tell whether something pushes the body that the log does not know."""
    rest = e.rows.unexplained
    if rest is None:
        return None
    force = np.nanmedian(rest.force[e.rows.core], axis=0)
    return Evidence(0.8, f"about ({force[0]:.3g}, {force[1]:.3g}, {force[2]:.3g}) N on the body, world axes")


@symptom(
    "wrong mass",
    "motion",
    cause="a payload, or the model's mass is not the robot's",
    confirm="weigh the robot",
    cure="correct the mass; estimate the payload while standing",
    body=True,
)
def wrong_mass(e: Episode) -> Evidence | None:
    """Tell whether the robot weighs something else than the log says."""
    rest = e.rows.unexplained
    if rest is None or e.failed["motion"].rows * e.rows.setting.dt < 0.2:
        return None
    force = rest.force[e.rows.core]
    force = force[np.isfinite(force).all(axis=1)]
    mean, spread = force.mean(axis=0), force.std(axis=0)
    upright = abs(mean[2]) > 0.9 * np.linalg.norm(mean)
    if not upright or np.linalg.norm(spread) > 0.6 * abs(mean[2]):
        return None
    return Evidence(0.9, f"the forces carry {-mean[2] / GRAVITY:+.3g} kg against the log's mass")
