"""52.2.3 OCS2's friction cone: one number for each contact.

mu (f_z + gripper) - sqrt(f_x² + f_y² + reg) >= 0; `reg` is in N².
每个接触一个标量；`reg` 的单位为 N²。
"""

import numpy as np


def cone_value(force, mu, gripper, reg):
    """Return the scalar of one contact [N]. 返回一个接触的标量 [N]。"""
    return mu * (force[2] + gripper) - np.sqrt(force[0] ** 2 + force[1] ** 2 + reg)


def gradient(force, mu, gripper, reg):
    """Return its derivative by the force: three numbers. 返回对力的一阶导数：三个数。"""
    root = np.sqrt(force[0] ** 2 + force[1] ** 2 + reg)
    return np.array([-force[0] / root, -force[1] / root, mu])


def hessian(force, mu, gripper, reg):
    """Return its second derivative by the force: a (3, 3) array. 返回对力的二阶导数：(3, 3) 数组。"""
    x, y = force[0], force[1]
    out = np.zeros((3, 3))
    out[:2, :2] = -np.array([[y * y + reg, -x * y], [-x * y, x * x + reg]]) / (x * x + y * y + reg) ** 1.5
    return out
