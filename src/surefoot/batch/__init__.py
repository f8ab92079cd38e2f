"""Many contact problems at once, and one in a caller's own compiled loop."""

from surefoot.batch.derivative import BatchDerivative as BatchDerivative
from surefoot.batch.solving import BatchSolution as BatchSolution
from surefoot.batch.solving import solve_batch as solve_batch
