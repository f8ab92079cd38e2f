"""Many contact problems at once, and one in a caller's own compiled loop."""

from surefoot.contact.batch.derivative import BatchDerivative as BatchDerivative
from surefoot.contact.batch.solving import BatchSolution as BatchSolution
from surefoot.contact.batch.solving import solve_batch as solve_batch
