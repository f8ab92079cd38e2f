"""52.4.3 Contact inside the forward dynamics, and what damping is for.

M a = M free + Jᵀ f, where `free` is the acceleration without contact; undamped the contact holds, J a = 0.
Damped the forces obey (J M⁻¹ Jᵀ + damping 1) f = -J free.
`free` 是没有接触时的加速度；无阻尼时接触保持，J a = 0；有阻尼时接触力满足上式。
"""

import numpy as np


def constrained(M, J, free, damping):
    """Return the acceleration a and the contact forces f. 返回加速度 a 与接触力 f。"""
    inverse = np.linalg.solve(M, J.T)
    forces = np.linalg.solve(J @ inverse + damping * np.eye(len(J)), -J @ free)
    return free + inverse @ forces, forces


def needs_damping(J):
    """Return whether the undamped system cannot be solved for every `free`. 返回无阻尼时是否不能总是可解。"""
    return bool(np.linalg.matrix_rank(J) < len(J))
