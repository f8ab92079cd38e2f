"""What is lost without each stage of `auto`: `python -m benchmarks.contact.ablation [--quick] [FOLDER]`.

Every problem of the package's own sets, of a folder of FCLIB and Siconos files, and of the adversary's
families is solved by the whole plan first. Where the first call leaves it unsolved, it is solved again
without each of the stages that were asked, one at a time: a stage earns its place by problems that are then
no longer decided (SOLVED, or INFEASIBLE with its proof), or by the time that it saves.
"""

from __future__ import annotations

import argparse
import sys
import time
import zlib
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.contact.comparison import problems_in
from benchmarks.problems.contacts import NamedProblem, problem_set
from surefoot.contact import ContactProblem, Status
from surefoot.solvers import auto, plans
from surefoot.solvers.compiled import COMPILED_CONTACTS
from surefoot.solvers.solver import solve

TRY = auto.try_stage
ADVERSARY = Path(__file__).parents[2] / "tests" / "adversary"
TOLERANCE = {"robot": 1e-9, "large": 1e-6, "files": 1e-8, "adversary": 1e-8}
"""Wanted velocity error by set."""
DECIDED = Status.SOLVED, Status.INFEASIBLE


@dataclass(frozen=True)
class Loss:
    """What one stage does for the problems that reached it.

    Attributes
    ----------
    asked, lost
        Problems that reached it, and those decided with it and not without it.
    seconds, without
        Time on those that reached it, with and without it [s].
    """

    asked: int
    lost: tuple[str, ...]
    seconds: float
    without: float


def sets(folder: Path | None, seeds: int, quick: bool) -> Iterator[tuple[str, NamedProblem]]:
    """Yield every problem with the name of its set."""
    for name in ("robot", "large"):
        given = problem_set(name)
        yield from ((name, p) for p in given[:: 6 if quick else 1])
    if folder is not None:
        yield from (("files", p) for p in problems_in(folder))
    sys.path.insert(0, str(ADVERSARY))
    from families import FAMILIES  # type: ignore[import-not-found]

    for family, draw in FAMILIES.items():
        for seed in range(seeds):
            case = draw(np.random.default_rng([zlib.crc32(family.encode()), seed]))
            yield "adversary", NamedProblem(f"{family}-{seed}", family, ContactProblem(**case.arguments))


def table_of(problem: ContactProblem) -> tuple[dict[str, plans.Plan], str, str]:
    """Return the table that holds a problem's plan, its key there, and what to call it."""
    law = str(problem.law)
    if problem.general:
        return plans.GENERAL, plans.ANY_LAW, "any kind"
    if problem.facets is not None:
        return plans.PYRAMIDS, law, "pyramids"
    few = problem.contacts <= COMPILED_CONTACTS
    return (plans.CONES, law, "few") if few else (plans.CONES_LARGE, law, "many")


@contextmanager
def without(table: dict[str, plans.Plan], key: str, stage: plans.PlanStage) -> Iterator[None]:
    """Leave a stage out of a plan for a while."""
    with patch.dict(table, {key: tuple(s for s in table[key] if s != stage)}):
        yield


def decided(problem: ContactProblem, tol: float, most: float) -> tuple[bool, float]:
    """Solve a problem; return whether that decided it, and the time it took [s]."""
    start = time.perf_counter()
    found = solve(problem, "auto", tol, max_time=most)
    return found.status in DECIDED, time.perf_counter() - start


def _watched(asked: list[plans.PlanStage], stage: plans.PlanStage, *given: Any) -> Any:
    """Note a stage and try it."""
    asked.append(stage)
    return TRY(stage, *given)


def ablate(folder: Path | None, seeds: int, most: float, quick: bool) -> dict[tuple[str, str], Loss]:
    """Return the loss of every stage, by plan and stage."""
    rows: dict[tuple[str, str], list[tuple[str, bool, bool, float, float]]] = defaultdict(list)
    for kind, named in sets(folder, seeds, quick):
        problem = named.problem
        asked: list[plans.PlanStage] = []
        with patch.object(auto, "try_stage", partial(_watched, asked)):
            first = decided(problem, TOLERANCE[kind], most)
        table, key, size = table_of(problem)
        for stage in dict.fromkeys(s for s in asked if s in table[key]):
            with without(table, key, stage):
                then = decided(problem.replace(), TOLERANCE[kind], most)
            rows[f"{key}, {size}", stage.label].append((named.name, first[0], then[0], first[1], then[1]))
    return {
        place: Loss(
            len(runs), tuple(name for name, before, after, *_ in runs if before and not after),
            sum(r[3] for r in runs), sum(r[4] for r in runs),
        )
        for place, runs in rows.items()
    }  # fmt: skip


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
    for (plan, stage), loss in found.items():
        counts = f"{loss.asked} | {len(loss.lost)}"
        print(f"| {plan} | {stage} | {counts} | {loss.seconds:.2f} | {loss.without:.2f} |")
    for (plan, stage), loss in found.items():
        if loss.lost:
            print(f"{plan}, {stage}: {', '.join(loss.lost)}", file=sys.stderr)


if __name__ == "__main__":
    main()
