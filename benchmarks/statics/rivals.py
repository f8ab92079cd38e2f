"""The same questions to a stance, put to SciPy's HiGHS, Clarabel and cddlib.

Each is written from the mathematics and shares no code with `surefoot.mechanics.statics`: these are the
oracles of the tests as well as the rivals of the benchmark.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import linprog

from benchmarks.problems.stances import StanceCase
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import needs
from surefoot.base.spatial import GRAVITY, skew
from surefoot.contact.solvers.backends import ConeProgram, Options, backend
from surefoot.mechanics.stance import SoleContact, Stance

CAP = 1.0
"""Largest margin that the rivals look for, as a share of the load: squeezing may be unlimited."""


def load_of(case: StanceCase) -> FloatArray:
    """Return the (6,) wrench about the centre of mass that the contacts must give."""
    weight = np.array([0.0, 0.0, case.mass * GRAVITY, 0.0, 0.0, 0.0])
    return np.asarray(weight - case.external_wrench)


def corners(stance: Stance) -> list[tuple[FloatArray, FloatArray, float]]:
    """Return (position, rotation_world_contact, mu) of every point contact and sole corner."""
    out: list[tuple[FloatArray, FloatArray, float]] = []
    for c in stance:
        R = c.rotation_world_contact
        half = np.zeros(3)
        if isinstance(c, SoleContact):
            half[:2] = 0.5 * float(c.sole.length or 0.0), 0.5 * float(c.sole.width or 0.0)
        signs = [(0, 0)] if c.dim == 3 else [(1, 1), (1, -1), (-1, -1), (-1, 1)]
        out.extend((c.position + R @ (half * [x, y, 0.0]), R, c.mu) for x, y in signs)
    return out


def world_grasp(stance: Stance, about: FloatArray) -> FloatArray:
    """Return the (6, 3 k) grasp map of corner forces in contact frames, moments about a (3,) point."""
    return np.hstack([np.vstack([R, skew(p - about) @ R]) for p, R, _ in corners(stance)])


def edge_columns(stance: Stance, about: FloatArray, facets: int) -> FloatArray:
    """Return the (6, k facets) wrenches of unit weights on the edges of the corners' inner pyramids."""
    angles, grasp = 2.0 * np.pi * np.arange(facets) / facets, world_grasp(stance, about)
    edges = [
        np.array([mu * np.cos(angles), mu * np.sin(angles), np.ones(facets)]) for *_, mu in corners(stance)
    ]
    return np.hstack([grasp[:, 3 * k : 3 * k + 3] @ rays for k, rays in enumerate(edges)])


def clarabel_margin(case: StanceCase) -> Callable[[], float]:
    """Return a call that finds the margin over exact cones [N], at most `CAP` loads, by Clarabel.

    The matrices are built beforehand; the call makes the solver and solves. NaN where no forces at all
    give the load.
    """
    load = load_of(case)
    scale = float(np.linalg.norm(load))
    points = corners(case.stance)
    A, n = world_grasp(case.stance, case.com), 3 * len(points)
    cones = np.zeros((3 * len(points), n + 1))  # s = (mu f_z - t sqrt(1 + mu^2), f_x, f_y) in the cone
    for k, (_, _, mu) in enumerate(points):
        cones[3 * k, 3 * k + 2], cones[3 * k, n] = mu, -math.sqrt(1.0 + mu * mu)
        cones[3 * k + 1, 3 * k] = cones[3 * k + 2, 3 * k + 1] = 1.0
    cap = np.zeros((1, n + 1))
    cap[0, n] = 1.0
    grasp = np.hstack([A, np.zeros((6, 1))])
    program = ConeProgram.of(
        None, np.append(np.zeros(n), -1.0), zero=(grasp, load / scale), nonneg=(cap, [CAP]),
        second_order=(-cones, np.zeros(3 * len(points))),
    )  # fmt: skip
    clarabel = backend("clarabel", Options(1e-10))
    call = clarabel.call(clarabel.ready(program))

    def solve() -> float:
        found = clarabel.read(call())
        return math.nan if found.x is None or not found.found else float(found.x[n]) * scale

    return solve


def highs_margin(case: StanceCase, facets: int = 8) -> Callable[[], float]:
    """Return a call that finds the margin over inner pyramids [N], at most `CAP` loads, by HiGHS.

    Unknowns are the weights of the pyramids' edges; NaN where no forces at all give the load.
    """
    load = load_of(case)
    scale = float(np.linalg.norm(load))
    A = edge_columns(case.stance, case.com, facets)
    side = np.repeat([mu * math.cos(math.pi / facets) for *_, mu in corners(case.stance)], facets)
    e = np.sqrt(1.0 + side * side) / side / facets
    # beta = beta' + t e with beta' >= 0
    equal = np.hstack([A, (A @ e)[:, None]])
    cost = np.concatenate([np.zeros(A.shape[1]), [-1.0]])
    bounds = [(0.0, None)] * A.shape[1] + [(None, CAP)]
    options: Any = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}

    def solve() -> float:
        result: Any = linprog(
            cost, A_eq=equal, b_eq=load / scale, bounds=bounds, method="highs", options=options
        )
        return float(-result.fun) * scale if result.status == 0 else math.nan

    return solve


def highs_feasible(case: StanceCase, facets: int = 8) -> Callable[[], bool]:
    """Return a call that only tells whether inner pyramids can give the load: the usual LP, by HiGHS."""
    load, A = load_of(case), edge_columns(case.stance, case.com, facets)
    cost = np.zeros(A.shape[1])

    def solve() -> bool:
        return bool(linprog(cost, A_eq=A, b_eq=load, bounds=(0.0, None), method="highs").status == 0)

    return solve


def highs_region(
    stance: Stance, mass: float, directions: int = 32, facets: int = 8
) -> Callable[[], FloatArray]:
    """Return a call that finds the CoM region's corners by one LP per direction, by HiGHS."""
    A = edge_columns(stance, np.zeros(3), facets)
    weight = mass * GRAVITY
    # [sum of forces; moments about the origin] = [0, 0, weight; weight (y, -x), 0]
    com = np.zeros((6, 2))
    com[3, 1], com[4, 0] = -weight, weight
    equal = np.hstack([A, com])
    load = np.array([0.0, 0.0, weight, 0.0, 0.0, 0.0])
    bounds = [(0.0, None)] * A.shape[1] + [(None, None)] * 2
    turn = 2.0 * np.pi * np.arange(directions) / directions

    def solve() -> FloatArray:
        out = []
        for angle in turn:
            cost = np.concatenate([np.zeros(A.shape[1]), [-np.cos(angle), -np.sin(angle)]])
            result: Any = linprog(cost, A_eq=equal, b_eq=load, bounds=bounds, method="highs")
            if result.status == 0:
                out.append(result.x[-2:])
        return np.array(out).reshape(-1, 2)

    return solve


def cddlib_rows(rays: FloatArray) -> Callable[[], FloatArray]:
    """Return a call that turns rays into half-spaces by cddlib's double description."""
    with needs("pycddlib", "cdd"):
        import cdd
    rows = np.hstack([np.zeros((len(rays), 1)), rays]).tolist()

    def solve() -> FloatArray:
        generators = cdd.matrix_from_array(rows, rep_type=cdd.RepType.GENERATOR)
        found = cdd.copy_inequalities(cdd.polyhedron_from_matrix(generators))
        return -np.array(found.array)[:, 1:]

    return solve
