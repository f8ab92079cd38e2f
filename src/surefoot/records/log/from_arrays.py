"""Logs from arrays, as Isaac Lab, MJX, Brax or one's own loop give them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from surefoot.base.arrays import of_kind, positive_number
from surefoot.base.errors import ProblemError, check_name, shown
from surefoot.contact import Sole
from surefoot.records.log.array_names import ALIASES, PER_FOOT
from surefoot.records.log.channels import CHANNELS
from surefoot.records.log.from_source import log_from_source, take_friction
from surefoot.records.log.log import Log
from surefoot.records.log.mapping import QUATERNIONS, LogMapping, Take, name_list
from surefoot.records.log.source import Source, Topic

WRENCHES = "foot_wrenches"
"""Array that is two channels: forces and contact moments."""


def log_from_arrays(
    arrays: Mapping[str, Any],
    *,
    dt: float | None = None,
    quaternion: str = "",
    frames: Mapping[str, str] | None = None,
    feet: Sequence[str] = (),
    joints: Sequence[str] = (),
    soles: Sequence[Sole] = (),
    facts: Mapping[str, Any] | None = None,
) -> Log:
    r"""Return the log of arrays over time, its doubts in `Log.doubts`.

    Parameters
    ----------
    arrays
        Name to (T, ...) numbers of NumPy, JAX or Torch: channels such as ``forces`` (T, feet, 3) [N], or the
        names of `ALIASES` (Isaac Lab's ``net_forces_w``, MuJoCo's and MJX's ``qpos``). MuJoCo's qfrc_actuator
        has a row of the base's six numbers first, which are dropped where qpos has a floating base.
        ``foot_wrenches`` (T, feet, 6) [N, N m], force and moment about each foot's own point as its sensor
        gives them, are ``forces`` and ``contact_moments``.
    dt
        Time between rows [s], where no ``time`` is given.
    quaternion
        "xyzw" or "wxyz"; must be said where there is a quaternion, since engines and their versions differ.
    frames
        Channel to "world", "base" or "contact", where a vector is not in its channel's axes.
    feet, joints
        Names, in the arrays' order.
    soles
        An `sf.Sole` a foot, its corners in the axes of that foot's wrench: the audit then judges the whole
        wrench. Friction is the array ``mu`` or ``contact_friction``; the soles' own where there is neither.
    facts
        ``mass`` and other facts; ``mu``, a number or one a contact, is the friction of all rows. A fact that
        nothing knows is kept, with a doubt.

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
    for name, table in (("frames", frames), ("facts", facts)):
        of_kind(name, {} if table is None else table, Mapping)
    frames = {**(frames or {})}
    if WRENCHES in arrays:
        arrays, frames = _split_wrenches(arrays, frames)
    fields, frame_of = _channels(arrays)
    frame_of |= frames
    facts = {**(facts or {}), **_sole_facts(soles, fields)}
    take_friction(facts, fields)
    rows = {name: len(array) for name, array in fields.items() if array.ndim}
    if len(set(rows.values())) != 1 or len(rows) != len(fields):
        raise ProblemError(f"arrays must have the same number of rows, got {rows}")
    if "time" not in fields:
        step = positive_number("give the array time, or dt > 0: dt", np.nan if dt is None else dt, "s")
        fields["time"] = step * np.arange(float(min(rows.values())))
    if "q" in fields and "torques" in fields and fields["torques"].shape[1] == fields["q"].shape[1] - 1:
        fields["torques"] = fields["torques"][:, 6:]
    turned = [name for name in ("base_orientation", "q") if name in fields and _has_quaternion(name, fields)]
    if turned and not (isinstance(quaternion, str) and quaternion in QUATERNIONS):
        raise ProblemError(
            f"{turned[0]} holds a quaternion: say quaternion='xyzw' or 'wxyz', got {shown(quaternion)}"
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
    mapping = LogMapping(takes, feet, joints, facts)
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
        check_name("array", name, [*CHANNELS, *ALIASES, WRENCHES])
        if channel in fields:
            raise ProblemError(f"two arrays are the channel {channel}: {', '.join(arrays)}")
        array = _numpy(name, given)
        if array.ndim == 2:
            channel = PER_FOOT.get(channel, channel) if array.shape[1] != 3 or channel == "mu" else channel
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


def _split_wrenches(
    arrays: Mapping[str, Any], frames: Mapping[str, str]
) -> tuple[dict[str, Any], dict[str, str]]:
    """Return arrays and frames with the feet's wrenches as forces and contact moments."""
    wrenches = _numpy(WRENCHES, arrays[WRENCHES])
    if wrenches.ndim != 3 or wrenches.shape[2] != 6:
        raise ProblemError(f"array {WRENCHES} must have shape (T, feet, 6), got {wrenches.shape}")
    parts = {"forces": wrenches[..., :3], "contact_moments": wrenches[..., 3:]}
    twice = [name for name in arrays if ALIASES.get(name, (name,))[0] in parts]
    if twice:
        raise ProblemError(f"{WRENCHES} and {twice[0]} say the same: give one of them")
    others = {name: array for name, array in arrays.items() if name != WRENCHES}
    axes = {name: axis for name, axis in frames.items() if name != WRENCHES}
    if WRENCHES in frames:
        axes |= dict.fromkeys(parts, frames[WRENCHES])
    return {**others, **parts}, axes


def _sole_facts(soles: Sequence[Sole], fields: dict[str, Any]) -> dict[str, Any]:
    """Return the facts of soles, and add their friction to the fields where these have none."""
    if not len(soles):
        return {}
    forces = fields.get("forces")
    count = forces.shape[1] if forces is not None and forces.ndim == 3 else 0
    if not all(isinstance(sole, Sole) for sole in soles) or len(soles) != count:
        raise ProblemError(f"soles must be one sf.Sole for each of {count} feet, got {shown(soles)}")
    if "contact_moments" not in fields:
        raise ProblemError(f"soles are judged by their wrenches: give the array {WRENCHES}")
    pads = [sole for sole in soles if sole.torsional_radius]
    if pads:
        raise ProblemError(f"logs keep soles without a torsional radius, got {pads[0]!r}")
    if not {"mu", "contact_friction"} & set(fields):
        fields["contact_friction"] = np.tile([sole.mu for sole in soles], (len(fields["forces"]), 1))
    return {
        "sole_corners": np.concatenate([sole.corners for sole in soles]).tolist(),
        "sole_contact": [k for k, sole in enumerate(soles) for _ in sole.corners],
    }


def _has_quaternion(name: str, fields: Mapping[str, Any]) -> bool:
    """Return whether an array holds a quaternion: q with more numbers than v, or seven alone."""
    if name == "base_orientation":
        return True
    width = fields[name].shape[1]
    return bool(fields["v"].shape[1] < width) if "v" in fields else bool(width >= 7)


def host_array(name: str, given: Any) -> Any:
    """Return an array of real numbers of any kind, from a graphics card too, without a copy where it can.

    Raises
    ------
    ProblemError
        For what holds no real numbers.
    """
    for method in ("detach", "cpu"):
        given = getattr(given, method)() if hasattr(given, method) else given
    try:
        array = np.asarray(given)
        if array.dtype.kind not in "biuf":
            raise TypeError
        return array
    except (TypeError, ValueError, RuntimeError) as error:
        raise ProblemError(f"array {name} must hold real numbers, got {shown(given)}") from error


def _numpy(name: str, given: Any) -> Any:
    return host_array(name, given).astype(np.float64)
