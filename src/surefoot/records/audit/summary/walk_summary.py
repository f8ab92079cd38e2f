"""What a walk came to: velocity tracking, footfalls, commanded and measured forces, and a verdict."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import ClassVar

import numpy as np

from surefoot.base.spatial import rotation_from_quaternion
from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.audit.motion import commanded_excess, heading_velocity
from surefoot.records.audit.summary.estimate_summary import (
    EstimateErrors,
    LoadEstimate,
    estimate_errors,
    load_estimate,
)
from surefoot.records.audit.summary.run_summary import RunSummary, ending_of, shared_fields
from surefoot.records.log import Ending, Log

NONE = 0.005
"""Share of a velocity below which nothing of it is granted: 0 % in words."""


@dataclass(frozen=True)
class AxisTracking:
    """Mean velocity along one axis [m/s or rad/s]; whether the error is within its tolerance."""

    commanded: float
    measured: float
    error: float
    within: bool


@dataclass(frozen=True)
class VelocityTracking:
    """Mean velocities after `WalkLimits.settled` in the heading frame; whether all are within tolerance."""

    forward: AxisTracking
    left: AxisTracking
    turn: AxisTracking
    within: bool

    @property
    def followed(self) -> bool:
        """Whether the velocity is what was commanded by half at least, along the ground and turning."""
        return self.followed_within(LIMITS)

    def followed_within(self, judged: AuditLimits) -> bool:
        """Return whether it was followed by given limits."""
        limits = judged.walk
        for axes in ((self.forward, self.left), (self.turn,)):
            wanted, missed = (float(np.linalg.norm([astuple(a)[k] for a in axes])) for k in (0, 2))
            if missed > max(limits.followed_share * wanted, limits.followed_floor):
                return False
        return True


@dataclass(frozen=True)
class WalkSummary(RunSummary):
    """What a walk came to; its outcome is "walked", "did not follow", or how the run ended.

    Attributes
    ----------
    gait
        Its name.
    velocity
        Against the commanded one.
    commanded_cone_excess
        Largest distance of a commanded force outside the controller's cone [N].
    feasible_share
        Share of the steps whose command was possible within all limits.
    tilt_max_deg
        Largest angle of the base's vertical axis from the vertical [deg].
    distance, climb
        Of the base along the ground, and upwards [m].
    notes
        What the controller changed in its command.
    estimate
        Errors of the state that the controller was given; None if that was the true one.
    load
        What the controller found that it carries; None if it did not look.
    stale
        Time in which joints were damped because no fresh state came [s]; None for a run without a watchdog.
    """

    success_key: ClassVar[str] = "walked"

    gait: str
    velocity: VelocityTracking
    commanded_cone_excess: float
    feasible_share: float
    tilt_max_deg: float
    distance: float
    climb: float
    notes: list[str]
    estimate: EstimateErrors | None = None
    load: LoadEstimate | None = None
    stale: float | None = None


def summarise_walk(log: Log, limits: AuditLimits = LIMITS) -> WalkSummary:
    """Return the summary of a walk, judged by limits.

    Raises
    ------
    ProblemError
        If the log lacks a channel or a fact that it needs.
    """
    ended = ending_of(log)
    velocity, q = velocity_tracking(log, limits), log["q"]

    def judge(slip: float) -> str:
        if ended is not Ending.DONE:
            return str(ended)
        return "walked" if follows(log, limits) else "did not follow"

    up = rotation_from_quaternion(q[:, 3:7])[:, :, 2]
    return WalkSummary(
        **shared_fields(log, judge, WalkSummary.success_key, steps=True, limits=limits),
        gait=log.fact("gait"),
        velocity=velocity,
        commanded_cone_excess=float(commanded_excess(log).max()),
        feasible_share=float(np.mean(log["attained"])),
        tilt_max_deg=float(np.degrees(np.arccos(np.clip(up[:, 2].min(), -1.0, 1.0)))),
        distance=float(np.linalg.norm(np.diff(q[:, :2], axis=0), axis=1).sum()),
        climb=float(q[-1, 2] - q[0, 2]),
        notes=log.fact("notes") if log.facts.get("notes") else [],
        estimate=estimate_errors(log, limits) if "q_estimated" in log else None,
        load=load_estimate(log, limits) if "load_estimated" in log else None,
        stale=float(log.fact("dt") * np.sum(log["stale"])) if "stale" in log else None,
    )


def follows(log: Log, limits: AuditLimits = LIMITS) -> bool:
    """Return whether a walk went by half its command at least, see `VelocityTracking.followed_within`.

    A walk that granted nothing of a velocity asked for did not, though it followed what was left: none.
    """
    return least_granted(log) >= NONE and velocity_tracking(log, limits).followed_within(limits)


def least_granted(log: Log) -> float:
    """Return the least share of a velocity asked for that a walk granted."""
    return float(log.facts.get("granted_share", 1.0))


def velocity_tracking(log: Log, judged: AuditLimits) -> VelocityTracking:
    """Return the mean velocities after the start, against the commanded ones."""
    limits = judged.walk
    late = log["time"] >= limits.settled
    if not late.any():
        late = np.ones(len(log), dtype=bool)
    wanted, measured = log["command"][late].mean(axis=0), heading_velocity(log)[late].mean(axis=0)
    allowed = np.maximum(limits.tracking_share * np.abs(wanted), limits.tracking_floor)
    error = measured - wanted
    forward, left, turn = (
        AxisTracking(float(w), float(m), float(e), bool(abs(e) <= a))
        for w, m, e, a in zip(wanted, measured, error, allowed, strict=True)
    )
    return VelocityTracking(forward, left, turn, forward.within and left.within and turn.within)
