"""52.1.3 Does MuJoCo's soft contact satisfy Signorini's conditions?

Gravity is 9.81 m/s². At rest MuJoCo's contact with a constant impedance d gives the acceleration
(1 - d) * (-9.81) + d * k * depth, with k = 1 / (d * timeconst² * dampratio²).
静止时，阻抗为常数 d 的 MuJoCo 接触给出上式的加速度。
"""

import numpy as np


def signorini_errors(gaps, forces):
    """Return the deepest penetration [m], the largest pull [N] and the largest |gap * force| [N m] of a log.

    None of them is negative. 返回记录中最大的穿透、拉力与 |间隙 · 力|，均不为负。
    """
    gaps, forces = np.asarray(gaps), np.asarray(forces)
    return max(0.0, -gaps.min()), max(0.0, -forces.min()), np.abs(gaps * forces).max()


def satisfies(gaps, forces, tol):
    """Return whether a log obeys Signorini's three relations, each to within `tol`.

    返回记录是否在 `tol` 之内满足三条关系。
    """
    return all(error <= tol for error in signorini_errors(gaps, forces))


def resting_depth(timeconst, dampratio, impedance):
    """Return how deep a body at rest lies in MuJoCo's ground [m]. Does its mass matter?

    返回静止物体陷入 MuJoCo 地面的深度 [m]。与质量有关吗？
    """
    return (1.0 - impedance) * 9.81 * (timeconst * dampratio) ** 2
