"""From somebody's fields to a log: one clock, Surefoot's units, frames and orders."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.errors import ProblemError, shown
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.records.log.channels import CHANNELS, size_of
from surefoot.records.log.log import Log
from surefoot.records.log.mapping import (
    LogMapping,
    Take,
    mapping_from_yaml,
    read_mapping,
    unit_factor,
    with_rate,
)
from surefoot.records.log.mapping_guess import guess_mapping
from surefoot.records.log.plausibility import find_doubts
from surefoot.records.log.source import Source

LATEST = 1e30
"""A stamp beyond this is none [s]; nanoseconds taken for seconds are far below."""
HELD = 1.5
"""A topic slower than the clock by more than this factor is reported as held."""


def log_from_source(
    source: Source, mapping: LogMapping | Path | str | None = None, name: str = "", rate: float | None = None
) -> Log:
    """Return the log of a source: what the mapping takes of it, in Surefoot's units, frames and orders.

    Parameters
    ----------
    source
        Topics and fields.
    mapping
        Or the path of its YAML file; None for the source's own, or a guess.
    name
        What the source is called in the fact ``source``.
    rate
        Of the rows of a table without stamps [Hz]; None for what the mapping says.

    Raises
    ------
    ProblemError
        If a field is missing, has not as many numbers as its channel, or no channel could be guessed.
    """
    if mapping is None:
        own = mapping_from_yaml(source.mapping, name) if source.mapping else None
        mapping = guess_mapping(source) if own is None else own
    elif not isinstance(mapping, LogMapping):
        mapping = read_mapping(mapping)
    mapping = with_rate(mapping, rate)
    build = _Build(source, mapping)
    arrays = build.arrays()
    if source.mapping:  # one of ours: as it was
        return Log(arrays, dict(mapping.facts), channels=dict(mapping.define))
    single = {
        k: v for k, v in source.facts.items() if k != "mu" or not {"mu", "contact_friction"} & set(arrays)
    }
    facts = {
        "source": name, **build.facts(arrays), "mapping": mapping.as_yaml(), **single, **mapping.facts,
    }  # fmt: skip
    take_friction(facts, arrays)
    log = Log(arrays, facts, channels=dict(mapping.define))
    doubts = [*source.notes, *build.doubts, *find_doubts(log)]
    if mapping.guessed:
        doubts.insert(0, f"the mapping was guessed ({', '.join(mapping.channels)}): look at the fact mapping")
    log.facts["doubts"] = doubts
    return log


def take_friction(facts: dict[str, Any], fields: dict[str, Any]) -> None:
    """Make the fact ``mu`` what logs call it: the channel of the ground, or of each contact, at every row.

    Raises
    ------
    ProblemError
        For friction that an array tells, too, or that is neither one number nor one a contact.
    """
    if "mu" not in facts:
        return
    if {"mu", "contact_friction"} & set(fields):
        raise ProblemError("mu is given as an array and as a fact: give one of them")
    rows = len(next(iter(fields.values()), ()))
    given = np.asarray(facts.pop("mu"))
    if given.dtype.kind not in "biuf":
        raise ProblemError(f"the fact mu must hold real numbers, got {shown(given.tolist())}")
    forces = fields.get("forces")
    points = forces.shape[1] if forces is not None and forces.ndim == 3 else 0
    if given.ndim > 1 or (given.ndim == 1 and len(given) != points):
        wanted = f"a number or one for each of {points} contacts"
        raise ProblemError(f"the fact mu must be {wanted}, got the shape {given.shape}")
    if given.ndim:
        fields["contact_friction"] = np.tile(given.astype(np.float64), (rows, 1))
    else:
        fields["mu"] = np.full(rows, float(given))


class _Build:
    """The channels of one source under one mapping."""

    def __init__(self, source: Source, mapping: LogMapping) -> None:
        self.source, self.mapping = source, mapping
        self.doubts: list[str] = []
        self.known = {**CHANNELS, **mapping.define}
        self.joints = mapping.joints
        self.taken = {name: self._take(name, take) for name, take in mapping.channels.items()}
        if mapping.guessed:
            self._leave_out_other_joints()
        self.time, self._rows = self._clock()

    def arrays(self) -> dict[str, Any]:
        """Return the channels, all on one clock, frames and quaternions turned."""
        out: dict[str, Any] = {"time": self.time}
        for name, taken in self.taken.items():
            if name != "time":
                out[name] = self._shape_rows(
                    name, np.hstack([numbers[self._rows[topic]] for topic, numbers in taken])
                )
        for name, take in self.mapping.channels.items():
            if take.quaternion == "wxyz":
                out[name] = _wxyz_to_xyzw(name, out[name])
        for name, take in self.mapping.channels.items():
            own = self.known[name].frame
            if take.frame and take.frame != own:
                out[name] = self._in_channel_axes(name, out[name], take.frame, out)
        if not self.source.mapping:
            _compose(out)
        return out

    def facts(self, arrays: dict[str, Any]) -> dict[str, Any]:
        """Return what the source tells about the run."""
        out: dict[str, Any] = {}
        steps = np.diff(arrays["time"])
        steps = steps[steps > 0.0]
        if steps.size:
            out["dt"] = float(np.median(steps))
        if math.isfinite(self.source.start):
            out["start"] = self.source.start
        points = arrays["forces"].shape[1] if "forces" in arrays else 0
        if self.mapping.feet:
            out["feet"] = list(self.mapping.feet)
            if points == len(self.mapping.feet):
                out["contact_foot"] = list(range(points))
        if self.joints:
            out["joints"] = list(self.joints)
        return out

    def _take(self, name: str, take: Take) -> list[tuple[str, FloatArray]]:
        """Return a channel's numbers in its own unit as they came, each field's with its topic."""
        fields = take.expanded(self.mapping.feet, self.mapping.joints)
        if not fields:
            raise ProblemError(f"channel {name} is taken from no field")
        found = [self.source.find(f) for f in fields]
        topics = {topic for topic, _ in found}
        if self.known[name].shape == ("joints",) and len(topics) == 1:
            topic, values = found[0][0], np.hstack([numbers for _, numbers in found])
            found = [(topic, self._pick_joints(topic, values))]
        factor = take.scale * unit_factor(take.unit, self.known[name])
        return [(topic, numbers * factor) for topic, numbers in found]

    def _pick_joints(self, topic: str, values: FloatArray) -> FloatArray:
        """Return the numbers of the joints in the log's order, by the names that the messages bring."""
        names = next((t for t in self.source.topics[topic].texts.values() if len(t) == values.shape[1]), ())
        if len(names) < 2:
            if told := self.source.topics[topic].texts.get("name", ()):
                doubt = (
                    f"{topic} names {len(told)} joints for {values.shape[1]} numbers: its names are not used"
                )
                self.doubts += [doubt] if doubt not in self.doubts else []
            return values
        if len(set(names)) < len(names):
            raise ProblemError(f"{topic} names a joint twice: {', '.join(names)}")
        self.joints = self.joints or names
        missing = [j for j in self.joints if j not in names]
        if missing:
            raise ProblemError(f"{topic} has no joint {missing[0]!r}; it has: {', '.join(names)}")
        return values[:, [names.index(j) for j in self.joints]]

    def _leave_out_other_joints(self) -> None:
        """Drop what a guess took of other joints than those of the angles: numbers, and names."""
        counts = {
            name: sum(numbers.shape[1] for _, numbers in taken)
            for name, taken in self.taken.items()
            if self.known[name].shape == ("joints",)
        }
        wanted = counts.get("joint_positions", 0)
        for name in [name for name, count in counts.items() if wanted and count != wanted]:
            self.doubts.append(f"{name}: {counts[name]} numbers for {wanted} joints, left out")
            del self.taken[name]
        if wanted and len(self.joints) != wanted:
            self.joints = ()

    def _times(self, topic: str) -> FloatArray:
        times = self.source.topics[topic].times
        if times is None:
            raise ProblemError(
                "the mapping must say which column is the time: time: NAME; or the rate of the rows where "
                "none is: time: {rate: 500}, rate=500 or --rate 500"
            )
        return times

    def _clock(self) -> tuple[FloatArray, dict[str, Any]]:
        """Return the times of the rows and which message of every topic is in force at each."""
        topics = dict.fromkeys(t for n, taken in self.taken.items() if n != "time" for t, _ in taken)
        if not topics:
            raise ProblemError("the mapping takes no channel")
        if "time" in self.taken:
            clock, values = self.taken["time"][0][0], np.hstack([v for _, v in self.taken["time"]])
            if values.shape[1] != 1:
                raise ProblemError(f"the time is one number per row, got {values.shape[1]}")
            time = values[:, 0]
        elif self.mapping.rate:
            clock = next(iter(topics))
            if len(topics) > 1 or self.source.topics[clock].times is not None:
                raise ProblemError("a rate is for a table without stamps: messages bring their own")
            count = len(next(iter(self.source.topics[clock].fields.values())))
            time = np.arange(count) / self.mapping.rate
        else:
            clock = max(topics, key=lambda t: len(self._times(t)))
            time = self._times(clock)
        if not len(time):
            raise ProblemError("the file has no rows")
        usable = np.abs(time) < LATEST  # false for NaN
        if not usable.all():
            raise ProblemError(f"the time stamp of row {int(np.argmin(usable))} is no finite number")
        rows: dict[str, Any] = {clock: np.arange(len(time))}
        good = np.ones(len(time), dtype=bool)
        for topic in topics:
            if topic != clock:
                rows[topic], bad = self._latest_messages(topic, clock)
                good &= ~bad
        if not good.any():
            raise ProblemError(f"the topics {', '.join(rows)} have no time in common")
        return time[good], {topic: at[good] for topic, at in rows.items()}

    def _latest_messages(self, topic: str, clock: str) -> tuple[Any, BoolArray]:
        """Return the message of a topic that is in force at each row, and the rows where none is."""
        times, at = self._times(topic), self._times(clock)
        if len(times) == len(at) and np.array_equal(times, at):
            return np.arange(len(at)), np.zeros(len(at), dtype=bool)
        order = np.argsort(times, kind="stable")
        place = np.searchsorted(times[order], at, side="right") - 1  # the last message not after each row
        period = (times.max() - times.min()) / max(len(times) - 1, 1)
        own = (at.max() - at.min()) / max(len(at) - 1, 1)
        if period > HELD * own:
            self.doubts.append(
                f"{topic} comes every {1e3 * period:.3g} ms and is held for rows every {1e3 * own:.3g} ms"
            )
        return order[np.maximum(place, 0)], (place < 0) | (at > times.max() + 2.0 * period)

    def _shape_rows(self, name: str, values: FloatArray) -> Any:
        """Return a channel's rows in its shape."""
        channel = self.known[name]
        sizes = {"n": len(self.mapping.feet), "joints": len(self.joints)}
        wanted = [size_of(size, {k: v for k, v in sizes.items() if v}) for size in channel.shape]
        free = wanted.count(None)
        known = math.prod(w for w in wanted if w is not None)
        count = values.shape[1]
        if (count != known) if free == 0 else (count % max(known, 1) or count == 0):
            shape = ", ".join(str(s if w is None else w) for s, w in zip(channel.shape, wanted, strict=True))
            raise ProblemError(f"channel {name} has the row shape ({shape}), its fields give {count} numbers")
        if free > 1:
            raise ProblemError(f"channel {name} cannot be made of a flat row")
        shaped = values.reshape(len(values), *(-1 if w is None else w for w in wanted))
        if channel.flag:
            if not np.isin(shaped, (0.0, 1.0)).all():
                raise ProblemError(f"channel {name} must hold true and false")
            return shaped.astype(bool)
        return shaped

    def _in_channel_axes(
        self, name: str, values: FloatArray, frame: str, arrays: dict[str, Any]
    ) -> FloatArray:
        """Return vectors in the axes of their channel."""
        own = self.known[name].frame
        if name == "v":
            return _base_linear(values, frame, arrays)
        if values.ndim < 2 or values.shape[-1] != 3 or name == "q":
            raise ProblemError(f"channel {name} cannot be turned from {frame} axes")
        if frame == "contact":
            raise ProblemError(
                f"channel {name} is in {own} axes and cannot be turned from those of the contacts"
            )
        if own == "contact":
            self.doubts.append(f"{name}: contact axes are taken to be the world's, as on level ground")
            own = "world"
        if frame == own:
            return values
        quaternion = arrays.get("base_orientation")
        if quaternion is None:
            raise ProblemError(f"channel {name} in {frame} axes needs the channel base_orientation")
        R = _rotations(quaternion)
        equation = "tij,t...j->t...i" if frame == "base" else "tji,t...j->t...i"
        return np.asarray(np.einsum(equation, R, values))


