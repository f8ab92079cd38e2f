"""How often the 95 % intervals of `surefoot identify` hold the truth: a table of docs/reports/.

Run: python -m benchmarks.identify_coverage [--sets 100] [--tosses 64] [--first 1000] [--out FILE]
[--json]. A set
is made-up tosses with a good camera's noise on a tilted ground; with --out its row is written as soon as
it is known, and a run that was interrupted goes on after the last one.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.printing import show, table
from benchmarks.problems.tosses import random_tosses
from surefoot.records.identification.identify import identify
from surefoot.records.identification.toss_model import ThrownModel

RESAMPLES = 400
LAW = {"mu": 0.18, "restitution": 0.15, "rounding": 0.0026}
GROUND = (0.003, 0.01, -0.005)
"""Height [m] and slopes."""
TRUTH = LAW | {
    "ground": GROUND[0],
    "tilt_x": float(np.degrees(np.arctan(GROUND[1]))),
    "tilt_y": float(np.degrees(np.arctan(GROUND[2]))),
    "gravity": 9.81, "scale": 1.0, "com_z": 0.0, "spread_z": float(np.sqrt(0.5 * 0.00081 / 0.37)),
}  # fmt: skip


def one_set(seed: int, tosses: int) -> dict[str, list[float]]:
    """Return error and ends of the interval less the truth, by parameter, of one made-up set."""
    recorded = random_tosses(tosses, list(LAW.values()), ground=GROUND, seed=seed)
    fit = identify(recorded, ThrownModel(), resamples=RESAMPLES)
    rows = {name: [fit[name].value, fit[name].low, fit[name].high] for name in TRUTH}
    return {name: [v - TRUTH[name] for v in row] for name, row in rows.items()}


def coverage(rows: Sequence[dict[str, list[float]]]) -> Table:
    """Return the table: how many intervals hold the truth, their half-width, and the error's size."""
    found = []
    for name, truth in TRUTH.items():
        error, low, high = np.array([row[name] for row in rows]).T
        held = int(np.count_nonzero((low <= 0.0) & (high >= 0.0)))
        half, size = float(np.median(high - low)) / 2.0, float(np.sqrt(np.mean(error**2)))
        found.append((name, f"{truth:.4g}", f"{held} of {len(rows)}", f"{half:.2g}", f"{size:.2g}"))
    columns = ("parameter", "truth", "hold it", "half-width (median)", "error (rms)")
    return table(columns, found, f"{len(rows)} sets: 95 % intervals")


def main(arguments: Sequence[str] | None = None) -> None:
    """Fit the sets and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sets", type=int, default=100)
    parser.add_argument("--tosses", type=int, default=64)
    parser.add_argument("--first", type=int, default=1000, help="seed of the first set")
    parser.add_argument("--out", type=Path, help="file of rows, gone on with where it exists")
    parser.add_argument("--json", action="store_true", help="print the tables as JSON")
    given = parser.parse_args(arguments)
    rows: list[dict[str, list[float]]] = []
    if given.out is not None and given.out.exists():
        rows = [json.loads(line) for line in given.out.read_text().splitlines()][: given.sets]
    seeds = range(given.first + len(rows), given.first + given.sets)
    for seed in track(seeds, "sets", console=Console(stderr=given.json)):
        rows.append(one_set(seed, given.tosses))
        if given.out is not None:
            with given.out.open("a") as file:
                file.write(json.dumps(rows[-1]) + "\n")
    show([coverage(rows)], given.json)


if __name__ == "__main__":
    main()
