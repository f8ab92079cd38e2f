"""What a search lowers: how far simulated tosses are from recorded ones, robust against those that part.

A row of deviations has places in its first three columns, turns and joints in the others; rows of whole
tosses come weighed (`frame_weights`). Of each of these two kinds every toss has an error e, the root mean
square over its frames, made robust as sqrt(c² + e²) - c with the median error of the kind for c: a square
for tosses that fit, the distance itself for those that end on another face. The loss is the mean over
tosses of the sum over both kinds, turns shared so that their c is as much as that of places. For a toss on
another face is as far off in its turn as it can be, but where it slid to still tells friction and
restitution: in one error of both, turns drown places.

It is soft-L1 of a whole toss, which `least_squares` [1]_ knows for single numbers only: so the deviations of
a toss are scaled until their squares add up to it.

References
----------
.. [1] M. A. Branch, T. F. Coleman, Y. Li, "A subspace, interior, and conjugate gradient method for
   large-scale bound-constrained minimization problems", SIAM J. Sci. Comput. 21(1), 1999.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray

PLACES = 3
"""Columns of a row of deviations that are a place."""
KINDS = slice(0, PLACES), slice(PLACES, None)
"""Columns of each kind: places, and turns with joints."""
FLOOR = 1e-3
"""Least median error [widths] that the robust loss takes."""


def spread_kinds(numbers: FloatArray, columns: int) -> FloatArray:
    """Return numbers of each kind (N, G, ...) as numbers of each of so many columns (N, m, ...)."""
    return np.asarray(numbers[:, np.minimum(np.arange(columns) // PLACES, numbers.shape[1] - 1)])


class Deviations(NamedTuple):
    """How far the frames of tosses are off, and what the loss makes of it.

    Attributes
    ----------
    rows
        (N, m) deviations [widths].
    frames
        (B,) rows of each toss.
    errors
        (B, G) root mean squares over the frames of each toss: of places, and of the other columns if any.
    scale
        (G,) the errors c from which the loss is robust.
    """

    rows: FloatArray
    frames: IntArray
    errors: FloatArray
    scale: FloatArray

    @property
    def share(self) -> FloatArray:
        """(G,) of each kind in the loss."""
        return np.asarray(self.scale[0] / self.scale)

    @property
    def away(self) -> FloatArray:
        """(B, G) sqrt(c² + e²)."""
        return np.asarray(np.hypot(self.scale, self.errors))

    @property
    def robust(self) -> FloatArray:
        """(B,) the loss of each toss [widths]."""
        return np.asarray((self.away - self.scale) @ self.share)

    @property
    def loss(self) -> float:
        """The mean over tosses [widths]."""
        return float(np.mean(self.robust))

    def spread(self, kinds: FloatArray) -> FloatArray:
        """Return numbers of each toss and kind (B, G, ...) as numbers of each row and column (N, m, ...)."""
        return np.repeat(spread_kinds(kinds, self.rows.shape[1]), self.frames, axis=0)


class Slopes(NamedTuple):
    """Derivatives of deviations and loss per step of the parameters.

    Attributes
    ----------
    rows
        (N, m, d) of the deviations.
    weight
        (N, m) by which they are weighed in the curvature.
    moments
        (B, G, d) gradients of each kind's part of a toss's loss.
    squares
        (B, d, d) curvature of each toss's loss by Gauss and Newton.
    """

    rows: FloatArray
    weight: FloatArray
    moments: FloatArray
    squares: FloatArray

    @property
    def gradients(self) -> FloatArray:
        """(B, d) of each toss's loss."""
        return np.asarray(self.moments.sum(axis=1))


def measure_rows(rows: FloatArray, frames: IntArray, scale: FloatArray | None) -> Deviations:
    """Return deviations (N, m) with their errors; without a scale (G,) it is the median toss's."""
    errors = np.sqrt(_sums(rows**2, frames) / frames[:, None])
    c = np.maximum(np.median(errors, axis=0), FLOOR) if scale is None else scale
    return Deviations(rows, frames, errors, c)


def slopes_of_rows(here: Deviations, J: FloatArray) -> Slopes:
    """Return the derivatives of the loss from those (N, m, d) of the deviations."""
    weight = here.spread(here.share / here.away / here.frames[:, None])
    moments = _sums(J * (weight * here.rows)[:, :, None], here.frames)
    squares = np.einsum("nik,nil,ni->nkl", J, J, weight)
    return Slopes(J, weight, moments, np.add.reduceat(squares, _first(here.frames)))


def curvature(here: Deviations, slopes: Slopes) -> FloatArray:
    """Return (B, d, d) how each toss's loss bends: flat beyond c, by less than its squares do."""
    moments = slopes.moments
    bent = np.einsum("bgk,bgl,bg->bkl", moments, moments, 1.0 / (here.share * here.away))
    return np.asarray(slopes.squares - bent)


def robust_deviations(here: Deviations) -> FloatArray:
    """Return the deviations (N m,), scaled: half the sum of their squares is c of places times the losses."""
    return np.asarray((here.rows * here.spread(_weights(here))).ravel())


def robust_slopes(here: Deviations, slopes: Slopes) -> FloatArray:
    """Return the derivatives (N m, d) of `robust_deviations`, per step of the parameters."""
    # The weight s of a toss falls with its error: ds = -s e de / (2 q (q + c)), e de the toss's mean of r dr.
    q, c = here.away, here.scale
    mean = slopes.moments * (q / here.share)[:, :, None]
    fall = here.spread((0.5 / (q * (q + c)))[:, :, None] * mean)
    J = here.spread(_weights(here))[:, :, None] * (slopes.rows - here.rows[:, :, None] * fall)
    return np.asarray(J.reshape(-1, J.shape[2]))


def _weights(here: Deviations) -> FloatArray:
    """Return the weights s (B, G) of rows."""
    # 2 c (q - c) = 2 c e² / (q + c): no difference of like numbers, no division by e
    sizes = 2.0 * here.scale[0] * here.share / (here.away + here.scale)
    return np.asarray(np.sqrt(sizes / here.frames[:, None]))


def _sums(rows: FloatArray, frames: IntArray) -> FloatArray:
    """Return the sums (B, G, ...) of (N, m, ...) numbers over a toss's rows and a kind's columns."""
    kinds = [rows[:, part].sum(axis=1) for part in KINDS]
    return np.asarray(np.add.reduceat(np.stack(kinds, axis=1), _first(frames)))[:, : _kinds(rows)]


def _kinds(rows: FloatArray) -> int:
    """Return of how many kinds the columns are."""
    return 1 if rows.shape[1] <= PLACES else 2


def _first(frames: IntArray) -> IntArray:
    """Return (B,) the first row of each toss."""
    return np.asarray(np.cumsum(frames) - frames)
