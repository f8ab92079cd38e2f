"""Many contact problems at once, and one in a caller's own compiled loop."""

from surefoot.batch.derivative import BatchCotangents, BatchDerivative, BatchTangents
from surefoot.batch.realtime import DifferentiableSolver, Gradient
from surefoot.batch.solving import BatchSolution, solve_batch

__all__ = [
    "BatchCotangents",
    "BatchDerivative",
    "BatchSolution",
    "BatchTangents",
    "DifferentiableSolver",
    "Gradient",
    "solve_batch",
]
