"""QP rivals with prepared calls and kept workspaces, which the package itself drives through qpsolvers."""

from __future__ import annotations

from benchmarks.prepared.osqp import PreparedOsqp
from benchmarks.prepared.piqp import PreparedPiqp
from benchmarks.prepared.quadprog import PreparedQuadprog
from surefoot.contact.solvers.backends import BACKENDS, Backend, Options

RIVALS: dict[str, type[Backend]] = BACKENDS | {
    kind.name: kind for kind in (PreparedOsqp, PreparedPiqp, PreparedQuadprog)
}
"""By name, all outside solvers as benchmarks run them."""


def rival(name: str, options: Options | None = None) -> Backend:
    """Return an outside solver by its name, with its shortest call."""
    return RIVALS[name](options)
