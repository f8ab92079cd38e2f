"""The tasks by name; a task's file is imported when it is asked for."""

from __future__ import annotations

from surefoot.base.lazy_table import LazyTable
from surefoot.motion.planning.tasks.task import Task

TASKS: LazyTable[Task] = LazyTable(
    "task",
    {
        "ball": "surefoot.motion.planning.tasks.small_tasks:BALL",
        "hopper": "surefoot.motion.planning.tasks.small_tasks:HOPPER",
        "push": "surefoot.motion.planning.tasks.small_tasks:PUSH",
        "jump": "surefoot.motion.planning.tasks.jump:JUMP",
        "jump-up": "surefoot.motion.planning.tasks.jump:JUMP_UP",
        "backflip": "surefoot.motion.planning.tasks.backflip:BACKFLIP",
        "stand-up": "surefoot.motion.planning.stand_up.stand_up_task:STAND_UP",
    },
)
"""Name to task."""


def find_task(name: str) -> Task:
    """Return the task of a name.

    Raises
    ------
    ProblemError
        For an unknown name.
    """
    return TASKS.load(name)
