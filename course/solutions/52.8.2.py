"""52.8.2 The pressure under a sole: rigid points, or a pressure field?

A rectangular sole reaches half_x, half_y from its middle and bears `force` [N] at the centre of pressure `cop`.
矩形鞋底半长 half_x、半宽 half_y，在压力中心 `cop` 承受 `force` [N]。
"""

import numpy as np


def whole_sole_loaded(half_x, half_y, cop):
    """Return whether a pressure that changes linearly over the sole is nowhere negative. 返回线性压力是否处处非负。"""
    return abs(cop[0]) / half_x + abs(cop[1]) / half_y <= 1.0 / 3.0


def pressure(x, y, half_x, half_y, force, cop):
    """Return the linear pressure at (x, y) that has this force and this centre [Pa].

    返回合力与压力中心均符合给定值的线性压力 [Pa]。
    """
    mean = force / (4.0 * half_x * half_y)
    return mean * (1.0 + 3.0 * cop[0] * x / half_x**2 + 3.0 * cop[1] * y / half_y**2)


def two_splits(half_x, half_y, force, cop):
    """Return two different ways in which four rigid corners can bear the force: a (2, 4) array, none pulls.

    Corners in the order (+, +), (+, -), (-, +), (-, -). 返回四个刚性角点承力的两种不同方式，均不为拉力。
    """
    signs = np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)])
    one = force / 4.0 * np.prod(1.0 + signs * cop / np.array([half_x, half_y]), axis=1)
    return np.array([one, one + min(one[1], one[2]) * np.array([1.0, -1.0, -1.0, 1.0])])
