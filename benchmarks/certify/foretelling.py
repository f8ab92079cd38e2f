"""What a reference's certificate foretells of its execution, beside what its acceleration alone foretells.

Each motion that a controller tracked comes as two files: what was asked of it, and what it did. Both are cut
into pieces; of a piece of the reference the share of impossible frames, their mean residual and the mean
acceleration of its centre of mass are told; of the execution, by how much that acceleration deviated. Rank
correlations say which of them foretells it, with 95 % intervals over pieces drawn anew.

    python -m benchmarks.certify.foretelling REFERENCE EXECUTED [REFERENCE EXECUTED ...] [--piece 0.5]

A reference that hangs above the ground is lowered first: a controller stands on it however high it was drawn.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import surefoot as sf
from benchmarks.certify.corruptions import resampled
from surefoot.base.arrays import FloatArray
from surefoot.records.motions.motion import Motion

RATE = 50.0
"""Of the motions that are compared [Hz]."""
STEP = 5
"""Frames to either side over which an acceleration is a difference: the window of certificates, 0.2 s."""
LOWERED = 1.0
"""Time over which the height of a reference above the ground is told [s]: its drift, not its jumps."""
RESTS = 20.0
"""Share of that time in which it stands at least [%]."""
DRAWS = 2000
LEAST = 5
"""Pieces of which a correlation is told at all."""
MEASURES = ("impossible frames", "mean residual", "mean acceleration")


class Piece(NamedTuple):
    """Of a reference: share of impossible frames [-], residual [m g], acceleration [m/s²].

    The deviation is of its execution's acceleration from that [m/s²].
    """

    motion: str
    impossible: float
    residual: float
    acceleration: float
    deviation: float


class Foretold(NamedTuple):
    """A measure's rank correlation with the deviation, and its 95 % interval over pieces drawn anew."""

    measure: str
    correlation: float
    low: float
    high: float


def lowered(motion: Motion) -> Motion:
    """Return a reference that stands on the ground: its height there, smooth over a second, is taken off."""
    from scipy.ndimage import gaussian_filter1d, percentile_filter

    frames = sf.certify_motion(motion.robot, motion).frames
    width = round(LOWERED * motion.rate)
    height = percentile_filter(frames.gap - frames.penetration, RESTS, 2 * (width // 2) + 1)
    q = motion.q.copy()
    q[:, 2] -= gaussian_filter1d(height, 0.25 * width)
    return replace(motion, q=q)


def accelerations(motion: Motion) -> FloatArray:
    """Return the (T - 2 STEP, 3) accelerations of the centre of mass [m/s²]."""
    com: FloatArray = np.array([motion.robot.com(q) for q in motion.q])
    change: FloatArray = com[2 * STEP :] - 2.0 * com[STEP:-STEP] + com[: -2 * STEP]
    return change / (STEP / motion.rate) ** 2


def pieces_of(reference: Motion, executed: Motion, piece: float) -> list[Piece]:
    """Return the whole pieces [s] of a motion and its execution, both from their first frame on."""
    asked, done = resampled(reference, RATE), resampled(executed, RATE)
    frames = sf.certify_motion(asked.robot, lowered(asked)).frames
    wanted, had = accelerations(asked), accelerations(done)
    count = min(len(wanted), len(had))
    size = np.linalg.norm(wanted[:count], axis=1)
    off = np.linalg.norm(had[:count] - wanted[:count], axis=1)
    inner = slice(STEP, STEP + count)
    bad, left = frames.verdict[inner] == "impossible", np.nan_to_num(frames.share[inner])
    long = round(piece * RATE)
    return [
        Piece(reference.name, *(float(x[k : k + long].mean()) for x in (bad, left, size, off)))
        for k in range(0, count - long + 1, long)
    ]


def foretell(pieces: Sequence[Piece], seed: int = 0) -> list[Foretold]:
    """Return each measure's rank correlation with the deviation."""
    table = np.array([piece[1:] for piece in pieces])
    drawn = table[np.random.default_rng(seed).integers(0, len(table), (DRAWS, len(table)))]
    out = []
    for j, measure in enumerate(MEASURES):
        again = np.array([_rank_correlation(t[:, j], t[:, -1]) for t in drawn])
        told = again[np.isfinite(again)]
        low, high = np.percentile(told, [2.5, 97.5]) if len(told) else (np.nan, np.nan)
        out.append(Foretold(measure, _rank_correlation(table[:, j], table[:, -1]), float(low), float(high)))
    return out


def _rank_correlation(x: FloatArray, y: FloatArray) -> float:
    """Return the rank correlation of two measures of the same pieces, NaN where one of them never changes."""
    from scipy.stats import spearmanr

    return float(spearmanr(x, y).statistic) if np.ptp(x) * np.ptp(y) > 0.0 else np.nan


def main() -> None:
    """Print the correlations of pairs of files."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("files", nargs="+", help="references, each before its execution")
    parser.add_argument("--robot", default="g1")
    parser.add_argument("--piece", type=float, default=0.5, help="length of a piece [s]")
    options = parser.parse_args()
    if len(options.files) % 2:
        parser.error("each reference needs its execution: an even number of files")
    robot, pieces = sf.load_robot(options.robot), []
    for asked, done in zip(options.files[::2], options.files[1::2], strict=True):
        motions = (sf.read_motion(asked, robot), sf.read_motion(done, robot))
        pieces += pieces_of(*motions, options.piece)
    if len(pieces) < LEAST:
        parser.error(f"{len(pieces)} pieces of {options.piece:g} s tell nothing: at least {LEAST} are needed")
    print(f"{len(pieces)} pieces of {options.piece:g} s of {len(options.files) // 2} motions")
    for one in foretell(pieces):
        print(f"{one.measure}: rank correlation {one.correlation:.2f} ({one.low:.2f} to {one.high:.2f})")


if __name__ == "__main__":
    main()
