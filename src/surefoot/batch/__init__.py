"""Many contact problems at once, and one in a caller's own compiled loop."""

from surefoot.batch.derivative import BatchDerivative
from surefoot.batch.solving import BatchSolution, solve_batch

__all__ = [
    "BatchDerivative",
    "BatchSolution",
    "solve_batch",
]
