"""What goes into a derivative and comes out of it: rates, tangents, cotangents; the last of batches, too."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray, finite_array
from surefoot.base.errors import ProblemError


@dataclass(frozen=True)
class Tangents:
    """What `ContactDerivative.jvp` returns.

    Attributes
    ----------
    forces, velocities
        (n, 3) rates of change.
    removed
        Norm of the part of the perturbation that redundant contacts cannot follow, and that was taken off
        [unit of g]; zero where the active system is regular.
    settled
        False where no consistent choice of modes was found at kinks; the least inconsistent one is returned.
    """

    forces: FloatArray
    velocities: FloatArray
    removed: float = 0.0
    settled: bool = True


class Cotangents:
    """What `vjp` returns: the gradient of one number with respect to what was given, problem by problem.

    Each property is in the unit of that number over its own, see `ContactProblem`; (...) is nothing for one
    problem, (B,) for a batch.

    Attributes
    ----------
    regular
        (...,) False where contacts are redundant, see `ContactDerivative`.
    valid
        (...,) False where a batch's problem is not SOLVED; its gradient is zero.

    Inside they are one array (..., 2n, 3): rows 0 to n - 1 belong to u at fixed forces, row n + k to contact
    k's mu, normal_min and normal_max.
    """

    __slots__ = ("_forces", "_out", "regular", "valid")

    def __init__(
        self,
        out: FloatArray,
        forces: FloatArray,
        regular: bool | BoolArray = True,
        valid: bool | BoolArray = True,
    ) -> None:
        self._out, self._forces, self.regular, self.valid = out, forces, regular, valid

    @property
    def g(self) -> FloatArray:
        """(..., 3n) by g, in the unit of the number per that of g."""
        return self._out[..., : self._forces.shape[-2], :].reshape(*self._forces.shape[:-2], -1)

    @property
    def mu(self) -> FloatArray:
        """(..., n) by mu, in the unit of the number per that of mu."""
        return self._out[..., self._forces.shape[-2] :, 0]

    @property
    def normal_min(self) -> FloatArray:
        """(..., n) by normal_min, in the unit of the number per that of normal_min."""
        return self._out[..., self._forces.shape[-2] :, 1]

    @property
    def normal_max(self) -> FloatArray:
        """(..., n) by normal_max, in the unit of the number per that of normal_max."""
        return self._out[..., self._forces.shape[-2] :, 2]

    @property
    def G(self) -> FloatArray:
        """(..., 3n, 3n) by G, symmetric, in the unit of the number per that of G; made when asked for."""
        g = self.g
        outer = g[..., :, None] * self._forces.reshape(g.shape)[..., None, :]
        return np.asarray(0.5 * (outer + np.swapaxes(outer, -1, -2)))

    @property
    def compliance(self) -> FloatArray:
        """(..., 3n) by compliance, in the unit of the number per that of compliance."""
        g = self.g
        return np.asarray(g * self._forces.reshape(g.shape))


def read_rates(
    forces: FloatArray, G: ArrayLike | None, g: ArrayLike | None, compliance: ArrayLike | None,
    laws: tuple[ArrayLike | None, ...],
) -> tuple[FloatArray, tuple[FloatArray, ...]]:  # fmt: skip
    """Return the rate (3n,) of u at fixed forces (n, 3), and those of mu and both bounds, (n,) each.

    `laws` are the latter as they were given.
    """
    flat = forces.ravel()
    n, m = len(forces), flat.size
    b = np.zeros(m)
    if G is not None:
        dG = finite_array("G", G, (m, m))
        b += 0.5 * (dG + dG.T) @ flat
    if g is not None:
        b += finite_array("g", g, (m,))
    if compliance is not None:
        rate = fitting("compliance", finite_array("compliance", compliance), (), n, m)
        b += (np.repeat(rate, 3) if rate.shape == (n,) else rate) * flat
    rates = np.zeros((3, n))
    for row, name, value in zip(rates, ("mu", "normal_min", "normal_max"), laws, strict=True):
        if value is not None:
            row[:] = fitting(name, finite_array(name, value), (), n)
    return b, tuple(rates)


def fitting(name: str, array: FloatArray, lead: tuple[int, ...], *widths: int) -> FloatArray:
    """Return an array that is a number or (width,) of one of the widths, the last also (..., width)."""
    shapes = dict.fromkeys((*((width,) for width in widths), (*lead, widths[-1])))
    if array.shape and array.shape not in shapes:
        words = " or ".join(map(str, shapes))
        raise ProblemError(f"{name} must be a number or have shape {words}, got {array.shape}")
    return array
