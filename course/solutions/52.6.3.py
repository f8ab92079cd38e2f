"""52.6.3 Why a running humanoid swings its arms, and a quadruped need not.

x points forward, y to the left, z up; limbs are points with masses.
x 向前，y 向左，z 向上；肢体视为质点。
"""

import numpy as np


def angular_momentum(masses, positions, velocities):
    """Return the angular momentum of points about their centre of mass: three numbers [kg m²/s].

    返回质点系绕其质心的角动量：三个数。
    """
    centre = masses @ positions / masses.sum()
    speed = masses @ velocities / masses.sum()
    return np.sum(masses[:, None] * np.cross(positions - centre, velocities - speed), axis=0)


def arm_speed(leg_mass, hip, leg_speed, arm_mass, shoulder):
    """Return the forward speed of the *left* arm that cancels the legs' yaw momentum [m/s].

    The left leg, at y = hip, moves forward with `leg_speed`, the right one, at y = -hip, backward as fast; the
    arms, at y = shoulder and -shoulder, move against each other. 返回抵消两腿偏航动量所需的*左*臂前向速度。
    """
    return -leg_mass * hip * leg_speed / (arm_mass * shoulder)


def quadruped_yaw(leg_mass, half_width, speeds):
    """Return the yaw momentum of four legs at y = +-half_width with forward speeds of (FL, FR, RL, RR).

    返回四条腿的偏航角动量；前向速度依次为 (FL, FR, RL, RR)。
    """
    side = np.array([1.0, -1.0, 1.0, -1.0]) * half_width
    return float(-leg_mass * side @ speeds)
