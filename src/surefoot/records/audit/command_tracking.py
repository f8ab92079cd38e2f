"""What the controller asked for, and whether the task was attained: the other half of an audit.

Forces that obey every law of contact are no success: a robot that lies on the ground obeys them, too. What a
log says of its controller (`forces_commanded`, `active`, `attained`, `torques_commanded`) is judged by the
same laws: were forces asked for that contacts can give, and did the ground's answer agree with them? How the
run ended (`outcome`), how the base lies and which velocity was asked for say whether the task was attained.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.numerics.windows import sliding_mean
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.records.audit.continuity import free_base
from surefoot.records.audit.episode import LONGEST
from surefoot.records.audit.intervals import Interval, Track
from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.audit.log_context import Setting
from surefoot.records.audit.report import Finding, Task
from surefoot.records.audit.rows import Rows, on_body, pieces
from surefoot.records.audit.summary.stand_summary import displaced
from surefoot.records.audit.summary.walk_summary import follows
from surefoot.records.audit.symptoms.fits import fitted_pyramid, rotation_angle, rotation_between
from surefoot.records.log import Ending, Log


@dataclass(frozen=True)
class _Question:
    """One thing that is asked of the command in every row: a measure, and what it means if it is over."""

    name: str
    needs: tuple[str, ...]
    measure: Callable[[Rows], tuple[FloatArray, float]]
    text: str
    cause: str
    confirm: str
    cure: str
    named: Callable[[Finding, Rows, int], Finding] = lambda found, rows, column: found


def judge_command(log: Log, setting: Setting) -> Iterator[Finding]:
    """Yield where the command was not what laws allow, or the ground's answer not what was asked for.

    What the log has no channels for is not asked.
    """
    asked = [q for q in _QUESTIONS if setting.names and all(_known(log, name) for name in q.needs)]
    window = setting.limits.command.window
    join = max(1, round(window / setting.dt)) if setting.dt > 0.0 else 1
    tracks = [Track(q.name, join) for q in asked]
    for rows in pieces(log, setting):
        for q, track in zip(asked, tracks, strict=True):
            value, limit = q.measure(rows)
            bad = np.where(np.isfinite(value), value, 0.0)[rows.core] > limit
            if bad.any():
                bound = np.full(bad.shape, limit)
                track.add(bad, value[rows.core], bound, rows.first + rows.core.start)
    pairs = zip(asked, tracks, strict=True)
    found = [_finding(q, one, log, setting) for q, track in pairs for one in track.kept]
    # what begins first comes first, of what begins together the named cause
    yield from sorted(found, key=lambda f: (f.start // window, f.name == _UNNAMED, f.start))


def _finding(q: _Question, one: Interval, log: Log, setting: Setting) -> Finding:
    """Return what an interval means, named by what explains its beginning."""
    time = log["time"]
    start, end = float(time[one.first]), float(time[one.last]) + setting.dt
    where, text = setting.columns[one.column], q.text.format(value=one.value)
    found = Finding(q.name, where, start, end, text, q.cause, q.confirm, q.cure, 1.0)
    shown = Rows(log, setting, one.first, min(one.last + 1, one.first + LONGEST))
    return q.named(found, shown, one.column)


def _active(rows: Rows) -> BoolArray:
    """Return which contacts the controller lets push: (T, p), all where the log does not say."""
    if "active" in rows.log:
        return np.asarray(rows.log["active"], dtype=bool)
    return np.ones((rows.count, rows.points), dtype=bool)


def _commanded_pull(rows: Rows) -> tuple[FloatArray, float]:
    return -rows.numbers("forces_commanded")[..., 2], rows.setting.limits.laws.pull * rows.setting.weight


def _commanded_cone(rows: Rows) -> tuple[FloatArray, float]:
    f, limits = rows.numbers("forces_commanded"), rows.setting.limits.laws
    needed = np.hypot(f[..., 0], f[..., 1]) / np.maximum(f[..., 2], rows.setting.threshold)
    return needed / np.maximum(rows.mu, limits.least_friction), limits.cone


def _known(log: Log, name: str) -> bool:
    """Return whether a channel says anything: a controller of torques alone has NaN for its forces."""
    return name in log and bool(np.isfinite(np.asarray(log[name][: 1 << 16], dtype=np.float64)).any())


def _may_not_push(rows: Rows) -> tuple[FloatArray, float]:
    limits = rows.setting.limits.command
    near = (rows.gaps <= limits.touching).any(axis=1) if rows.has("gaps") else rows.loaded.any(axis=1)
    idle = np.abs(rows.numbers("forces_commanded")).max(axis=(1, 2)) <= rows.setting.threshold
    none = (~_active(rows).any(axis=1) | idle) & near
    share = sliding_mean(none.astype(np.float64), rows.window(limits.at_once))
    return on_body(rows, share), limits.nearly_all


def _impossible(rows: Rows) -> tuple[FloatArray, float]:
    lost = 1.0 - np.asarray(rows.log["attained"], dtype=np.float64)
    limits = rows.setting.limits.command
    return on_body(rows, sliding_mean(lost, rows.window(limits.window))), limits.nearly_all


def _other_torques(rows: Rows) -> tuple[FloatArray, float]:
    asked, given = rows.numbers("torques_commanded"), rows.numbers("torques")
    limits = rows.setting.limits.command
    off = np.abs(sliding_mean(given - asked, rows.window(limits.window))).max(axis=1)
    return on_body(rows, off / max(float(np.abs(asked).max(initial=0.0)), 1e-9)), limits.torque_mismatch


def _answer(rows: Rows) -> FloatArray:
    """Return what came of commanded forces, (T, p, 3): what the torques balance, else what was measured."""
    return rows.forces if rows.balanced is None else np.where(
        np.isfinite(rows.balanced), rows.balanced, rows.numbers("forces_commanded")
    )  # fmt: skip


def _other_forces(rows: Rows) -> tuple[FloatArray, float]:
    f, stance, limits = rows.numbers("forces_commanded"), _active(rows), rows.setting.limits.command
    if rows.balanced is None:
        stance = stance & rows.loaded  # not in place: the flags are the log's own
    off = sliding_mean(np.where(stance[..., None], _answer(rows) - f, 0.0), rows.window(limits.window))
    return np.linalg.norm(off, axis=-1) / rows.setting.weight, limits.mismatch


def _facets(found: Finding, rows: Rows, column: int) -> Finding:
    """Return the finding of commanded forces outside the cone, as a coarse pyramid's where they fill one."""
    f, mu = (
        x[rows.core] for x in (rows.numbers("forces_commanded"), np.broadcast_to(rows.mu, rows.normal.shape))
    )
    shape = fitted_pyramid(f, mu, rows.setting.weight, rows.setting.limits.fits)
    if shape is None:
        return found
    words = f"commanded forces fill a pyramid of {shape[0]} facets about the cone"
    return replace(found, name="coarse facets", evidence=words, cause="an outer pyramid of too few facets")


