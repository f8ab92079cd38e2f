"""Plans through contact: motions whose contacts an optimiser chose, or was given, and that obey the laws."""

from surefoot.motion.planning.plan import Phase, Plan, PlanSearch, plan_from
from surefoot.motion.planning.trajectory import Trajectory, rollout

__all__ = ["Phase", "Plan", "PlanSearch", "Trajectory", "plan_from", "rollout"]
