"""Problems to try solvers, questions and controllers on: contact problems, stances, allocations, walks.

Everything is made from a seed, so that two machines and two versions are asked the same. Benchmarks and tests
use them, and whoever writes a solver can; nothing else in the package does.
"""

from surefoot.problems.allocations import Instance, four_feet, pushed_stance, random_instances
from surefoot.problems.contacts import NamedProblem, families, problem_set
from surefoot.problems.stances import StanceCase, random_case, random_cases

__all__ = [
    "Instance",
    "NamedProblem",
    "StanceCase",
    "families",
    "four_feet",
    "problem_set",
    "pushed_stance",
    "random_case",
    "random_cases",
    "random_instances",
]
