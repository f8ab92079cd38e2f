"""Symptoms of what is measured: the logged force is not the true one, or the joints tell another."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.records.audit.episode import Episode
from surefoot.records.audit.symptoms.fits import best_shift, rotation_angle, rotation_between
from surefoot.records.audit.symptoms.symptom import Evidence, Judge, symptom

_SIGNS = np.array([[-1.0, 1.0, 1.0], [1.0, -1.0, 1.0]])


def compared(judge: Callable[[Episode, FloatArray], Evidence | None]) -> Judge:
    """Return a judge that is asked where the force (m, 3) [N] that the joint torques ask for is known."""
    return lambda e: None if e.true is None else judge(e, e.true)


@symptom(
    "wrong frame",
    "motion",
    cause="forces and Jacobian are in different frames (LOCAL with world forces, another normal)",
    confirm="the power test f . J v = tau . v, in each frame",
    cure="state the frame in the name and rotate once, at the door",
)
@compared
def wrong_frame(e: Episode, true: FloatArray) -> Evidence | None:
    """Tell whether the logged force is the true one, (m, 3) [N], turned."""
    turn = rotation_between(true, e.force)
    angle = rotation_angle(turn)
    share, limits, ranks = e.share_explained(true @ turn.T), e.limits.measured, e.limits.ranks
    if angle < limits.turn or share < limits.turn_share:
        return None
    doubt = (
        ranks.turn_of_many if _same_turn(e, turn) else ranks.turn_of_one
    )  # of one foot, more friction may look like a turn
    return Evidence(
        share - doubt, f"turning the forces by {angle:.0f} deg explains {100 * share:.0f} % of the mismatch"
    )


def _same_turn(e: Episode, turn: FloatArray) -> bool:
    """Return whether the same turn explains the forces of other feet that carry then, too."""
    limits = e.limits.measured
    others = [k for k in range(e.rows.points) if k != e.column]
    pairs = [(e.rows.forces[e.rows.core, k], true) for k in others if (true := e.true_of(k)) is not None]
    if not pairs:
        return False
    logged, true = (np.concatenate(part) for part in zip(*pairs, strict=True))
    known = np.isfinite(true).all(axis=1)
    amiss = float(((logged - true)[known] ** 2).sum())
    if amiss < (limits.turn_amiss * e.weight) ** 2 * known.sum():
        return False
    left = float(((logged - true @ turn.T)[known] ** 2).sum())
    return left < (1.0 - limits.explained) * amiss


@symptom(
    "mirrored",
    "motion",
    cause="one tangent has the wrong sign: a left-handed contact frame or another order of axes",
    confirm="push the robot sideways and compare the sign of the forces",
    cure="build the frame from the normal and a heading, right-handed",
)
@compared
def mirrored(e: Episode, true: FloatArray) -> Evidence | None:
    """Tell whether the logged force is the true one, (m, 3) [N], in a mirror."""
    best, which = max((e.share_explained(true * sign), k) for k, sign in enumerate(_SIGNS))
    if best < e.limits.measured.explained:
        return None
    return Evidence(
        best - e.limits.ranks.mirror,
        f"the sign of {'xy'[which]} reversed explains {100 * best:.0f} % of the mismatch",
    )


@symptom(
    "reversed",
    cause="action and reaction are exchanged: the force on the ground, not on the robot",
    confirm="a standing robot's forces must add up to +m g",
    cure="reverse the sign where the forces are read",
)
def reversed_force(e: Episode) -> Evidence | None:
    """Tell whether the logged force acts on the ground."""
    true, limits = e.true, e.limits.measured
    if true is None:
        total = e.rows.normal[e.rows.core].sum(axis=1)  # one foot alone may be pulled, all together are not
        if e.has("pull") and float(np.mean(total)) < -limits.reversed_pull * e.weight:
            return Evidence(e.limits.ranks.reversed_pull, "the ground pulls at all feet together")
        return None
    share = e.share_explained(-true)
    if share < limits.explained:
        return None
    return Evidence(share, f"the sign reversed explains {100 * share:.0f} % of the mismatch")


@symptom(
    "wrong scale",
    "motion",
    cause="wrong unit (kgf, lbf), gain, or share of a foot",
    confirm="a standing robot's forces must add up to m g",
    cure="convert once, where the log is read",
)
@compared
def wrong_scale(e: Episode, true: FloatArray) -> Evidence | None:
    """Tell whether the logged force is a multiple of the true one, (m, 3) [N]."""
    known, limits = np.isfinite(true).all(axis=1), e.limits.measured
    factor = float((e.force[known] * true[known]).sum() / max(float((true[known] ** 2).sum()), 1e-12))
    share = e.share_explained(factor * true)
    if factor <= limits.scale_least or abs(factor - 1.0) < limits.scale_change or share < limits.explained:
        return None
    return Evidence(
        share - e.limits.ranks.scale,
        f"{factor:.3g} times the force that the legs carry ({100 * share:.0f} % explained)",
    )


@symptom(
    "bias",
    "motion",
    cause="the sensor's zero has drifted, or the foot's own weight is in it",
    confirm="read the sensor with the foot in the air",
    cure="zero it in flight",
)
@compared
def bias(e: Episode, true: FloatArray) -> Evidence | None:
    """Tell whether a constant has been added to the true force, (m, 3) [N]."""
    offset, limits, ranks = np.nanmean(e.force - true, axis=0), e.limits.measured, e.limits.ranks
    share = e.share_explained(true + offset)
    if share < limits.explained:
        return None
    air = np.linalg.norm(np.nan_to_num(true), axis=1) < limits.unloaded * e.weight
    flies = bool(air.mean() > limits.bias_flies)
    doubt = (
        ranks.bias_in_flight if flies else ranks.bias_on_ground
    )  # where the load never changes a gain or a turn explains as much
    return Evidence(
        share - doubt, f"a constant of {float(np.linalg.norm(offset)):.3g} N explains {100 * share:.0f} %"
    )


@symptom(
    "delayed",
    "motion",
    cause="two clocks, or a filter before the log",
    confirm="knock on the foot and compare the stamps with the joints'",
    cure="stamp at the source; shift or filter all channels alike",
)
def delayed(e: Episode) -> Evidence | None:
    """Tell whether the force comes late or early."""
    whole, limits = e.whole_true(e.column), e.limits.measured
    if whole is None:
        return None
    most = e.rows.window(limits.delay_most)
    best, shift = best_shift(whole, e.rows.forces[:, e.column], most, e.rows.core)
    if best < limits.delay_share or abs(shift) < limits.delay_rows:
        return None
    late = "late" if shift > 0 else "early"
    return Evidence(
        best - e.limits.ranks.delay,
        f"{1e3 * abs(shift) * e.rows.setting.dt:.0f} ms {late} explains {100 * best:.0f} % of the mismatch",
    )


@symptom(
    "swapped feet",
    "motion",
    cause="the order of the feet differs between the sensor and the robot",
    confirm="lift one foot: which channel goes to zero?",
    cure="map by name, never by position",
)
@compared
def swapped_feet(e: Episode, true: FloatArray) -> Evidence | None:
    """Tell whether the force is not this foot's true one, (m, 3) [N], but another's."""
    others = [k for k in range(e.rows.points) if k != e.column]
    fits = [(e.share_explained(theirs), k) for k in others if (theirs := e.true_of(k)) is not None]
    share, other = max(fits, default=(0.0, 0))
    if share < e.limits.measured.explained:
        return None
    return Evidence(
        share,
        f"what is logged here is the force of {e.rows.setting.names[other]} ({100 * share:.0f} % explained)",
    )


@symptom(
    "dropout",
    "motion",
    cause="the sensor or its message was lost, or the contact was not found",
    confirm="compare with the leg's torques: they carry on",
    cure="hold or flag lost samples; check the contact filter",
)
@compared
def dropout(e: Episode, true: FloatArray) -> Evidence | None:
    """Tell whether a foot that carries its true force, (m, 3) [N], reports nothing."""
    none = np.linalg.norm(e.force, axis=1) <= e.rows.setting.threshold
    carried = np.nan_to_num(true[:, 2]) > e.limits.measured.dropout_load * e.weight
    share = float((none & carried).mean())
    if share < e.limits.measured.dropout_share:
        return None
    text = f"zero where the leg carries {float(np.nanmean(true[:, 2])):.3g} N"
    return Evidence(e.limits.ranks.dropout, text)


@symptom(
    "frozen",
    "frozen",
    cause="the same sample again: a stale buffer or a driver that repeats",
    confirm="compare the message's own time stamp",
    cure="log the sensor's stamp, drop repeats",
)
def frozen(e: Episode) -> Evidence | None:
    """Tell whether the force does not change in the last digit."""
    if e.true is not None and not e.has("motion"):
        return None
    same, limits = (np.diff(e.force, axis=0) == 0.0).all(axis=1), e.limits.measured
    if not len(same) or same.mean() < limits.frozen_share:
        return None
    if float(np.median(e.gap)) > limits.frozen_gap or e.static:
        return None
    value = float(np.median(e.force[:, 2]))
    text = f"{value:.6g} N in {e.failed['frozen'].rows} rows, not one digit moves"
    return Evidence(e.limits.ranks.frozen, text)


@symptom(
    "clipped",
    "motion",
    cause="the sensor or its channel is at the end of its range",
    confirm="load the foot by hand beyond it",
    cure="a larger range; treat the limit as unknown, not as a value",
)
@compared
def clipped(e: Episode, true: FloatArray) -> Evidence | None:
    """Tell whether the force stops at a value that the true one, (m, 3) [N], exceeds."""
    limits, ranks = e.limits.measured, e.limits.ranks
    whole = e.rows.normal[:, e.column]
    top = float(whole.max())
    at = np.isclose(e.force[:, 2], top, rtol=1e-9)
    if top <= 0.0 or at.mean() < limits.clipped_share:
        return None
    if float(np.nanmin(true[at, 2] - top)) < -limits.clipped_below * e.weight:
        return None
    varies = (
        float(np.nanstd(true[at, 2])) > limits.flat * e.weight
    )  # which no scale makes the same to nine digits
    return Evidence(
        ranks.clipped if varies else ranks.clipped_flat,
        f"stays at {top:.4g} N in {100 * at.mean():.0f} % of the rows, none is higher",
    )


@symptom(
    "phantom force",
    "distance",
    "motion",
    cause="the sensor has an offset, or another foot's force got into this channel",
    confirm="lift the foot by hand: it should read zero",
    cure="zero the sensors in flight",
)
@compared
def phantom_force(e: Episode, true: FloatArray) -> Evidence | None:
    """Tell whether a sensor reports force in the air, where the true one, (m, 3) [N], is none."""
    limits = e.limits.measured
    air = e.gap > limits.phantom_gap
    none = np.linalg.norm(true, axis=1) < limits.unloaded * e.weight
    if (air & none).mean() < limits.phantom_air:
        return None
    text = f"{float(np.abs(e.force[air, 2]).max()):.3g} N while the leg carries nothing"
    return Evidence(e.limits.ranks.phantom_force, text)


@symptom(
    "joint stop",
    "motion",
    cause="a joint rests on its stop (the robot fell, or squats too deep), whose torque is not in the log",
    confirm="compare the joint's angle with its range",
    cure="keep away from the range's ends; log the constraint torques of the simulator",
)
def joint_stop(e: Episode) -> Evidence | None:
    """Tell whether a joint rests on its mechanical stop, whose torque no log has."""
    robot, limits = e.rows.setting.robot, e.limits.measured
    if robot is None:
        return None
    leg = robot.support[e.column][robot.base_dof :]
    q = np.asarray(e.rows.log["q"])[e.rows.core, 7:]
    low, high = robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]
    if q.shape[1] != len(leg):
        return None  # joints whose configuration has more numbers than their velocity
    beyond = ((q < low + limits.at_stop) | (q > high - limits.at_stop)) & leg
    share = float(beyond.any(axis=1).mean())
    if share < limits.stop_share:
        return None
    name = robot.joint_names[int(beyond.sum(axis=0).argmax())]
    text = f"{name} is at the end of its range in {100 * share:.0f} % of the rows"
    return Evidence(e.limits.ranks.joint_stop, text)


@symptom(
    "dead torque",
    "motion",
    cause="a motor or its current sensor is off: the log has zero where the leg needs torque",
    confirm="hold the joint by hand",
    cure="check the driver; log the applied torque",
)
def dead_torque(e: Episode) -> Evidence | None:
    """Tell whether one joint of the leg has no torque at all while the leg carries."""
    robot, log = e.rows.setting.robot, e.rows.log
    if robot is None or "torques" not in log or not e.has("motion"):
        return None
    leg = np.flatnonzero(robot.support[e.column][robot.base_dof :])
    torques = np.asarray(log["torques"])[e.rows.core][:, leg]
    dead = (torques == 0.0).mean(axis=0) > e.limits.measured.dead_share
    if dead.sum() != 1 or not (torques[:, ~dead] != 0.0).any():
        return None
    joint = robot.joint_names[int(leg[int(np.argmax(dead))])]
    return Evidence(e.limits.ranks.dead_torque, f"{joint} has no torque while the leg carries")


@symptom(
    "wrong torques",
    "motion",
    cause="joint torques are permuted, of the other sign, or not those that were applied",
    confirm="the power test tau . v = f . J v, joint by joint",
    cure="map joints by name; log the applied torque, not the commanded one",
)
def wrong_torques(e: Episode) -> Evidence | None:
    """Tell whether forces explain the body's motion, the joint torques do not."""
    rest = e.rows.unexplained
    if rest is None:
        return None
    body = np.linalg.norm(rest.force[e.rows.core], axis=1)
    if float(np.nanmean(body)) > e.limits.measured.torques_body * e.weight:
        return None
    text = "the forces add up to the body's motion, and this leg's torques ask for others"
    return Evidence(e.limits.ranks.wrong_torques, text)


@symptom(
    "unexplained motion",
    "motion",
    cause="a measurement of this leg is wrong: force, torque or joints",
    confirm="stand still and compare J^T f with the torques",
    cure="check units, order and time of the channels of this leg",
)
def unexplained_motion(e: Episode) -> Evidence | None:
    """Tell whether forces and motion do not belong together."""
    text = f"{e.failed['motion'].value:.3g} N of this foot's force are unaccounted for"
    return Evidence(e.limits.ranks.unexplained_motion, text)
