"""What formulas need that are written once for NumPy, JAX and Torch."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np


def array_module(*arrays: Any) -> Any:
    """Return the module whose functions take some arrays: numpy, where none is of JAX or Torch."""
    names = {type(array).__module__.partition(".")[0] for array in arrays}
    if "torch" in names:
        return sys.modules["torch"]
    # an array of JAX, traced or not, exists only where jax.numpy is loaded
    return sys.modules["jax.numpy"] if names & {"jax", "jaxlib"} else np


def vector_length(xp: Any, x: Any, y: Any) -> Any:
    """Return the lengths of vectors of two components; the slope at zero is zero, and no NaN.

    In the shape and unit of the components, which are arrays of one framework.
    """
    square = x**2 + y**2
    some = square > 0.0
    return xp.where(some, xp.sqrt(xp.where(some, square, xp.ones_like(square))), xp.zeros_like(square))
