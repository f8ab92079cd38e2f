"""Contact problems, their solutions and the laws as numbers; free of any solver."""

from surefoot.contact import sets
from surefoot.contact.problem import ContactProblem as ContactProblem
from surefoot.contact.proof import InfeasibilityProof as InfeasibilityProof
from surefoot.contact.proof import check_proof as check_proof
from surefoot.contact.residuals import Residuals as Residuals
from surefoot.contact.residuals import residuals as residuals
from surefoot.contact.sets import ContactSet as ContactSet
from surefoot.contact.solution import ContactSolution as ContactSolution
from surefoot.contact.solution import Status as Status

contact_sets = sets
