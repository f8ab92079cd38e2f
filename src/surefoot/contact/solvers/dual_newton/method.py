"""Newton's method on the dual of a program over friction cones: the algorithm, whatever the linear algebra.

::

    min  h(a) + κ/2 ||f - c||²   subject to   a = B f,   f_i in truncated friction cones

with h strongly convex (for force distribution ½ ||a - b||², for a horizon the cost of the motion). Given the
multipliers y of the equation, both minimisations are closed: the forces are f = Π(c + Bᵀ y / κ), one
projection per contact, hence always inside the cones. What is left is to minimise the dual, a convex function
of y without constraints, whose gradient F = ∇h*(y) + B f is piecewise smooth and strongly monotone::

    d = -(∇²h* + B Π' Bᵀ / κ)⁻¹ F,      y <- y + t d

with the projection's generalised Jacobian Π' converges from anywhere under a line search, in the end
quadratically [1]_. ||F||² in the metric of h is twice the duality gap at f, so that every answer carries a
bound on its own error.

Where the optimum needs forces far from c and κ is small, the dual is almost polyhedral and Newton alone
zigzags. Then κ is first taken larger and brought back in stages (`follow_path`), each with a prediction of y:
a path that starts at an easy program and ends at ours.

The points c + Bᵀ y / κ are carried along and not computed from y, which has too few digits for them when κ is
tiny; a rounding error in a point is harmless, it acts like one in c.

References
----------
.. [1] L. Qi, J. Sun, "A nonsmooth version of Newton's method", Mathematical Programming 58, 1993.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from surefoot.base.kernels import inline_kernel, takes_kernels
from surefoot.base.numerics.line_search import search


class Form(NamedTuple):
    """What the method asks of a form; y, F and d are whatever the form keeps them as, numbers or arrays.

    Attributes
    ----------
    enter
        (memory, y, κ) -> F, error: the points and forces at the start of a stage.
    direction
        (memory, F, κ) -> d, F · d: Newton's direction, and what a full step does to the points.
    take
        (memory, y, d, κ, t, before) -> y + (t - before) d, F, error, F · d, with points and forces there.
    line
        (memory, y, d) -> y's part of the dual's derivative along d, and how it grows along a full step.
    derivative
        ((memory, κ, ahead, curve), t) -> the dual's derivative along d, t of the way, given `line` at y + d.
    rounding
        (memory, progress, tol) -> whether the error is no more than that of doubles.
    predict
        (memory, y, κ, smaller) -> a guess of y for a smaller κ.
    """

    enter: Callable[..., Any]
    direction: Callable[..., Any]
    take: Callable[..., Any]
    line: Callable[..., Any]
    derivative: Callable[..., Any]
    rounding: Callable[..., Any]
    predict: Callable[..., Any]


class Progress(NamedTuple):
    """Error now, the least so far, the steps taken, and those since the error was last halved."""

    error: float
    best: float
    steps: int
    idle: int


class Steps(NamedTuple):
    """When a full step is taken as it is, and how well a shorter one is searched.

    Attributes
    ----------
    ahead
        Share of the derivative at the start up to which the one at the end may have grown,
    nearer
        ... unless the error has fallen to this share of the best.
    accuracy
        Share of the derivative at which a search ends.
    """

    ahead: float
    nearer: float
    accuracy: float


@inline_kernel
@takes_kernels
def descend(
    form: Form, steps: Steps, memory: Any, y: Any, F: Any, error: float, kappa: float, tol: float,
    limit: float, patience: float,
) -> tuple[Any, Any, float, int]:  # fmt: skip
    """Take Newton steps from a point where F and its error are known; return y, F, error and their number.

    Stops at `tol`, at rounding, after `limit` steps, or when full steps have failed `patience` times.
    """
    best, count, idle = error, 0, 0
    while error > tol and count < limit and patience != 0.0:
        if form.rounding(memory, Progress(error, best, count, idle), tol):
            break
        count += 1
        d, at_0 = form.direction(memory, F, kappa)
        t, before, again = 1.0, 0.0, True
        while again:  # the full step, and a shorter one where that goes too far and no nearer either
            y, F, error, at_1 = form.take(memory, y, d, kappa, t, before)
            # at_1 = F · d at the full step: the dual's slope there. If it has grown to a share of what it was
            # at the start the step went far beyond the minimum; an error that fell well excuses it
            again = before == 0.0 and at_1 > -steps.ahead * at_0 and error > steps.nearer * best
            if again:
                patience -= 1.0
                before = 1.0
                ahead, curve = form.line(memory, y, d)
                line = memory, kappa, ahead, curve
                # out of patience: back to where the step began (t = 0), so
                # that the caller finds a point it knows
                t = 0.0 if patience == 0.0 else search(form.derivative, line, at_0, at_1, steps.accuracy)
        idle = 0 if error < 0.5 * best else idle + 1
        best = min(best, error)
    return y, F, error, count


class Path(NamedTuple):
    """A way from a larger κ to the wanted one.

    Attributes
    ----------
    start, end
        κ at the first stage and at the last.
    shrink
        Factor from stage to stage.
    accuracy, steps
        Error of a stage that is enough, and most steps of one.
    limit, last
        Most steps in all, and of the last stage.
    """

    start: float
    end: float
    shrink: float
    accuracy: float
    steps: float
    limit: float
    last: float


@inline_kernel
@takes_kernels
def follow_path(
    form: Form, newton: Callable[..., Any], memory: Any, y: Any, path: Path, tol: float
) -> tuple[Any, Any, float, int]:
    """Solve for a larger κ first and bring it back in stages; `newton`, of the form, is its `descend`."""
    kappa, count = path.start, 0
    while True:
        F, error = form.enter(memory, y, kappa)
        last = kappa <= path.end
        most = min(path.last if last else path.steps, path.limit - count)
        enough = tol if last else path.accuracy
        y, F, error, used = newton(memory, y, F, error, kappa, enough, most, -1.0)
        count += used
        # stages on the way are solved loosely: only their faces matter, which the prediction starts from
        if last:
            return y, F, error, count
        smaller = max(path.end, kappa * path.shrink)
        y = form.predict(memory, y, kappa, smaller)
        kappa = smaller
