"""What an audit knows of a log once, and where the log contradicts itself."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray, finite_array
from surefoot.base.errors import ProblemError, SurefootError
from surefoot.base.settings import describe
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot, load_robot
from surefoot.records.audit.dynamics import MOTOR_FACTS
from surefoot.records.audit.ground import ground_plane
from surefoot.records.audit.laws import stated
from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.audit.logged_robot import LoggedRobot, from_recording, from_robot
from surefoot.records.audit.missing_rows import find_missing_rows
from surefoot.records.audit.row_velocities import MEANS, forces_late, velocities_after
from surefoot.records.log import Log
from surefoot.records.log.snapshot import point_names

BODY = "body"
"""Stands in a report where the whole robot is meant and no single contact."""
REMEDIES = {
    "sinking": "a stiffer contact (solref with a shorter time constant, solimp nearer to one)",
    "creep": "an elliptic cone with impratio of 10 or more, or a stiffer solref",
    "stopping": "solref with a shorter time constant, an elliptic cone with impratio of 10 or more",
    "settling": "solref with a shorter time constant",
}
"""What makes such a world tell more, in MuJoCo's words."""
PLANES = ("flat", "slope")
"""Kinds of ground that are one plane."""
PER_POINT = ("forces", "gaps", "contact_velocities", "contact_positions", "normals", "contact_friction")
"""Channels with a row for each contact point."""
OF_POINTS = ("contact_with", "moment_friction", "contact_margin", "contact_damping", "critically_damped")
"""Facts with a row for each contact point."""

REAL = {*MOTOR_FACTS, *OF_POINTS[1:], "gravity", "free_wrenches"}
"""Facts that the laws are worked out with: NaN in one of them would leave nothing over."""


