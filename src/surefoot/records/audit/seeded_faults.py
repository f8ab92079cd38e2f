"""Seeded faults: ways to spoil a clean log, each with the symptom that an audit should report.

For whoever tests a detector, ours included. A fault takes a log, a seeded generator and its amplitude; it
returns what it made, or None where the run does not suit it (a foot that should fly never does). Amplitudes
are those of the table and of docs/reports/audit.md.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from surefoot.base.arrays import FloatArray, of_kind, whole_number
from surefoot.base.errors import ProblemError, check_name
from surefoot.base.spatial import GRAVITY, rotation_about
from surefoot.mechanics import load_robot, surface_frames
from surefoot.records.audit import fault_injection as spoiling
from surefoot.records.audit.fault_injection import (
    FaultyLog,
    LogCopy,
    Spoil,
    everywhere,
    on_stance,
    on_swing,
)
from surefoot.records.log import Log


@dataclass(frozen=True)
class LogFault:
    """A way to spoil a log.

    Attributes
    ----------
    name, title
        Key, and one line for the table.
    amplitude, unit
        How much.
    symptom
        What an audit should report first; empty for a fault of the log itself, which must not be lawful.
    spoil
        From a copy of a log and the amplitude to the spoilt log, or None.
    """

    name: str
    title: str
    amplitude: float
    unit: str
    symptom: str
    spoil: Spoil

    def apply(self, log: Log, seed: int) -> FaultyLog | None:
        """Return the spoilt log, or None where the run does not suit the fault."""
        spoilt = self.spoil(LogCopy(log, np.random.default_rng([seed, len(self.name)])), self.amplitude)
        return spoilt and replace(spoilt, fault=self.name, symptom=self.symptom)


def seeded_faults(log: Log, *kinds: str, seed: int = 0) -> Iterator[FaultyLog]:
    """Yield copies of a clean log with one fault in each, for testing what should find it.

    Parameters
    ----------
    log
        A lawful run, as `sf.run` returns it. It is not changed.
    kinds
        Names of docs/reports/audit.md, such as "pull" or "delay"; all of them if none is given. One that does
        not suit the run is left out: no foot of a robot that stands can push while it flies.
    seed
        Of the faults' feet, times and directions.

    Raises
    ------
    ProblemError
        For an unknown kind, and for a log that is no run of a robot on point feet, or shorter than 0.5 s.
    """
    of_kind("log", log, Log)
    by_name = {fault.name: fault for fault in LOG_FAULTS}
    for name in kinds:
        check_name("fault", name, by_name)
    for name in kinds or by_name:
        try:
            spoilt = by_name[name].apply(log, whole_number("seed", seed))
        except KeyError as lacks:
            raise ProblemError(f"the fault {name} needs the channel {lacks}, which the log lacks") from lacks
        if spoilt is not None:
            yield spoilt


def _pull(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    c.arrays["forces"][part, foot, 2] = -amplitude * c.weight


def _direction(c: LogCopy, foot: int, part: slice) -> FloatArray:
    f = c.arrays["forces"][part, foot, :2]
    size = np.linalg.norm(f, axis=1, keepdims=True)
    return np.where(size > 1e-9, f / np.maximum(size, 1e-9), [1.0, 0.0])


def _overload(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    f = c.arrays["forces"]
    f[part, foot, :2] = (
        _direction(c, foot, part) * (amplitude * c.arrays["mu"][part] * f[part, foot, 2])[:, None]
    )


def _corner(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    f, signs = c.arrays["forces"], c.rng.choice([-1.0, 1.0], 2)
    f[part, foot, :2] = signs * (amplitude * c.arrays["mu"][part] * f[part, foot, 2])[:, None]


def _lean(c: LogCopy, degrees: float) -> FloatArray:
    """Return a turn about a random axis in the ground."""
    axis = np.append(c.rng.normal(size=2), 0.0)
    return rotation_about(axis / np.linalg.norm(axis), np.radians(degrees))


def _turn(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    c.arrays["forces"][part, foot] = c.arrays["forces"][part, foot] @ _lean(c, amplitude).T


def _mirror(c: LogCopy, amplitude: float) -> FaultyLog | None:
    side = np.abs(c.arrays["forces"][..., 1]).max(axis=0)
    if (side < 0.04 * c.weight).any():
        return None  # hardly any force across: its sign does not matter
    c.arrays["forces"][..., 1] *= -1.0
    return c.whole()


def _reverse(c: LogCopy, foot: slice, part: slice, amplitude: float) -> None:
    c.arrays["forces"] *= -1.0


def _air_friction(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    c.arrays["forces"][part, foot, :2] += amplitude * c.weight * np.array([0.8, 0.6])


def _phantom(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    c.arrays["forces"][part, foot, 2] += amplitude * c.weight


def _raise(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    c.arrays["gaps"][part, foot] += amplitude


def _lower(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    c.arrays["gaps"][part, foot] -= amplitude


def _throw(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    count = part.stop - part.start
    c.arrays["gaps"][part, foot] -= amplitude * np.linspace(1.0, 0.2, count)
    c.arrays["contact_velocities"][part, foot, 2] += 0.8 * amplitude / (count * c.dt) + 0.1


def _on_off(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    half = max(1, round(0.5 / (amplitude * c.dt)))
    on = (np.arange(part.stop - part.start) // half) % 2
    c.arrays["forces"][part, foot] *= 2.0 * on[:, None]


def _skate(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    _on_off(c, foot, part, 100.0)
    c.arrays["contact_velocities"][part, foot, 0] += amplitude


def _blow(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    row = (part.start + part.stop) // 2
    c.arrays["forces"][row, foot, 2] += amplitude * c.weight


def _silence(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    c.arrays["forces"][part, foot] = 0.0


def _silence_all(c: LogCopy, amplitude: float) -> FaultyLog:
    need = round(amplitude / c.dt)
    start = int(c.rng.integers(50, c.rows - need - 50))
    part = slice(start, start + need)
    c.arrays["forces"][part] = 0.0
    return c.faulty_log("body", part)


def _levitate(c: LogCopy, amplitude: float) -> FaultyLog | None:
    spoilt = _silence_all(c, 0.2)
    rows = slice(round(spoilt.start / c.dt), round(spoilt.end / c.dt))
    gaps = spoilt.log.arrays["gaps"]
    gaps[rows] = np.maximum(gaps[rows], 0.0) + amplitude
    return spoilt


def _freeze(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    c.arrays["forces"][part, foot] = c.arrays["forces"][part.start, foot] * amplitude


def _clip(c: LogCopy, amplitude: float) -> FaultyLog | None:
    at = c.stance(amplitude + 0.08)
    if at is None:
        return None
    foot, f = at[0], c.arrays["forces"]
    top = amplitude * c.weight
    f[:, foot, 2] = np.minimum(f[:, foot, 2], top)
    return c.faulty_log(c.feet[foot], at[1])


def _scale(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    c.arrays["forces"][part, foot] *= amplitude


def _offset(c: LogCopy, amplitude: float) -> FaultyLog | None:
    if not ((c.normal == 0.0).mean(axis=0) > 0.2).all():
        return None  # in a stand an offset and a gain are one
    foot = int(c.rng.integers(len(c.feet)))
    c.arrays["forces"][:, foot] += amplitude * c.weight * np.array([0.3, 0.2, 0.93])
    return c.whole(c.feet[foot])


def _delay(c: LogCopy, amplitude: float) -> FaultyLog | None:
    if not ((c.normal == 0.0).mean(axis=0) > 0.2).all():
        return None  # nothing changes in a stand
    rows = round(amplitude / c.dt)
    c.arrays["forces"] = np.concatenate([c.arrays["forces"][:1].repeat(rows, 0), c.arrays["forces"][:-rows]])
    return c.whole()


def _swap(c: LogCopy, amplitude: float) -> FaultyLog | None:
    order = np.arange(len(c.feet))
    a, b = c.rng.choice(len(order), 2, replace=False).tolist()
    if np.abs(c.normal[:, a] - c.normal[:, b]).mean() < 0.1 * c.weight:
        return None  # both carry the same: nothing to see
    order[[a, b]] = order[[b, a]]
    c.arrays["forces"] = c.arrays["forces"][:, order]
    return c.whole(c.feet[a])


def _hide_push(c: LogCopy, amplitude: float) -> FaultyLog | None:
    rows = np.flatnonzero(np.linalg.norm(c.arrays["push"], axis=1) > amplitude * c.weight)
    if not rows.size:
        return None
    c.arrays["push"][:] = 0.0
    return c.faulty_log("body", slice(int(rows[0]), int(rows[-1]) + 1))


def _mass(c: LogCopy, foot: slice, part: slice, amplitude: float) -> None:
    c.facts["mass"] = float(c.facts["mass"]) * amplitude


def _drive(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    v, f, d = c.arrays["contact_velocities"], c.arrays["forces"], _direction(c, foot, part)
    v[part, foot, :2] = amplitude * d
    side = np.maximum(
        np.linalg.norm(f[part, foot, :2], axis=1), 0.3 * c.arrays["mu"][part] * f[part, foot, 2]
    )
    f[part, foot, :2] = d * side[:, None]


def _glide(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    d = _direction(c, foot, part)
    c.arrays["contact_velocities"][part, foot, :2] = amplitude * np.column_stack([-d[:, 1], d[:, 0]])


def _diagonal(c: LogCopy, amplitude: float) -> FaultyLog | None:
    if len(c.feet) != 4 or not (c.normal > 0.15 * c.weight).all():
        return None  # only while all four stand
    change = np.zeros(c.arrays["forces"].shape)
    change[..., 2] = 0.25 * amplitude * c.weight * np.array([1.0, -1.0, -1.0, 1.0])
    forces = c.arrays["forces"] = c.arrays["forces"] + change
    if (np.hypot(forces[..., 0], forces[..., 1]) > c.arrays["mu"][:, None] * forces[..., 2]).any():
        return None  # the lightened feet would slip
    shift_support(c, change)
    return c.whole()


def shift_support(c: LogCopy, change: FloatArray) -> None:
    """Let the joint torques carry a change of the forces (T, p, 3), contact frames."""
    import pinocchio

    robot = load_robot(str(c.facts["robot"]))
    data, frames = robot.model.createData(), np.empty((len(c.feet), 3, 3))
    for k in range(c.rows):
        surface_frames(np.ascontiguousarray(c.arrays["normals"][k]), frames)
        world = np.einsum("pij,pj->pi", frames, change[k])
        J = np.array(pinocchio.computeJointJacobians(robot.model, data, c.arrays["q"][k]))
        for p, force in enumerate(world):
            wrench = np.concatenate([force, np.cross(c.arrays["contact_positions"][k, p], force)])
            torque = np.where(robot.contact_points.support[p], wrench @ J, 0.0)
            c.arrays["torques"][k] -= torque[robot.base_dof :]


def _permute_torques(c: LogCopy, amplitude: float) -> FaultyLog | None:
    c.arrays["torques"] = c.arrays["torques"][:, np.roll(c.legs, 1, axis=1).ravel()]
    return c.whole()


LOG_FAULTS: tuple[LogFault, ...] = (
    LogFault("pull", "the ground pulls a standing foot", 0.1, "m g", "pull", on_stance(_pull)),
    LogFault("reversed", "force on the ground logged", 1.0, "", "reversed", everywhere(_reverse)),
    LogFault(
        "friction", "a foot uses more than its cone", 1.3, "mu", "too much friction", on_stance(_overload)
    ),
    LogFault(
        "pyramid", "a foot in the corner of a pyramid of four", 1.0, "mu", "coarse facets", on_stance(_corner)
    ),
    LogFault("normal", "contact frame of a foot tilted", 20.0, "deg", "wrong frame", on_stance(_turn)),
    LogFault("frame", "all forces in another frame", 35.0, "deg", "wrong frame", everywhere(_turn)),
    LogFault("mirror", "left-handed contact frames", 1.0, "", "mirrored", _mirror),
    LogFault("air", "friction on a flying foot", 0.05, "m g", "friction in the air", on_swing(_air_friction)),
    LogFault("phantom", "normal force on a flying foot", 0.1, "m g", "phantom force", on_swing(_phantom)),
    LogFault(
        "invisible", "a foot carried above the ground", 0.01, "m", "invisible geometry", on_stance(_raise)
    ),
    LogFault("sink", "a foot sinks in", 8e-3, "m", "sinking", on_stance(_lower)),
    LogFault(
        "thrown", "a foot thrown out of the ground", 8e-3, "m", "push off penetration", on_stance(_throw)
    ),
    LogFault("chatter", "force on and off", 100.0, "Hz", "chatter", on_stance(_on_off)),
    LogFault("skate", "chatter that travels", 0.2, "m/s", "skating", on_stance(_skate)),
    LogFault("blow", "force of one row", 5.0, "m g", "one step impulse", on_stance(_blow)),
    LogFault("dropout", "a standing foot reports nothing", 1.0, "", "dropout", on_stance(_silence, 0.15)),
    LogFault("no-forces", "no foot reports anything", 0.2, "s", "no forces", _silence_all),
    LogFault("levitation", "held up with all feet in the air", 0.05, "m", "infeasible", _levitate),
    LogFault("frozen", "one sample again and again", 0.7, "of it", "frozen", on_stance(_freeze, 0.25)),
    LogFault("clipped", "sensors at the end of their range", 0.3, "m g", "clipped", _clip),
    LogFault("gain", "one foot with a wrong gain", 1.5, "", "wrong scale", on_stance(_scale, 0.2)),
    LogFault("unit", "all forces in kgf", 1.0 / GRAVITY, "", "wrong scale", everywhere(_scale)),
    LogFault("offset", "a sensor with an offset", 0.1, "m g", "bias", _offset),
    LogFault("delay", "forces come late", 0.02, "s", "delayed", _delay),
    LogFault("swap", "two feet exchanged", 1.0, "", "swapped feet", _swap),
    LogFault("push", "a push that is not in the log", 0.1, "m g", "outside force", _hide_push),
    LogFault("mass", "the log tells another mass", 1.2, "", "wrong mass", everywhere(_mass, "body")),
    LogFault("drive", "friction along the slip", 0.2, "m/s", "friction drives", on_stance(_drive)),
    LogFault(
        "glide",
        "a loaded foot slides across its friction",
        0.15,
        "m/s",
        "frictionless slide",
        on_stance(_glide),
    ),
    LogFault("diagonal", "one diagonal of feet favoured", 0.5, "m g", "solver asymmetry", _diagonal),
    LogFault("torques", "joint torques in another order", 1.0, "", "wrong torques", _permute_torques),
    LogFault("teleport", "the base jumps aside", 0.02, "m", "teleport", spoiling.teleport),
    LogFault("encoder", "a joint's angle jumps", 0.3, "rad", "teleport", spoiling.encoder_jump),
    LogFault("stopped", "velocities are zero", 0.2, "s", "other velocities", spoiling.no_velocities),
    LogFault("kick", "the base's velocity jumps", 0.3, "m/s", "velocity jump", spoiling.velocity_jump),
    LogFault("held", "rows held", 0.06, "s", "held rows", spoiling.held_rows),
    LogFault("motor", "a knee without torque", 1.0, "", "dead torque", on_stance(spoiling.dead_torque)),
    LogFault("tilt", "all forces in a frame a little off", 10.0, "deg", "wrong frame", everywhere(_turn)),
    LogFault("nan", "numbers that are none", 1.0, "", "", on_stance(spoiling.not_finite)),
    LogFault("twice", "a time stamp twice", 1.0, "row", "", spoiling.clock(spoiling.twice)),
    LogFault("backward", "a clock set back", 0.05, "s", "", spoiling.clock(spoiling.back)),
    LogFault("lost", "rows lost", 0.1, "s", "", spoiling.clock(spoiling.gap_in_time)),
)
"""Every kind of fault, with its amplitude."""
