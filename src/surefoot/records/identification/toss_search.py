"""The search for the parameters of a simulator of tosses: Levenberg and Marquardt's on means over tosses.

The loss of a toss is the root mean square e of its corners' deviations over its frames, made robust as
sqrt(c² + e²) - c with the median error for c: a square for tosses that fit, the distance itself for those
that end on another face. A single toss jumps where a corner lands first, the mean over many hardly does, so
that differences over steps that show have slopes to go by [1]_. They are taken along the principal axes of
the curvature: parameters that make up for each other leave a valley across them, and single steps see its
bend rather than its fall. Intervals are bootstraps of the linearised fit, of what leaving out each toss moves
(the jackknife, since few tosses can bend a fit to themselves), with a share for what is held but not exactly
known. The model is a black box: all get this search.

References
----------
.. [1] J. J. Moré, "The Levenberg-Marquardt algorithm: implementation and theory", Numerical Analysis, 1978.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.records.identification.thrown_body import TossParameter
from surefoot.records.identification.toss_errors import LOST

FLOOR = 1e-3
"""Least median error [widths] that the robust loss takes."""
ROUNDS, TRIALS = 10, 5
"""Linearisations, and steps tried in each."""
SAME = 3e-4
"""Relative decrease of the loss that ends a search."""
PART, NEAR, WIDEST = 0.5, 2e-3, 10.0
"""Differences move tosses by this share of the median error or of so many widths, within so many steps."""
NARROW = 1e-4
"""Least share of a mean curvature along an axis that counts as measured."""
HIDDEN = 1e-6
"""A combination of parameters that differences move by less than this share is not shown by them."""
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


class TossResiduals(NamedTuple):
    """Deviations (N, m) [widths], the loss, the errors e (B,) of the tosses, and c."""

    rows: FloatArray
    loss: float
    errors: FloatArray
    scale: float


class Slopes(NamedTuple):
    """Derivatives per step of the parameters.

    Those of the deviations (N, m, d), weights (N,) of their rows; the gradient (B, d) of each toss and its
    curvature (B, d, d) by Gauss and Newton.
    """

    rows: FloatArray
    weight: FloatArray
    moments: FloatArray
    squares: FloatArray


def search(
    simulate: Callable[[FloatArray], FloatArray],
    parameters: Sequence[TossParameter],
    values: FloatArray,
    frames: IntArray,
    draws: FloatArray,
    held: FloatArray | None = None,
) -> SearchResult:
    """Fit parameters.

    Parameters
    ----------
    simulate
        From (d + h,) values, the last of them held, to (N, m) deviations, see `toss_errors.deviations`.
    parameters, values
        What is fitted, and (d + h,) where the search begins.
    frames
        (B,) rows of each toss.
    draws
        (S, B) weights of the tosses in each bootstrap sample.
    held
        (S, h) what the bootstrap samples say of the numbers that are held; none if there are none.
    """
    first, count = np.cumsum(frames) - frames, len(parameters)
    low, high, steps = (np.array([getattr(p, k) for p in parameters]) for k in ("low", "high", "step"))
    fixed, values = values[count:], np.clip(values[:count], low, high)

    def rows(values: FloatArray, others: FloatArray = fixed) -> FloatArray:
        found = simulate(np.concatenate([values, others]))
        return np.clip(np.nan_to_num(found, nan=LOST), -LOST, LOST)

    damp, settled, axes = DAMP, False, np.eye(count)
    here = _residuals(rows(values), first, frames, None)
    for _ in range(ROUNDS):
        slopes = _slopes(rows, values, steps, axes, (low, high), here, frames)
        square, slope, better = slopes.squares.mean(axis=0), slopes.moments.mean(axis=0), None
        axes = _axes(square, here.scale)
        for _ in range(TRIALS):
            # Marquardt's scaling by the diagonal: damping has no unit, and leaves the parameters' sizes
            # alone.
            lifted = square + damp * np.diag(np.diag(square) + 1e-12)
            ahead = np.clip(values - steps * _within(lifted, slope, values, low, high), low, high)
            there = _residuals(rows(ahead), first, frames, here.scale)
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
    moments = slopes.moments  # flat beyond c, the loss bends by less than its squares do
    bent = np.einsum("bk,bl,b->bkl", moments, moments, 1.0 / np.sqrt(here.scale**2 + here.errors**2))
    squares = slopes.squares - bent
    total = squares.sum(axis=0)
    # Newton's step of each bootstrap sample from the common optimum, where Σ moments = 0: a toss moves the
    # fit by its gradient over the curvature of the others (the jackknife's).
    moved = (draws - 1.0) @ np.einsum("bkl,bl->bk", _inverse(total - squares), moments)
    if held is not None:
        moved += _share(rows, values, fixed, held, here, slopes) @ _inverse(total)
    return SearchResult(values, np.clip(values - steps * moved, low, high), settled)


def _within(
    square: FloatArray, slope: FloatArray, values: FloatArray, low: FloatArray, high: FloatArray
) -> FloatArray:
    """Return the step (d,), in steps, of the parameters that are not held at the end of their range."""
    free = ~(((values <= low) & (slope > 0.0)) | ((values >= high) & (slope < 0.0)))
    out = np.zeros(len(values))
    out[free] = np.linalg.solve(square[np.ix_(free, free)], slope[free])
    return out


def _residuals(rows: FloatArray, first: IntArray, frames: IntArray, scale: float | None) -> TossResiduals:
    errors = np.sqrt(np.add.reduceat(np.einsum("ni,ni->n", rows, rows), first) / frames)
    c = max(float(np.median(errors)), FLOOR) if scale is None else scale
    return TossResiduals(rows, float(np.mean(np.sqrt(c * c + errors**2) - c)), errors, c)


def _axes(square: FloatArray, scale: float) -> FloatArray:
    """Return the principal axes of a curvature (d, d), in columns, so long that each moves tosses alike."""
    size = np.sqrt(np.maximum(np.diag(square), 1e-12))
    values, vectors = np.linalg.eigh(square / np.outer(size, size))
    axes = PART * np.sqrt(min(scale, NEAR)) * vectors / np.sqrt(np.maximum(values, NARROW)) / size[:, None]
    return np.asarray(axes / np.maximum(np.abs(axes).max(axis=0) / WIDEST, 1.0))


def _slopes(
    rows: Callable[[FloatArray], FloatArray], values: FloatArray, steps: FloatArray, axes: FloatArray,
    ends: tuple[FloatArray, FloatArray], here: TossResiduals, frames: IntArray,
) -> Slopes:  # fmt: skip
    """Return derivatives per step of the parameters, by differences along axes (d, d) within their ranges."""
    J, ways = np.empty((*here.rows.shape, len(values))), np.empty((len(values), len(values)))
    for k, way in enumerate(steps * axes.T):
        up, down = np.clip(values + way, *ends), np.clip(values - way, *ends)
        J[:, :, k], ways[:, k] = rows(up) - rows(down), (up - down) / steps
    long = np.maximum(np.abs(ways).max(axis=0), 1e-300)  # ranges may have left two ways alike, or none
    # Slopes along the axes, taken back to slopes by the parameters.
    J = J / long @ np.linalg.pinv(ways / long, rcond=HIDDEN)
    weight = np.repeat(1.0 / (frames * np.sqrt(here.scale**2 + here.errors**2)), frames)
    terms = np.einsum("nik,ni,n->nk", J, here.rows, weight)
    squares = np.einsum("nik,nil,n->nkl", J, J, weight)
    first = np.cumsum(frames) - frames
    return Slopes(J, weight, np.add.reduceat(terms, first), np.add.reduceat(squares, first))


def _inverse(square: FloatArray) -> FloatArray:
    """Return the inverses of curvatures (..., d, d); what nothing tells is left where it is."""
    size = square.shape[-1]
    lift = 1e-9 * np.trace(square, axis1=-2, axis2=-1)[..., None, None] / size * np.eye(size)
    return np.asarray(np.linalg.pinv(square + lift, hermitian=True))


def _share(
    rows: Callable[[FloatArray, FloatArray], FloatArray], values: FloatArray, fixed: FloatArray,
    held: FloatArray, here: TossResiduals, slopes: Slopes,
) -> FloatArray:  # fmt: skip
    """Return the gradients (S, d) that draws (S, h) of what is held make, one deviation a way."""
    spread = np.maximum(held.std(axis=0), 1e-12)
    left, sizes, ways = np.linalg.svd((held - fixed) / spread, full_matrices=False)
    out, count = np.zeros((len(held), len(values))), np.sqrt(len(held))
    for k in np.flatnonzero(sizes > 1e-6 * sizes[0]):
        there = np.clip(fixed + sizes[k] / count * ways[k] * spread, held.min(axis=0), held.max(axis=0))
        change = rows(values, there) - here.rows
        slope = np.einsum("nik,ni,n->k", slopes.rows, change, slopes.weight)
        out += np.outer(count * left[:, k], slope)
    return out
