"""The arrays of a framework, so that the law is written once for JAX and for PyTorch, on their devices.

`certificate`, `modes`, `path` and `array_form` call these by one name, `xp`: the functions that `jax.numpy`
and `torch` share, with positional axes, and the few below in which they differ.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import Any


@dataclass(frozen=True)
class Framework:
    """Arrays of one framework: its module's functions, and what the frameworks spell differently.

    Attributes
    ----------
    module
        `jax.numpy` or `torch`.
    eye
        (n, like) to the identity (n, n) of an array's dtype, on its device.
    integers
        An array as 32-bit integers.
    solve
        (A, b) to x with A x = b, batched; a singular A gives numbers that are not finite, or wrong, and no
        error.
    loop
        (unfinished, step, state) to the state at the end.
    ask_host
        (convex, tol, G, g, mu, on) to the forces (..., n, 3) that `host.solve_on_host` finds.
    """

    module: ModuleType
    eye: Callable[[int, Any], Any]
    integers: Callable[[Any], Any]
    solve: Callable[[Any, Any], Any]
    loop: Callable[[Callable[[Any], Any], Callable[[Any], Any], Any], Any]
    ask_host: Callable[..., Any]

    def __getattr__(self, name: str) -> Any:
        return getattr(self.module, name)
