"""Many contact problems at once, and one in a caller's own compiled loop."""

from surefoot.batch.derivative import BatchDerivative, BatchTangents
from surefoot.batch.realtime import DifferentiableSolver
from surefoot.batch.solving import BatchSolution, solve_batch

__all__ = [
    "BatchDerivative",
    "BatchSolution",
    "BatchTangents",
    "DifferentiableSolver",
    "solve_batch",
]
