"""One judge of accuracy for everybody's forces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from surefoot.base.arrays import FloatArray
from surefoot.contact.problem import ContactProblem, residuals

STEPS_PER_DECADE = 8
"""How finely a rival's tolerance is chosen."""
DECADES = tuple(range(2, -6, -1))
"""Powers of ten, times the wanted residual, that a rival's tolerance is tried at; loosest first."""
Kept = TypeVar("Kept")


def judge(problem: ContactProblem, forces: FloatArray) -> float:
    """Return how far (n, 3) forces are from a solution, as `Status.SOLVED` is judged; infinite for NaN."""
    error = residuals(problem, forces).worst
    return error if error >= 0.0 else float("inf")


def finer(decade: int) -> tuple[float, ...]:
    """Return the powers of ten between the next looser decade and this one, loosest first."""
    return tuple(decade + k / STEPS_PER_DECADE for k in range(STEPS_PER_DECADE - 1, 0, -1))


def coarsest(
    attempt: Callable[[float], Kept | None],
    more_time: Callable[[], bool] = lambda: True,
    decades: Sequence[int] = DECADES,
) -> Kept | None:
    """Return the answer of the loosest tolerance that is accurate enough, None if no decade is.

    Parameters
    ----------
    attempt
        Is given a tolerance as a multiple of the wanted residual; None where it misses that residual.
    more_time
        Whether a tighter decade may be tried.
    decades
        Powers of ten to try, loosest first.
    """
    for decade in decades:
        best = attempt(10.0**decade)
        if best is not None:
            break
        if not more_time():
            return None
    else:
        return None
    if decade == decades[0]:
        return best
    steps = finer(decade)
    low, high = 0, len(steps)  # the loosest that reaches it is steps[low..high], the last being the decade
    while low < high:
        middle = (low + high) // 2
        found = attempt(10.0 ** steps[middle])
        low, high, best = (low, middle, found) if found is not None else (middle + 1, high, best)
    return best
