"""What the frameworks' solvers return, and the checks of shapes that they share."""

from __future__ import annotations

from typing import Any, NamedTuple

from surefoot.base.errors import ProblemError, check_name
from surefoot.contact.laws import LAWS
from surefoot.contact.solution import Status

STATUSES = tuple(Status)
"""Status codes are places in this tuple: 0 is SOLVED."""
SOLVED, ALMOST, STALLED, INVALID = (
    STATUSES.index(s) for s in (Status.SOLVED, Status.ALMOST, Status.STALLED, Status.INVALID)
)
MODES = ("off", "open", "stick", "slide")
"""Mode codes are places in this tuple."""
OFF, OPEN, STICK, SLIDE = range(4)
KINK = 1e-6
"""Distance from a change of mode, over the problem's speed, within which a contact counts as a kink."""


class Forces(NamedTuple):
    """Contact forces of a batch, with their certificate; arrays of the framework that was asked.

    Attributes
    ----------
    forces, velocities
        (..., n, 3), contact frames (tangent, tangent, normal). Zero where the status is INVALID.
    status
        (...,) codes into `STATUSES`; 0 is SOLVED.
    residual
        (...,) the velocity error of `surefoot.Residuals`; infinite where the status is INVALID.
    modes
        (..., n) codes into `MODES`. The forces of a contact that is off or open are zero and so are their
        gradients, truly; `smoothing` gives open contacts gradients.
    kinks
        (..., n) whether the contact is within 1e-6 of changing its mode: gradients belong to `modes`.
    """

    forces: Any
    velocities: Any
    status: Any
    residual: Any
    modes: Any
    kinks: Any


def check_law(law: str) -> bool:
    """Return whether the law is convex.

    Raises
    ------
    ProblemError
        If there is no law of that name.
    """
    check_name("law", law, LAWS)
    return law == "convex"


def check_shapes(G: Any, g: Any, mu: Any, mask: Any = None) -> int:
    """Return the number of contacts n of G (..., 3n, 3n), g (..., 3n), mu () or (..., n), mask (..., n).

    Raises
    ------
    ProblemError
        If a shape does not fit; it names the array, what it has and what it should have.
    """
    shape = tuple(g.shape)
    if not shape or shape[-1] % 3 or shape[-1] == 0:
        raise ProblemError(f"g must have shape (..., 3n) with n >= 1 contacts, got {shape}")
    size = int(shape[-1])
    n = size // 3
    if tuple(G.shape) != (*shape[:-1], size, size):
        raise ProblemError(f"G must have shape {(*shape[:-1], size, size)} for this g, got {tuple(G.shape)}")
    for name, array, scalar in (("mu", mu, True), ("mask", mask, False)):
        if array is None:
            continue
        allowed = ((n,), (*shape[:-1], n)) + (((),) if scalar else ())
        if tuple(array.shape) not in allowed:
            words = " or ".join(str(s) for s in dict.fromkeys(allowed))
            raise ProblemError(f"{name} must have shape {words}, got {tuple(array.shape)}")
    return n


def check_dtype(name: str, dtype: Any) -> None:
    """Accept float32 and float64 by name.

    Raises
    ------
    ProblemError
        If it is another type.
    """
    kind = str(dtype).removeprefix("torch.")
    if kind not in ("float32", "float64"):
        raise ProblemError(f"{name} must be float32 or float64, got {kind}")
