"""Hunt for contact verdicts that lie: `python tests/adversary/hunt.py --count 2000 --seed 1`.

Every lie is printed with the command that brings it back. Feasible problems that are not solved are misses,
not lies: a figure of quality for each family. `--solver all` takes every solver that takes the problem.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from building import FEASIBLE, INFEASIBLE, NO_SOLUTION, Case, case
from families import FAMILIES
from oracle import VANISHING, Data, Verdict, check_proof, judge, ratio, read, velocities_of, velocity_rounding

import surefoot as sf

RAW = "raw"
"""The name of `ContactSolver` here."""
SLACK, ALMOST = 10.0, 1e3
"""An error is a lie where it exceeds so many tolerances; an almost solved one has so many."""
STARTS = ("cold", "huge", "random", "lawful")
"""Warm starts: none, forces of 1e12, forces of size 1, the known solution."""


@dataclass(frozen=True)
class Finding:
    """One solve and what is wrong with it."""

    family: str
    seed: int
    solver: str
    tol: float
    start: str
    status: str
    truth: str
    seconds: float
    share: float
    lies: tuple[str, ...]
    leaks: tuple[str, ...]
    missed: bool
    unproved: bool

    @property
    def command(self) -> str:
        """The command that shows it again."""
        return (
            f"hunt.py --family {self.family} --only {self.seed} --solver {self.solver} "
            f"--tol {self.tol:g} --start {self.start}"
        )


def warm_start(kind: str, found: Case, seed: int) -> np.ndarray | None:
    """(n, 3) forces to start from."""
    rng = np.random.default_rng(seed)
    n = len(found.arguments["g"]) // 3
    if kind == "huge":
        return 1e12 * rng.normal(size=(n, 3))
    if kind == "random":
        return rng.normal(size=(n, 3))
    return found.forces if kind == "lawful" else None


def solve(found: Case, solver: str, tol: float, start: np.ndarray | None, settings: dict[str, Any]) -> Any:
    """Solve by name; "raw" is the `ContactSolver`, which takes matrices instead of problems."""
    if solver != RAW:
        return sf.solve(sf.ContactProblem(**found.arguments), solver, tol, warm_start=start, **settings)
    laws = {name: value for name, value in found.arguments.items() if name not in ("G", "g")}
    G = found.arguments["G"]
    G = np.asarray(G.toarray() if hasattr(G, "toarray") else G, dtype=float)
    contacts = sf.ContactSolver(
        len(found.arguments["g"]) // 3, tol=tol, max_iterations=settings.get("max_iterations"), **laws
    )
    return contacts.solve(G, np.asarray(found.arguments["g"], dtype=float))


def examine(
    name: str, seed: int, solver: str = "auto", tol: float = 1e-8, start: str = "cold", **settings: Any
) -> Finding:
    """Solve one problem and judge what the package says of it."""
    found = case(name, seed)
    before = time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            solution = solve(found, solver, tol, warm_start(start, found, seed), settings)
    except Exception as error:
        lies = (f"raised {type(error).__name__}: {error}",)
        return Finding(
            name, seed, solver, tol, start, "RAISED", found.truth, 0.0, 0.0, lies, (), False, False
        )
    seconds = time.perf_counter() - before
    data = read(found.arguments)
    forces = np.asarray(solution.forces)
    verdict = judge(data, forces)
    lies = [*_lies(found, data, forces, solution, verdict, tol)]
    leaks = []
    if solution.solved and found.truth in (INFEASIBLE, NO_SOLUTION):
        leaks.append("SOLVED, and the problem has no solution")
    missed = found.truth == FEASIBLE and not solution.solved
    if missed and found.forces is not None and not judge(data, found.forces).solved(tol):
        missed = False  # double precision cannot show that its solution is one
    return Finding(
        name, seed, solver, tol, start, solution.status.name, found.truth, seconds, verdict.share,
        tuple(lies), tuple(leaks), missed, found.truth == INFEASIBLE and solution.status.name != "INFEASIBLE",
    )  # fmt: skip


def _lies(
    found: Case, data: Data, forces: np.ndarray, solution: Any, verdict: Verdict, tol: float
) -> Iterator[str]:
    """Everything that is false in a solution."""
    if not verdict.finite:
        yield "forces that are not finite"
        return
    if solution.solved:
        if verdict.share > SLACK * tol:
            yield f"SOLVED with an error of {verdict.share:.1e} s sqrt(1 + mu²)"
        if verdict.rounding > SLACK * tol:
            yield f"SOLVED with forces that double precision cannot judge ({verdict.rounding:.1e} s)"
    elif solution.status.name == "ALMOST" and verdict.share > SLACK * ALMOST * tol:
        yield f"ALMOST with an error of {verdict.share:.1e} s sqrt(1 + mu²)"
    elif solution.status.name == "INFEASIBLE":
        proof = getattr(solution, "proof", None)
        if proof is None:
            yield "INFEASIBLE without a proof"
        else:
            checked = check_proof(data, proof.direction, proof.reach)
            if checked.fault:
                yield f"INFEASIBLE with a proof that {checked.fault}"
            elif found.forces is not None:
                total = float(np.abs(found.forces).sum())  # at least the sum of norms, and nothing overflows
                if total < checked.reach and judge(data, found.forces).solved(tol):
                    yield f"INFEASIBLE, but forces of {total:.1e} N solve it"
    yield from _false_figures(data, solution, verdict, forces)


def _false_figures(data: Data, solution: Any, verdict: Verdict, forces: np.ndarray) -> Iterator[str]:
    """What a solution states of itself and is not so: its velocities, its velocity error."""
    exact = np.array(velocities_of(data, forces))
    stated = np.asarray(solution.velocities)
    if np.isfinite(exact).all() and np.abs(exact).max(initial=0.0) < 1e300:
        allowed = 1e-13 * np.abs(exact) + 1e-300 + velocity_rounding(data, forces)[:, None]
        if not (np.abs(stated - exact) <= allowed).all():
            yield "velocities that are not G λ + g"
    error = getattr(solution.residuals, "velocity_error", None)
    told = verdict.scale != VANISHING  # where it stands for less, all speeds are rounding
    worst = max(map(ratio, verdict.error[told], verdict.scale[told]), default=0.0)
    if error is None or not worst > 1e-10 + 10.0 * verdict.rounding:
        return
    if error < 0.1 * min(worst, 1.0):
        yield f"states an error of {error:.1e} s, it is {worst:.1e} s"


def sweep(
    families: Iterable[str], seeds: Iterable[int], solvers: tuple[str, ...], tol: float,
    starts: Iterable[str], max_time: float, max_iterations: int | None = None,
) -> Iterator[Finding]:  # fmt: skip
    """Examine families x seeds x solvers x starts, as far as solvers take the problems."""
    starts = tuple(starts)
    for seed in seeds:
        for name in families:
            found = case(name, seed)
            takes = (
                *sf.solver_names(sf.ContactProblem(**found.arguments)),
                *((RAW,) if hasattr(sf, "ContactSolver") else ()),
            )
            for solver in takes if solvers == ("all",) else [s for s in solvers if s in takes]:
                for start in starts:
                    yield examine(
                        name, seed, solver, tol, start, max_time=max_time, max_iterations=max_iterations
                    )


def report(findings: list[Finding], limit: float) -> str:
    """A table: counts of each family and status, misses, lies, time."""
    groups: dict[tuple[str, str], list[Finding]] = defaultdict(list)
    for f in findings:
        groups[f.family, f.solver].append(f)
    several = len({f.solver for f in findings}) > 1
    heads = "solved", "missed", "noprf", "leaks", "lies"
    lines = [
        f"{'family':<34} {'truth':<12} {'runs':>5} {' '.join(f'{x:>6}' for x in heads)}  median, most ms"
    ]
    for (name, solver), group in sorted(groups.items()):
        times = 1e3 * np.array([f.seconds for f in group])
        statuses = ", ".join(f"{k} {v}" for k, v in Counter(f.status for f in group).most_common())
        truth = Counter(f.truth for f in group).most_common(1)[0][0]
        counts = (f.status == "SOLVED" for f in group), (f.missed for f in group), (f.unproved for f in group)
        counts += (bool(f.leaks) for f in group), (bool(f.lies) for f in group)
        lines.append(
            f"{name + (' ' + solver if several else ''):<34} {truth:<12} {len(group):>5} "
            f"{' '.join(f'{sum(c):>6}' for c in counts)} "
            f"{np.median(times):>7.1f} {times.max():>8.0f}  {statuses}"
        )
    feasible, bad = ([f for f in findings if f.truth == x] for x in (FEASIBLE, INFEASIBLE))
    lines.append(
        f"{len(findings)} runs, {sum(bool(f.lies) for f in findings)} lies, "
        f"{sum(bool(f.leaks) for f in findings)} solved without having a solution, "
        f"{sum(f.missed for f in feasible)} of {len(feasible)} feasible ones missed, "
        f"{sum(f.unproved for f in bad)} of {len(bad)} infeasible ones "
        f"without a proof, {sum(f.seconds > 1.0 + 3.0 * limit for f in findings)} far beyond the time allowed"
    )
    return "\n".join(lines)


def main() -> int:
    """Run from the command line; 1 if something lied."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=2000, help="problems, spread over the families")
    parser.add_argument("--seed", type=int, default=0, help="first seed")
    parser.add_argument("--only", type=int, help="one seed of each family")
    parser.add_argument("--family", action="append", choices=sorted(FAMILIES), help="may be repeated")
    parser.add_argument("--solver", action="append", help="a name, or all; may be repeated")
    parser.add_argument("--start", action="append", choices=STARTS, help="warm start; may be repeated")
    parser.add_argument("--tol", type=float, default=1e-8)
    parser.add_argument("--max-time", type=float, default=1.0, help="seconds for each solve")
    parser.add_argument("--max-iterations", type=int)
    parser.add_argument("--misses", type=int, default=10, help="how many misses to list, the worst first")
    options = parser.parse_args()
    names = options.family or list(FAMILIES)
    seeds = range(options.seed, options.seed + max(1, -(-options.count // len(names))))
    findings = []
    for f in sweep(
        names, seeds if options.only is None else [options.only], tuple(options.solver or ["auto"]),
        options.tol, options.start or ["cold"], options.max_time, options.max_iterations,
    ):  # fmt: skip
        findings.append(f)
        for line in (*(f"LIE   {x}" for x in f.lies), *(f"LEAK  {x}" for x in f.leaks)):
            print(f"{line}: {f.command}", flush=True)
    for f in sorted((f for f in findings if f.missed), key=lambda f: -f.share)[: options.misses]:
        print(f"MISS  {f.status}, error {f.share:.1e} s, {f.seconds:.2f} s: {f.command}")
    print(report(findings, options.max_time))
    return int(any(f.lies for f in findings))


if __name__ == "__main__":
    sys.exit(main())
