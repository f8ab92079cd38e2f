"""52.5.1 The base's columns of the centroidal momentum matrix, for a robot with its joints held.

Link i has the mass `masses[i]`, its centre at `positions[i]` from the base and the inertia `inertias[i]` about
its centre, all in base axes; R turns base axes into world axes. The momentum is h = (linear, angular about the
centre of mass), in world axes; the base's velocity is (linear of its origin, angular), in base axes if
`axes` is "local", in world axes if it is "world".
连杆 i 的质量、质心位置与惯量均在基座轴中给出；R 把基座轴变到世界轴。动量在世界轴中；基座速度在 `axes` 所指的轴中。
"""

import numpy as np


def _cross(x):
    return np.array([[0.0, -x[2], x[1]], [x[2], 0.0, -x[0]], [-x[1], x[0], 0.0]])


def momentum_matrix(masses, positions, inertias, R, axes):
    """Return the (6, 6) matrix A with h = A (base velocity). 返回满足 h = A（基座速度）的 (6, 6) 矩阵。"""
    mass = masses.sum()
    centre = masses @ positions / mass
    inertia = sum(inertias)
    for m, x in zip(masses, positions - centre):
        inertia = inertia + m * (x @ x * np.eye(3) - np.outer(x, x))
    local = np.block([[mass * np.eye(3), -mass * _cross(centre)], [np.zeros((3, 3)), inertia]])
    turn = np.kron(np.eye(2), R)
    return turn @ local if axes == "local" else turn @ local @ turn.T


def linear_block(mass, R, axes):
    """Return the (3, 3) block that takes linear base velocity to linear momentum. 返回线速度到线动量的块。"""
    return mass * R if axes == "local" else mass * np.eye(3)
