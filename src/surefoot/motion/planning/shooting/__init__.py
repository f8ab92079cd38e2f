"""Own shooting solver: exact contact forward, smoothed derivatives backward, bounded torques."""

from surefoot.motion.planning.shooting.costs import Costs as Costs
from surefoot.motion.planning.shooting.costs import FootCost as FootCost
from surefoot.motion.planning.shooting.costs import JointCost as JointCost
from surefoot.motion.planning.shooting.costs import StateCost as StateCost
from surefoot.motion.planning.shooting.costs import TorqueCost as TorqueCost
from surefoot.motion.planning.shooting.shooting_problem import Goal as Goal
from surefoot.motion.planning.shooting.shooting_problem import ShootingProblem as ShootingProblem
from surefoot.motion.planning.shooting.shooting_problem import ShootingResult as ShootingResult
from surefoot.motion.planning.shooting.shooting_problem import ShootingSettings as ShootingSettings
from surefoot.motion.planning.shooting.solver import Shooting as Shooting
