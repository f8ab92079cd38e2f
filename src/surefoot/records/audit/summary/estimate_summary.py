"""What a controller found out in a run: its state, against the true one of its world, and its load."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.base.errors import ProblemError
from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.audit.summary.run_summary import StepTimes
from surefoot.records.log import Log


@dataclass(frozen=True)
class EstimateErrors:
    """Errors of the estimated state of the base.

    Attributes
    ----------
    velocity_rms, velocity_max
        Length of the linear velocity's error in base axes, root of the mean square and largest [m/s].
    drift
        Growth of the place's error over the run [m].
    drift_share
        The same over the way along the ground; None for a way shorter than `EstimateLimits.shortest_way`.
    tilt_rms_deg
        Error of roll and pitch, root of the mean square [deg].
    heading_deg
        Growth of the heading's error over the run [deg].
    step_us
        Wall time of the estimator's step.
    """

    velocity_rms: float
    velocity_max: float
    drift: float
    drift_share: float | None
    tilt_rms_deg: float
    heading_deg: float
    step_us: StepTimes


def estimate_errors(log: Log, limits: AuditLimits = LIMITS) -> EstimateErrors:
    """Return the errors of a log's ``q_estimated`` and ``v_estimated``.

    Latency counts as error: both are held against the true state of the same row. Of an estimate that is not
    finite in some row they are NaN.

    Raises
    ------
    ProblemError
        If the log has no estimate, or no rows.
    """
    from scipy.spatial.transform import Rotation  # takes 0.1 s

    if "q_estimated" not in log or "v_estimated" not in log or len(log) == 0:
        raise ProblemError("the log has no estimated state")
    # Each in its own base's axes: what the attitude is wrong by does not count as an error of velocity again.
    velocity = np.linalg.norm(log["v_estimated"][:, :3] - log["v"][:, :3], axis=1)
    place = log["q_estimated"][:, :3] - log["q"][:, :3]
    # IMU, encoders and contacts do not show place and heading: those drift, from whatever they started with,
    # so the growth of their errors counts. Gravity shows tilt: its error is taken as it is.
    drift = float(np.linalg.norm(place[-1] - place[0]))
    way = float(np.linalg.norm(np.diff(log["q"][:, :2], axis=0), axis=1).sum())
    turns = np.stack([log[name][:, 3:7] for name in ("q", "q_estimated")])
    tilt = heading = np.full(len(log), np.nan)
    if (np.linalg.norm(turns, axis=2) > 0.0).all():  # SciPy refuses others, NaN among them
        true, estimated = (Rotation.from_quat(turn) for turn in turns)
        # The attitude's error as a turn about the vertical and one about a level axis. The heading's may grow
        # beyond half a turn, where that of a rotation vector jumps back by a whole one.
        x, y, z, w = (estimated * true.inv()).as_quat().T
        tilt, heading = 2.0 * np.arctan2(np.hypot(x, y), np.hypot(z, w)), np.unwrap(2.0 * np.arctan2(z, w))
    time = 1e6 * np.asarray(log["estimator_time"]) if "estimator_time" in log else np.full(1, np.nan)
    return EstimateErrors(
        velocity_rms=float(np.sqrt(np.mean(velocity**2))),
        velocity_max=float(velocity.max()),
        drift=drift,
        drift_share=drift / way if way >= limits.estimate.shortest_way else None,
        tilt_rms_deg=float(np.degrees(np.sqrt(np.mean(tilt**2)))),
        heading_deg=float(np.degrees(heading[-1] - heading[0])),
        step_us=StepTimes.of(time),
    )


@dataclass(frozen=True)
class LoadEstimate:
    """The payload and the wrench that were estimated, means of the last `EstimateLimits.last`.

    Attributes
    ----------
    mass
        Beyond the controller's model [kg].
    place
        (3,) base axes [m], the third seen only while the base leans; None for a mass too light to have one.
    force, moment
        (3,) what else pushed from outside, world axes, the moment about the base's origin [N, N m].
    """

    mass: float
    place: list[float] | None
    force: list[float]
    moment: list[float]


def load_estimate(log: Log, limits: AuditLimits = LIMITS) -> LoadEstimate:
    """Return the mean of a log's ``load_estimated`` and ``wrench_estimated`` at its end."""
    rows = max(1, round(limits.estimate.last / float(log.fact("dt"))))
    mass, *moment = log["load_estimated"][-rows:].mean(axis=0).tolist()
    wrench = log["wrench_estimated"][-rows:].mean(axis=0)
    light = abs(mass) < limits.estimate.light * float(log.fact("mass_controller"))
    place = None if light else (np.array(moment) / mass).tolist()
    return LoadEstimate(mass, place, wrench[:3].tolist(), wrench[3:].tolist())
