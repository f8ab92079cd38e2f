"""The search for parameters of a simulator of tosses: a trust region on means over tosses, several starts.

What falls is the robust mean of `toss_loss`. A single toss jumps where a corner lands first, the mean over
many hardly does, so that differences over steps that show have slopes to go by. They are taken along the
principal axes of the curvature: parameters that make up for each other leave a valley across them, and single
steps see its bend rather than its fall. What is left of the jumps are small valleys beside each other. So a
search looks at points around where it ended, single parameters moved and all of them at random, and starts
again from the best of them. At the end single parameters are moved by a third of a step to twelve steps until
none of these moves pays.

Intervals are bootstraps over tosses: each sample takes the point that is best for its tosses, of all that the
search has been at, which is as far away as the loss is rough, and from there the step of the linearised fit,
by what leaving out each toss moves (the jackknife, since few tosses can bend a fit to themselves), with a
share for what is held but not exactly known. The model is a black box: all get this search.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.records.identification.thrown_body import TossParameter
from surefoot.records.identification.toss_errors import clip_deviations
from surefoot.records.identification.toss_loss import (
    Deviations,
    Slopes,
    curvature,
    measure_rows,
    robust_deviations,
    robust_slopes,
    slopes_of_rows,
)

TRIALS = 40
"""Points that one descent may try; each that is better also takes two simulations a parameter for slopes."""
SAME = 3e-4
"""Relative decrease of the loss that ends a descent, and the least that another start has to bring."""
DRAWN, AROUND = 24, 3.0
"""Points looked at around the end of a descent, and how far each parameter is moved at most [steps]."""
STARTS = 4
"""Most descents of a search."""
FEW = 6
"""Parameters up to which another start need not itself be better than the best point: descents are cheap."""
PART, NEAR, WIDEST = 0.5, 2e-3, 10.0
"""Differences move tosses by this share of the median error or of so many widths, within so many steps."""
WAYS = (0.3, 1.0, 3.5, 12.0)
"""Moves of a single parameter in the first round of the polish, either way [steps]."""
FACTORS = (1.0, 0.6, 1.7, 0.35, 1.3, 0.8, 0.5, 1.5, 0.25, 1.1, 0.7, 2.0)
"""Factors on these moves, round by round: a round looks where the one before did not."""
ALONE = 2e-3
"""Relative decrease of the loss by one parameter alone from which a further round is made."""
FAR, ELSEWHERE = 0.05, 0.01
"""A move that raises the loss by the first share was too far: longer ones to that side are left out, until a
round has lowered it by the second."""
SHORTER, THIRDS = 1.0 / 3.0, 4
"""Where the shortest move is too far, it is shortened by this factor so often at most until it is not."""
NARROW = 1e-4
"""Least share of a mean curvature along an axis that counts as measured."""
HIDDEN = 1e-6
"""A combination of parameters that differences move by less than this share is not shown by them."""


class SearchResult(NamedTuple):
    """What a search found.

    Attributes
    ----------
    values
        (d,) the parameters.
    draws
        (S, d) the same for each bootstrap sample.
    settled
        Whether the loss had stopped falling, along single parameters too.
    loss, scale
        Of the values, and the errors c (G,) from which it is robust [widths].
    """

    values: FloatArray
    draws: FloatArray
    settled: bool
    loss: float
    scale: FloatArray


def search(
    simulate: Callable[[FloatArray], FloatArray],
    parameters: Sequence[TossParameter],
    values: FloatArray,
    frames: IntArray,
    draws: FloatArray,
    held: FloatArray | None = None,
    *,
    others: Sequence[FloatArray] = (),
    scale: FloatArray | None = None,
    descents: int = STARTS,
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
    others
        (d,) further points to start from. The result is at least as good as each of them, and as `values`.
    scale
        The errors c (G,) from which the loss is robust [widths]; None for the median errors at the start.
    descents
        Most descents; with 0 single parameters alone are moved.
    """
    count = len(parameters)
    low, high, steps = (np.array([getattr(p, k) for p in parameters]) for k in ("low", "high", "step"))
    fixed, values = values[count:], np.clip(values[:count], low, high)

    def rows(values: FloatArray, others: FloatArray = fixed) -> FloatArray:
        return clip_deviations(simulate(np.concatenate([values, others])))

    valley = _Valley(rows, frames, (low, high), steps, values, scale)
    for other in others:
        valley.at(np.clip(other, low, high))
    settled = descents == 0 or _descend_often(valley, [values, *others], descents)
    settled &= valley.polish()
    values, here = valley.values, valley.best
    slopes = valley.slopes(values, here)
    squares = curvature(here, slopes)
    total = squares.sum(axis=0)
    # Newton's step of each bootstrap sample from the common optimum, where the gradients add up to 0: a toss
    # moves the fit by its own over the curvature of the others (the jackknife's).
    moved = (draws - 1.0) @ np.einsum("bkl,bl->bk", _inverse(total - squares), slopes.gradients)
    if held is not None:
        moved += _share(rows, values, fixed, held, here, slopes) @ _inverse(total)
    spread = np.clip(valley.best_points(draws) - steps * moved, low, high)
    return SearchResult(values, spread, settled, here.loss, here.scale)


