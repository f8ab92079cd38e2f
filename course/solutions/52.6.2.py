"""52.6.2 A cat of two bodies turns without angular momentum by changing its shape.

A plane model: the trunk has the inertia `trunk`; the limb turns by an angle measured *from the trunk*, and its
inertia can be changed between `small` and `large` (drawn in, stretched). Along a path of shapes, each a pair
(limb inertia, limb angle), either value changes in a straight line from one to the next.
平面模型：肢体角度*相对躯干*度量，其惯量可在 `small`（收）与 `large`（伸）之间改变；形状路径由（惯量，角度）点组成，相邻点之间线性变化。
"""

import numpy as np


def turn(trunk, path):
    """Return by how much the trunk turns along a path, (n, 2), of which no step changes both values [rad].

    返回沿路径（每步只改变一个量）躯干转过的角度 [rad]。
    """
    inertia, angle = path.T
    middle = 0.5 * (inertia[1:] + inertia[:-1])
    return float(np.sum(-middle / (trunk + middle) * np.diff(angle)))


def path_for(trunk, small, large, swing, angle):
    """Return a path, (n, 2), that starts and ends in one shape and turns the trunk by `angle` [rad].

    Inertias stay within [small, large], limb angles within [-swing, swing], and no step changes both.
    返回首尾形状相同、使躯干转过 `angle` 的路径；惯量与角度不出界，每步只改变一个量。
    """
    per_radian = large / (trunk + large) - small / (trunk + small)
    loops = int(np.ceil(abs(angle) / (2.0 * swing * per_radian)))
    reach = -angle / (2.0 * loops * per_radian)
    loop = [(small, -reach), (large, -reach), (large, reach), (small, reach)]
    return np.array(loop * loops + [loop[0]])
