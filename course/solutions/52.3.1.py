"""52.3.1 The Fischer-Burmeister function, regularised: a + b - sqrt(a² + b² + eps²).

Mind the sign, and that eps is squared under the root.
注意符号，以及根号下是 eps 的平方。
"""

import numpy as np


def fb(a, b, eps):
    """Return the function's value. 返回函数值。"""
    return a + b - np.sqrt(a * a + b * b + eps * eps)


def gradient(a, b, eps):
    """Return its derivatives by a and by b; at (0, 0) with eps = 0 any finite limit of gradients nearby.

    返回对 a、b 的导数；eps = 0 时在 (0, 0) 处返回附近梯度的任一有限极限。
    """
    root = np.sqrt(a * a + b * b + eps * eps)
    if root == 0.0:
        return 1.0 - np.sqrt(0.5), 1.0 - np.sqrt(0.5)
    return 1.0 - a / root, 1.0 - b / root


def partner(a, eps):
    """Return the b at which the function is zero, for a > 0. 对 a > 0，返回使函数为零的 b。"""
    return eps * eps / (2.0 * a)
