"""The search for the parameters of a simulator of tosses: Levenberg and Marquardt's on means over tosses.

The loss of a toss is the root mean square e of its corners' deviations over its frames, made robust as
sqrt(c² + e²) - c with the median error for c: a square for tosses that fit, the distance itself for those
that end on another face. A single toss jumps where a corner lands first, the mean over many hardly does, so
that differences over steps that show have slopes to go by [1]_. Intervals are bootstraps of the linearised
fit: one gradient a toss, then sums over resampled tosses. The model is a black box: all get this search.

References
----------
.. [1] J. J. Moré, "The Levenberg-Marquardt algorithm: implementation and theory", Numerical Analysis, 1978.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.estimation.thrown_body import TossParameter
from surefoot.estimation.toss_errors import LOST

FLOOR = 1e-3
"""Least median error [widths] that the robust loss takes."""
ROUNDS, TRIALS = 10, 5
"""Linearisations, and steps tried in each."""
SAME = 3e-4
"""Relative decrease of the loss that ends a search."""
DAMP, LESS, MORE = 1e-3, 0.1, 10.0
"""First damping, and its change after a step that helped and one that did not."""


class SearchResult(NamedTuple):
    """What a search found.

    Attributes
    ----------
    values
        (d,) the parameters.
    draws
        (S, d) the same for each bootstrap sample.
    settled
        Whether the loss had stopped falling.
    """

    values: FloatArray
    draws: FloatArray
    settled: bool


class Residuals(NamedTuple):
    """Deviations (N, m) [widths], the loss, the errors e (B,) of the tosses, and c."""

    rows: FloatArray
    loss: float
    errors: FloatArray
    scale: float


def search(
    simulate: Callable[[FloatArray], FloatArray],
    parameters: Sequence[TossParameter],
    values: FloatArray,
    frames: IntArray,
    draws: FloatArray,
) -> SearchResult:
    """Fit parameters.

    Parameters
    ----------
    simulate
        From (d,) values to (N, m) deviations, see `toss_errors.deviations`.
    parameters, values
        What is fitted, and (d,) where the search begins.
    frames
        (B,) rows of each toss.
    draws
        (S, B) weights of the tosses in each bootstrap sample.
    """
    owner = np.repeat(np.arange(frames.size), frames)
    low, high, steps = (np.array([getattr(p, k) for p in parameters]) for k in ("low", "high", "step"))
    values, damp, settled = np.clip(values, low, high), DAMP, False
    here = _residuals(simulate(values), owner, frames, None)
    for _ in range(ROUNDS):
        square, moments = _linearised(simulate, values, steps, high, here, owner, frames)
        slope, better = moments.mean(axis=0), None
        for _ in range(TRIALS):
            lifted = square + damp * np.diag(np.diag(square) + 1e-12)
            ahead = np.clip(values - steps * _within(lifted, slope, values, steps, low, high), low, high)
            there = _residuals(simulate(ahead), owner, frames, here.scale)
            if there.loss < here.loss:
                better = there
                break
            damp *= MORE
        if better is None:
            settled = True
            break
        settled = here.loss - better.loss < SAME * here.loss
        values, here, damp = ahead, better, LESS * damp
        if settled:
            break
    square, moments = _linearised(simulate, values, steps, high, here, owner, frames)
    turned = (draws - 1.0) @ moments / frames.size
    inverse = np.linalg.pinv(
        square + 1e-9 * np.trace(square) / len(values) * np.eye(len(values)), hermitian=True
    )
    return SearchResult(values, np.clip(values - steps * (turned @ inverse), low, high), settled)


def _within(
    square: FloatArray, slope: FloatArray, values: FloatArray, steps: FloatArray, low: FloatArray,
    high: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return the step (d,), in steps, of the parameters that are not held at the end of their range."""
    free = ~(((values <= low) & (slope > 0.0)) | ((values >= high) & (slope < 0.0)))
    out = np.zeros(len(values))
    out[free] = np.linalg.solve(square[np.ix_(free, free)], slope[free])
    return out


def _residuals(rows: FloatArray, owner: IntArray, frames: IntArray, scale: float | None) -> Residuals:
    rows = np.clip(np.nan_to_num(rows, nan=LOST), -LOST, LOST)
    errors = np.sqrt(np.bincount(owner, np.einsum("ni,ni->n", rows, rows)) / frames)
    c = max(float(np.median(errors)), FLOOR) if scale is None else scale
    return Residuals(rows, float(np.mean(np.sqrt(c * c + errors**2) - c)), errors, c)


def _linearised(
    simulate: Callable[[FloatArray], FloatArray], values: FloatArray, steps: FloatArray, high: FloatArray,
    here: Residuals, owner: IntArray, frames: IntArray,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Return the curvature (d, d) and the gradients of all tosses (B, d), per step of the parameters."""
    J = np.empty((*here.rows.shape, len(values)))
    for k, step in enumerate(steps):
        way = step if values[k] + step <= high[k] else -step
        moved = values.copy()
        moved[k] += way
        rows = np.clip(np.nan_to_num(simulate(moved), nan=LOST), -LOST, LOST)
        J[:, :, k] = (rows - here.rows) * (step / way)
    weight = (1.0 / (frames * np.sqrt(here.scale**2 + here.errors**2)))[owner]
    square = np.einsum("nik,nil,n->kl", J, J, weight) / frames.size
    terms = np.einsum("nik,ni,n->nk", J, here.rows, weight)
    moments = np.stack([np.bincount(owner, terms[:, k]) for k in range(len(values))], axis=1)
    return np.asarray(square), np.asarray(moments)
