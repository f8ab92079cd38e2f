"""52.4.1 A planar arm by hand: each angle is relative to the link before it, the first to the x axis.

平面机械臂：每个角相对于前一连杆，第一个相对于 x 轴。
"""

import numpy as np


def tip(lengths, angles):
    """Return where the arm ends: (x, y) [m]. 返回末端位置 (x, y) [m]。"""
    total = np.cumsum(angles)
    return np.array([lengths @ np.cos(total), lengths @ np.sin(total)])


def jacobian(lengths, angles):
    """Return the (2, n) Jacobian of the tip. 返回末端的 (2, n) 雅可比。"""
    total = np.cumsum(angles)
    steps = np.array([-lengths * np.sin(total), lengths * np.cos(total)])
    return np.cumsum(steps[:, ::-1], axis=1)[:, ::-1]


def torques(lengths, angles, force):
    """Return the joint torques that a force on the tip amounts to [N m], counter-clockwise positive.

    返回作用在末端的力折合成的关节力矩 [N m]，逆时针为正。
    """
    return jacobian(lengths, angles).T @ force
