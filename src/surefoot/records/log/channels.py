"""The channels of a log: what each number is called, how many there are, in which unit and frame."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from surefoot.base.errors import ProblemError

SCHEMA = 2
"""Version of the channels' meaning that is written and read."""


@dataclass(frozen=True)
class Channel:
    """One quantity over time.

    Attributes
    ----------
    name
        What it is called in the log.
    shape
        Of one row: numbers, or the names of sizes that channels share (``nq``, ``nv``, ``joints``, ``p``
        contact points, ``n`` feet), with a factor before them: ``3p``.
    unit
        Of its numbers; empty for flags.
    frame
        Axes of its vectors: "contact" (tangent, tangent, normal), "world", "heading"; empty for none.
    optional
        Whether a log can do without it.
    flag
        Whether it is true or false.
    meaning
        One line for people.
    """

    name: str
    shape: tuple[int | str, ...] = ()
    unit: str = ""
    frame: str = ""
    optional: bool = True
    flag: bool = False
    meaning: str = ""

    def sized(self, **sizes: int) -> Channel:
        """Return the channel with its named sizes replaced by numbers.

        Raises
        ------
        ProblemError
            For a size that is not given.
        """
        return replace(self, shape=tuple(_value(s, sizes, self.name) for s in self.shape))

    @property
    def row_shape(self) -> tuple[int, ...]:
        """Shape of one row of a channel whose sizes are numbers."""
        return tuple(_value(size, {}, self.name) for size in self.shape)

    @property
    def dtype(self) -> Any:
        """NumPy's type of its numbers."""
        return np.dtype(bool if self.flag else np.float64)


def _split(size: int | str) -> tuple[int, str]:
    """Return factor and name of a size; the name is empty for a plain number."""
    match = re.fullmatch(r"(\d*)([A-Za-z_]\w*)?", str(size))
    if match is None or not match.group(0):
        raise ProblemError(f"a size is a number, a name or both as in '3p', got {size!r}")
    return int(match.group(1) or 1), match.group(2) or ""


def _value(size: int | str, sizes: Mapping[str, int], channel: str) -> int:
    factor, name = _split(size)
    if name and name not in sizes:
        raise ProblemError(f"the size {name} of channel {channel} is not given; given: {', '.join(sizes)}")
    return factor * sizes[name] if name else factor


def size_of(size: int | str, sizes: Mapping[str, int]) -> int | None:
    """Return a size as a number; None where its name is not among `sizes`."""
    factor, name = _split(size)
    return factor * sizes.get(name, 0) or None if name else factor


