"""What the summary of a run holds whatever the robot did; its fields are the keys of summary.json."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, ClassVar

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, of_kind
from surefoot.base.errors import ProblemError, check_name
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.laws import LawFigures, contact_use, friction_of, log_laws
from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.audit.motion import finite, foot_forces, slips, touching
from surefoot.records.audit.pressure import sole_pressures
from surefoot.records.audit.summary.motor_summary import MotorUse, limits_broken, motor_use
from surefoot.records.log import Ending, Log


@dataclass(frozen=True)
class FootSummary:
    """What one foot did.

    Attributes
    ----------
    name
        Of the foot.
    normal_force_mean, weight_share
        Mean normal force [N], and over m g.
    cone_use_max
        Highest ||f_t|| / (mu f_n) of its force.
    slip
        Furthest that one of its points slid since it was commanded to push [m].
    pressure_margin
        Least distance of the centre of pressure from a flat sole's edge [m]; None for a point foot.
    footfalls, duty
        Of a walk: number of touchdowns, share of the time on the ground.
    """

    name: str
    normal_force_mean: float
    weight_share: float
    cone_use_max: float
    slip: float
    pressure_margin: float | None = None
    footfalls: int | None = None
    duty: float | None = None


@dataclass(frozen=True)
class StepTimes:
    """Wall time of the controller's step [us]."""

    median: float
    p99: float
    largest: float

    @classmethod
    def of(cls, times: FloatArray) -> StepTimes:
        """Return those of (N,) times [us]."""
        return cls(*(float(np.percentile(times, share)) for share in (50, 99, 100)))


