"""`auto` beside its own methods, and from 45 to 46 contacts: `python -m benchmarks.contact.methods`.

One problem of each family, cold, from raw arrays, at each of four accuracies: CPU time of `auto` over that of
the quickest single method that reaches the accuracy, by `judge`. Names or beginnings of families may be given
(`stack`, `wall`); `--quick` takes the small ones. Then the median of random contacts of one size over that of
the size before it.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from rich.console import Console

import surefoot as sf
from benchmarks.contact.accuracy import OURS
from benchmarks.printing import table
from benchmarks.problems.contacts import pile, problem_set
from benchmarks.problems.judge import judge
from benchmarks.problems.stacked_scenes import SCENES, steps
from surefoot.base.arrays import FloatArray

LEVELS = (1e-2, 1e-4, 1e-6, 1e-8)
"""Accuracies that are asked for."""
MOST_RATIO, PATIENCE, REPEATS, QUICK = 1.5, 5.0, 3, 0.05
"""What `auto` may take over the best single method, seconds of a call at most, and timed calls of one that
takes less than so many seconds; the quickest counts."""
AT_STEP, QUICK_CONTACTS = 40, 30
"""The step of a scene that stands for it, and contacts up to which a family is quick."""
SIZES, DRAWS, SIZE_TOL = (44, 45, 46, 47), 12, 1e-8
"""Contacts whose times are compared, random problems of each, and their tolerance."""


Raw = tuple[FloatArray, FloatArray, FloatArray]
"""G, g and mu of a problem."""


class Cell(NamedTuple):
    """One family at one accuracy: seconds of `auto` and of the best method; infinite where not reached."""

    family: str
    contacts: int
    level: float
    auto: float
    best: float
    method: str

    @property
    def ratio(self) -> float:
        """How many times as long `auto` takes; NaN where nobody gets there."""
        return self.auto / self.best if np.isfinite(self.best) else float("nan")

    @property
    def words(self) -> str:
        """What the table says."""
        own = f"{1e6 * self.auto:.0f}" if np.isfinite(self.auto) else "not reached"
        return f"{own}, {self.ratio:.2f} ({self.method})" if np.isfinite(self.best) else own


def families(names: list[str], quick: bool) -> Iterator[tuple[str, sf.ContactProblem]]:
    """Yield a problem of each family: scenes of bodies on bodies, and the two sets of the contact bench."""

    def chosen(name: str) -> bool:
        return not names or any(name.startswith(given) for given in names)

    for name, scene in SCENES.items():
        if chosen(name) and not (quick and name.startswith("wall")):
            *_, step = steps(scene, AT_STEP)
            if not (quick and step.problem.contacts > QUICK_CONTACTS):
                yield name, step.problem
    seen = set[str]()
    for scale in ("robot",) if quick else ("robot", "large"):
        for one in problem_set(scale):
            if one.family not in seen and chosen(one.family):
                seen.add(one.family)
                if not (quick and one.problem.contacts > QUICK_CONTACTS):
                    yield one.family, one.problem


def cells(name: str, problem: sf.ContactProblem) -> Iterator[Cell]:
    """Yield a family's cell at each accuracy."""
    dense = problem.G, problem.g, problem.mu
    methods = [method for method in OURS if method in sf.solver_names(problem)]
    for method in methods:  # kernels are compiled or loaded by a first call
        _call(dense, method, LEVELS[0])
    for level in LEVELS:
        took = {}
        for method in methods:
            seconds, forces = _call(dense, method, level)
            took[method] = seconds if judge(problem, forces) <= level else np.inf
        own = took.pop("auto")
        best = min(took, key=took.__getitem__)
        yield Cell(name, problem.contacts, level, own, took[best], best)


def _call(dense: Raw, method: str, tol: float) -> tuple[float, FloatArray]:
    """Return the least CPU seconds of a cold call from raw arrays, and its forces (n, 3)."""
    least = np.inf
    for _ in range(REPEATS):
        start = time.thread_time()
        forces = sf.solve(sf.ContactProblem(*dense), method, tol, max_time=PATIENCE).forces
        least = min(least, time.thread_time() - start)
        if least > QUICK:
            break
    return least, forces


def sizes() -> Iterator[tuple[int, float, float]]:
    """Yield contacts, median CPU seconds of cold and of warm calls on random contacts of a pile."""
    for contacts in SIZES:
        cold, warm = [], []
        for seed in range(DRAWS):
            problem = pile(np.random.default_rng(seed), 12, contacts, 0.6, 3.0)
            dense = problem.G, problem.g, problem.mu
            seconds, forces = _call(dense, "auto", SIZE_TOL)
            cold.append(seconds)
            pushed = sf.ContactProblem(dense[0], 1.001 * dense[1], dense[2])
            times = []
            for _ in range(REPEATS):
                start = time.thread_time()
                sf.solve(pushed, "auto", SIZE_TOL, warm_start=forces)
                times.append(time.thread_time() - start)
            warm.append(min(times))
        yield contacts, float(np.median(cold)), float(np.median(warm))


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("families", nargs="*", help="names of families or their beginnings; all by default")
    parser.add_argument("--quick", action="store_true", help="families of few contacts")
    given = parser.parse_args()
    console, rows, ratios = Console(), [], list[float]()
    for name, problem in families(given.families, given.quick):
        found = list(cells(name, problem))
        ratios += [cell.ratio for cell in found if not np.isnan(cell.ratio)]
        rows.append((name, str(problem.contacts), *(cell.words for cell in found)))
        print(*rows[-1], sep=", ", file=sys.stderr, flush=True)
    heads = ("family", "contacts", *(f"to {level:g}" for level in LEVELS))
    over = sum(ratio > MOST_RATIO for ratio in ratios)
    console.print(table(heads, rows, "auto [µs of CPU], over the best of its methods (which)"))
    console.print(
        f"largest ratio {max(ratios, default=0.0):.2f}; {over} of {len(ratios)} above {MOST_RATIO:g}"
    )
    lines, before = [], (np.nan, np.nan)
    for contacts, *now in sizes():
        texts = (f"{1e6 * a:.0f} ({a / b:.2f})" for a, b in zip(now, before, strict=True))
        lines.append((str(contacts), *(text.removesuffix(" (nan)") for text in texts)))
        before = now[0], now[1]
    console.print(table(("contacts", "cold", "warm"), lines, "Random contacts [µs], over one fewer"))


if __name__ == "__main__":
    main()
