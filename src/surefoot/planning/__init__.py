"""Plans through contact: motions whose contacts an optimiser chose, or was given, and that obey the laws."""

from surefoot.planning.plan import Phase, Plan, Search, plan_from
from surefoot.planning.trajectory import Trajectory, rollout

__all__ = ["Phase", "Plan", "Search", "Trajectory", "plan_from", "rollout"]
