"""What a policy's numbers mean: joints, gains, actions and observations, and the YAML that says so.

The keys of a description, ours or read from a publisher's (`policy.publishers`), are `KEYS`. What
stands for joints is a number, a list in the policy's order, or a table of patterns of joint names, the last
that fits counts.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array, real_array, real_number, whole_number
from surefoot.base.errors import ProblemError, check_name
from surefoot.base.text_files import table_of
from surefoot.mechanics import Robot
from surefoot.motion.policy.observation_terms import ALIASES, KINDS

REQUIRED = ("joints", "default", "stiffness", "damping", "action_scale", "observations")
"""Without these a network cannot be used."""
OPTIONAL: dict[str, Any] = {
    "rate": 50.0, "action_clip": None, "action_offset": None, "target_clip": None, "observation_clip": None,
    "history": None, "command_range": None, "others": None,
}  # fmt: skip
KEYS = ("convention", *REQUIRED, *OPTIONAL)
SLACK = 0.05
"""A default pose may be this far outside a joint's range [rad]."""
OTHERS = {"stiffness": 300.0, "damping": 5.0}
"""Gains that hold joints which the policy does not move [N m/rad, N m s/rad]."""
HISTORY = {"length": 1, "order": "oldest", "by": "term", "start": "repeat"}


@dataclass(frozen=True, eq=False)
class Term:
    """One term of an observation.

    Attributes
    ----------
    name
        A kind of `surefoot.motion.policy.observation_terms.KINDS`, or a function of the user's.
    scale
        Of its numbers: one, or one for each.
    clip
        (low, high) of its numbers, before the scale; None for none.
    history
        How many of its last values the network is given.
    settings
        Its kind's own.
    """

    name: str
    scale: FloatArray
    clip: tuple[float, float] | None
    history: int
    settings: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class PolicySpec:
    """What a policy's numbers mean; k joints in the policy's order.

    Attributes
    ----------
    joints
        Names of the joints that it moves.
    default, stiffness, damping
        (k,) pose from which it counts [rad], kp [N m/rad], kd [N m s/rad].
    action_scale, action_offset
        (k,) target = offset + scale * action [rad].
    action_clip, target_clip
        (2, k) least and largest actions and targets [rad].
    observations
        Its terms in order.
    observation_clip
        Largest size of an observed number, after its scale.
    order, by, start
        Histories "newest" or "oldest" first; "term" after term or "time" after time; they begin with the
        first value, "repeat", or with "zeros".
    rate
        Steps of the policy in a second [1/s].
    command_range
        (2, 3) commands that it was trained for: forward, left [m/s], yaw rate [rad/s].
    others
        kp and kd of joints that it does not move.
    """

    joints: tuple[str, ...]
    default: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    action_scale: FloatArray
    action_offset: FloatArray
    action_clip: FloatArray
    target_clip: FloatArray
    observations: tuple[Term, ...]
    observation_clip: float
    order: str
    by: str
    start: str
    rate: float
    command_range: FloatArray
    others: Mapping[str, float]

    @staticmethod
    def of(table: Mapping[str, Any], robot: Robot, functions: Sequence[str] = ()) -> PolicySpec:
        """Return what a table with the keys `KEYS` says for a robot.

        Parameters
        ----------
        table
            See the module.
        robot
            Whose joints are meant.
        functions
            Names of terms that are functions of the user's.

        Raises
        ------
        ProblemError
            Naming what is missing, unknown, of the wrong size, or a joint that the robot does not have or
            that cannot be where its default is.
        """
        table_of("the policy", dict(table), KEYS)
        absent = missing(table)
        if absent:
            raise ProblemError(f"the policy's description lacks {', '.join(absent)}")
        says = {**OPTIONAL, **table}
        joints = tuple(says["joints"])
        for name in joints:
            check_name("joint", name, robot.joint_names, f"of the policy for {robot.name}")
        if len(set(joints)) < len(joints):
            twice = next(name for name in joints if joints.count(name) > 1)
            raise ProblemError(f"the policy's joints name {twice} twice")
        default, stiffness, damping, scale = (
            per_joint(key, says[key], joints) for key in ("default", "stiffness", "damping", "action_scale")
        )
        _check_range(robot, joints, default)
        offset, history = says["action_offset"], {**HISTORY, **(says["history"] or {})}
        for key, valid in (
            ("order", ("newest", "oldest")),
            ("by", ("term", "time")),
            ("start", ("repeat", "zeros")),
        ):
            check_name(key, history[key], valid, "history")
        table_of("history", history, tuple(HISTORY))
        terms = tuple(_term(one, int(history["length"]), functions, robot) for one in says["observations"])
        if history["by"] == "time" and len({term.history for term in terms}) > 1:
            raise ProblemError("history by time: every term needs the same length")
        clip = says["observation_clip"]
        return PolicySpec(
            joints, default, stiffness, damping, scale,
            default if offset is None else per_joint("action_offset", offset, joints),
            _bounds("action_clip", says["action_clip"], joints),
            _bounds("target_clip", says["target_clip"], joints), terms,
            np.inf if clip is None else real_number("observation_clip", clip, low=0.0),
            history["order"], history["by"], history["start"],
            real_number("rate", says["rate"], low=1.0, high=2000.0),
            _command_range(says["command_range"]),
            {**OTHERS, **table_of("others", says["others"] or {}, tuple(OTHERS))},
        )  # fmt: skip


