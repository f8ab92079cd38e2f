"""Accuracy against time of force distribution: exact cones and facets, cold and along a trajectory."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from benchmarks.forces.rivals import EXACT_RIVALS, FACET_RIVALS, Kind, Rival, available
from benchmarks.problems.allocation_program import (
    Program,
    cone_violation,
    facet_violation,
    objective,
    program,
    shortfall,
)
from benchmarks.problems.allocations import (
    CLASSES,
    FORCE_WEIGHT,
    WRENCH_WEIGHTS,
    Instance,
    four_feet,
    pushed_stance,
)
from benchmarks.problems.judge import coarsest
from benchmarks.timing import Timing, one_core
from surefoot.base.arrays import FloatArray
from surefoot.contact.cones import FrictionCone
from surefoot.contact.cones.cone import Fit
from surefoot.contact.solution import Status
from surefoot.mechanics.statics.force_distribution import ForceDistributor

FITS: tuple[Fit, Fit] = ("inner", "outer")
CONES: tuple[tuple[int | None, Fit], ...] = ((None, "inner"), *product((4, 8, 16), FITS))
"""Facets, None for exact cones, and on which side of the cone they are."""
TRAJECTORY = "trajectory"
OURS = "Surefoot"
REPEATS = 5
"""Every instance is solved this often and its least time counts: what is left is the solver's own spread."""
GAP, BROKEN = 1e-4, 1e-3
"""A rival has solved a program if its objective is within GAP, relative, of the best known and its own
constraints are broken by less than BROKEN newtons. It is asked for the loosest tolerance that does this."""
DECADES = tuple(range(-1, -11, -1))
"""Powers of ten that a rival's tolerance is tried at; eighths of a decade follow."""


@dataclass(frozen=True)
class Row:
    """One line of the table: a solver on one kind of cone, over one class of instances.

    Attributes
    ----------
    solver, cone, instances
        Names; the cone is "exact" or like "8 inner".
    warm
        Whether it went on from its last answer.
    timing
        Time per call [s], spread over instances.
    solved
        Share of the instances that it has really solved (see GAP and BROKEN).
    gap
        Largest relative excess of the objective over the best known of the same program.
    cone_violation
        Largest distance of a force to its exact cone [N].
    lost_friction
        Share of the friction that the cone gives away in its worst direction (negative for outer
        facets, which promise more than the ground gives).
    distance, distance_worst
        Median and largest distance of a foot's force to the exact optimum [N]; for Surefoot itself
        the error bound that it gives.
    shortfall
        Mean weighted wrench error above that of the exact optimum (below it for outer facets).
    tolerance
        That it was asked for, the loosest with which it solves all instances; NaN if it knows none.
    """

    solver: str
    cone: str
    instances: str
    warm: bool
    timing: Timing
    solved: float
    gap: float
    cone_violation: float
    lost_friction: float
    distance: float
    distance_worst: float
    shortfall: float
    tolerance: float = np.nan


@dataclass(frozen=True)
class Exact:
    """Our forces for every instance of a class, the bound on their error [N], and their times."""

    forces: list[FloatArray]
    errors: FloatArray
    cold: FloatArray
    warm: FloatArray


def distributor_for(instance: Instance) -> ForceDistributor:
    """Return the distributor that the comparison runs."""
    return ForceDistributor(
        instance.mu, instance.normal_min, instance.normal_max, WRENCH_WEIGHTS, FORCE_WEIGHT, tol=1e-8
    )


def run_ours(instances: Sequence[Instance]) -> Exact:
    """Time `ForceDistributor` cold and warm; both take the grasp map, not a prepared Hessian."""
    distributor = distributor_for(instances[0])
    masks = [i.active for i in instances]
    changes = [k > 0 and not np.array_equal(masks[k], masks[k - 1]) for k in range(len(masks))]
    same = all(np.array_equal(i.mu, instances[0].mu) for i in instances)
    full = same and all(
        np.array_equal(i.normal_max[i.active], instances[0].normal_max[i.active])
        and np.array_equal(i.normal_min[i.active], instances[0].normal_min[i.active])
        for i in instances
    )
    times = np.full((2, len(instances)), np.inf)
    errors = np.zeros(len(instances))
    forces: list[FloatArray] = []
    clock = time.perf_counter
    for turn in range(REPEATS):
        for warm in (0, 1):
            distributor.reset()
            for k, instance in enumerate(instances):
                if not full:
                    distributor = distributor_for(instance)
                elif changes[k]:
                    distributor.set_active(masks[k])
                if not warm:
                    distributor.reset()
                start = clock()
                f = distributor.solve(instance.grasp_map, instance.wrench)
                times[warm, k] = min(times[warm, k], clock() - start)
                if turn == 0 and not warm:
                    if distributor.status is not Status.SOLVED:
                        raise RuntimeError(f"instance {k} ended {distributor.status}")
                    forces.append(f)
                    errors[k] = distributor.force_error
    return Exact(forces, errors, times[0], times[1])


def run_rival(
    rival: Rival, programs: Sequence[Program], warm: bool
) -> tuple[FloatArray, list[FloatArray | None]]:
    """Return the least time of every program and the last solutions."""
    times = np.full(len(programs), np.inf)
    answers: list[FloatArray | None] = []
    clock = time.perf_counter
    items = [rival.ready(p) for p in programs]
    for _ in range(REPEATS):
        answers = []
        for k, item in enumerate(items):
            asked = rival.ask(item, warm)
            call = asked.call
            start = clock()
            answer = call()
            times[k] = min(times[k], clock() - start)
            answers.append(asked.read(answer))
    return times, answers