def _base_linear(v: FloatArray, frame: str, arrays: dict[str, Any]) -> FloatArray:
    """Return velocities whose linear part was in world axes, as MuJoCo's qvel, in base axes."""
    if frame != "world" or "q" not in arrays or arrays["q"].shape[1] < 7 or v.shape[1] < 6:
        raise ProblemError("channel v in world axes (of its linear part) needs q with a floating base")
    linear = np.einsum("tji,tj->ti", _rotations(arrays["q"][:, 3:7]), v[:, :3])
    return np.hstack([linear, v[:, 3:]])


def _rotations(quaternion: FloatArray) -> FloatArray:
    """Return rotations (T, 3, 3), NaN where a quaternion is none."""
    norm = np.linalg.norm(quaternion, axis=1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(rotation_from_quaternion(np.where(norm > 0.0, quaternion / norm, np.nan)))


def _wxyz_to_xyzw(name: str, values: FloatArray) -> FloatArray:
    """Return an orientation, or a configuration with a floating base, with x, y, z, w."""
    first = {"base_orientation": 0, "q": 3}.get(name)
    if first is None or values.shape[1] < first + 4:
        raise ProblemError(f"channel {name} holds no quaternion")
    out = values.copy()
    out[:, first : first + 4] = values[:, [first + 1, first + 2, first + 3, first]]
    return out


def _compose(arrays: dict[str, Any]) -> None:
    """Add q and v where all their parts are there."""
    parts = ("base_position", "base_orientation", "joint_positions")
    if "q" not in arrays and all(name in arrays for name in parts):
        arrays["q"] = np.hstack([arrays[name] for name in parts])
    rates = ("base_velocity", "base_angular_velocity", "joint_velocities", "base_orientation")
    if "v" not in arrays and all(name in arrays for name in rates):
        linear = np.einsum("tji,tj->ti", _rotations(arrays["base_orientation"]), arrays["base_velocity"])
        arrays["v"] = np.hstack([linear, arrays["base_angular_velocity"], arrays["joint_velocities"]])