@dataclass(frozen=True)
class Setting:
    """What an audit knows once.

    Attributes
    ----------
    names, owner
        (p,) names of the contact points and index of the foot of each.
    feet
        Names of the feet.
    weight
        m g [N].
    dt
        Usual time from row to row [s].
    sinking, creep, stopping, settling
        What the world declares of its own softness [m], [m/s], [m], [s].
    payload, payload_position
        Point mass on the base, part of the weight [kg], and where: (3,) base axes [m].
    robot
        For the equations of motion; None where they cannot be judged, for the reason `why_no_motion`.
    after
        Whether a row's contact velocities are those after its force has acted; else those before; None for
        means while it acts.
    late
        Whether a row's forces, and the momentum's rate, are those of the step that ended at its time.
    plane
        Whether the ground is known to be one plane, on which a gap changes as its contact moves.
    ground
        (4,) that plane's normal, world axes, and its height along it [m], where the contacts show it, or
        (p, 4) one a contact; else None.
    notes
        What was assumed, a line each.
    doubts
        Where the log contradicts itself, a line each: such a log is never lawful.
    limits
        What the log is judged by.
    missing_rows
        Which rows the log lacks, see `find_missing_rows`: laws from row to row cannot be judged.
    robots
        Robots of one weight side by side, whose contacts lie next to one another, as many of each; see
        `surefoot.records.audit.batch`.
    step_depth
        How deep contacts may be before a step finds them, as the log declares it [m].
    """

    names: tuple[str, ...]
    owner: IntArray
    feet: tuple[str, ...]
    weight: float
    dt: float
    sinking: float
    creep: float
    stopping: float
    settling: float
    payload: float
    payload_position: FloatArray
    robot: LoggedRobot | None
    why_no_motion: str
    after: bool | None = False
    late: bool = False
    plane: bool = False
    ground: FloatArray | None = None
    notes: tuple[str, ...] = field(default=())
    doubts: tuple[str, ...] = field(default=())
    limits: AuditLimits = LIMITS
    missing_rows: str = ""
    robots: int = 1
    step_depth: float = 0.0

    @property
    def means(self) -> bool:
        """Whether velocities and forces are means over their rows, see `after`."""
        return self.after is None

    @property
    def threshold(self) -> float:
        """Normal force from which a contact counts as loaded [N]."""
        return self.limits.laws.loaded * self.weight

    @property
    def slide_limit(self) -> float:
        """Longest way without friction that counts as sticking [m]."""
        return self.limits.laws.slide + self.stopping

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the contacts, and of the body at the end."""
        return (*self.names, BODY)

    def single(self, contact: int) -> bool:
        """Return whether a contact is all that its foot has."""
        return int((self.owner == self.owner[contact]).sum()) == 1


def setting_of(log: Log, robot: Robot | None, limits: AuditLimits = LIMITS) -> Setting:
    """Return what a log tells once, to be judged by limits; `robot` None for the one that it names.

    Raises
    ------
    ProblemError
        If the log has no rows, or facts that are none.
    """
    if len(log) == 0:
        raise ProblemError("the log has no rows")
    notes = [f"doubt of the reader: {line}" for line in log.doubts]
    doubts: list[str] = []
    count = max((log[name].shape[1] for name in PER_POINT if name in log), default=0)
    feet, owner = _feet(log, count)
    names = tuple(point_names(feet, owner.tolist()))
    steps = np.diff(np.asarray(log["time"][: 1 << 16]))
    good = steps[np.isfinite(steps) & (steps > 0.0)]
    stated_dt = float(log.fact("dt")) if "dt" in log.facts else 0.0
    dt = float(np.median(good)) if good.size else stated_dt
    if stated_dt and good.size and abs(stated_dt - dt) > limits.records.same_dt * dt:
        doubts.append(f"the log says dt = {stated_dt:g} s, its time stamps {dt:g} s")
    lost = find_missing_rows(log, good)
    doubts += [lost] if lost else []
    for name in REAL.intersection(log.facts):
        finite_array(f"the fact {name}", log.fact(name))
    softest = describe(limits.softness)
    soft = [stated(log, one.name) for one in softest]
    if _by_row(log):  # friction is judged by its own law, row by row: what is left to allow is bounded
        soft[1], soft[2] = _mean_creep(log), min(soft[2], limits.softness.stopping)
    sinking, creep, stopping, settling = soft
    payload = stated(log, "payload")
    place = finite_array("the fact payload_position", log.facts.get("payload_position", np.zeros(3)), (3,))
    kept = _by_row(log) and soft[0] > limits.softness.sinking and _deepest(log) <= limits.softness.sinking
    doubts += softness_doubts([0.0 if kept else soft[0], *soft[1:]], limits)
    notes += _fact_notes(log, limits)
    if any(soft):
        deep = "; that is soft: a stiffer contact would show more" if sinking > limits.records.deep else ""
        held = f"and {1e3 * stopping:.2g} mm until a sliding foot is held"
        if _by_row(log):
            held = f"{held}, by its own law"
        swing = ""
        if settling > 0.0:
            swing = f"; for {1e3 * settling:.2g} ms after a hard touchdown friction's work is not judged"
        notes.append(
            f"the world declares itself soft: sinking to {1e3 * sinking:.2g} mm, creep to "
            f"{1e3 * creep:.2g} mm/s {held} count as lawful{deep}{swing}"
        )
    model, why = _robot(log, robot, owner, doubts, limits.records.same_mass)
    notes += _whirl_note(log, model, dt)
    weight = _weight(log, model, payload, notes, doubts)
    plane, ground = ground_of(log, limits, sinking, weight)
    return Setting(
        names, owner, feet, weight, dt, sinking, creep, stopping, settling, payload, place, model, why,
        velocities_after(log, dt, limits.records.clear), forces_late(log, dt, weight),
        plane or ground is not None, ground, tuple(notes), tuple(doubts), limits, lost,
        step_depth=min(stated(log, "step_depth"), limits.softness.sinking),
    )  # fmt: skip


def softness_doubts(soft: Sequence[float], limits: AuditLimits) -> Iterator[str]:
    """Yield a line for each declared softness that hides anything: sinking, creep, stopping, settling."""
    for one, value in zip(describe(limits.softness), soft, strict=True):
        name, most, unit = one.name, float(one.value or 0.0), one.info.unit
        if value > most:
            yield (
                f"the world declares a {name} of {value:.3g} {unit}: beyond {most:g} it hides anything; "
                f"what helps is {REMEDIES[name]}"
            )


def _fact_notes(log: Log, limits: AuditLimits) -> Iterator[str]:
    """Yield a line for each declared fact that widens a limit by its own size."""
    if log.facts.get("velocities") == "mean":
        yield MEANS
    if (found := stated(log, "step_depth")) > limits.laws.penetration:
        yield (
            f"contacts go up to {1e3 * found:.3g} mm into the ground before a step finds them: that counts "
            f"as lawful, up to {1e3 * limits.softness.sinking:g} mm; a shorter step tells more"
        )
    if (margin := float(np.max(log.facts.get("contact_margin", 0.0)))) > limits.laws.penetration:
        yield (
            f"the world's contacts push from a margin of up to {1e3 * margin:.3g} mm: forces across such a "
            f"gap count as lawful, up to {1e3 * limits.softness.sinking:g} mm; a margin of zero tells more"
        )


def _whirl_note(log: Log, model: LoggedRobot | None, dt: float) -> Iterator[str]:
    """Yield a line where limbs whirl: their forces are not judged there."""
    if model is None or "v" not in log:
        return
    count = sum(int(model.whirls(np.asarray(piece["v"]), dt).sum()) for piece in log.chunks())
    if count:
        yield (
            f"in {count} rows a joint is faster than its motor can, and turns far within a row: forces are "
            "not held against the motion there"
        )


def ground_of(log: Log, limits: AuditLimits, sinking: float, weight: float) -> tuple[bool, FloatArray | None]:
    """Return whether a log's terrain is one plane by name, and the plane (4,) that its contacts show."""
    terrain = str(log.facts.get("terrain", "")).split(":")[0]
    if terrain and terrain not in PLANES:
        return False, None
    share = 0.0 if terrain else limits.consistency.shown
    near = limits.consistency.place + sinking
    return bool(terrain), ground_plane(log, share, near, limits.laws.loaded * weight)


