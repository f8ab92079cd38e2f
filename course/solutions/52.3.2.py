"""52.3.2 A ball that falls from rest, with contact left to the law.

Each step obeys mass (v⁺ - v) = impulse - mass 9.81 dt and z⁺ = z + dt v⁺, and its *end* obeys
z⁺ >= 0, impulse >= 0, z⁺ impulse = 0. Any method will do: an optimiser over all steps, or step by step.
每步满足上述两式，且步*末*满足 z⁺ >= 0、impulse >= 0、z⁺ impulse = 0。方法不限：整体优化或逐步求解均可。
"""

import numpy as np


def drop(height, mass, dt, steps):
    """Return heights [m], velocities [m/s] and impulses [N s] at the end of each step: three arrays.

    返回各步末的高度、速度与各步的冲量：三个数组。
    """
    z, v, out = height, 0.0, []
    for _ in range(steps):
        free = v - 9.81 * dt
        impulse = max(0.0, -mass * (z / dt + free))
        v = free + impulse / mass
        z = z + dt * v
        out.append((z, v, impulse))
    return tuple(np.array(out).T)
