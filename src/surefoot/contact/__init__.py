"""Contact problems, their solutions and the laws as numbers; free of any solver."""

from surefoot.contact import sets as contact_sets
from surefoot.contact.diagnosis import Redundancy, redundancy
from surefoot.contact.files import read_lcp, read_problem, write_problem
from surefoot.contact.lcp import LCP, FrictionLCP, stewart_trinkle
from surefoot.contact.problem import ContactProblem
from surefoot.contact.proof import InfeasibilityProof, check_proof
from surefoot.contact.residuals import Residuals, residuals
from surefoot.contact.sets import ContactSet
from surefoot.contact.solution import ContactSolution, Status
from surefoot.contact.warm_start import carry_over, persisting

__all__ = [
    "LCP",
    "ContactProblem",
    "ContactSet",
    "ContactSolution",
    "FrictionLCP",
    "InfeasibilityProof",
    "Redundancy",
    "Residuals",
    "Status",
    "carry_over",
    "check_proof",
    "contact_sets",
    "persisting",
    "read_lcp",
    "read_problem",
    "redundancy",
    "residuals",
    "stewart_trinkle",
    "write_problem",
]
