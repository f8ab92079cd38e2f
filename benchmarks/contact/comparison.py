"""Every contact solver on every problem: time, accuracy, performance profile, and rivals in the same run.

Two times are measured for everybody. "Ready": the best case, one problem solved again and again, with all
that can be prepared made beforehand. "New G": what a simulator pays, whose matrix and free velocities are
new in every call; then setting up a problem from raw arrays is on the clock. All calls start cold.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from benchmarks.contact import rivals as contact_rivals
from benchmarks.contact import siconos_rival
from benchmarks.contact.ours import CONTACT_SOLVER, in_turn, our_calls
from benchmarks.problems.contacts import NamedProblem
from benchmarks.problems.judge import judge
from benchmarks.timing import Timing, interleaved, one_core
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.contact.files.formats import KINDS, read_problem
from surefoot.contact.problem import ContactProblem

OURS = ("auto", "nsgs", "newton", "admm")
ROBOT_SCALE = 25
COPIES, COPIED = 4, 45
"""Problems of up to `COPIED` contacts are measured on so many slightly different matrices, others on one."""
TIMED = 0.1
"""About how long the calls of a solver on a problem are timed [s]."""
RIVAL_STACK = 512 * 2**20
NOTHING = Timing(float("inf"), float("inf"), float("inf"), 0)
Kind = Literal["ready", "fresh"]


@dataclass(frozen=True)
class Run:
    """One solver on one problem.

    Attributes
    ----------
    problem, family, contacts, solver
        Who on what.
    seconds
        Median wall time per call on one ready problem [s].
    residual
        Of its forces, by `benchmarks.problems.judge`; the worst over all matrices it was given.
    solved
        Whether that is below the wanted tolerance.
    p99
        99th percentile of `seconds`' calls [s].
    fresh, fresh_p99
        The same for calls with a new matrix and new free velocities each [s].
    """

    problem: str
    family: str
    contacts: int
    solver: str
    seconds: float
    residual: float
    solved: bool
    p99: float = float("inf")
    fresh: float = float("inf")
    fresh_p99: float = float("inf")


@dataclass(frozen=True)
class FamilyRow:
    """One solver on one family of problems: times of those solved [s], the p99 of its slowest problem."""

    family: str
    problems: int
    solved: int
    mean: float
    median: float
    p99: float


@dataclass(frozen=True)
class Comparison:
    """All runs of one benchmark, and what follows from them."""

    tol: float
    runs: tuple[Run, ...]

    @property
    def solvers(self) -> tuple[str, ...]:
        """Names of the solvers, in the order of their first run."""
        return tuple(dict.fromkeys(r.solver for r in self.runs))

    @property
    def ours_fresh(self) -> str:
        """Who of ours is measured with a new matrix: the real-time path, or `auto` without it."""
        return CONTACT_SOLVER if CONTACT_SOLVER in self.solvers else self.solvers[0]

    def times(self, kind: Kind = "ready") -> dict[str, FloatArray]:
        """Return each solver's seconds per problem, infinite where it did not solve: (problems,)."""
        names = {name: k for k, name in enumerate(dict.fromkeys(r.problem for r in self.runs))}
        table = {s: np.full(len(names), np.inf) for s in self.solvers}
        for r in self.runs:
            if r.solved:
                table[r.solver][names[r.problem]] = r.seconds if kind == "ready" else r.fresh
        return table

    def families(self, solver: str, kind: Kind = "ready") -> list[FamilyRow]:
        """Return geometric mean, median and p99 of a solver on each family, and on "all"."""
        rows = [r for r in self.runs if r.solver == solver]
        groups: dict[str, list[Run]] = {}
        for r in rows:
            groups.setdefault(r.family, []).append(r)
        groups["all"] = rows
        out = []
        for name, members in groups.items():
            done = [r for r in members if r.solved]
            median = np.array([r.seconds if kind == "ready" else r.fresh for r in done])
            tail = [r.p99 if kind == "ready" else r.fresh_p99 for r in done]
            numbers = (
                (np.exp(np.mean(np.log(median))), np.median(median), max(tail)) if done else [np.nan] * 3
            )
            out.append(FamilyRow(name, len(members), len(done), *(float(x) for x in numbers)))
        return out

    def ratios(self, rivals: Sequence[str], who: str, kind: Kind = "ready") -> dict[str, list[float]]:
        """Return, by family, the best rival's time over ours on each problem that some rival solved.

        Problems that we did not solve count as a ratio of 0.01.
        """
        times = self.times(kind)
        best = np.min([times[r] for r in rivals if r in times] or [np.full(len(times[who]), np.inf)], axis=0)
        groups: dict[str, list[float]] = {}
        family = [r.family for r in self.runs if r.solver == who]
        for name, ours, theirs in zip(family, times[who], best, strict=True):
            if np.isfinite(theirs):
                groups.setdefault(name, []).append(float(theirs / ours) if np.isfinite(ours) else 0.01)
        return groups

    def speed_up(self, rivals: Sequence[str], who: str = "auto", kind: Kind = "ready") -> dict[str, float]:
        """Return the geometric mean, by family and over "all", of the best rival's time over ours.

        See `ratios`. "least" is the least ratio, "lost" the number of problems where a rival is faster,
        "no rival" that of problems that no rival solved, which no mean holds.
        """
        groups = self.ratios(rivals, who, kind)
        everything = np.array([x for g in groups.values() for x in g])
        out = {name: float(np.exp(np.mean(np.log(g)))) for name, g in groups.items()}
        out["all"] = float(np.exp(np.mean(np.log(everything)))) if everything.size else float("nan")
        out["least"] = float(everything.min()) if everything.size else float("nan")
        out["lost"] = float(np.count_nonzero(everything < 1.0))
        out["no rival"] = float(sum(r.solver == who for r in self.runs) - everything.size)
        return out