def judge(
    name: str, cone: str, kind: str, warm: bool, times: FloatArray, programs: Sequence[Program],
    answers: Sequence[FloatArray | None], best: FloatArray, exact: Exact, lost: float,
) -> Row:  # fmt: skip
    """Return the row of a run, each answer checked against the program it was asked to solve."""
    gaps, violations, distances, short = [], [], [], []
    for p, x, least, ours in zip(programs, answers, best, exact.forces, strict=True):
        if x is None or not solves(p, x, least):
            continue
        f = p.forces(x)
        gaps.append(excess(p, x, least)[0])
        violations.append(cone_violation(p.instance, f))
        distances.append(np.linalg.norm(f - ours, axis=1).max())
        short.append(shortfall(p.instance, f) - shortfall(p.instance, ours))

    def over(how: Callable[[list[float]], Any], values: list[float]) -> float:
        return float(how(values)) if values else np.nan

    return Row(
        name, cone, kind, warm, Timing.of(times), len(gaps) / len(programs), over(max, gaps),
        over(max, violations), lost, over(np.median, distances), over(max, distances), over(np.mean, short),
    )  # fmt: skip


def solves(p: Program, x: FloatArray | None, least: float) -> bool:
    """Tell whether an answer counts as one; see GAP and BROKEN."""
    if x is None or not np.isfinite(x).all():
        return False
    gap, broken = excess(p, x, least)
    return gap <= GAP and broken <= BROKEN


def excess(p: Program, x: FloatArray, least: float) -> tuple[float, float]:
    """Return the objective above the best known, relative, and by how much its own limits are broken [N]."""
    gap = (objective(p, x) - least) / max(least, 1e-9)
    return gap, facet_violation(p, x) if p.C is not None else cone_violation(p.instance, p.forces(x))


def tuned(kind: Kind, programs: Sequence[Program], best: FloatArray, warm: bool) -> Rival:
    """Return a rival with the loosest tolerance that solves all programs, its default if none does."""

    def attempt(tol: float) -> float | None:
        rival = kind(tol)
        for p, least in zip(programs, best, strict=True):
            if not solves(p, rival.solve(p, warm), least):
                return None
        return tol

    found = coarsest(attempt, decades=DECADES) if kind.has_tol else None
    return kind() if found is None else kind(found)


def best_known(programs: Sequence[Program], answers: Sequence[Sequence[FloatArray | None]]) -> FloatArray:
    """Return the least objective that any solver reached within the constraints, per program."""
    best = np.full(len(programs), np.inf)
    for run in answers:
        for k, (p, x) in enumerate(zip(programs, run, strict=True)):
            if x is not None and np.isfinite(x).all() and excess(p, x, 0.0)[1] <= 1e-10:
                best[k] = min(best[k], objective(p, x))
    return best


def lost_friction(facets: int, fit: Fit) -> float:
    """Return the share of the friction that facets give away in their worst direction."""
    error = FrictionCone(0.6).polyhedral(facets, fit).fit_error.radial
    return error if fit == "inner" else -error


def run_class(kind: str, instances: Sequence[Instance], say: Callable[[str], None]) -> Iterator[Row]:
    """Yield the rows of one class of instances; on a trajectory solvers that can start warm do."""
    along = kind == TRAJECTORY
    exact = run_ours(instances)
    for facets, fit in CONES:
        cone = "exact" if facets is None else f"{facets} {fit}"
        rivals = available(EXACT_RIVALS if facets is None else FACET_RIVALS)
        programs = [program(i, facets, fit) for i in instances]
        runs: list[tuple[str, bool, FloatArray, list[FloatArray | None]]] = []
        if facets is None:
            ours: list[FloatArray | None] = [
                f.ravel()[p.columns] for f, p in zip(exact.forces, programs, strict=True)
            ]
            runs.append((OURS, False, exact.cold, ours))
            if along:
                runs.append((OURS, True, exact.warm, ours))
        tolerances: dict[tuple[str, bool], float] = {}
        for rival in sorted(rivals, key=lambda r: r.has_tol):  # those that are exact are what others aim at
            say(f"{kind}: {cone}: {rival.name}")
            for warm in (False, True) if along and rival.can_warm else (False,):
                best = best_known(programs, [answers for *_, answers in runs])
                known = bool(np.isfinite(best).all())
                solver = tuned(rival, programs, best, warm) if known else rival()
                tolerances[rival.name, warm] = solver.tol if rival.has_tol else np.nan
                runs.append((rival.name, warm, *run_rival(solver, programs, warm)))
        best = best_known(programs, [answers for *_, answers in runs])
        lost = 0.0 if facets is None else lost_friction(facets, fit)
        for name, warm, times, answers in runs:
            row = judge(name, cone, kind, warm, times, programs, answers, best, exact, lost)
            row = replace(row, tolerance=tolerances.get((name, warm), np.nan))
            if name == OURS:  # no distance to itself: the bound that comes with every answer
                middle, worst = float(np.median(exact.errors)), float(exact.errors.max())
                row = replace(row, distance=middle, distance_worst=worst)
            yield row


def run_all(count: int, steps: int, say: Callable[[str], None] = lambda _: None) -> list[Row]:
    """Return the whole table.

    Parameters
    ----------
    count
        Instances of each class.
    steps
        Length of the trajectory.
    say
        Told what is being run.
    """
    trajectory = pushed_stance(steps, 1.0 / steps)
    distributor_for(trajectory[0]).solve(trajectory[0].grasp_map, trajectory[0].wrench)  # compile
    rows = []
    with one_core():
        for kind in (*CLASSES, TRAJECTORY):
            instances = trajectory if kind == TRAJECTORY else four_feet(kind, count)
            rows += list(run_class(kind, instances, say))
            gc.collect()
    return rows
