"""52.5.2 The composite inertia of links in one pose.

Link i has the mass `masses[i]`, its centre at `positions[i]` and the inertia `inertias[i]` about its centre, all
in the same axes.
各连杆的质量、质心位置与绕自身质心的惯量都在同一坐标轴中。
"""

import numpy as np


def centre_of_mass(masses, positions):
    """Return the centre of mass [m]. 返回质心 [m]。"""
    return masses @ positions / masses.sum()


def composite_inertia(masses, positions, inertias):
    """Return the (3, 3) inertia of all links about their common centre of mass [kg m²].

    返回全部连杆绕公共质心的 (3, 3) 惯量 [kg m²]。
    """
    centre, out = centre_of_mass(masses, positions), np.zeros((3, 3))
    for m, x, own in zip(masses, positions - centre, inertias):
        out += own + m * (x @ x * np.eye(3) - np.outer(x, x))
    return out
