"""The first method: motions over a given mode schedule, whole body, with limits of torques and speeds."""

from surefoot.motion.planning.schedule.schedule_problem import ScheduleProblem, ScheduleWeights
from surefoot.motion.planning.schedule.search import ScheduledMotion, optimise

__all__ = ["ScheduleProblem", "ScheduleWeights", "ScheduledMotion", "optimise"]
