"""Names under which files keep the arrays of a motion."""

from __future__ import annotations

QUATERNIONS = ("xyzw", "wxyz")
"""Orders of a quaternion's numbers."""
PLACES = (
    *("root_pos", "root_trans_offset", "root_trans", "root_translation", "root_position", "root_pos_w"),
    *("base_pos", "base_position", "base_pos_w", "trans"),
)
"""Names of the root's place, (T, 3) [m]."""
TURNS: dict[str, str] = {
    "root_rot": "xyzw", "root_quat": "", "root_quat_w": "wxyz", "root_orientation": "", "root_ori": "",
    "root_rotation": "", "base_quat": "", "base_quat_w": "wxyz", "base_orientation": "", "root_orn": "",
}  # fmt: skip
"""Names of the root's quaternion, (T, 4), and the order that files with that name usually have.

PHC, ASAP, PBHC, GMR and TWIST2 write `root_rot` as xyzw, Isaac Lab `root_quat_w` as wxyz. A name that ends
in `_xyzw` or `_wxyz` says it.
"""
ANGLES = (
    *("dof", "dof_pos", "dof_positions", "joint_pos", "joint_positions", "joint_angles"),
    *("joints", "joint_q"),
)
"""Names of the joints' angles, (T, n) [rad]; with 7 + n columns whole configurations, as of holosoma."""
WHOLE: dict[str, str] = {
    "qpos": "wxyz", "q": "xyzw", "": "", "motion": "", "data": "", "arr_0": "", "joint_pos": "wxyz",
}  # fmt: skip
"""Names of whole configurations, (T, 7 + n), and the order that their quaternions usually have."""
BODIES = (("body_pos_w", "body_quat_w"), ("body_positions", "body_rotations"), ("xpos", "xquat"))
"""Names of places (T, bodies, 3) and quaternions (T, bodies, 4), w first, of bodies, the root first."""
JOINT_NAMES = ("joint_names", "dof_names", "joints_names", "jnt_names")
"""Names of the lists of the joints' names."""
BODY_NAMES = ("body_names", "link_names")
"""Names of the lists of the bodies' names."""
RATES = (
    *("fps", "framerate", "frame_rate", "mocap_framerate", "mocap_frame_rate", "motion_fps", "rate"),
    *("frequency", "hz"),
)
"""Names of the rate [Hz]."""
STEPS = ("dt", "timestep", "frame_time")
"""Names of the time between frames [s]."""
TIMES = ("times", "time", "t", "timestamps", "timestamp")
"""Names of the frames' times [s]."""
SPEEDS = ("joint_vel", "dof_vel", "dof_velocities", "joint_velocities", "qvel")
"""Names of the joints' velocities [rad/s], as (T, n) or behind the root's six."""
TORQUES = ("torques", "joint_torques", "tau", "dof_torques", "applied_torque")
"""Names of what motors gave, (T, n) [N m]."""