_TABLE = (
    Channel("time", (), "s", optional=False, meaning="at the start of each step"),
    Channel("q", ("nq",), "m, rad", "world", meaning="configuration, Pinocchio's order"),
    Channel("v", ("nv",), "m/s, rad/s", "base", meaning="velocity, Pinocchio's order"),
    Channel("others_q", ("others_nq",), "m, rad", "world", meaning="of what else moves, the engine's order"),
    Channel("others_v", ("others_nv",), "m/s, rad/s", meaning="of what else moves, the engine's order"),
    Channel("torques", ("joints",), "N m", meaning="applied joint torques"),
    Channel("torques_commanded", ("joints",), "N m", meaning="torques asked for, where motors give less"),
    Channel("forces", ("p", 3), "N", "contact", meaning="ground force on each contact point, as measured"),
    Channel("forces_commanded", ("p", 3), "N", "contact", meaning="forces that the controller asked for"),
    Channel("gaps", ("p",), "m", meaning="distance to the ground, negative in penetration"),
    Channel("contact_velocities", ("p", 3), "m/s", "contact", meaning="of the foot's material there"),
    Channel("contact_positions", ("p", 3), "m", "world", meaning="contact points"),
    Channel("normals", ("p", 3), "1", "world", meaning="of the ground at the contact points"),
    Channel("wrench_desired", (6,), "N, N m", "world", meaning="wanted about the centre of mass"),
    Channel("wrench_error", (6,), "N, N m", "world", meaning="the commanded forces' wrench less the wanted"),
    Channel("grasp_map", (6, "3p"), "1, m", meaning="from commanded forces to the wrench"),
    Channel("active", ("p",), flag=True, meaning="whether the controller lets a point push"),
    Channel("attained", (), flag=True, meaning="whether the command was possible within the cones"),
    Channel("saturated", (), flag=True, meaning="whether a torque was at its limit"),
    Channel(
        "other_forces", ("nv",), "N, N m", "base", meaning="generalised, of all that pushes but `forces`"
    ),
    Channel("momentum", (6,), "N s, N m s", "world", meaning="of all; the angular about the centre of mass"),
    Channel("energy", (), "J", meaning="of all, zero height at z = 0, without springs and rotors"),
    Channel("momentum_rate", (6,), "N, N m", "world", meaning="of all; the angular about the centre of mass"),
    Channel("com", (3,), "m", "world", meaning="centre of mass"),
    Channel(
        "wrench_applied", (6,), "N, N m", "world", meaning="pushes, thrust, drag, about the centre of mass"
    ),
    Channel("contact_moments", ("p", 3), "N m", "contact", meaning="torsional and rolling friction's"),
    Channel("contact_creep", ("p",), "m/s", meaning="at which the world's soft friction lets it move"),
    Channel("pyramid_turn", ("p",), "rad", meaning="of a friction pyramid's first edge in contact axes"),
    Channel("solver_error", (), "N", meaning="of a contact force, as the world's solver left it"),
    Channel("pushed_body", (), "1", meaning="place in model_bodies of what is pushed most; -1 for none"),
    Channel("inner_force", (), "N", meaning="between links of the robot, all contacts together"),
    Channel("inner_bodies", (2,), "1", meaning="places in model_bodies of the links that press most; -1"),
    Channel("push", (3,), "N", "world", meaning="external force on the base"),
    Channel("mu", (), "1", meaning="friction of the ground"),
    Channel("planned", ("n",), flag=True, meaning="whether the gait wants a foot on the ground"),
    Channel("command", (3,), "m/s, rad/s", "heading", meaning="wanted velocity: forward, left, yaw rate"),
    Channel("asked_by", (13,), "1", meaning="rank of the behaviour that each quantity is by; -1 for none"),
    Channel("contact_friction", ("p",), "1", meaning="friction of each contact, where they differ"),
    Channel("foot_sensors", ("n",), "raw", meaning="readings of the feet's sensors, not calibrated"),
    Channel("joint_positions", ("joints",), "rad, m", meaning="in the order of the fact joints"),
    Channel("joint_velocities", ("joints",), "rad/s, m/s", meaning="in the order of the fact joints"),
    Channel("base_position", (3,), "m", "world", meaning="of the base's origin"),
    Channel("base_orientation", (4,), "1", "world", meaning="quaternion x, y, z, w from base to world"),
    Channel("base_velocity", (3,), "m/s", "world", meaning="of the base's origin"),
    Channel("base_angular_velocity", (3,), "rad/s", "base", meaning="of the base"),
    Channel("imu_acceleration", (3,), "m/s^2", "base", meaning="specific force: +9.81 upwards at rest"),
    Channel("imu_angular_velocity", (3,), "rad/s", "base", meaning="as the IMU says"),
    Channel("q_estimated", ("nq",), "m, rad", "world", meaning="configuration as estimated, like q"),
    Channel("v_estimated", ("nv",), "m/s, rad/s", "base", meaning="velocity as estimated, like v"),
    Channel("contact_estimated", ("n",), flag=True, meaning="which feet touch, as the controller is given"),
    Channel(
        "innovations", ("n",), "1", meaning="of each foot, squared over three: one where beliefs are right"
    ),
    Channel("trusted", (), flag=True, meaning="whether the estimate is as good as it says"),
    Channel("estimator_time", (), "s", meaning="wall time of the estimator's step"),
    Channel("load_estimated", (4,), "kg, kg m", "base", meaning="unknown payload: mass, first moment"),
    Channel("wrench_estimated", (6,), "N, N m", "world", meaning="other wrench from outside, about the base"),
    Channel("stale", (), flag=True, meaning="whether joints were damped because no fresh state came"),
    Channel("controller_time", (), "s", meaning="wall time of the controller's step"),
)
CHANNELS: dict[str, Channel] = {channel.name: channel for channel in _TABLE}
"""The channels that Surefoot writes and reads by name; every one has a row per step, T rows in all."""


def check_shapes(arrays: Mapping[str, Any], channels: Mapping[str, Channel]) -> dict[str, int]:
    """Return the named sizes of arrays over time, after checking every array against its channel.

    Raises
    ------
    ProblemError
        For an array without a channel, a missing channel that is not optional, a shape, a number of rows or
        a size that does not fit, and numbers that are none.
    """
    for name, channel in channels.items():
        if not channel.optional and name not in arrays:
            raise ProblemError(f"the log has no channel {name!r}; it has: {', '.join(arrays)}")
    rows = arrays["time"].size if "time" in arrays else None
    sizes: dict[str, int] = {}
    for name, array in arrays.items():
        if name not in channels:
            raise ProblemError(f"{name!r} is no channel of a log: say what it is with a Channel of its own")
        channel, shape = channels[name], array.shape
        expected = ", ".join(["T", *map(str, channel.shape)])
        if len(shape) != 1 + len(channel.shape) or (rows is not None and shape[0] != rows):
            raise ProblemError(f"channel {name} must have shape ({expected}) with T = {rows}, got {shape}")
        if array.dtype.kind not in "biuf":
            raise ProblemError(f"channel {name} must hold real numbers, got {array.dtype}")
        for size, length in zip(channel.shape, shape[1:], strict=True):
            factor, symbol = _split(size)
            known = factor * sizes.setdefault(symbol, length // factor) if symbol else factor
            if known != length:
                more = f", {symbol} = {sizes[symbol]}" if symbol else ""
                raise ProblemError(f"channel {name} must have shape ({expected}){more}, got {shape}")
    return sizes


def channels_from(table: list[dict[str, Any]]) -> dict[str, Channel]:
    """Return definitions from tables of their fields, as JSON holds them."""
    made = (Channel(**{**row, "shape": tuple(row["shape"])}) for row in table)
    return {channel.name: channel for channel in made}
