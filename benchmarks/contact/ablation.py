"""What is lost without each stage of `auto`: `python -m benchmarks.contact.ablation [--quick] [FOLDER]`.

Every problem of the package's own sets, of a folder of FCLIB and Siconos files, and of the adversary's
families is solved by the whole plan first. Where the first call leaves it unsolved, it is solved again
without each of the stages that were asked, one at a time, and without all stages of a solver ("all"): a stage
earns its place by problems that are then no longer decided (SOLVED, or INFEASIBLE with its proof), or by the
time of the processor that it saves.
"""

from __future__ import annotations

import argparse
import sys
import time
import zlib
from collections import defaultdict
from collections.abc import Iterator
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from benchmarks.contact.comparison import problems_in
from benchmarks.problems.contacts import NamedProblem, problem_set
from surefoot.contact.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.contact.solvers import auto
from surefoot.contact.solvers import strategies as plans
from surefoot.contact.solvers.compiled import COMPILED_CONTACTS
from surefoot.contact.solvers.newton_step import FEW
from surefoot.contact.solvers.solver import solve

TRY, RUN = auto.try_stage, auto._run
Stages = frozenset[plans.PlanStage]
TESTS = Path(__file__).parents[2] / "tests"
TOLERANCE = {"robot": 1e-9, "large": 1e-6, "files": 1e-8, "adversary": 1e-8}
"""Wanted velocity error by set."""
DECIDED = Status.SOLVED, Status.INFEASIBLE


class Run(NamedTuple):
    """A problem that reached a stage: decided with it and without, seconds of the processor for either."""

    problem: str
    before: bool
    seconds: float
    after: bool
    without: float


def sets(folder: Path | None, seeds: int, quick: bool) -> Iterator[tuple[str, NamedProblem]]:
    """Yield every problem with the name of its set."""
    for name in ("robot", "large"):
        given = problem_set(name)
        yield from ((name, p) for p in given[:: 6 if quick else 1])
    if folder is not None:
        yield from (("files", p) for p in problems_in(folder))
    sys.path[:0] = [str(TESTS / "adversary"), str(TESTS / "conformance")]
    from families import FAMILIES  # type: ignore[import-not-found]
    from test_set_mixtures import mixture  # type: ignore[import-not-found]

    for family, draw in FAMILIES.items():
        for seed in range(seeds):
            case = draw(np.random.default_rng([zlib.crc32(family.encode()), seed]))
            yield "adversary", NamedProblem(f"{family}-{seed}", family, ContactProblem(**case.arguments))
    for seed in range(4 * seeds):
        yield "adversary", NamedProblem(f"mixture-{seed}", "mixture", mixture(seed)[0])


def plan_of(problem: ContactProblem) -> str:
    """Return what to call a problem's plan."""
    if problem.general:
        return "any kind"
    law = str(problem.law)
    if problem.facets is not None:
        return f"{law}, pyramids"
    if problem.contacts > COMPILED_CONTACTS:
        return f"{law}, many"
    return f"{law}, few" if problem.contacts <= FEW else f"{law}, more"


def without(dropped: Stages) -> AbstractContextManager[Any]:
    """Leave stages out of every plan for a while, those of connected parts as well."""

    def run(problem: Any, settings: Any, forces: Any, done: int, plan: plans.Plan, start: float) -> Any:
        return RUN(problem, settings, forces, done, tuple(s for s in plan if s not in dropped), start)

    return patch.object(auto, "_run", run)


def decided(problem: ContactProblem, tol: float, most: float) -> tuple[bool, float]:
    """Solve a problem; return whether that decided it, and the time it took [s]."""
    start = time.process_time()
    found = solve(problem, "auto", tol, max_time=most)
    return found.status in DECIDED, time.process_time() - start


def _watched(asked: list[plans.PlanStage], stage: plans.PlanStage, *given: Any) -> Any:
    """Note a stage and try it."""
    asked.append(stage)
    return TRY(stage, *given)


def ablate(folder: Path | None, seeds: int, most: float, quick: bool) -> dict[tuple[str, str], list[Run]]:
    """Return the problems that reached every stage, by plan and stage."""
    rows: dict[tuple[str, str], list[Run]] = defaultdict(list)
    for kind, named in sets(folder, seeds, quick):
        problem = named.problem
        asked: list[plans.PlanStage] = []
        with patch.object(auto, "try_stage", partial(_watched, asked)):
            first = decided(problem, TOLERANCE[kind], most)
        found: dict[Stages, tuple[bool, float]] = {}
        places = [(plan_of(problem), s.label, frozenset([s])) for s in dict.fromkeys(asked)]
        places += [("all", n, frozenset(s for s in asked if s.name == n)) for n in {s.name for s in asked}]
        for plan, label, dropped in places:
            if dropped not in found:
                with without(dropped):
                    found[dropped] = decided(problem.replace(), TOLERANCE[kind], most)
            rows[plan, label].append(Run(named.name, *first, *found[dropped]))
    return rows


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--max-time", type=float, default=10.0)
    given = parser.parse_args()
    seeds, most = (3, 2.0) if given.quick else (given.seeds, given.max_time)
    found = ablate(given.folder, seeds, most, given.quick)
    print("| plan | stage | reached by | lost without it | time with it [s] | without |")
    print("| --- | --- | --- | --- | --- | --- |")
    for (plan, stage), runs in sorted(found.items()):
        lost = [run.problem for run in runs if run.before and not run.after]
        times = f"{sum(run.seconds for run in runs):.2f} | {sum(run.without for run in runs):.2f}"
        print(f"| {plan} | {stage} | {len(runs)} | {len(lost)} | {times} |", flush=True)
        print(f"{plan}, {stage}: {', '.join(lost)}", file=sys.stderr)


if __name__ == "__main__":
    main()
