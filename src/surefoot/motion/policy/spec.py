"""What a policy's numbers mean: joints, gains, actions and observations, and the YAML that says so.

The keys of a description, ours or read from a publisher's (`surefoot.motion.policy.publishers`), stand in
`policy.spec_keys`. What stands for joints is a number, a list in the policy's order, or a table of
patterns of joint names, the last that fits counts.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array
from surefoot.base.errors import ProblemError, check_name, located, shown
from surefoot.base.text_files import table_of
from surefoot.mechanics import Robot
from surefoot.motion.policy.observation_terms import ALIASES, KINDS

REQUIRED = ("joints", "default", "stiffness", "damping", "action_scale", "observations")
"""Without these a network cannot be used."""
SLACK = 0.05
"""A default pose may be this far outside a joint's range [rad]."""
RATE = 50.0
"""Steps of a policy in a second where nothing says it [1/s]."""
OTHERS = {"stiffness": 300.0, "damping": 5.0}
"""Gains that hold joints which the policy does not move [N m/rad, N m s/rad]."""
HISTORY: dict[str, Any] = {"length": 1, "order": "oldest", "by": "term", "start": "repeat"}


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
        """Return what a table with the keys of `PolicyKeys` says for a robot.

        Parameters
        ----------
        table
            See the module; None is as good as no entry.
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
        from surefoot.base.file_models import read_as
        from surefoot.motion.policy.spec_keys import PolicyKeys

        absent = missing(table)
        if absent:
            raise ProblemError(f"the policy's description lacks {', '.join(absent)}")
        with located("the policy"):
            given = {key: _plain(value) for key, value in table.items() if value is not None}
            said = read_as(PolicyKeys, given)
        joints = said["joints"]
        for name in joints:
            check_name("joint", name, robot.joint_names, f"of the policy for {robot.name}")
        if len(set(joints)) < len(joints):
            twice = next(name for name in joints if joints.count(name) > 1)
            raise ProblemError(f"the policy's joints name {twice} twice")
        default = per_joint("default", said["default"], joints)
        _check_range(robot, joints, default)
        history = {**HISTORY, **said.get("history", {})}
        terms = tuple(_term(one, history["length"], functions, robot) for one in said["observations"])
        if history["by"] == "time" and len({term.history for term in terms}) > 1:
            raise ProblemError("history by time: every term needs the same length")
        others = cast("dict[str, float]", said.get("others", {}))
        return PolicySpec(
            joints, default,
            per_joint("stiffness", said["stiffness"], joints), per_joint("damping", said["damping"], joints),
            per_joint("action_scale", said["action_scale"], joints),
            per_joint("action_offset", said["action_offset"], joints) if "action_offset" in said else default,
            _bounds("action_clip", said.get("action_clip"), joints),
            _bounds("target_clip", said.get("target_clip"), joints),
            terms, said.get("observation_clip", np.inf),
            history["order"], history["by"], history["start"], said.get("rate", RATE),
            _command_range(said.get("command_range")), {**OTHERS, **others},
        )  # fmt: skip


def _plain(value: Any) -> Any:
    """Return a value of somebody's Python as YAML would have it: arrays and tuples as lists."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, Mapping):
        return {key: _plain(each) for key, each in value.items()}
    return [_plain(each) for each in value] if isinstance(value, (list, tuple)) else value


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
            fits = [v for pattern, v in value.items() if _matches(key, pattern, name)]
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


def _matches(key: str, pattern: str, name: str) -> bool:
    try:
        return re.fullmatch(pattern, name) is not None
    except re.error as error:
        raise ProblemError(f"{key}: {shown(pattern)} is no pattern of names: {error}") from error


def _bounds(key: str, value: Any, joints: Sequence[str]) -> FloatArray:
    """Return (2, k) bounds: of None, a number, or low and high."""
    if value is None:
        return np.outer([-np.inf, np.inf], np.ones(len(joints)))
    low, high = value if isinstance(value, tuple) else (-abs(value), value)
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


def _term(entry: Mapping[str, Any], length: int, functions: Sequence[str], robot: Robot) -> Term:
    """Return a term of its entry: its name with scale, clip, history and settings."""
    ((said, own),) = entry.items()
    name = ALIASES.get(said, said)
    check_name("observation", name, (*KINDS, *functions))
    settings = dict(KINDS[name].settings) if name in KINDS else {}
    if name == "foot_contact":
        settings["feet"] = len(robot.feet)
    own = table_of(f"observation {said}", own or {}, ("scale", "clip", "history", *settings))
    return Term(
        name, np.asarray(own.get("scale", 1.0)), own.get("clip"), own.get("history", length),
        settings | {key: own[key] for key in settings if key in own},
    )  # fmt: skip


def _command_range(value: Any) -> FloatArray:
    """Return (2, 3) least and largest commands: of None, or three pairs."""
    if value is None:
        return np.outer([-np.inf, np.inf], np.ones(3))
    return np.asarray(finite_array("command_range", value, (3, 2)).T)
