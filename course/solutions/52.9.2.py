"""52.9.2 An experiment that compares two policies on one robot.

Batteries run down and grounds wear: what drifts must hit both policies alike.
电池会耗尽，地面会磨损：一切漂移都应同等地影响两个策略。
"""

import itertools
from statistics import NormalDist

import numpy as np


def trials(difference, spread, level, power):
    """Return how many trials each policy needs to see a difference of means, two-sided, by normal theory.

    `spread` is the standard deviation of one trial. 返回每个策略所需的试验次数（双侧，正态近似）。
    """
    z = NormalDist().inv_cdf(1.0 - level / 2.0) + NormalDist().inv_cdf(power)
    return int(np.ceil(2.0 * (z * spread / difference) ** 2))


def schedule(pairs, seed):
    """Return the order of 2 * pairs trials, a string of "A" and "B": each pair has both, in a random order.

    返回 2 * pairs 次试验的次序；每一对含 A 与 B 各一次，先后随机。
    """
    first = np.random.default_rng(seed).integers(2, size=pairs)
    return "".join("AB" if k else "BA" for k in first)


def p_value(a, b):
    """Return the two-sided p-value of paired results: how often random signs give a mean difference as large.

    返回配对结果的双侧 p 值：随机变号后平均差至少同样大的比例。
    """
    difference = np.asarray(a) - np.asarray(b)
    n = len(difference)
    if n <= 12:
        signs = np.array(list(itertools.product((1.0, -1.0), repeat=n)))
    else:
        signs = np.random.default_rng(0).choice((1.0, -1.0), size=(4999, n))
        signs = np.vstack([np.ones(n), signs])
    means = np.abs(signs @ difference) / n
    return float(np.mean(means >= abs(difference.mean()) - 1e-12))
