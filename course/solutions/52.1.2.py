"""52.1.2 Signorini's conditions as a normal cone, for a foot on flat ground.

The admissible gaps are the set {gap >= 0}; the force is positive where the ground pushes.
允许的间隙为集合 {gap >= 0}；地面推时力为正。
"""

import numpy as np


def residual(gap, force, r):
    """Return a number that is zero exactly where gap and force obey Signorini, for any r > 0.

    One equation without inequalities. 返回一个数，恰在满足 Signorini 条件处为零，对任意 r > 0 成立。
    """
    return gap - np.maximum(0.0, gap - r * force)


def in_normal_cone(direction, gap):
    """Return whether `direction` is in the normal cone of {gap >= 0} at `gap`.

    It is if direction * (other - gap) <= 0 for every admissible other gap; outside of the set the cone is empty.
    返回 `direction` 是否属于集合在 `gap` 处的法锥；在集合之外法锥为空。
    """
    if gap < 0.0:
        return False
    return direction == 0.0 if gap > 0.0 else direction <= 0.0


def lawful(gap, force):
    """Return whether gap and force obey Signorini, by the normal cone.

    用法锥判断间隙与力是否满足 Signorini 条件。
    """
    return in_normal_cone(-force, gap)
