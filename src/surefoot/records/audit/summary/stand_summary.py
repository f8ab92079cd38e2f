"""What a stand came to: where the base ended, what every foot did, and an honest verdict."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.audit.motion import tilt_angles
from surefoot.records.audit.summary.run_summary import RunSummary, ending_of, shared_fields
from surefoot.records.log import Ending, Log


@dataclass(frozen=True)
class BaseMotion:
    """How far the base went from where it started, and ended [m, deg]."""

    position_max: float
    position_end: float
    tilt_max_deg: float
    tilt_end_deg: float


@dataclass(frozen=True)
class StandSummary(RunSummary):
    """What a stand came to; its outcome is "stood", "slipped", "displaced", or how the run ended.

    Attributes
    ----------
    normal_force_total_mean
        Of all feet together [N].
    attained_share
        Share of the steps whose wanted wrench was possible.
    base
        How far the base went.
    """

    success_key: ClassVar[str] = "stood"

    normal_force_total_mean: float
    attained_share: float
    base: BaseMotion


def summarise_stand(log: Log, limits: AuditLimits = LIMITS) -> StandSummary:
    """Return the summary of a stand, judged by limits.

    Raises
    ------
    ProblemError
        If the log lacks a channel or a fact that it needs.
    """
    ended, base = ending_of(log), _base(log)

    def judge(slip: float) -> str:
        return _outcome(log, ended, slip, base, limits)

    return StandSummary(
        **shared_fields(log, judge, StandSummary.success_key, steps=False, limits=limits),
        normal_force_total_mean=float(log["forces"][..., 2].sum(axis=1).mean()),
        attained_share=float(np.mean(log["attained"])),
        base=base,
    )


def _base(log: Log) -> BaseMotion:
    q = log["q"]
    away, tilt = np.linalg.norm(q[:, :3] - q[0, :3], axis=1), np.degrees(tilt_angles(q))
    return BaseMotion(float(away.max()), float(away[-1]), float(tilt.max()), float(tilt[-1]))


def _outcome(log: Log, ended: Ending, slip: float, base: BaseMotion, limits: AuditLimits) -> str:
    """Return "stood", or why not."""
    if ended in (Ending.INVALID, Ending.INTERRUPTED, Ending.STOPPED):
        return str(ended)
    if slip > limits.stand.slip:
        return "slipped"
    if ended is Ending.FELL:
        return str(ended)
    return "displaced" if displaced(log, base, limits) else "stood"


def displaced(log: Log, base: BaseMotion | None = None, limits: AuditLimits = LIMITS) -> bool:
    """Return whether the base of a stand ends too far from where it started, or leans."""
    base = _base(log) if base is None else base
    height = abs(float(log["q"][0, 2] - log["contact_positions"][0, :, 2].mean()))
    leans = np.radians(base.tilt_end_deg) > np.radians(limits.stand.tilt)
    return bool(base.position_end > limits.stand.drift * height or leans)
