"""What a run came to: per-foot figures, the laws as numbers, and an honest verdict."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.audit import check_laws, contact_use
from surefoot.audit.laws import LOADED_SHARE
from surefoot.simulation.log import Log
from surefoot.simulation.pressure import sole_pressures
from surefoot.spatial import GRAVITY, rotation_from_quaternion

SLIP_LIMIT = 0.01
"""A foot that has moved further than this over the ground while loaded has slipped [m]."""
DRIFT_LIMIT, TILT_LIMIT = 0.1, np.radians(10.0)
"""A robot stands if its base ends within this share of its height, and this angle, of its place."""


def slips(log: Log) -> FloatArray:
    """Return how far each contact point has slid since it was last told to push: (T, p) [m].

    Integrates the velocity of the foot's material at the contact while loaded, so that rolling is no
    slip and a foot that hops while it slides is not forgiven; zero for a foot in the air on purpose.
    """
    travel = np.cumsum(np.where(_loaded(log)[..., None], log["contact_velocities"][..., :2], 0.0), axis=0)
    travel *= log.facts["dt"]
    active = np.asarray(log["active"])
    before = np.vstack([np.zeros((1, active.shape[1]), dtype=bool), active[:-1]])
    steps = np.arange(len(log))[:, None]
    since = np.maximum.accumulate(np.where(active & ~before, steps, 0), axis=0)
    start = np.take_along_axis(travel, np.repeat(since[..., None], 2, axis=2), axis=0)
    return np.where(active, np.linalg.norm(travel - start, axis=-1), 0.0)


def _loaded(log: Log) -> BoolArray:
    threshold = LOADED_SHARE * log.facts["mass"] * GRAVITY
    return np.asarray(log["forces"][..., 2] > threshold)


def summarise(log: Log) -> dict[str, Any]:
    """Return the summary of a standing run, ready for JSON.

    Keys: robot, mass, duration (simulated) [s], outcome, error, stood, laws_judged, laws_broken, feet (name,
    normal_force_mean [N], weight_share, cone_use_max, slip [m]), normal_force_total_mean [N], laws
    (see `surefoot.audit.Laws`), torque_use_max, saturated_share, attained_share, base (position and
    tilt: largest and last deviation from the start [m, deg]), controller_step_us, real_time_factor.
    """
    facts, weight = log.facts, log.facts["mass"] * GRAVITY
    forces, mu = log["forces"], log["mu"]
    owner = np.asarray(facts["contact_foot"])
    slip, threshold = slips(log), LOADED_SHARE * weight
    feet = []
    for k, name in enumerate(facts["feet"]):
        mine = owner == k
        total = forces[:, mine].sum(axis=1)
        mean = float(total[:, 2].mean())
        feet.append(
            {
                "name": name,
                "normal_force_mean": mean,
                "weight_share": mean / weight,
                "cone_use_max": float(contact_use(total[:, None], mu, threshold).max()),
                "slip": float(slip[:, mine].max()),
            }
        )
    for sole in sole_pressures(log):
        feet[sole.foot]["pressure_margin"] = sole.margin
    laws = check_laws(forces, log["gaps"], log["contact_velocities"], mu, weight, facts["dt"])
    base = _base(log)
    outcome = _outcome(log, max(foot["slip"] for foot in feet), base)
    step = 1e6 * np.asarray(log["controller_time"])
    limits = np.asarray(facts["effort_limits"])
    return {
        "robot": facts["robot"],
        "mass": facts["mass"],
        "duration": len(log) * facts["dt"],
        "outcome": outcome,
        "error": str(facts.get("error", "")),
        "stood": outcome == "stood",
        "laws_judged": list(laws.judged),
        "laws_broken": laws.broken(weight),
        "feet": feet,
        "normal_force_total_mean": float(forces[..., 2].sum(axis=1).mean()),
        "laws": {
            "penetration_max": laws.penetration_max,
            "unilateral_min": laws.unilateral_min,
            "cone_use_max": laws.cone_use_max,
            "complementarity_max": laws.complementarity_max,
            "separation_max": laws.separation_max,
            "dissipation_max": laws.dissipation_max,
            "free_slide_max": laws.free_slide_max,
        },
        "torque_use_max": float((np.abs(log["torques"]) / limits).max()),
        "torque_use_joint": facts["joints"][int((np.abs(log["torques"]) / limits).max(axis=0).argmax())],
        "saturated_share": float(np.mean(log["saturated"])),
        "attained_share": float(np.mean(log["attained"])),
        "base": base,
        "controller_step_us": {"median": float(np.median(step)), "p99": float(np.percentile(step, 99))},
        "real_time_factor": len(log) * facts["dt"] / facts["wall_time"],
        "wall_time": facts["wall_time"],
    }


def measured(log: Log) -> bool:
    """Return whether every state, torque and contact of a run is a finite number."""
    names = ("q", "v", "torques", "forces", "gaps", "contact_velocities", "contact_positions")
    return all(bool(np.isfinite(piece[name]).all()) for piece in log.chunks() for name in names)


def tilt_angles(q: FloatArray) -> FloatArray:
    """Return the turn of the base since the first row of (T, nq) configurations: (T,) [rad]."""
    R = rotation_from_quaternion(q[:, 3:7])
    trace = np.einsum("ij,tij->t", R[0], R)
    # from the chord, which keeps its digits near zero: ||R - R0||² = 2 (3 - trace)
    return np.asarray(2.0 * np.arcsin(np.clip(np.sqrt(np.maximum(3.0 - trace, 0.0)) / 2.0, 0.0, 1.0)))


def _base(log: Log) -> dict[str, float]:
    """Return how far the base went from where it started, and ended."""
    q = log["q"]
    away = np.linalg.norm(q[:, :3] - q[0, :3], axis=1)
    tilt = np.degrees(tilt_angles(q))
    return {
        "position_max": float(away.max()),
        "position_end": float(away[-1]),
        "tilt_max_deg": float(tilt.max()),
        "tilt_end_deg": float(tilt[-1]),
    }


def _outcome(log: Log, slip: float, base: dict[str, float]) -> str:
    """Return "stood", or why not: "interrupted", "stopped", "invalid", "slipped", "fell", "displaced"."""
    ended = str(log.facts["outcome"])
    if ended == "invalid" or not measured(log):
        return "invalid"
    if ended in ("interrupted", "stopped"):
        return ended
    if slip > SLIP_LIMIT:
        return "slipped"
    if ended == "fell":
        return "fell"
    height = abs(float(log["q"][0, 2] - log["contact_positions"][0, :, 2].mean()))
    moved = base["position_end"] > DRIFT_LIMIT * height or np.radians(base["tilt_end_deg"]) > TILT_LIMIT
    return "displaced" if moved else "stood"