def _name_finding(found: Finding, rows: Rows, column: int) -> Finding:
    """Return the finding of forces that are not the commanded ones, under the name of what explains them."""
    limits = rows.setting.limits.command
    first = slice(rows.core.start, min(rows.core.stop, rows.core.start + rows.window(limits.at_once)))
    asked, given = rows.numbers("forces_commanded")[first, column], _answer(rows)[first, column]
    amiss = float(((given - asked) ** 2).sum())

    def explained(model: FloatArray) -> float:
        return 1.0 - float(((given - model) ** 2).sum()) / max(amiss, 1e-300)

    if explained(-asked) > limits.explained:
        words = "the forces are those commanded with the other sign"
        return replace(found, name="reversed", evidence=words, cause="action and reaction are exchanged")
    turn = rotation_between(asked, given)
    angle = rotation_angle(turn)
    if angle > limits.least_turn and explained(asked @ turn.T) > limits.explained:
        words = f"the forces are those commanded, turned by {angle:.0f} deg"
        cause = "J^T f with force and Jacobian in different frames (LOCAL with world forces, another normal)"
        return replace(found, name="wrong frame", evidence=words, cause=cause)
    return found


_UNNAMED = "not as commanded"
_QUESTIONS = (
    _Question(
        "no forces", ("forces_commanded",), _may_not_push, "no foot is asked to push though feet touch",
        "the schedule says swing, or contacts were not found", "print the contact schedule while it stands",
        "check phases, body names and the contact detector",
    ),
    _Question(
        _UNNAMED, ("forces_commanded", "forces"), _other_forces,
        "torques or forces are beside the commanded forces by {value:.2f} m g",
        "torques that do not belong to the commanded forces: frame, sign, model or saturation",
        "compare -J^T f with the torques while it stands", "state the frame in the name; rotate once",
        _name_finding,
    ),
    _Question(
        "infeasible", ("attained",), _impossible, "the wanted wrench is impossible in {value:.0%} of rows",
        "the motion asks for more than cones and torques allow", "which constraint is active throughout?",
        "slow down; relax the tasks before the cones",
    ),
    _Question(
        "commanded pull", ("forces_commanded",), _commanded_pull, "a pull of {value:.3g} N is commanded",
        "a row f_n >= 0 is missing in the controller's program", "print its smallest normal force",
        "bound normal forces from below",
    ),
    _Question(
        "commanded cone", ("forces_commanded", "mu"), _commanded_cone,
        "commanded forces need {value:.3g} times the friction that the ground has",
        "the controller believes in more friction, or in a coarse outer pyramid",
        "compare its mu and facets with the ground's cone", "an inner pyramid or the exact cone; find mu",
        _facets,
    ),
    _Question(
        "torques not applied", ("torques", "torques_commanded"), _other_torques,
        "applied and commanded torques differ by {value:.0%} of the largest",
        "motor limits, another order of joints, or a command that comes late", "plot both, joint by joint",
        "map joints by name; put the motors' limits into the controller",
    ),
)  # fmt: skip


