"""52.1.1 A foot on a slope: unilateral force and friction in world axes.

The slope rises along +x by `slope` degrees; forces are the ground's on the foot, in world axes [N].
斜坡沿 +x 升高 `slope` 度；力是地面对脚的力，用世界轴表示 [N]。
"""

import numpy as np


def split(force, slope):
    """Return the normal force (positive: the ground pushes) and the size of the tangential force [N].

    返回法向力（地面推为正）与切向力的大小 [N]。
    """
    angle = np.radians(slope)
    normal = np.array([-np.sin(angle), 0.0, np.cos(angle)])
    pressing = float(normal @ force)
    return pressing, float(np.linalg.norm(force - pressing * normal))


def allowed(force, slope, mu):
    """Return whether the ground can give this force: it only pushes, and within the cone of mu.

    返回地面能否给出这个力：只推不拉，且在摩擦锥内。
    """
    pressing, tangential = split(force, slope)
    return pressing >= 0.0 and tangential <= mu * pressing


def least_mu(slope):
    """Return the least friction coefficient with which a robot stands on this slope.

    返回在该斜坡上站住所需的最小摩擦系数。
    """
    return float(np.tan(np.radians(slope)))


def stands(slope, mu):
    """Return whether a robot can stand on this slope with this friction.

    返回在该斜坡与摩擦系数下能否站住。
    """
    return mu >= least_mu(slope)
