"""What a warm start is worth along trajectories, through Python and in a compiled loop."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.forces.race import distributor_for, run_ours, run_rival
from benchmarks.forces.rivals import DAQP, available
from benchmarks.problems.allocation_program import program
from benchmarks.problems.allocations import Instance
from benchmarks.timing import Timing, one_core
from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import kernel
from surefoot.contact.solution import Status
from surefoot.contact.solvers.dual_newton.distribution_memory import WARM
from surefoot.contact.solvers.dual_newton.wrench_distribution import distribute_wrench

FACETS = 8
LOOPS, TRIES = 100, 5
"""A step is solved in loops of LOOPS, and the fastest loop of TRIES counts."""
EDGE = 1e-9
"""Relative distance to a cone's side or a bound at which it counts as active."""


@dataclass(frozen=True)
class WarmRow:
    """One trajectory.

    Attributes
    ----------
    trajectory, steps
        Name and length.
    active
        Share of the steps at which a cone or a bound is active.
    iterations_cold, iterations_warm
        Mean Newton iterations; a cold start solves the program without cones first, which is not counted.
    cold, warm
        Times through Python [s].
    loop_cold, loop_warm
        Times in a compiled loop, without the call from Python [s].
    daqp_cold, daqp_warm
        Times of DAQP on FACETS inner facets [s]; None if it is not installed.
    """

    trajectory: str
    steps: int
    active: float
    iterations_cold: float
    iterations_warm: float
    cold: Timing
    warm: Timing
    loop_cold: Timing
    loop_warm: Timing
    daqp_cold: Timing | None
    daqp_warm: Timing | None


@kernel
def solve_often(
    grasp_map: FloatArray, wrench: FloatArray, work: FloatArray, memory: FloatArray, forces: FloatArray,
    times: int,
) -> int:  # fmt: skip
    """Solve one step again and again, from the same memory: the two rows after the contacts'."""
    contacts, code = forces.shape[0], 0
    for _ in range(times):
        for i in range(memory.shape[0]):
            for j in range(memory.shape[1]):
                work[contacts + i, j] = memory[i, j]
        code = max(code, distribute_wrench(grasp_map, wrench, work, forces))
    return code


def loop_times(instances: Sequence[Instance], warm: bool) -> tuple[FloatArray, FloatArray]:
    """Return time [s] and iterations of every step in a compiled loop."""
    first = distributor_for(instances[0])
    work, contacts = first.work, instances[0].mu.size
    forces, clock = np.empty((contacts, 3)), time.perf_counter
    times, iterations = np.full(len(instances), np.inf), np.zeros(len(instances))
    for k, instance in enumerate(instances):
        memory = work[contacts : contacts + 2, :24].copy()
        memory[1, WARM] *= warm
        for _ in range(TRIES):
            start = clock()
            code = solve_often(instance.grasp_map, instance.wrench, work, memory, forces, LOOPS)
            times[k] = min(times[k], (clock() - start) / LOOPS)
            if code != 0:
                raise RuntimeError(f"step {k} was not solved")
        iterations[k] = first.iterations
    return times, iterations


def on_the_edge(instance: Instance, forces: FloatArray) -> bool:
    """Tell whether any foot's force is on its cone's side or at a bound."""
    f, on = forces, instance.active
    side = np.hypot(f[:, 0], f[:, 1]) >= (1.0 - EDGE) * instance.mu * f[:, 2]
    low = f[:, 2] <= (1.0 + EDGE) * instance.normal_min
    high = f[:, 2] >= (1.0 - EDGE) * instance.normal_max
    return bool(np.any((side | low | high) & on))


def same_feet(instances: Sequence[Instance]) -> list[Instance]:
    """Return the instances with the first one's feet on the ground and the first one's limits."""
    first = instances[0]
    return [
        i
        for i in instances
        if np.array_equal(i.active, first.active)
        and np.array_equal(i.mu, first.mu)
        and np.array_equal(i.normal_max, first.normal_max)
        and np.array_equal(i.normal_min, first.normal_min)
    ]


def measure(name: str, instances: Sequence[Instance]) -> WarmRow:
    """Return the row of one trajectory; every answer, cold or warm, is checked to be solved."""
    steps = same_feet(instances)
    exact = run_ours(steps)
    loop_cold, cold_iterations = loop_times(steps, warm=False)
    loop_warm, warm_iterations = loop_times(steps, warm=True)
    check = distributor_for(steps[0])
    for k, (instance, cold) in enumerate(zip(steps, exact.forces, strict=True)):
        f = check.solve(instance.grasp_map, instance.wrench)
        if check.status is not Status.SOLVED or np.abs(f - cold).max() > 2.0 * check.tol + exact.errors[k]:
            raise RuntimeError(f"{name}: the warm answer of step {k} differs from the cold one")
    daqp: list[Timing | None] = [None, None]
    if available((DAQP,)):
        programs = [program(i, FACETS) for i in steps]
        daqp = [Timing.of(run_rival(DAQP(), programs, warm)[0]) for warm in (False, True)]
    active = np.mean([on_the_edge(i, f) for i, f in zip(steps, exact.forces, strict=True)])
    return WarmRow(
        name, len(steps), float(active), float(cold_iterations.mean()), float(warm_iterations.mean()),
        Timing.of(exact.cold), Timing.of(exact.warm), Timing.of(loop_cold), Timing.of(loop_warm), *daqp,
    )  # fmt: skip


def measure_all(
    trajectories: Iterable[tuple[str, Sequence[Instance]]], say: Callable[[str], None] = lambda _: None
) -> Iterator[WarmRow]:
    """Yield a row per trajectory."""
    for name, instances in trajectories:
        say(f"warm starts: {name}")
        with one_core():
            yield measure(name, instances)