def _descend_often(valley: _Valley, starts: Sequence[FloatArray], most: int) -> bool:
    """Go down from several points; return whether the last descent that paid had come to its end."""
    few = len(starts[0]) <= FEW
    settled = True
    for start in starts if few else [valley.values]:
        before = valley.best.loss
        done = valley.descend(start)
        settled = done if valley.best.loss < before else settled
    for number in range(1, most):
        before = valley.best.loss
        around = valley.around(number, better=not few)
        if around is None:
            break
        done = valley.descend(around)
        if valley.best.loss < (1.0 - SAME) * before:
            settled = done
    return settled


class _Valley:
    """The loss around the best values found so far, and descents in it."""

    def __init__(
        self, rows: Callable[[FloatArray], FloatArray], frames: IntArray, ends: tuple[FloatArray, FloatArray],
        steps: FloatArray, values: FloatArray, scale: FloatArray | None,
    ) -> None:  # fmt: skip
        self._rows, self._frames, self._ends, self._steps = rows, frames, ends, steps
        self._axes = np.eye(len(values))
        self.values, self.best = values, measure_rows(rows(values), frames, scale)
        self._last, self._there = values, self.best
        self._tried = [(values, self.best.robust)]

    def at(self, values: FloatArray) -> Deviations:
        """Return the deviations at values (d,), and remember them if they are the best."""
        if np.array_equal(values, self._last):
            return self._there
        there = measure_rows(self._rows(values), self._frames, self.best.scale)
        self._last, self._there = values.copy(), there
        self._tried.append((self._last, there.robust))
        if there.loss < self.best.loss:
            self.values, self.best = self._last, there
        return there

    def slopes(self, values: FloatArray, here: Deviations) -> Slopes:
        """Return the derivatives at values (d,); the next ones go along the axes of this curvature."""
        out = _slopes(self._rows, values, self._steps, self._axes, self._ends, here)
        self._axes = _axes(out.squares.mean(axis=0), float(here.scale[0]))
        return out

    def descend(self, values: FloatArray) -> bool:
        """Go down from values (d,) by a trust region; return whether the loss stopped falling."""
        free = self._ends[0] < self._ends[1]  # a range that is a point leaves nothing to search
        if not free.any():
            return True
        steps, (low, high) = self._steps[free], (end[free] for end in self._ends)

        def point(x: FloatArray) -> FloatArray:
            out = values.copy()
            out[free] = x * steps
            return out

        def residuals(x: FloatArray) -> FloatArray:
            return robust_deviations(self.at(point(x)))

        def jacobian(x: FloatArray) -> FloatArray:
            here = self.at(point(x))
            return robust_slopes(here, self.slopes(point(x), here))[:, free]

        found = least_squares(
            residuals, values[free] / steps, jacobian, (low / steps, high / steps),
            method="trf", ftol=SAME, xtol=1e-4, gtol=1e-12, x_scale="jac", max_nfev=TRIALS,
        )  # fmt: skip
        return bool(found.status > 0)

    def polish(self) -> bool:
        """Move single parameters, wherever that pays; return whether none of a whole round's moves did.

        Rounds leave out what was too far before, until one brings little: the next leaves out nothing.
        """
        random, whole = np.random.default_rng(0), False
        far = np.full((2, len(self._steps)), np.inf)  # to either side, the shortest move that was too far
        for factor in FACTORS:
            begin, most = self.best.loss, 0.0
            for k in random.permutation(len(self._steps)):
                before, middle = self.best.loss, self.values[k]
                for i, side in enumerate((1.0, -1.0)):
                    known = np.inf if whole else far[i, k]
                    far[i, k] = min(known, self._move_alone(k, middle, side, factor, known, whole))
                most = max(most, 1.0 - self.best.loss / max(before, 1e-300))
            if most < ALONE and whole:
                return True
            whole = most < ALONE
            if self.best.loss < (1.0 - ELSEWHERE) * begin:  # what was too far there need not be so here
                far[:] = np.inf
        return False

    def _move_alone(
        self, k: int, middle: float, side: float, factor: float, known: float, whole: bool
    ) -> float:
        """Move parameter k from a value to one side; return the shortest move [steps] that was too far."""

        def is_far(way: float) -> bool:
            point, (low, high) = self.values.copy(), self._ends
            point[k] = np.clip(middle + side * way * self._steps[k], low[k], high[k])
            return bool(self.at(point).loss > (1.0 + FAR) * self.best.loss)

        nearest, short = known, factor * WAYS[0]
        for way in WAYS:
            if (whole or factor * way < nearest) and is_far(factor * way):
                nearest = min(nearest, factor * way)
        for _ in range(THIRDS):
            if nearest > short:
                break
            short *= SHORTER
            if short < nearest and is_far(short):
                nearest = short
        return nearest

    def best_points(self, draws: FloatArray) -> FloatArray:
        """Return (S, d) the best of all points that were tried, for weights (S, B) of the tosses."""
        points, losses = (np.array(part) for part in zip(*self._tried, strict=True))
        return np.asarray(points[np.argmin(draws @ losses.T, axis=1)])

    def around(self, seed: int, better: bool) -> FloatArray | None:
        """Return the best point (d,) of those around the best one; with `better`, None if it is no better."""
        middle, least, count = self.values, self.best.loss, len(self._steps)
        drawn = np.random.default_rng(seed).uniform(-AROUND, AROUND, (DRAWN, count))
        moves = np.concatenate([np.eye(count), -np.eye(count), drawn])
        points = np.clip(middle + moves * self._steps, *self._ends)
        losses = [self.at(point).loss for point in points]
        best = int(np.argmin(losses))
        return None if better and not losses[best] < (1.0 - SAME) * least else points[best]


