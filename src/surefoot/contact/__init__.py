"""Contact problems, their solutions and the laws as numbers; free of any solver."""

from surefoot.contact import sets as contact_sets
from surefoot.contact.problem import ContactProblem
from surefoot.contact.proof import InfeasibilityProof, check_proof
from surefoot.contact.residuals import Residuals, residuals
from surefoot.contact.sets import ContactSet
from surefoot.contact.solution import ContactSolution, Status

__all__ = [
    "ContactProblem",
    "ContactSet",
    "ContactSolution",
    "InfeasibilityProof",
    "Residuals",
    "Status",
    "check_proof",
    "contact_sets",
    "residuals",
]
