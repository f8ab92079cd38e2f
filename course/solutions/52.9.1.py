"""52.9.1 One policy on two frictions: what its log says of friction, and whether it reacts.

Forces are in contact axes (tangent, tangent, normal), positions in the world.
力在接触轴中（切向、切向、法向），位置在世界中。
"""

import numpy as np


def friction_use(forces, mu):
    """Return the largest share of its friction that any loaded foot of a log, (steps, feet, 3), uses.

    Feet that press with less than 1 N are not loaded. 返回受力脚用掉摩擦的最大份额；压力不足 1 N 的脚不算。
    """
    forces = np.asarray(forces).reshape(-1, 3)
    pressing = forces[forces[:, 2] >= 1.0]
    return float((np.hypot(pressing[:, 0], pressing[:, 1]) / (mu * pressing[:, 2])).max(initial=0.0))


def slip(positions, loaded):
    """Return the way over the ground of feet, (steps, feet, 3), between two moments at both of which they are loaded.

    `loaded` is (steps, feet); heights do not count; all feet together [m]. 返回脚在受力期间沿地面滑过的总距离 [m]。
    """
    step = np.linalg.norm(np.diff(positions[:, :, :2], axis=0), axis=2)
    return float(step[loaded[1:] & loaded[:-1]].sum())


def reacts(low, high):
    """Return whether a feature of the policy differs between two frictions by more than chance.

    `low` and `high` hold its value of each episode. It must be right for equal distributions in at least 95 % of
    cases. 返回该特征在两种摩擦下的差异是否超出偶然；分布相同时至少 95 % 的情况要答"否"。
    """
    both, n = np.r_[low, high], len(low)
    rng = np.random.default_rng(0)
    shuffled = np.array([rng.permutation(both) for _ in range(999)])
    chance = np.abs(shuffled[:, :n].mean(axis=1) - shuffled[:, n:].mean(axis=1))
    return bool(np.mean(chance >= abs(np.mean(low) - np.mean(high))) < 0.03)
