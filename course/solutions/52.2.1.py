"""52.2.1 Inner and outer pyramids of k sides against the friction cone, in the section f_z = 1.

`fit` is "inner" or "outer". The circle has the radius mu.
`fit` 取 "inner"（内接）或 "outer"（外切）；圆的半径为 mu。
"""

import numpy as np


def corners(k, mu, fit):
    """Return the k corners (f_x, f_y) of the pyramid's section, in order around the circle: a (k, 2) array.

    返回截面多边形的 k 个顶点 (f_x, f_y)，沿圆周依次排列。
    """
    angle = 2.0 * np.pi * np.arange(k) / k
    reach = mu if fit == "inner" else mu / np.cos(np.pi / k)
    return reach * np.column_stack([np.cos(angle), np.sin(angle)])


def rows(k, mu, fit):
    """Return A, (k, 3), so that A f <= 0 says that the force f is in the same pyramid.

    返回 A (k, 3)，使 A f <= 0 表示力 f 在同一棱锥内。
    """
    middle = 2.0 * np.pi * (np.arange(k) + 0.5) / k
    distance = mu * np.cos(np.pi / k) if fit == "inner" else mu
    return np.column_stack([np.cos(middle), np.sin(middle), np.full(k, -distance)])


def errors(k, fit):
    """Return the error in the worst direction and in area, as shares of the circle's; inner ones are negative.

    返回最坏方向的误差与面积误差，均为相对于圆的份额；内接为负。
    """
    if fit == "inner":
        return np.cos(np.pi / k) - 1.0, k / 2.0 * np.sin(2.0 * np.pi / k) / np.pi - 1.0
    return 1.0 / np.cos(np.pi / k) - 1.0, k * np.tan(np.pi / k) / np.pi - 1.0
