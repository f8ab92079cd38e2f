"""Contact problems, their solutions and the laws as numbers; free of any solver."""

from surefoot.contact.problem import ContactProblem
from surefoot.contact.residuals import Residuals, residuals
from surefoot.contact.solution import ContactSolution, Status

__all__ = ["ContactProblem", "ContactSolution", "Residuals", "Status", "residuals"]
