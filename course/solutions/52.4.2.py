"""52.4.2 One Jacobian in three frames: rows are (linear, angular), (6, n).

The foot has the orientation R (foot axes to world axes) and the place p in the world.
LOCAL: velocity of the foot's point, in foot axes. LOCAL_WORLD_ALIGNED: the same point, world axes.
WORLD: world axes, and the velocity of the point of the moving foot that is at the world's origin.
脚的姿态为 R（脚轴到世界轴），位置为 p。LOCAL：脚上的点，脚轴；LOCAL_WORLD_ALIGNED：同一点，世界轴；
WORLD：世界轴，参考点为随脚运动、此刻位于世界原点的点。
"""

import numpy as np


def aligned(local, R):
    """Return the LOCAL_WORLD_ALIGNED Jacobian of a LOCAL one. 由 LOCAL 求 LOCAL_WORLD_ALIGNED。"""
    return np.vstack([R @ local[:3], R @ local[3:]])


def world(local, R, p):
    """Return the WORLD Jacobian of a LOCAL one. 由 LOCAL 求 WORLD。"""
    linear, angular = R @ local[:3], R @ local[3:]
    return np.vstack([linear + np.cross(p, angular, axisb=0, axisc=0), angular])


def contact_torques(local, R, force):
    """Return the joint torques of a force [N] that acts at the foot's point, given in world axes.

    返回作用在脚上的力（世界轴）折合成的关节力矩。
    """
    return aligned(local, R)[:3].T @ force