def _axes(square: FloatArray, scale: float) -> FloatArray:
    """Return the principal axes of a curvature (d, d), in columns, so long that each moves tosses alike."""
    size = np.sqrt(np.maximum(np.diag(square), 1e-12))
    values, vectors = np.linalg.eigh(square / np.outer(size, size))
    axes = PART * np.sqrt(min(scale, NEAR)) * vectors / np.sqrt(np.maximum(values, NARROW)) / size[:, None]
    return np.asarray(axes / np.maximum(np.abs(axes).max(axis=0) / WIDEST, 1.0))


def _slopes(
    rows: Callable[[FloatArray], FloatArray], values: FloatArray, steps: FloatArray, axes: FloatArray,
    ends: tuple[FloatArray, FloatArray], here: Deviations,
) -> Slopes:  # fmt: skip
    """Return derivatives per step of the parameters, by differences along axes (d, d) within their ranges."""
    J, ways = np.empty((*here.rows.shape, len(values))), np.empty((len(values), len(values)))
    for k, way in enumerate(steps * axes.T):
        up, down = np.clip(values + way, *ends), np.clip(values - way, *ends)
        J[:, :, k], ways[:, k] = rows(up) - rows(down), (up - down) / steps
    long = np.maximum(np.abs(ways).max(axis=0), 1e-300)  # ranges may have left two ways alike, or none
    # Slopes along the axes, taken back to slopes by the parameters.
    J = J / long @ np.linalg.pinv(ways / long, rcond=HIDDEN)
    return slopes_of_rows(here, J)


def _inverse(square: FloatArray) -> FloatArray:
    """Return the inverses of curvatures (..., d, d); what nothing tells is left where it is."""
    size = square.shape[-1]
    lift = 1e-9 * np.trace(square, axis1=-2, axis2=-1)[..., None, None] / size * np.eye(size)
    return np.asarray(np.linalg.pinv(square + lift, hermitian=True))


def _share(
    rows: Callable[[FloatArray, FloatArray], FloatArray], values: FloatArray, fixed: FloatArray,
    held: FloatArray, here: Deviations, slopes: Slopes,
) -> FloatArray:  # fmt: skip
    """Return the gradients (S, d) that draws (S, h) of what is held make, one deviation a way."""
    spread = np.maximum(held.std(axis=0), 1e-12)
    left, sizes, ways = np.linalg.svd((held - fixed) / spread, full_matrices=False)
    out, count = np.zeros((len(held), len(values))), np.sqrt(len(held))
    for k in np.flatnonzero(sizes > 1e-6 * sizes[0]):
        there = np.clip(fixed + sizes[k] / count * ways[k] * spread, held.min(axis=0), held.max(axis=0))
        change = rows(values, there) - here.rows
        slope = np.einsum("nik,ni,ni->k", slopes.rows, change, slopes.weight)
        out += np.outer(count * left[:, k], slope)
    return out
