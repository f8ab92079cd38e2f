"""Contact problems and friction cones in PyTorch: batched, with exact gradients.

`solve` computes on the CPU in double precision: tensors from a device are copied there and back, and float32
in and out is rounded to float32 (about 1e-7), not solved in it. Its gradient is that of the active system
(`batch.modes`), once differentiable. The cone functions are made of PyTorch's own operations and stay on
their device.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.batch import cones
from surefoot.batch.answers import Forces, check_dtype, check_law, check_shapes
from surefoot.batch.host import answer, answer_gradients
from surefoot.errors import MissingExtra, ProblemError

try:
    import torch
    from torch.autograd.function import once_differentiable
except ImportError as error:
    raise MissingExtra("torch", "torch") from error


def solve(G: Any, g: Any, mu: Any, *, law: str = "coulomb", mask: Any = None, tol: float = 1e-8) -> Forces:
    """Solve a batch of contact problems; differentiable in G, g and mu.

    Parameters
    ----------
    G, g
        (..., 3n, 3n) Delassus operators and (..., 3n) free velocities: tensors, float32 or float64.
    mu
        Friction coefficient >= 0: a number, or a tensor () or (n,) or (..., n).
    law
        "coulomb" or "convex".
    mask
        (n,) or (..., n) tensor: which contacts are there; all by default.
    tol
        Velocity error that counts as solved, in double precision and before any rounding to float32.

    Returns
    -------
    Forces
        Tensors of the dtype and device of g. Look at the `status`; gradients at a problem that is not
        solved are those of the modes it shows, and zero where it is INVALID.

    Raises
    ------
    ProblemError
        If a type, shape, dtype or law is wrong; never for what the entries are (see the status INVALID).
    """
    for name, value in (("G", G), ("g", g)):
        if not isinstance(value, torch.Tensor):
            raise ProblemError(f"{name} must be a tensor, got {type(value).__name__}")
        check_dtype(name, value.dtype)
    mu = mu if isinstance(mu, torch.Tensor) else torch.as_tensor(mu, dtype=g.dtype, device=g.device)
    mask = None if mask is None else torch.as_tensor(mask)
    n = check_shapes(G, g, mu, mask)
    shape = (*g.shape[:-1], n)
    on = torch.ones(shape, dtype=torch.bool) if mask is None else mask.bool().expand(shape)
    return Forces(*_Solve.apply(G, g, mu.expand(shape), on, check_law(law), float(tol)))


def _double(tensor: Any) -> Any:
    """Return a tensor as a NumPy array on the CPU, in double precision if it is one of numbers."""
    array = tensor.detach().cpu().numpy()
    return array if array.dtype == np.bool_ else array.astype(np.float64)


class _Solve(torch.autograd.Function):  # type: ignore[misc]
    """Forces and velocities with their gradients; the certificate has none."""

    @staticmethod
    def forward(ctx: Any, G: Any, g: Any, mu: Any, on: Any, convex: bool, tol: float) -> Any:
        given = _double(G), _double(g), _double(mu), _double(on)
        found = answer(*given, convex, tol)
        ctx.given, ctx.convex, ctx.point = given, convex, (found.forces, found.velocities)
        ctx.likes = tuple((v.dtype, v.device) for v in (G, g, mu))
        out = tuple(torch.as_tensor(v).to(g.device) for v in found)
        forces, velocities, residual = (out[k].to(g.dtype) for k in (0, 1, 3))
        rest = out[2], residual, *out[4:]
        ctx.mark_non_differentiable(*rest)
        return forces, velocities, *rest

    @staticmethod
    @once_differentiable  # type: ignore[untyped-decorator]
    def backward(ctx: Any, forces: Any, velocities: Any, *_: Any) -> Any:
        weights = _double(forces), _double(velocities)
        G, g, mu, on = ctx.given
        found = answer_gradients(G, g, mu, on, ctx.convex, ctx.point, weights)
        tensors = (
            torch.as_tensor(v).to(dtype=like, device=device)
            for v, (like, device) in zip(found, ctx.likes, strict=True)
        )
        return (*tensors, None, None, None)


def cone_margin(forces: Any, mu: Any) -> Any:
    """Return the signed distance of (..., 3) forces to the friction cone [N]: (...), positive inside."""
    return cones.margin(torch, torch.detach, forces, mu)


def cone_project(forces: Any, mu: Any) -> Any:
    """Return the nearest points of the friction cone to (..., 3) forces [N]."""
    return cones.project(torch, torch.detach, forces, mu)


def friction_needed(forces: Any, least_normal: float = cones.LEAST_NORMAL) -> Any:
    """Return the friction coefficient (...) that (..., 3) forces need; see `batch.cones.friction_needed`."""
    return cones.friction_needed(torch, torch.detach, forces, least_normal)
