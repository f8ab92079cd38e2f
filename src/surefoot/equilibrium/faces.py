"""Facial reduction: what is left of the cones when every solution lies on their boundary.

Where the best margin is zero, some contacts cannot take part (a foot on a wall too steep for it) or can
only push along one edge of their cone (a slope at the very limit of friction). The multipliers of the margin
problem say which: y.(A x) = y.w = 0 for every solution x, so that x and z = A' y, both of them in
self-dual cones, are orthogonal part by part. J. Borwein, H. Wolkowicz, "Regularizing the abstract convex
program", J. Math. Anal. Appl. 1981.
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray

_ZERO = 1e-6


def smallest_face(z: FloatArray, e: FloatArray, lorentz: int) -> tuple[FloatArray, FloatArray, int]:
    """Return coordinates of the face of the cone that is orthogonal to z.

    Parameters
    ----------
    z
        (m,) in the cone: 3-D Lorentz cones first, then half-lines.
    e
        (m,) axes of the cones.
    lorentz
        Number of Lorentz cones.

    Returns
    -------
    tuple[FloatArray, FloatArray, int]
        (m, m') map x = map @ x', the axes of the cones in x' and the number of Lorentz cones there.
    """
    m = len(z)
    scale = float(np.abs(z).max(initial=0.0))
    whole, lines, axes = [], [], []
    for k in range(lorentz):
        head = z[3 * k : 3 * k + 3]
        side = float(np.hypot(head[1], head[2]))
        if head[0] <= _ZERO * scale:
            whole.append(k)
        elif head[0] - side <= _ZERO * scale:
            edge = np.zeros(m)
            edge[3 * k : 3 * k + 3] = [1.0, -head[1] / side, -head[2] / side]
            lines.append(edge)
            axes.append(e[3 * k])
    for i in range(3 * lorentz, m):
        if z[i] <= _ZERO * scale:
            lines.append(np.eye(m)[i])
            axes.append(e[i])
    columns = [np.eye(m)[:, 3 * k : 3 * k + 3] for k in whole]
    columns += [line[:, None] for line in lines]
    kept = [e[3 * k : 3 * k + 3] for k in whole] + [np.array(axes)]
    if not columns:
        return np.zeros((m, 0)), np.zeros(0), 0
    return np.hstack(columns), np.concatenate(kept), len(whole)
