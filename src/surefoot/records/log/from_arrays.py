"""Logs from arrays, as Isaac Lab, MJX, Brax or one's own loop give them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from surefoot.base.arrays import of_kind, positive_number
from surefoot.base.errors import ProblemError, check_name
from surefoot.records.log.channels import CHANNELS
from surefoot.records.log.from_source import log_from_source
from surefoot.records.log.log import Log
from surefoot.records.log.mapping import QUATERNIONS, LogMapping, Take, name_list
from surefoot.records.log.source import Source, Topic

ALIASES: dict[str, tuple[str, str]] = {
    "net_forces_w": ("forces", "world"),
    "root_pos_w": ("base_position", ""),
    "root_quat_w": ("base_orientation", ""),
    "root_lin_vel_w": ("base_velocity", ""),
    "root_ang_vel_w": ("base_angular_velocity", "world"),
    "root_lin_vel_b": ("base_velocity", "base"),
    "root_ang_vel_b": ("base_angular_velocity", ""),
    "joint_pos": ("joint_positions", ""),
    "joint_vel": ("joint_velocities", ""),
    "applied_torque": ("torques", ""),
    "qpos": ("q", ""),
    "qvel": ("v", "world"),
    "qfrc_actuator": ("torques", ""),
    "t": ("time", ""),
}
"""Names of Isaac Lab, MuJoCo, MJX and Brax: the channel, and the axes where they are not the channel's."""


def log_from_arrays(
    arrays: Mapping[str, Any],
    *,
    dt: float | None = None,
    quaternion: str = "",
    frames: Mapping[str, str] | None = None,
    feet: Sequence[str] = (),
    joints: Sequence[str] = (),
    facts: Mapping[str, Any] | None = None,
) -> Log:
    r"""Return the log of arrays over time, its doubts in `Log.doubts`.

    Parameters
    ----------
    arrays
        Name to (T, ...) numbers of NumPy, JAX or Torch: channels such as ``forces`` (T, feet, 3) [N], or the
        names of `ALIASES` (Isaac Lab's ``net_forces_w``, MuJoCo's and MJX's ``qpos``). MuJoCo's qfrc_actuator
        has a row of the base's six numbers first, which are dropped where qpos has a floating base.
    dt
        Time between rows [s], where no ``time`` is given.
    quaternion
        "xyzw" or "wxyz"; must be said where there is a quaternion, since engines and their versions differ.
    frames
        Channel to "world", "base" or "contact", where a vector is not in its channel's axes.
    feet, joints
        Names, in the arrays' order.
    facts
        ``mass`` and other facts.

    Raises
    ------
    ProblemError
        For a name that is no channel, shapes that do not fit, a quaternion whose order is not said.

    Examples
    --------
    >>> import numpy as np
    >>> forces = np.zeros((100, 4, 3)) + [0.0, 0.0, 40.0]
    >>> feet = ["FL", "FR", "RL", "RR"]
    >>> log = log_from_arrays({"net_forces_w": forces}, dt=0.01, feet=feet, facts={"mass": 10.0})
    >>> print(*log.doubts, sep="\n")
    forces: contact axes are taken to be the world's, as on level ground
    normal forces are 1.63 m g on average: unit, mass, or feet that are missing?
    """
    of_kind("arrays", arrays, Mapping)
    fields, frame_of = _channels(arrays)
    for name, table in (("frames", frames), ("facts", facts)):
        of_kind(name, {} if table is None else table, Mapping)
    frame_of |= {**(frames or {})}
    rows = {name: len(array) for name, array in fields.items() if array.ndim}
    if len(set(rows.values())) != 1 or len(rows) != len(fields):
        raise ProblemError(f"arrays must have the same number of rows, got {rows}")
    if "time" not in fields:
        step = positive_number("give the array time, or dt > 0: dt", np.nan if dt is None else dt, "s")
        fields["time"] = step * np.arange(float(min(rows.values())))
    if "q" in fields and "torques" in fields and fields["torques"].shape[1] == fields["q"].shape[1] - 1:
        fields["torques"] = fields["torques"][:, 6:]
    turned = [name for name in ("base_orientation", "q") if name in fields and _has_quaternion(name, fields)]
    if turned and quaternion not in QUATERNIONS:
        raise ProblemError(
            f"{turned[0]} holds a quaternion: say quaternion='xyzw' or 'wxyz', got {quaternion!r}"
        )
    if "v" in frame_of and "q" not in turned:
        del frame_of["v"]  # no base that moves
    takes = {
        name: Take((name,), frame=frame_of.get(name, ""), quaternion=quaternion if name in turned else "")
        for name in fields
    }
    for name in frame_of:
        check_name("array", name, fields)
    feet, joints = name_list("arrays", "feet", feet), name_list("arrays", "joints", joints)
    mapping = LogMapping(takes, feet, joints, dict(facts or {}))
    points = "forces" in fields and fields["forces"].ndim == 3 and fields["forces"].shape[1]
    if feet and points and points != len(feet) and "contact_foot" not in mapping.facts:
        raise ProblemError(f"forces has {points} contact points, feet names {len(feet)}")
    return log_from_source(Source({"": Topic(None, fields)}), mapping, "arrays")


def _channels(arrays: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """Return the arrays by channel, and the axes of those that are not in their channel's."""
    fields: dict[str, Any] = {}
    frame_of: dict[str, str] = {}
    for name, given in arrays.items():
        channel, frame = ALIASES.get(name, (name, ""))
        check_name("array", name, [*CHANNELS, *ALIASES])
        if channel in fields:
            raise ProblemError(f"two arrays are the channel {channel}: {', '.join(arrays)}")
        array = _numpy(name, given)
        wanted = 1 + len(CHANNELS[channel].shape)
        if array.ndim != wanted:
            more = ": pick one environment, array[:, k]" if array.ndim == wanted + 1 else ""
            shape = ", ".join(["T", *map(str, CHANNELS[channel].shape)])
            raise ProblemError(f"array {name} must have shape ({shape}), got {array.shape}{more}")
        if CHANNELS[channel].shape[-1:] == (3,) and array.shape[-1] != 3:
            raise ProblemError(f"array {name} must have three numbers last, got {array.shape}")
        fields[channel] = array
        if frame:
            frame_of[channel] = frame
    return fields, frame_of


def _has_quaternion(name: str, fields: Mapping[str, Any]) -> bool:
    """Return whether an array holds a quaternion: q with more numbers than v, or seven alone."""
    if name == "base_orientation":
        return True
    width = fields[name].shape[1]
    return bool(fields["v"].shape[1] < width) if "v" in fields else bool(width >= 7)


def _numpy(name: str, given: Any) -> Any:
    """Return an array of numbers, from a graphics card too."""
    for method in ("detach", "cpu"):
        given = getattr(given, method)() if hasattr(given, method) else given
    try:
        array = np.asarray(given)
        if array.dtype.kind not in "biuf":
            raise TypeError
        return array.astype(np.float64)
    except (TypeError, ValueError) as error:
        raise ProblemError(f"array {name} must hold real numbers, got {given!r:.60}") from error
