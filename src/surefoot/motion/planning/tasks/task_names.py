"""The tasks by name; a task's file is imported when it is asked for."""

from __future__ import annotations

from pkgutil import resolve_name

from surefoot.base.errors import check_name
from surefoot.motion.planning.tasks.task import Task

TASKS: dict[str, str] = {
    "ball": "surefoot.motion.planning.tasks.small_tasks:BALL",
    "hopper": "surefoot.motion.planning.tasks.small_tasks:HOPPER",
    "push": "surefoot.motion.planning.tasks.small_tasks:PUSH",
    "jump": "surefoot.motion.planning.tasks.jump:JUMP",
    "jump-up": "surefoot.motion.planning.tasks.jump:JUMP_UP",
    "backflip": "surefoot.motion.planning.tasks.backflip:BACKFLIP",
    "stand-up": "surefoot.motion.planning.stand_up.stand_up_task:STAND_UP",
}
"""Name to "module:object"."""


def find_task(name: str) -> Task:
    """Return the task of a name.

    Raises
    ------
    ProblemError
        For an unknown name.
    """
    check_name("task", name, TASKS)
    task: Task = resolve_name(TASKS[name])
    return task