def judge_task(log: Log, limits: AuditLimits = LIMITS) -> tuple[Task, str]:
    """Return whether the task of a log was attained, and how it failed."""
    ended = str(log.facts.get("outcome", ""))
    if ended in (Ending.FELL, Ending.LOST, Ending.INVALID):
        return "failed", f"the run ended after {float(log['time'][-1]):.2f} s: {_ENDED[ended]}"
    if (down := _lies(log, limits)) and (not ended or ended == Ending.DONE):
        return "failed", down
    if ended != Ending.DONE:
        return "unknown", ""
    walked = "command" in log and "q" in log and float(log["time"][-1]) > limits.walk.settled
    walked = walked and _has_velocity(log)
    if log.facts.get("kind") == "recording" and not walked:
        return "unknown", ""  # of somebody's loop: that its steps were made is no task
    if walked and not follows(log, limits):
        return "failed", "the robot did not follow the commanded velocity"
    standing = log.facts.get("kind") == "stand" and {"q", "contact_positions"} <= set(log.arrays)
    if standing and displaced(log, limits=limits):
        return "failed", "the base is not where it should stand"
    return "attained", ""


def _has_velocity(log: Log) -> bool:
    """Return whether a log says how fast its robot went: by a free base, or by the momentum of another."""
    q, v = np.asarray(log["q"][:1]), np.asarray(log["v"][:1])
    return free_base(q, v) or ("momentum" in log and "mass" in log.facts)


_ENDED = {
    str(Ending.FELL): "the robot fell",
    str(Ending.LOST): "the robot lost the estimate of its state",
    str(Ending.INVALID): "the state or a torque stopped being finite",
}


def _lies(log: Log, judged: AuditLimits) -> str:
    """Return how a robot with a free base lies at the end; empty if it does not, or one cannot tell."""
    limits, unit = judged.command, judged.records.unit_quaternion
    if not {"q", "v"} <= set(log.arrays):
        return ""
    if not free_base(np.asarray(log["q"][:1]), np.asarray(log["v"][:1]), unit):
        return ""
    q = np.asarray(log["q"])[[0, -1]]
    if not np.isfinite(q).all():
        return ""
    up = rotation_from_quaternion(q[:, 3:7])[:, :, 2]
    lean = float(np.arccos(np.clip(up[0] @ up[1], -1.0, 1.0)))
    if lean > np.radians(limits.leans):
        return f"the base ends {np.degrees(lean):.0f} deg from its upright pose"
    if "contact_positions" in log and np.size(log["contact_positions"]):  # nothing may ever have touched
        ground = np.asarray(log["contact_positions"])[[0, -1], :, 2].min(axis=1)
        heights = q[:, 2] - ground
        if heights[0] > 0.0 and heights[1] < limits.low * heights[0]:
            return f"the base ends at {heights[1]:.2f} m above its feet, {heights[0]:.2f} m at the start"
    return ""
