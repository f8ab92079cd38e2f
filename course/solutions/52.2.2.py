"""52.2.2 The wrench cone of a rectangular sole.

The sole reaches `half_x` and `half_y` from its middle; each corner can give a force with f_z >= 0 and
|f_x|, |f_y| <= mu f_z. A wrench is w = (f_x, f_y, f_z, tau_x, tau_y, tau_z) about the middle.
鞋底半长 `half_x`、半宽 `half_y`；每个角的力满足 f_z >= 0 与 |f_x|, |f_y| <= mu f_z；力旋量对鞋底中心取。
"""

import itertools

import numpy as np


def wrench_rows(half_x, half_y, mu):
    """Return A, (m, 6), so that A w <= 0 holds exactly for the wrenches that the four corners can give.

    返回 A (m, 6)，使 A w <= 0 恰好描述四角所能给出的力旋量。
    """
    rows = [[0.0, 0.0, -1.0, 0.0, 0.0, 0.0]]
    for sign in (1.0, -1.0):
        rows += [[sign, 0, -mu, 0, 0, 0], [0, sign, -mu, 0, 0, 0]]
        rows += [[0, 0, -half_y, sign, 0, 0], [0, 0, -half_x, 0, sign, 0]]
    for turn, s, t in itertools.product((1.0, -1.0), repeat=3):
        rows.append([s * half_y, t * half_x, -mu * (half_x + half_y), turn * s * mu, turn * t * mu, turn])
    return np.array(rows)


def centre_of_pressure(wrench):
    """Return the point (x, y) of the sole about which the tipping moment is zero [m].

    返回鞋底上倾覆力矩为零的点 (x, y) [m]。
    """
    return np.array([-wrench[4], wrench[3]]) / wrench[2]


def tight(rows, wrench):
    """Return which rows hold with equality (to 1e-6 of the normal force): an array of m truths.

    返回哪些行取等号（误差为法向力的 1e-6）：长为 m 的布尔数组。
    """
    return np.abs(rows @ wrench) <= 1e-6 * abs(wrench[2])