def missing(table: Mapping[str, Any]) -> list[str]:
    """Return the keys that a description still needs."""
    return [key for key in REQUIRED if table.get(key) is None]


def per_joint(key: str, value: Any, joints: Sequence[str]) -> FloatArray:
    """Return (k,) values for joints: of a number, a list, or a table of patterns of names.

    >>> per_joint("default", {".*": 0.8, ".*calf.*": -1.5}, ("FL_thigh_joint", "FL_calf_joint"))
    array([ 0.8, -1.5])
    """
    if isinstance(value, Mapping):
        found = []
        for name in joints:
            fits = [v for pattern, v in value.items() if re.fullmatch(str(pattern), name)]
            if not fits:
                raise ProblemError(f"{key} has no entry for the joint {name}")
            found.append(fits[-1])
        value = found
    array = finite_array(key, value)
    if array.ndim == 0:
        return np.full(len(joints), float(array))
    if array.shape != (len(joints),):
        raise ProblemError(f"{key} has {array.size} values for {len(joints)} joints: {', '.join(joints)}")
    return array


def _bounds(key: str, value: Any, joints: Sequence[str]) -> FloatArray:
    """Return (2, k) bounds: of None, a number, or a list of low and high."""
    if value is None:
        return np.outer([-np.inf, np.inf], np.ones(len(joints)))
    low, high = value if isinstance(value, (list, tuple)) and len(value) == 2 else (-abs(value), value)
    return np.array([per_joint(key, low, joints), per_joint(key, high, joints)])


def _check_range(robot: Robot, joints: Sequence[str], default: FloatArray) -> None:
    """Refuse a default pose that joints cannot have: its numbers, or the joints, stand in another order."""
    at = [robot.joint_names.index(name) for name in joints]
    first = robot.model.nq - robot.joints
    low, high = (x[first:][at] for x in (robot.model.lowerPositionLimit, robot.model.upperPositionLimit))
    outside = np.flatnonzero((default < low - SLACK) | (default > high + SLACK))
    if len(outside):
        k = int(outside[0])
        raise ProblemError(
            f"the default of {joints[k]} is {default[k]:g} rad, its range on {robot.name} {low[k]:.3g} to "
            f"{high[k]:.3g}: is the order of the policy's joints another?"
        )


def _term(entry: Any, length: int, functions: Sequence[str], robot: Robot) -> Term:
    """Return a term of its entry: a name, or a name with scale, clip, history and settings."""
    if isinstance(entry, str):
        entry = {entry: None}
    if not isinstance(entry, Mapping) or len(entry) != 1:
        raise ProblemError(f"an observation is a name, or a name with its settings, got {entry!r:.60}")
    said, own = str(next(iter(entry))), next(iter(entry.values()))
    name = ALIASES.get(said, said)
    check_name("observation", name, (*KINDS, *functions))
    settings = dict(KINDS[name].settings) if name in KINDS else {}
    if name == "foot_contact":
        settings["feet"] = len(robot.feet)
    own = table_of(f"observation {said}", own or {}, ("scale", "clip", "history", *settings))
    scale = real_array(f"scale of {said}", own.get("scale", 1.0))
    clip = own.get("clip")
    return Term(
        name, scale, None if clip is None else (float(clip[0]), float(clip[1])),
        whole_number(f"history of {said}", own.get("history", length), low=1),
        settings | {key: own[key] for key in settings if key in own},
    )  # fmt: skip


def _command_range(value: Any) -> FloatArray:
    """Return (2, 3) least and largest commands: of None, or three pairs."""
    if value is None:
        return np.outer([-np.inf, np.inf], np.ones(3))
    return np.asarray(finite_array("command_range", value, (3, 2)).T)
