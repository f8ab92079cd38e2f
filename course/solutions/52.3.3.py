"""52.3.3 Three softenings of one contact: gap(force) = a + c force, with c > 0.

The law: gap >= 0, force >= 0, gap force = 0.
定律：gap >= 0，force >= 0，gap force = 0。
"""

import numpy as np


def relaxed_band(a, c, eps):
    """Return the least and the largest force that gap >= 0, force >= 0, gap force <= eps admit.

    返回松弛条件所允许的最小与最大力。
    """
    return max(0.0, -a / c), barrier(a, c, eps)


def barrier(a, c, kappa):
    """Return the force that minimises c force² / 2 + a force - kappa ln(force).

    返回使上式最小的力。
    """
    root = np.sqrt(a * a + 4.0 * c * kappa)
    return 2.0 * kappa / (a + root) if a > 0.0 else (root - a) / (2.0 * c)


def fischer_burmeister(a, c, eps):
    """Return the force with gap + force = sqrt(gap² + force² + eps²).

    返回满足上式的力。
    """
    return barrier(a, c, eps * eps / 2.0)


def continuation(start, end):
    """Return the softenings to solve with in turn: from `start`, each half the last, until one is below `end`.

    返回依次使用的软化参数：从 `start` 起逐次减半，直到小于 `end`。
    """
    out = [start]
    while out[-1] >= end:
        out.append(out[-1] / 2.0)
    return out
