"""52.5.3 The rate of the centroidal momentum from the forces of the ground.

Gravity is (0, 0, -9.81) m/s²; forces [N] act on the robot at `points` [m].
重力为 (0, 0, -9.81) m/s²；力 [N] 在 `points` [m] 处作用于机器人。
"""

import numpy as np


def momentum_rate(com, mass, points, forces):
    """Return (rate of linear momentum, rate of angular momentum about the centre of mass): six numbers.

    返回（线动量变化率，绕质心角动量变化率）：六个数。
    """
    linear = forces.sum(axis=0) + mass * np.array([0.0, 0.0, -9.81])
    return np.r_[linear, np.cross(points - com, forces).sum(axis=0)]
