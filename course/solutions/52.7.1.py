"""52.7.1 One wrench shared over feet by inner pyramids of k sides.

Feet at `feet`, (n, 3); the ground is level. A wrench is (force, moment about `com`), and so many sides has the
pyramid inside of each friction cone, with corners at the angles 2 pi i / k.
脚在 `feet`，地面水平；力旋量为（力，对 `com` 的力矩）；每只脚用 k 边内接棱锥，顶点在角度 2 pi i / k。
"""

import numpy as np
from scipy.optimize import minimize


def use(forces, mu):
    """Return the share of friction that each force uses: tangential by mu times normal. 返回各力用掉的摩擦份额。"""
    return np.hypot(forces[:, 0], forces[:, 1]) / (mu * forces[:, 2])


def closest(forces, mu):
    """Return the number of the foot whose force is closest to the edge of its cone. 返回最接近锥边缘的脚的序号。"""
    return int(np.argmax(use(forces, mu)))


def distribute(feet, com, mu, wrench, k):
    """Return the forces, (n, 3), of the least sum of squares that give the wrench within the pyramids.

    返回棱锥内给出该力旋量、平方和最小的各力 (n, 3)。
    """
    n = len(feet)
    middle = 2.0 * np.pi * (np.arange(k) + 0.5) / k
    one = np.column_stack([np.cos(middle), np.sin(middle), np.full(k, -mu * np.cos(np.pi / k))])
    rows = np.kron(np.eye(n), one)
    grasp = np.hstack([np.vstack([np.eye(3), np.cross(np.eye(3), -(p - com))]) for p in feet])
    grasp[3:] = np.hstack([np.cross(p - com, np.eye(3)).T for p in feet])
    scale = abs(wrench[2]) / n
    found = minimize(
        lambda x: 0.5 * x @ x,
        np.tile([0.0, 0.0, 1.0], n),
        jac=lambda x: x,
        constraints=[
            {"type": "eq", "fun": lambda x: grasp @ x - wrench / scale, "jac": lambda x: grasp},
            {"type": "ineq", "fun": lambda x: -rows @ x, "jac": lambda x: -rows},
        ],
        method="SLSQP",
        options={"maxiter": 500, "ftol": 1e-13},
    )
    return scale * found.x.reshape(n, 3)
