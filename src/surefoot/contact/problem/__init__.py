"""Contact problems, proofs of infeasibility, and the contact laws as numbers; free of any solver."""

from surefoot.contact import sets
from surefoot.contact.problem.problem import ContactProblem as ContactProblem
from surefoot.contact.problem.proof import InfeasibilityProof as InfeasibilityProof
from surefoot.contact.problem.proof import check_proof as check_proof
from surefoot.contact.problem.residuals import Residuals as Residuals
from surefoot.contact.problem.residuals import residuals as residuals
from surefoot.contact.sets import ContactSet as ContactSet

contact_sets = sets
