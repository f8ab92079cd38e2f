"""Own shooting solver: exact contact forward, smoothed derivatives backward, bounded torques."""

from surefoot.planning.shooting.costs import Costs, FootCost, JointCost, StateCost, TorqueCost
from surefoot.planning.shooting.problem import (
    Goal,
    ShootingProblem,
    ShootingResult,
    ShootingSettings,
)
from surefoot.planning.shooting.solver import Shooting

__all__ = [
    "Costs",
    "FootCost",
    "Goal",
    "JointCost",
    "Shooting",
    "ShootingProblem",
    "ShootingResult",
    "ShootingSettings",
    "StateCost",
    "TorqueCost",
]