def _by_row(log: Log) -> bool:
    """Return whether a log has row by row what its soft friction creeps, and how fast it brakes."""
    return {"contact_creep", "forces"} <= set(log.arrays) and "contact_damping" in log.facts


def _mean_creep(log: Log) -> float:
    """Return the speed at which the loads of a log creep by the world's own law, on average [m/s]."""
    load = way = 0.0
    for piece in log.chunks():
        normal = np.nan_to_num(np.maximum(np.asarray(piece["forces"])[..., 2], 0.0))
        load += float(normal.sum())
        way += float((normal * np.nan_to_num(np.asarray(piece["contact_creep"]))).sum())
    return way / load if load > 0.0 else 0.0


def _deepest(log: Log) -> float:
    """Return how deep any contact of a log went [m]."""
    return max((-float(np.nanmin(p["gaps"], initial=0.0)) for p in log.chunks()), default=0.0)


def _feet(log: Log, count: int) -> tuple[tuple[str, ...], IntArray]:
    if "contact_foot" not in log.facts or "feet" not in log.facts:
        return tuple(f"contact {k}" for k in range(count)), np.arange(count)
    feet = tuple(map(str, log.fact("feet")))
    owner = np.asarray(log.fact("contact_foot"))
    if count and (owner.shape != (count,) or not np.isin(owner, np.arange(len(feet))).all()):
        raise ProblemError(f"the fact contact_foot must name one of {len(feet)} feet for {count} contacts")
    return feet, owner.astype(np.int64)


def _weight(
    log: Log, model: LoggedRobot | None, payload: float, notes: list[str], doubts: list[str]
) -> float:
    """Return m g: the log's, else the robot's, else from the forces, which is a doubt."""
    if "mass" in log.facts:
        return float(log.fact("mass")) * GRAVITY
    if model is not None:
        notes.append(f"the log does not tell the robot's mass: {model.mass + payload:.3g} kg from its model")
        return (model.mass + payload) * GRAVITY
    mean = 0.0
    if "forces" in log:
        total = np.asarray(log["forces"][: 1 << 16, :, 2]).sum(axis=1)
        mean = float(np.mean(total[np.isfinite(total)])) if np.isfinite(total).any() else 0.0
    known = math.isfinite(mean) and mean > 0.0
    taken = f"{mean / GRAVITY:.3g} kg from its forces" if known else "1 kg is taken"
    doubts.append(f"the log does not tell the robot's mass: {taken}")
    return mean if known else GRAVITY


def _robot(
    log: Log, robot: Robot | None, owner: IntArray, doubts: list[str], same_mass: float
) -> tuple[LoggedRobot | None, str]:
    """Return the robot of a log, or why its equations of motion cannot be judged."""
    if len(log) < 3:
        return None, "the log has fewer than three rows"
    needed = ("q", "v", "forces", "contact_positions", "normals")
    lacking = [name for name in needed if name not in log]
    if lacking:
        return None, f"the log has no {', '.join(lacking)}"
    recorded = log.facts.get("kind") == "recording"
    kept = from_recording(log, owner) if robot is None and recorded else "no recording"
    if not isinstance(kept, str):
        return kept, ""
    if robot is None:
        if "robot" not in log.facts:
            return None, "the log does not name its robot: give one"
        name = str(log.fact("robot"))
        try:
            robot = _named_robot(name)
        except SurefootError as error:
            return None, kept if "model_bodies" in log.facts else str(error)
        if recorded and abs(robot.mass - float(log.fact("mass"))) > same_mass * robot.mass:
            return None, f"the recording's {name} has another mass than ours: give the robot itself"
    return _as_logged(robot, log, owner, doubts, recorded)


def _named_robot(name: str) -> Robot:
    """Return a robot that a log names: one of a file is read anew, ours are kept."""
    return load_robot(name) if Path(name).suffix else _known_robot(name)


@lru_cache(maxsize=4)
def _known_robot(name: str) -> Robot:
    return load_robot(name)


def _as_logged(
    robot: Robot, log: Log, owner: IntArray, doubts: list[str], recorded: bool
) -> tuple[LoggedRobot | None, str]:
    """Return a robot with the contact points of a log, or why they do not fit."""
    have = (log["q"].shape[1], log["v"].shape[1], log["forces"].shape[1])
    points = have[2] if recorded else len(robot.contact_points)
    want = (int(robot.model.nq), int(robot.model.nv), points)
    if not robot.floating and have[:2] == want[:2]:
        return None, "the robot is bolted to the world"
    if have != want:
        doubts.append(f"{robot.name} has (nq, nv, contact points) = {want}, the log {have}")
        return None, doubts[-1]
    if "torques" in log and log["torques"].shape[1] != robot.joints:
        doubts.append(f"{robot.name} has {robot.joints} joints, the log {log['torques'].shape[1]}")
        return None, doubts[-1]
    found = from_robot(robot, log, owner)
    return (None, found) if isinstance(found, str) else (found, "")
