"""What every controller, distributor and world is given: input that is not finite, infeasible or extreme.

A controller and a distributor never raise on numbers: what they return is finite and within every limit, says
so when it is not what was asked for, and is forgotten by the next good input. A world refuses what is not
finite by its name, and ends with a `SurefootError` where its state would not stay finite: it never goes on
without a word. A new member of a family is one line in its table, in `test_hard_inputs_of_*.py`.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.mechanics.stance import PointContact, Stance

NOT_FINITE = [math.nan, math.inf, -math.inf]
EXTREME = [1e6, -1e12, 1e100, -1e200, 1e308, 1e-310]
MU, LOW, HIGH = 0.6, 5.0, 200.0
FEET = [[0.2, 0.15, 0.0], [0.2, -0.15, 0.0], [-0.2, 0.15, 0.0], [-0.2, -0.15, 0.0]]
WRENCH = np.array([10.0, -5.0, 160.0, 1.0, -2.0, 0.5])


def grasp() -> np.ndarray:
    return np.ascontiguousarray(Stance([PointContact(p, mu=MU) for p in FEET]).grasp_map([0.01, 0.0, 0.3]))


def check_forces(forces: np.ndarray, low: np.ndarray, high: np.ndarray) -> None:
    assert np.isfinite(forces).all()
    assert np.all(np.hypot(forces[:, 0], forces[:, 1]) <= MU * forces[:, 2] + 1e-7)
    assert np.all((forces[:, 2] >= low - 1e-9) & (forces[:, 2] <= high + 1e-9))