@dataclass(frozen=True)
class RunSummary:
    """What every run came to.

    Attributes
    ----------
    robot, mass, duration
        Name, [kg], simulated time [s].
    world
        Where it ran, as `--world` has it: "mujoco", "rigid"; empty for a log that does not tell.
    unsolved_steps
        Steps whose contacts an exact world solved softly; None for a log that does not tell.
    outcome
        In a word.
    success
        Whether the robot did what it should.
    error
        What ended the run or its recording; empty for nothing.
    laws_judged, laws_broken
        Names of the laws that were judged, and a line for each that was broken.
    limits_broken
        A line for each limit of the robot's own that was not kept: joint speeds, what its links touched.
        None for a log that tells of none.
    motors
        What the joints were asked for; None for a log that does not tell their speeds.
    feet
        One for each.
    laws
        The laws as numbers.
    torque_use_max, torque_use_joint
        Highest share of a joint's torque limit that was used, and whose.
    saturated_share
        Share of the steps with a torque at its limit.
    controller_step_us, real_time_factor, wall_time
        What the run cost; simulated over real time; real time [s].
    """

    success_key: ClassVar[str] = "success"

    robot: str
    mass: float
    duration: float
    world: str
    unsolved_steps: int | None
    outcome: str
    success: bool
    error: str
    laws_judged: list[str]
    laws_broken: list[str]
    limits_broken: list[str] | None
    motors: MotorUse | None
    feet: list[FootSummary]
    laws: LawFigures
    torque_use_max: float
    torque_use_joint: str
    saturated_share: float
    controller_step_us: StepTimes
    real_time_factor: float
    wall_time: float

    @property
    def good(self) -> bool:
        """Whether the robot did what it should, no law was broken and no limit of its own."""
        return self.success and not self.laws_broken and not self.limits_broken

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name, for JSON; `success` under the name of what was done."""
        out = _plain(self)
        out[self.success_key] = out.pop("success")
        return dict(out)


def world_name(log: Log) -> str:
    """Return where a log's run took place, as `--world` has it; empty for a log that does not tell.

    >>> world_name(Log({"time": [0.0]}, {"world": "MujocoExactWorld"}))
    'mujoco-exact'
    """
    kind = str(log.facts.get("world", "")).removesuffix("World")
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "-", kind).lower()


def _plain(value: Any) -> Any:
    """Return dataclasses as dictionaries, without what is None, of laws the numbers alone."""
    if is_dataclass(value):
        skipped = ("judged", "not_finite") if isinstance(value, LawFigures) else ()
        pairs = ((f.name, getattr(value, f.name)) for f in fields(value) if f.name not in skipped)
        return {name: _plain(one) for name, one in pairs if one is not None}
    return [_plain(one) for one in value] if isinstance(value, list) else value


def shared_fields(
    log: Log, judge: Callable[[float], str], good: str, steps: bool, limits: AuditLimits = LIMITS
) -> dict[str, Any]:
    """Return the fields of `RunSummary` for a log.

    Parameters
    ----------
    log
        Of a run.
    judge
        From the largest slip of a foot [m] to the outcome.
    good
        The outcome that is a success.
    steps
        Whether footfalls are counted.
    limits
        What laws, slips and motors are judged by.
    """
    weight, laws = log.fact("mass") * GRAVITY, log_laws(log, limits)
    feet = _feet(log, weight, touching(log) if steps else None, limits)
    outcome = judge(max(foot.slip for foot in feet))
    time, use = 1e6 * np.asarray(log["controller_time"]), np.abs(log["torques"]) / log.fact("effort_limits")
    motors = motor_use(log, limits)
    duration, wall = len(log) * log.fact("dt"), log.fact("wall_time")
    return {
        "robot": log.fact("robot"),
        "mass": log.fact("mass"),
        "duration": duration,
        "world": world_name(log),
        "unsolved_steps": int(log.fact("unsolved_steps")) if "unsolved_steps" in log.facts else None,
        "outcome": outcome,
        "success": outcome == good,
        "error": str(log.facts.get("error", "")),
        "laws_judged": list(laws.judged),
        "laws_broken": laws.broken(weight, limits),
        "limits_broken": limits_broken(log, motors),
        "motors": motors,
        "feet": feet,
        "laws": laws,
        "torque_use_max": float(use.max()),
        "torque_use_joint": log.fact("joints")[int(use.max(axis=0).argmax())],
        "saturated_share": float(np.mean(log["saturated"])),
        "controller_step_us": StepTimes.of(time),
        "real_time_factor": duration / max(wall, 1e-9),
        "wall_time": wall,
    }


def ending_of(log: Log) -> Ending:
    """Return how a run ended; INVALID also where a measurement is not finite.

    Raises
    ------
    ProblemError
        If the log has no rows, or its outcome is none.
    """
    of_kind("log", log, Log)
    if len(log) == 0:
        raise ProblemError("the log has no rows")
    outcome = log.fact("outcome")
    check_name("outcome", outcome, Ending)
    return Ending(outcome) if finite(log) else Ending.INVALID


def _feet(log: Log, weight: float, down: BoolArray | None, limits: AuditLimits) -> list[FootSummary]:
    """Return what every foot did; `down` says when it was on the ground, (T, n)."""
    owner, slip, total = log.fact("contact_foot"), slips(log, limits), foot_forces(log)
    margins = {sole.foot: sole.margin for sole in sole_pressures(log)}
    friction = friction_of(log)
    if friction.ndim == 2:  # of a foot: where it has most
        friction = np.column_stack([friction[:, owner == k].max(axis=1) for k in range(total.shape[1])])
    laws = limits.laws
    use = contact_use(total, friction, laws.loaded * weight, laws.least_friction).max(axis=0)
    out = []
    for k, name in enumerate(log.fact("feet")):
        mean = float(total[:, k, 2].mean())
        own = float(slip[:, owner == k].max(initial=0.0))
        falls = None if down is None else int((down[1:, k] & ~down[:-1, k]).sum())
        duty = None if down is None else float(down[:, k].mean())
        out.append(FootSummary(name, mean, mean / weight, float(use[k]), own, margins.get(k), falls, duty))
    return out
