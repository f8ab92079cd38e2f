"""`--view`: a window that shows a run while it goes; keys steer a walk."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.errors import ProblemError


def check(planner: str) -> None:
    """Refuse, before any work, what cannot be shown or steered.

    Raises
    ------
    ProblemError
        Without a screen, or for a planner whose command cannot be changed on the way.
    """
    from surefoot.app.viz.window import check_display

    if planner != "convex":
        raise ProblemError(f"--view steers --planner convex, got {planner}")
    check_display()


def watching(robot: Any, terrain: Any, controller: Any = None) -> list[Any]:
    """Return the observers of a run that is shown; the controller is that of a walk, None for a stand."""
    from surefoot.app.viz.window import ViewerWindow
    from surefoot.worlds.running.live import Live, Steering

    if controller is None:
        return [Live(ViewerWindow(robot, terrain), Steering(np.zeros_like, (0.0, 0.0, 0.0)))]
    walker = controller
    while not hasattr(walker, "steer") and hasattr(walker, "controller"):  # what is around it
        walker = walker.controller
    if not hasattr(walker, "steer"):
        raise ProblemError(f"--view steers a walk, and {type(walker).__name__} takes no other command")
    steering = Steering(walker.steer, walker.command.at(0.0))
    return [Live(ViewerWindow(robot, terrain), steering)]
