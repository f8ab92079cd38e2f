"""What engines call the arrays that are channels of a log."""

from __future__ import annotations

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
PER_FOOT = {"mu": "contact_friction", "forces": "foot_sensors"}
"""Channels that one number a foot (T, feet) is taken for: friction of each, and how hard each presses."""
