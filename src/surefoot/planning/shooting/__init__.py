"""Own shooting solver: exact contact forward, smoothed derivatives backward, bounded torques."""

from surefoot.planning.shooting.costs import Costs as Costs
from surefoot.planning.shooting.costs import FootCost as FootCost
from surefoot.planning.shooting.costs import JointCost as JointCost
from surefoot.planning.shooting.costs import StateCost as StateCost
from surefoot.planning.shooting.costs import TorqueCost as TorqueCost
from surefoot.planning.shooting.problem import Goal as Goal
from surefoot.planning.shooting.problem import ShootingProblem as ShootingProblem
from surefoot.planning.shooting.problem import ShootingResult as ShootingResult
from surefoot.planning.shooting.problem import ShootingSettings as ShootingSettings
from surefoot.planning.shooting.solver import Shooting as Shooting
