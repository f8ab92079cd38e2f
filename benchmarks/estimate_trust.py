"""Error bars and doubts of the state estimate on made-up circles: the table of docs/tuning-estimates.md.

Run: python -m benchmarks.estimate_trust [--clean 20] [--seeds 1] [--json]. Clean circles are judged by NEES,
each fault is seeded into circles of its own.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np
from rich.table import Table
from scipy.stats import chi2

import surefoot as sf
from benchmarks.printing import show, table
from benchmarks.problems.circles import FAULTS, end_error, estimate_circle, random_circle, spoilt_circle


def circles(clean: int, seeds: int) -> Table:
    """Return the table: doubts in clean circles and those with a fault, errors in standard deviations."""
    robot, rows, total, raised = sf.load_robot("go1"), [], 0.0, 0
    for seed in range(clean):
        log = random_circle(robot, seed)
        ekf, doubts = estimate_circle(robot, log)
        error, covariance = end_error(ekf, log)
        total += float(error @ np.linalg.solve(covariance, error))
        raised += bool(doubts)
    low, high = (float(chi2.ppf(share, 12 * clean)) / clean for share in (0.025, 0.975))
    rows.append(("none", f"{raised} of {clean}", f"NEES {total / clean:.1f} ({low:.1f} to {high:.1f})", ""))
    for number, fault in enumerate(FAULTS):
        seen, worst, reason = 0, 0.0, ""
        for seed in range(seeds):
            log = spoilt_circle(robot, number + len(FAULTS) * seed, fault)
            ekf, doubts = estimate_circle(robot, log, mapped=fault.startswith("map"))
            error, covariance = end_error(ekf, log)
            worst = max(worst, float((np.abs(error) / np.sqrt(np.diag(covariance))).max()))
            seen, reason = seen + bool(doubts), doubts[0] if doubts else reason
        rows.append((fault, f"{seen} of {seeds}", f"{worst:.1f}", reason))
    columns = ("fault", "doubted", "largest error at the end [its deviations]", "first reason")
    return table(columns, rows, "go1, circles of 6.3 m", left=4)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clean", type=int, default=20)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args(arguments)
    show([circles(given.clean, given.seeds)], given.json)


if __name__ == "__main__":
    main()