def problems_in(folder: Path) -> list[NamedProblem]:
    """Return the problems of all files in a folder that we can read, by name.

    Raises
    ------
    ProblemError
        If there is no such folder, or no such file in it.
    """
    if not folder.is_dir():
        raise ProblemError(f"no such folder: {folder}")
    files = sorted(f for f in folder.iterdir() if f.suffix in KINDS)
    if not files:
        raise ProblemError(f"no contact problems ({', '.join(KINDS)}) in {folder}")
    return [NamedProblem(f.name, "files", read_problem(f)) for f in files]


def compare(
    problems: Sequence[NamedProblem],
    tol: float = 1e-8,
    solvers: Sequence[str] = OURS,
    rivals: bool = True,
    progress: Callable[[str], None] = lambda _: None,
    budget: float = TIMED,
) -> Comparison:
    """Run solvers and rivals on the problems, on one core, and judge every answer.

    Parameters
    ----------
    problems
        What to solve.
    tol
        Residual that everybody has to reach, see `benchmarks.problems.judge`.
    solvers
        Our solvers; with "auto" also the real-time path `ContactSolver`, where it takes the problem.
    rivals
        Whether to run Pinocchio's solvers, and Siconos where it is installed.
    progress
        Is told the name of each problem.
    budget
        About how long the calls of a solver on a problem are timed [s].
    """
    siconos: dict[str, list[tuple[siconos_rival.SiconosRun | None, float]]] = {}
    if rivals and siconos_rival.siconos_installed():
        progress("with Siconos")
        siconos = siconos_rival.siconos_best([p.problem for p in problems], tol)
    runs: list[Run] = []
    faults: list[BaseException] = []

    def work() -> None:
        try:
            with one_core():
                for k, named in enumerate(problems):
                    progress(named.name)
                    runs.extend(_runs(named, tol, solvers, rivals, budget))
                    for name, found in siconos.items():
                        runs.append(_run(named, name, _timings(name, found[k][0]), found[k][1], tol))
        except BaseException as fault:
            faults.append(fault)

    # Pinocchio keeps its temporaries on the stack and dies of a common one at a few hundred contacts
    before = threading.stack_size(RIVAL_STACK)
    thread = threading.Thread(target=work)
    thread.start()
    threading.stack_size(before)
    thread.join()
    if faults:
        raise faults[0]
    return Comparison(tol, tuple(runs))


def copies_of(problem: ContactProblem) -> list[ContactProblem]:
    """Return problems with new matrices and free velocities, in arrays of their own, about as hard."""
    if problem.contacts > COPIED:
        return [problem.replace()]
    return [
        problem.replace(G=(1.0 + 1e-3 * k) * problem.G, g=(1.0 + 7e-4 * k) * problem.g)
        for k in range(1, COPIES + 1)
    ]


def _runs(named: NamedProblem, tol: float, solvers: Sequence[str], rivals: bool, budget: float) -> list[Run]:
    """Return the runs of ours and of Pinocchio's solvers on one problem, timed in turns."""
    problem, copies = named.problem, copies_of(named.problem)
    calls: dict[tuple[str, Kind], Callable[[int], Any]] = {}
    gaps: dict[str, float] = {}
    for name, (ready, fresh) in our_calls(problem, copies, solvers, tol).items():
        answers = [ready(0), *(fresh(k) for k in range(len(copies)))]
        gaps[name] = max(judge(p, f) for p, f in zip([problem, *copies], answers, strict=True))
        if gaps[name] <= tol:
            calls[name, "ready"], calls[name, "fresh"] = ready, fresh
    for name, setting in contact_rivals.settings(problem).items() if rivals else ():
        found, gaps[name] = contact_rivals.best_call(problem, setting, tol, copies)
        if found is not None:
            raw = [(contact_rivals.matrix(p, setting), p.g) for p in copies]
            calls[name, "ready"] = found.ready
            calls[name, "fresh"] = in_turn(found.fresh, raw)
    timings = interleaved(calls, budget)
    return [_run(named, name, timings, gap, tol) for name, gap in gaps.items()]


def _timings(name: str, found: siconos_rival.SiconosRun | None) -> dict[tuple[str, Kind], Timing]:
    """Return the times of Siconos, which was timed in its own process."""
    if found is None:
        return {}
    return {(name, "ready"): Timing.of([found.solve]), (name, "fresh"): Timing.of([found.fresh])}


def _run(
    named: NamedProblem, solver: str, timings: Mapping[tuple[str, Kind], Timing], residual: float, tol: float
) -> Run:
    ready, fresh = timings.get((solver, "ready"), NOTHING), timings.get((solver, "fresh"), NOTHING)
    solved = bool(residual <= tol and ready.calls)
    return Run(
        named.name, named.family, named.problem.contacts, solver, ready.median, residual, solved, ready.p99,
        fresh.median, fresh.p99,
    )  # fmt: skip
