"""Terms of an observation: what a policy is given, each a function of what is sensed at one of its steps."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import heading_of
from surefoot.mechanics import Terrain
from surefoot.motion.control.controller import RobotState

STILL = 0.01
"""A command below this [m/s, rad/s] asks for no motion: a clock may rest."""


@dataclass
class Senses:
    """What a policy's terms are made of at one step, joints in the policy's order.

    Attributes
    ----------
    state
        As the controller is given it.
    positions, velocities
        (k,) joint angles less their default [rad], speeds [rad/s].
    command
        (3,) forward, left [m/s], yaw rate [rad/s].
    action
        (k,) the network's last answer, as it came.
    terrain
        The ground that the policy may know.
    """

    state: RobotState
    positions: FloatArray
    velocities: FloatArray
    command: FloatArray
    action: FloatArray
    terrain: Terrain


def _gravity(s: Senses, o: Mapping[str, Any]) -> FloatArray:
    """Return the direction of gravity in body axes: minus the third row of the body's rotation matrix."""
    x, y, z, w = s.state.q[3:7].tolist()
    return np.array([2.0 * (w * y - x * z), -2.0 * (y * z + w * x), 2.0 * (x * x + y * y) - 1.0])


def _phase(s: Senses, o: Mapping[str, Any]) -> FloatArray:
    """Return sines and cosines of clocks with the settings' period [s] and offsets [turns]."""
    still = o["still"] is not None and float(np.abs(s.command).max()) < STILL
    turns = [o["still"] if still else s.state.time / o["period"] + k for k in o["offsets"]]
    waves = {"sin": math.sin, "cos": math.cos}
    return np.array([waves[name](2.0 * math.pi * turn) for name in o["waves"] for turn in turns])


def _height_scan(s: Senses, o: Mapping[str, Any]) -> FloatArray:
    """Return the height of the base over points of a grid that turns with it, less an offset: (k,) [m]."""
    q = s.state.q
    along, across = np.meshgrid(o["x"], o["y"], indexing="ij" if o["fastest"] == "y" else "xy")
    cosine, sine = heading_of(q[3:7])
    turn = np.array([[cosine, sine], [-sine, cosine]])
    points = np.stack([along.ravel(), across.ravel()], axis=1) @ turn + q[:2]
    return np.asarray(q[2] - s.terrain.height(points) - o["offset"])


def _foot_contact(s: Senses, o: Mapping[str, Any]) -> FloatArray:
    """Return 1 for every foot that feels the ground, in the robot's order of feet; all where none tells."""
    contact = s.state.contact
    return np.ones(o["feet"]) if contact is None else np.asarray(contact, dtype=np.float64)


@dataclass(frozen=True)
class TermKind:
    """How a term is sensed.

    Attributes
    ----------
    sensed
        Its numbers, of the senses and the term's settings.
    settings
        The settings that it has, with their defaults.
    """

    sensed: Callable[[Senses, Mapping[str, Any]], FloatArray]
    settings: Mapping[str, Any] = field(default_factory=dict)


CLOCK = {"period": 0.8, "offsets": (0.0,), "waves": ("sin", "cos"), "still": None}
GRID = {"x": (0.0,), "y": (0.0,), "offset": 0.5, "fastest": "y"}
KINDS: dict[str, TermKind] = {
    "angular_velocity": TermKind(lambda s, o: s.state.v[3:6]),
    "linear_velocity": TermKind(lambda s, o: s.state.v[:3]),
    "gravity": TermKind(_gravity),
    "command": TermKind(lambda s, o: s.command),
    "command_linear": TermKind(lambda s, o: s.command[:2]),
    "command_angular": TermKind(lambda s, o: s.command[2:]),
    "joint_positions": TermKind(lambda s, o: s.positions),
    "joint_velocities": TermKind(lambda s, o: s.velocities),
    "last_action": TermKind(lambda s, o: s.action),
    "phase": TermKind(_phase, CLOCK),
    "height_scan": TermKind(_height_scan, GRID),
    "foot_contact": TermKind(_foot_contact, {"feet": 4}),
}
"""The terms by name; velocities in body axes [m/s, rad/s], joints [rad, rad/s] less their default."""
ALIASES = {
    "base_ang_vel": "angular_velocity", "ang_vel": "angular_velocity", "gyro": "angular_velocity",
    "base_lin_vel": "linear_velocity", "lin_vel": "linear_velocity", "linvel": "linear_velocity",
    "projected_gravity": "gravity", "gravity_vec": "gravity", "gravity_orientation": "gravity",
    "commands": "command", "velocity_commands": "command", "generated_commands": "command",
    "base_velocity": "command", "twist": "command",
    "command_lin_vel": "command_linear", "command_ang_vel": "command_angular",
    "joint_pos": "joint_positions", "joint_pos_rel": "joint_positions", "dof_pos": "joint_positions",
    "joint_vel": "joint_velocities", "joint_vel_rel": "joint_velocities", "dof_vel": "joint_velocities",
    "actions": "last_action", "action": "last_action", "last_actions": "last_action",
    "gait_phase": "phase", "height_scanner": "height_scan", "height_measurements": "height_scan",
    "feet_contact": "foot_contact", "foot_contacts": "foot_contact",
}  # fmt: skip
"""What publishers call them."""
