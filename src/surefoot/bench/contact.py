"""Every contact solver on every problem: time, residual, performance profile, and rivals in the same run."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.bench.contact_rivals import Measured, pinocchio_calls, siconos_installed, siconos_runs
from surefoot.bench.problems import NamedProblem
from surefoot.bench.timing import one_core
from surefoot.contact import ContactProblem, read_problem, residuals
from surefoot.contact.files import KINDS
from surefoot.errors import ProblemError
from surefoot.solvers import solve

RIVALS = {
    "pinocchio admm": ("admm", "OSQP"),
    "pinocchio admm spectral": ("admm", "SPECTRAL"),
    "pinocchio pgs": ("pgs", ""),
}
OURS = ("auto", "nsgs", "newton", "admm", "interior_point", "staggered")
ROBOT_SCALE = 25
RIVAL_STACK = 512 * 2**20
RIVAL_BUDGET = 8.0
"""Seconds after which a rival that has not reached the residual gets no tighter tolerance."""


@dataclass(frozen=True)
class Run:
    """One solver on one problem.

    Attributes
    ----------
    problem, family, contacts, solver
        Who on what.
    seconds
        Median wall time per call [s].
    residual
        Natural map of its forces, computed by `surefoot.contact.residuals`.
    solved
        Whether that is below the wanted tolerance.
    """

    problem: str
    family: str
    contacts: int
    solver: str
    seconds: float
    residual: float
    solved: bool


@dataclass(frozen=True)
class Comparison:
    """All runs of one benchmark, and what follows from them."""

    tol: float
    runs: tuple[Run, ...]

    @property
    def solvers(self) -> tuple[str, ...]:
        """Names of the solvers, in the order of their first run."""
        return tuple(dict.fromkeys(r.solver for r in self.runs))

    def times(self) -> dict[str, FloatArray]:
        """Return each solver's seconds per problem, infinite where it did not solve: (problems,)."""
        names = list(dict.fromkeys(r.problem for r in self.runs))
        table = {s: np.full(len(names), np.inf) for s in self.solvers}
        for r in self.runs:
            if r.solved:
                table[r.solver][names.index(r.problem)] = r.seconds
        return table

    def speed_up(self, rivals: Sequence[str], who: str = "auto") -> dict[str, float]:
        """Return the geometric mean, by family and over "all", of the best rival's time over ours.

        Problems that no rival solved are left out of the mean (and counted as "no rival"); problems that we
        did not solve count as a ratio of 0.01.
        """
        times = self.times()
        best = np.min([times[r] for r in rivals if r in times] or [np.full(len(times[who]), np.inf)], axis=0)
        family = [r.family for r in self.runs if r.solver == who]
        groups: dict[str, list[float]] = {}
        for k, name in enumerate(family):
            if np.isfinite(best[k]):
                ratio = float(best[k] / times[who][k]) if np.isfinite(times[who][k]) else 0.01
                groups.setdefault(name, []).append(ratio)
        everything = [x for g in groups.values() for x in g]
        out = {name: float(np.exp(np.mean(np.log(g)))) for name, g in groups.items()}
        out["all"] = float(np.exp(np.mean(np.log(everything)))) if everything else float("nan")
        out["least"] = min(everything, default=float("nan"))
        out["no rival"] = float(len(family) - len(everything))
        return out


def performance_profile(times: dict[str, FloatArray], ratios: FloatArray) -> dict[str, FloatArray]:
    """Return, for each solver, the share of problems solved within `ratios` times the best time.

    Source: E. D. Dolan, J. J. Moré, "Benchmarking optimization software with performance profiles",
    Mathematical Programming 91, 2002. Problems that nobody solved count as unsolved by all.

    Examples
    --------
    >>> times = {"a": np.array([1.0, 4.0]), "b": np.array([2.0, 2.0])}
    >>> found = performance_profile(times, np.array([1.0, 2.0]))
    >>> found["a"].tolist(), found["b"].tolist()
    ([0.5, 1.0], [0.5, 1.0])
    """
    best = np.min(list(times.values()), axis=0)
    out = {}
    for name, seconds in times.items():
        safe = np.where(np.isfinite(seconds), seconds, 1.0) / np.where(np.isfinite(best), best, 1.0)
        share = np.where(np.isfinite(seconds), safe, np.inf)
        out[name] = np.array([np.mean(share <= r) for r in ratios])
    return out


