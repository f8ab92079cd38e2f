"""Heaps of thousands of contacts, a minute of CPU each: `python -m benchmarks.contact.piles [LARGEST]`.

Problems of up to LARGEST contacts (all: 10,000). Siconos runs where it is installed, as many sweeps as take
about a minute for the largest; Pinocchio's ADMM on sparse matrices has `PATIENCE` [s] of wall time.
"""

from __future__ import annotations

import multiprocessing
import sys
import threading
import time

import numpy as np
from rich.console import Console

from benchmarks.contact import rivals, siconos_rival
from benchmarks.contact.comparison import RIVAL_STACK
from benchmarks.printing import table
from benchmarks.problems.heaps import capsules, rocks
from surefoot.contact.problem import ContactProblem, residuals
from surefoot.contact.solvers.solver import solve

HEAPS = ((rocks, 150, 1063), (rocks, 500, 3720), (rocks, 1300, 10_000), (capsules, 2600, 10_000))
TOL, MINUTE, PATIENCE, ITERATIONS = 1e-4, 60.0, 180.0, 2000


def _pinocchio(problem: ContactProblem) -> tuple[float, float]:
    """Return CPU seconds and error of Pinocchio's ADMM; infinite where it is not done in time."""
    context = multiprocessing.get_context("fork")
    here, there = context.Pipe(duplex=False)

    def work() -> None:
        start = time.process_time()
        call = rivals.PinocchioCall(problem, rivals.SPARSE["pinocchio admm sparse"], 0.01 * TOL, ITERATIONS)
        forces = call.ready()
        there.send((time.process_time() - start, residuals(problem, forces).velocity_error))

    def deep() -> None:
        threading.stack_size(RIVAL_STACK)
        thread = threading.Thread(target=work)
        thread.start()
        thread.join()

    process = context.Process(target=deep)
    process.start()
    found = here.recv() if here.poll(PATIENCE) else (np.inf, np.inf)
    process.kill()
    return float(found[0]), float(found[1])


def main() -> None:
    """Print the table."""
    largest, rows = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000, []
    for make, bodies, contacts in HEAPS:
        if contacts > largest:
            continue
        problem = make(np.random.default_rng(1), bodies, contacts, 0.5)
        bare = ContactProblem(problem.operator, problem.g, problem.mu)
        found = {}
        for name, given in (("auto, bodies known", problem), ("auto, G alone", bare)):
            start = time.process_time()
            solution = solve(given, tol=TOL, max_time=MINUTE)
            found[name] = time.process_time() - start, solution.residuals.velocity_error
        if siconos_rival.siconos_installed():
            run = siconos_rival.run_siconos([problem], {("nsgs", 0): [1e-14]})["nsgs", 0][0]
            found["siconos nsgs"] = run.solve, residuals(problem, run.forces).velocity_error
        found["pinocchio admm sparse"] = _pinocchio(problem)
        rows += [
            (make.__name__, str(contacts), name, f"{t:.1f}", f"{e:.1e}") for name, (t, e) in found.items()
        ]
        print(*rows[-len(found) :], sep="\n", file=sys.stderr, flush=True)
    Console().print(table(("heap", "contacts", "solver", "CPU [s]", "velocity error"), rows, "a minute each"))


if __name__ == "__main__":
    main()
