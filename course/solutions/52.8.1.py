"""52.8.1 MuJoCo's solref: a contact of a time constant and a damping ratio, at a constant impedance d.

In contact MuJoCo makes a body move with the acceleration (1 - d) a0 + d (-b v - k r): a0 without contact, r the
(signed) gap and v its rate. Gravity is 9.81 m/s².
接触中 MuJoCo 使物体以上述加速度运动：a0 为无接触时的加速度，r 为（有符号的）间隙，v 为其变化率。
"""

import numpy as np


def stiffness_damping(timeconst, dampratio, impedance):
    """Return k and b so that d k and d b are those of a spring with this damping ratio, and b's own time constant.

    Without gravity the motion is r'' + (2 / timeconst) r' + r / (timeconst dampratio)² = 0.
    返回 k 与 b，使无重力时的运动满足上式。
    """
    return 1.0 / (impedance * (timeconst * dampratio) ** 2), 2.0 / (impedance * timeconst)


def resting_depth(timeconst, dampratio, impedance):
    """Return the depth of a body at rest under gravity [m]. 返回重力下静止时的压深 [m]。"""
    return (1.0 - impedance) * 9.81 * (timeconst * dampratio) ** 2


def overshoot(dampratio):
    """Return the share of the start's distance by which a body that is let go swings beyond its rest.

    Zero where it does not oscillate. 返回松手后越过平衡位置的幅度（占初始距离的份额）；不振荡则为零。
    """
    if dampratio >= 1.0:
        return 0.0
    return float(np.exp(-np.pi * dampratio / np.sqrt(1.0 - dampratio**2)))


def least_timeconst(dt):
    """Return the shortest time constant that MuJoCo accepts with this step (its `refsafe`) [s].

    返回该步长下 MuJoCo 允许的最短时间常数（`refsafe`）[s]。
    """
    return 2.0 * dt
