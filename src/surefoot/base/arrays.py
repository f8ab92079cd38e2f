"""Array types, and the one place where numbers from outside are checked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surefoot.base.errors import ProblemError, shown

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]

_FLOAT, _BOOL = np.dtype(np.float64), np.dtype(np.bool_)


def array_of(name: str, value: ArrayLike, kinds: str, wanted: str, dtype: type | None) -> NDArray[Any]:
    """Return `value` as an array (...) of a dtype, in C order, if its entries are of NumPy's kinds.

    No dtype stands for the value's own; what was `wanted` is said in the message. Masked entries are no
    entries.
    """
    try:
        array = np.asarray(value)
        if array.dtype.kind not in kinds or (hasattr(value, "mask") and np.ma.is_masked(value)):
            raise TypeError
        return np.asarray(array, dtype, order="C")
    except (TypeError, ValueError, OverflowError, RuntimeError) as error:
        raise ProblemError(f"{name} must be {wanted}, got {shown(value)}") from error


def numbers(name: str, value: ArrayLike) -> FloatArray:
    """Return `value` as floats (...) in C order, itself where it is that, with its NaN and infinity.

    Neither text, dates nor complex numbers are numbers.
    """
    if type(value) is np.ndarray and value.dtype == _FLOAT and value.flags.c_contiguous:
        return value
    return array_of(name, value, "biufO", "numeric", np.float64)


def real_array(name: str, value: ArrayLike, shape: Sequence[int | None] | None = None) -> FloatArray:
    """Return `value` as a float array of the wanted shape, with no NaN in it (infinity is allowed).

    Parameters
    ----------
    name
        What the value is called in the error message.
    value
        Anything NumPy can read.
    shape
        Wanted shape; None stands for any length, and None as a whole for any shape.

    Raises
    ------
    ProblemError
        If it is not numeric, has the wrong shape or holds NaN; the message names the first bad entry.

    Examples
    --------
    >>> real_array("com", [0, 0, 0.3], (3,))
    array([0. , 0. , 0.3])
    """
    array = np.array(numbers(name, value))
    if shape is not None:
        wanted = tuple(shape)
        fits = array.ndim == len(wanted) and all(
            w is None or w == a for w, a in zip(wanted, array.shape, strict=True)
        )
        if not fits:
            text = str(tuple("any" if w is None else int(w) for w in wanted)).replace("'", "")
            raise ProblemError(f"{name} must have shape {text}, got {array.shape}")
    bad = np.isnan(array)
    if bad.any():
        raise ProblemError(f"{name}{_where(bad)} is NaN")
    return array


def sized_array(name: str, value: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    """Return `value` as a float array of a shape (...), NaN allowed: for steps that say of NaN what it did.

    Raises
    ------
    ProblemError
        If it is not numeric or has another shape.
    """
    if type(value) is np.ndarray and value.dtype == _FLOAT and value.shape == shape:
        return value
    array = numbers(name, value)
    if array.shape != shape:
        raise ProblemError(f"{name} must have shape {shape}, got {array.shape}")
    return array


def sized_flags(name: str, value: ArrayLike, count: int) -> BoolArray:
    """Return `value` as a (count,) array of True and False.

    Raises
    ------
    ProblemError
        If it is none.
    """
    if type(value) is np.ndarray and value.dtype == _BOOL and value.shape == (count,):
        return value
    flags: BoolArray = array_of(name, value, "b", "True and False", np.bool_)
    if flags.shape != (count,):
        raise ProblemError(f"{name} must have shape ({count},), got {flags.shape}")
    return flags


def finite_array(name: str, value: ArrayLike, shape: Sequence[int | None] | None = None) -> FloatArray:
    """Like `real_array`, and infinite entries are refused too."""
    plain = type(value) is np.ndarray and value.dtype == _FLOAT and (shape is None or value.shape == shape)
    if plain and np.isfinite(value).all():  # what the package hands to itself, at every step
        return np.array(value)
    array = real_array(name, value, shape)
    bad = ~np.isfinite(array)
    if bad.any():
        raise ProblemError(f"{name}{_where(bad)} is infinite")
    return array


def semidefinite(name: str, value: ArrayLike, size: int) -> FloatArray:
    """Return `value` as a symmetric positive semidefinite (size, size) matrix.

    Raises
    ------
    ProblemError
        If it is none, beyond rounding; the message says what is amiss.
    """
    matrix = finite_array(name, value, (size, size))
    scale = max(float(np.abs(matrix).max(initial=0.0)), 1e-300)
    if np.abs(matrix - matrix.T).max(initial=0.0) > 1e-12 * scale:
        raise ProblemError(f"{name} must be symmetric")
    if size and np.linalg.eigvalsh(matrix)[0] < -1e-10 * scale:
        raise ProblemError(f"{name} must be positive semidefinite")
    return matrix.copy()


def real_number(name: str, value: float, *, low: float = -np.inf, high: float = np.inf) -> float:
    """Return `value` as a float within [low, high]; NaN is refused.

    >>> real_number("mu", 0.6, low=0)
    0.6
    """
    try:
        if isinstance(value, np.ndarray | np.generic) and np.iscomplexobj(value):
            raise TypeError
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        wanted = "a number that a float can hold" if isinstance(error, OverflowError) else "a number"
        raise ProblemError(f"{name} must be {wanted}, got {shown(value)}") from error
    if not low <= number <= high:
        wanted = f">= {low:g}" if high == np.inf else f"between {low:g} and {high:g}"
        raise ProblemError(
            f"{name} must be a number {wanted if low > -np.inf else ''}".rstrip() + f", got {number:.10g}"
        )
    return number


def positive_number(name: str, value: float, unit: str = "") -> float:
    """Return `value` as a float that is positive and finite, or raise; the message tells the unit."""
    number = real_number(name, value, low=0.0)
    if not 0.0 < number < np.inf:
        raise ProblemError(f"{name} must be positive and finite{unit and f' [{unit}]'}, got {number:g}")
    return number


def whole_number(name: str, value: float, *, low: int = 0) -> int:
    """Return `value` as an integer >= low; 5.0 is one, 5.5 and True are not.

    >>> whole_number("max_iterations", 5)
    5
    """
    number = None if isinstance(value, (bool, np.bool_)) else real_number(name, value)
    if number is None or number != np.floor(number) or not low <= number < 2**53:
        raise ProblemError(f"{name} must be a whole number >= {low}, got {shown(value)}")
    return int(number)


def per_contact(name: str, value: ArrayLike, count: int, *, low: float = 0.0) -> FloatArray:
    """Return a scalar or (count,) value as a (count,) array with entries >= low (infinity allowed)."""
    array = real_array(name, value)
    if array.ndim == 0:
        array = np.full(count, float(array))
    if array.shape != (count,):
        raise ProblemError(f"{name} must be a number or have shape ({count},), got {array.shape}")
    bad = array < low
    if bad.any():
        raise ProblemError(f"{name}{_where(bad)} must be >= {low:g}, got {array[bad][0]:g}")
    return array


LARGEST = 1e12
"""Largest size of a mass, length, force or moment: beyond it products overflow, and nothing is told apart."""


LIKE = {
    "Stance": "sf.Stance([sf.PointContact(p)])",
    "ContactProblem": "sf.ContactProblem(G, g, mu)",
    "LCP": "sf.LCP(M, q)",
    "Robot": 'sf.load_robot("go2")',
    "Terrain": "sf.SlopeTerrain(10.0)",
    "Log": "sf.read_log(file)",
    "ContactSchedule": '"trot", the name of one,',
    "VelocityCommand": "sf.VelocityCommand.constant(0.5)",
    "ContactSequence": "sf.read_sequence(file)",
    "StanceQuestion": "sf.read_stance(file)",
    "SweepConfig": "sf.read_sweep(file)",
    "Mapping": '{"time": t, "forces": f}',
}
"""How one of each kind is made."""


def of_kind(name: str, value: object, kind: type) -> None:
    """Refuse a value that is not of a kind; the message shows how one is made.

    >>> of_kind("stance", None, list)
    Traceback (most recent call last):
    surefoot.base.errors.ProblemError: stance must be a list, got None
    """
    if not isinstance(value, kind):
        like = f", as {LIKE[kind.__name__]} is one" if kind.__name__ in LIKE else ""
        raise ProblemError(f"{name} must be a {kind.__name__}{like}, got {shown(value)}")


def check_order(low: FloatArray, high: FloatArray) -> None:
    """Refuse (n,) bounds on normal forces that are out of order; the message names the contact."""
    crossed = low > high
    if crossed.any():
        k = int(np.argmax(crossed))
        raise ProblemError(f"normal_min must be <= normal_max, got {low[k]:g} > {high[k]:g} at contact {k}")


def _where(bad: BoolArray) -> str:
    """Return the index of the first bad entry as text, empty for a scalar."""
    if bad.ndim == 0:
        return ""
    return "[" + ", ".join(str(i) for i in np.argwhere(bad)[0]) + "]"
