"""Accuracy over time on one contact problem: which error each method has reached after how much CPU time.

Every point is a whole call from raw arrays, cold, that was asked for one accuracy; the next asks for ten
times more. A method stays in the picture until a call of it takes longer than `PATIENCE`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import surefoot as sf
from benchmarks.contact import rivals
from benchmarks.problems.judge import judge
from surefoot.base.arrays import FloatArray

OURS = ("auto", "interior_point", "admm", "newton", "nsgs")
"""Our methods in the picture, `auto` first."""
ASKED = tuple(10.0**-k for k in range(1, 10))
"""Accuracies that are asked for."""
PATIENCE, QUICK, REPEATS = 2.0, 0.05, 3
"""Seconds of a call after which a method is asked no more, and below which a call is repeated so often; the
quickest counts."""


@dataclass(frozen=True)
class AccuracyPath:
    """One method on one problem.

    Attributes
    ----------
    scene, solver
        Who on what.
    seconds, errors
        (k,) CPU time [s] of each call, and the velocity error that it reached, by `judge`; both in the order
        of what was asked.
    """

    scene: str
    solver: str
    seconds: FloatArray
    errors: FloatArray


def accuracy_paths(scene: str, problem: sf.ContactProblem, with_rivals: bool) -> Iterator[AccuracyPath]:
    """Yield the path of every method on a problem, ours and Pinocchio's in all its settings."""
    taken = sf.solver_names(problem)
    for name in OURS:
        if name in taken:
            yield AccuracyPath(scene, name, *_path(problem, _ours(problem, name)))
    if with_rivals:
        plain = sf.ContactProblem(problem.G, problem.g, problem.mu)
        for name, setting in rivals.settings(plain).items():
            yield AccuracyPath(scene, name, *_path(plain, _pinocchio(plain, setting)))


def _path(
    problem: sf.ContactProblem, call_for: Callable[[float], Callable[[], FloatArray]]
) -> tuple[FloatArray, FloatArray]:
    """Return seconds and errors of calls that ask for more and more, after one that compiles."""
    call_for(ASKED[0])()
    seconds, errors = [], []
    for tol in ASKED:
        call = call_for(tol)
        took, forces = _timed(call)
        if took < QUICK:
            took = min(took, *(_timed(call)[0] for _ in range(REPEATS - 1)))
        seconds.append(took)
        errors.append(judge(problem, forces))
        if took > PATIENCE:
            break
    return np.array(seconds), np.array(errors)


def _timed(call: Callable[[], FloatArray]) -> tuple[float, FloatArray]:
    start = time.thread_time()
    forces = call()
    return time.thread_time() - start, forces


def _ours(problem: sf.ContactProblem, name: str) -> Callable[[float], Callable[[], FloatArray]]:
    """Return what makes a call of ours for an accuracy."""
    G, g, mu = problem.G, problem.g, problem.mu
    return lambda tol: (
        lambda: sf.solve(sf.ContactProblem(G, g, mu), name, tol, max_time=2.0 * PATIENCE).forces
    )


def _pinocchio(
    problem: sf.ContactProblem, setting: rivals.Setting
) -> Callable[[float], Callable[[], FloatArray]]:
    """Return what makes a call of Pinocchio's for an accuracy: its own test's, over the fastest velocity."""
    item = rivals.matrix(problem, setting), problem.g
    scale = float(np.abs(problem.g).max(initial=0.0)) or 1.0

    def call_for(tol: float) -> Callable[[], FloatArray]:
        call = rivals.PinocchioCall(problem, setting, tol * scale, rivals.ITERATIONS_MANY)
        return lambda: call.fresh(item)

    return call_for


def draw_accuracy(paths: Sequence[AccuracyPath], path: Path) -> Path:
    """Draw one panel a scene, one line a method: the least error reached by calls up to so long."""
    from surefoot.app.viz.style import house_style, new_grid, save

    scenes = list(dict.fromkeys(one.scene for one in paths))
    solvers = list(dict.fromkeys(one.solver for one in paths))
    with house_style():
        figure, axes = new_grid(len(scenes), 3, (4.2, 3.2), (2.0, 0.4))
        for scene, panel in zip(scenes, axes, strict=True):
            for one in paths:
                if one.scene == scene:
                    order = np.argsort(one.seconds)
                    least = np.minimum.accumulate(one.errors[order])
                    panel.loglog(
                        1e3 * one.seconds[order], np.maximum(least, 1e-13), marker=".",
                        color=f"C{solvers.index(one.solver) % 10}", label=one.solver,
                        linewidth=2.0 if one.solver == "auto" else 0.8,
                        linestyle="--" if one.solver.startswith("pinocchio") else "-",
                    )  # fmt: skip
            panel.set(title=scene, xlabel="CPU time [ms]", ylabel="velocity error")
        lines = {line.get_label(): line for panel in axes for line in panel.get_lines()}
        axes[-1].legend(lines.values(), lines, loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=7)
        return save(figure, path)
