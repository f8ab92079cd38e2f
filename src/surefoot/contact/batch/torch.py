"""Contact problems in PyTorch: batched, on any device, with exact gradients.

`solve` computes where its tensors are: on a device by the array form of the law (`batch.array_form`), in
their precision; on the CPU by the compiled `surefoot.solve_batch`, in double precision, float32 in and out
rounded to float32 (about 1e-7). Gradients are once differentiable.

Limits: normal bounds 0 and infinity (a mask switches contacts off).
"""

from __future__ import annotations

from typing import Any

from surefoot.base.errors import ProblemError, needs
from surefoot.contact.batch.answers import Forces, check_dtype, check_shapes
from surefoot.contact.batch.array_form import BatchRequest, answer, pull_back, request
from surefoot.contact.batch.cpu_fallback import solve_on_host
from surefoot.contact.batch.frameworks import Framework

with needs("torch", "torch"):
    import torch
    from torch.autograd.function import once_differentiable


def solve(
    G: Any,
    g: Any,
    mu: Any,
    *,
    law: str = "coulomb",
    mask: Any = None,
    smoothing: float = 0.0,
    tol: float | None = None,
    on_host: bool | None = None,
) -> Forces:
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
    smoothing
        Normal force times normal velocity [W] on the central path, the same for every contact; 0 for the
        law itself. The residual is then that of the path's equations.
    tol
        Residual that counts as solved, before any rounding to float32; 1e-8 in double, 1e-4 in single
        precision by default (1e-8 on the host).
    on_host
        Whether the compiled solver on the CPU finds the forces; by default where the tensors are on the CPU
        and there is no smoothing.

    Returns
    -------
    Forces
        Tensors of the dtype and device of g. Look at the `status`; gradients at a problem that is not
        solved are those of the modes it shows, and zero where it is INVALID.

    Raises
    ------
    ProblemError
        If a type, shape, dtype, law or number is wrong; never for what the entries are (see the status
        INVALID).
    """
    for name, value in (("G", G), ("g", g)):
        if not isinstance(value, torch.Tensor):
            raise ProblemError(f"{name} must be a tensor, got {type(value).__name__}")
        check_dtype(name, value.dtype)
    mu = mu if isinstance(mu, torch.Tensor) else torch.as_tensor(mu, dtype=g.dtype, device=g.device)
    mask = None if mask is None else torch.as_tensor(mask, device=g.device)
    shape = (*g.shape[:-1], check_shapes(G, g, mu, mask))
    on = torch.ones(shape, dtype=torch.bool, device=g.device) if mask is None else mask.bool().expand(shape)
    hosted = g.device.type == "cpu" and smoothing == 0.0 if on_host is None else on_host
    kind, device = (torch.float64, "cpu") if hosted else (g.dtype, g.device)
    given = (*(v.to(device, kind) for v in (G, g, mu.expand(shape))), on.to(device))
    found = _Solve.apply(request(TORCH, given[1], law, smoothing, tol, hosted), *given)
    forces, velocities, residual = (found[k].to(g.device, g.dtype) for k in (0, 1, 3))
    status, modes, kinks = (found[k].to(g.device) for k in (2, 4, 5))
    return Forces(forces, velocities, status, residual, modes, kinks)


class _Solve(torch.autograd.Function):  # type: ignore[misc]
    """Forces and velocities with their gradients; the certificate has none."""

    @staticmethod
    def forward(ctx: Any, asked: BatchRequest, *given: Any) -> Any:
        found, y = answer(TORCH, asked, *given)
        ctx.asked = asked
        ctx.save_for_backward(*given, found.forces, found.velocities, y)
        ctx.mark_non_differentiable(*found[2:])
        return tuple(found)

    @staticmethod
    @once_differentiable  # type: ignore[untyped-decorator]
    def backward(ctx: Any, forces: Any, velocities: Any, *_: Any) -> Any:
        kept = ctx.saved_tensors
        return (None, *pull_back(TORCH, ctx.asked, kept[:4], kept[4:], (forces, velocities)), None)


def _loop(unfinished: Any, step: Any, state: Any) -> Any:
    while bool(unfinished(state)):
        state = step(state)
    return state


def _ask_host(convex: bool, tol: float, *given: Any) -> Any:
    """Return the forces (..., n, 3) of lawful G, g, mu and mask, from the CPU."""
    found = solve_on_host(convex, tol, *(v.detach().cpu().numpy() for v in given))
    return torch.as_tensor(found).to(given[1])


TORCH = Framework(
    torch,
    eye=lambda n, like: torch.eye(n, dtype=like.dtype, device=like.device),
    integers=lambda v: v.to(torch.int32),
    solve=lambda A, b: torch.linalg.solve_ex(A, b)[0],
    loop=_loop,
    ask_host=_ask_host,
)