def problems_in(folder: Path, most: int | None = None) -> list[NamedProblem]:
    """Return the problems of all files in a folder that we can read, by name; at most so many contacts.

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
    found = [NamedProblem(f.name, "files", read_problem(f)) for f in files]
    return [p for p in found if most is None or p.problem.contacts <= most]


def compare(
    problems: Sequence[NamedProblem],
    tol: float = 1e-8,
    solvers: Sequence[str] = OURS,
    rivals: bool = True,
    max_time: float = 10.0,
    progress: Callable[[str], None] = lambda _: None,
) -> Comparison:
    """Run solvers and rivals on the problems, on one core, and certify every answer.

    Parameters
    ----------
    problems
        What to solve.
    tol
        Natural map that everybody has to reach.
    solvers
        Our solvers.
    rivals
        Whether to run Pinocchio's solvers, and Siconos where it is installed.
    max_time
        Bound on one solve of ours [s].
    progress
        Is told the name of each problem.
    """
    siconos = siconos_runs([p.problem for p in problems], tol) if rivals and siconos_installed() else {}
    runs: list[Run] = []
    faults: list[BaseException] = []

    def work() -> None:
        try:
            runs.extend(_all_runs(problems, tol, solvers, rivals, max_time, progress, siconos))
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


def _all_runs(
    problems: Sequence[NamedProblem],
    tol: float,
    solvers: Sequence[str],
    rivals: bool,
    max_time: float,
    progress: Callable[[str], None],
    siconos: dict[str, list[list[Measured]]],
) -> list[Run]:
    """Return every run, on one core."""
    runs: list[Run] = []
    with one_core():
        for k, named in enumerate(problems):
            progress(named.name)
            for name in solvers:
                runs.append(_ours(named, name, tol, max_time))
            for name, (method, rule) in RIVALS.items() if rivals else ():
                runs.append(_pinocchio(named, name, method, rule, tol))
            for name, found in siconos.items():
                runs.append(_siconos(named, name, found[k], tol))
    return runs


def _run(named: NamedProblem, solver: str, seconds: float, residual: float, tol: float) -> Run:
    count = named.problem.contacts
    return Run(named.name, named.family, count, solver, seconds, residual, bool(residual <= tol))


def _ours(named: NamedProblem, solver: str, tol: float, max_time: float) -> Run:
    """Time `solve` as users call it; the residual is computed once more, from the forces alone."""
    problem: ContactProblem = named.problem

    def call() -> FloatArray:
        return solve(problem, solver, tol, max_time=max_time).forces

    forces = call()
    return _run(named, solver, _median(call), residuals(problem, forces).natural_map, tol)


def _pinocchio(named: NamedProblem, name: str, method: str, rule: str, tol: float) -> Run:
    """Time the loosest tolerance that reaches our residual."""
    seconds, least = float("inf"), float("inf")
    start = time.perf_counter()
    for call in pinocchio_calls(named.problem, tol, method, rule):
        least = min(least, residuals(named.problem, call()).natural_map)
        if least <= tol:
            seconds = _median(call)
            break
        if time.perf_counter() - start > RIVAL_BUDGET:
            break
    return _run(named, name, seconds, least, tol)


def _siconos(named: NamedProblem, name: str, found: Sequence[tuple[float, FloatArray]], tol: float) -> Run:
    for seconds, forces in found:
        gap = residuals(named.problem, forces).natural_map
        if gap <= tol:
            return _run(named, name, seconds, gap, tol)
    gaps = [residuals(named.problem, f).natural_map for _, f in found]
    return _run(named, name, float("inf"), float(np.nanmin(gaps)) if gaps else float("inf"), tol)


def _median(call: Callable[[], Any], budget: float = 0.1) -> float:
    """Return the median wall time of a call, from 3 to 50 of them in about `budget` seconds."""
    times: list[float] = []
    clock = time.perf_counter
    stop = clock() + budget
    while len(times) < 3 or (len(times) < 50 and clock() < stop):
        start = clock()
        call()
        times.append(clock() - start)
    return float(np.median(times))
