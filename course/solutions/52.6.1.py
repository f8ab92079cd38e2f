"""52.6.1 A quadruped falls without angular momentum and arrives pitched. Is conservation broken?

A plane model: the trunk has the inertia `trunk`, the legs together `legs`, both about the common pivot at the
centre of mass. The legs' angle is measured *from the trunk*.
平面模型：躯干惯量 `trunk`，各腿合计 `legs`，公共转轴在质心。腿的角度*相对躯干*度量。
"""

import numpy as np


def fall_time(height):
    """Return how long a fall from this height takes from rest [s] (9.81 m/s²). 返回从静止下落的时间 [s]。"""
    return np.sqrt(2.0 * height / 9.81)


def angular_momentum(trunk, legs, pitch_rate, leg_rate):
    """Return the angular momentum of trunk and legs [kg m²/s]. 返回躯干与腿的总角动量。"""
    return trunk * pitch_rate + legs * (pitch_rate + leg_rate)


def pitch_change(trunk, legs, leg_angles):
    """Return by how much the trunk has turned at the end [rad], where angular momentum is zero all the way.

    `leg_angles` are the legs' angles over time. 返回角动量恒为零时躯干最终转过的角度 [rad]。
    """
    return -legs / (trunk + legs) * (leg_angles[-1] - leg_angles[0])
