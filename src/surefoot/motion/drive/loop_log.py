"""What a loop did, as a log that can be audited: its estimates and what motors and feet reported."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.motion.drive.modes import CONTROLLED
from surefoot.motion.drive.robot_loop import RobotLoop
from surefoot.records import Log, log_from_arrays


class LoopLog:
    """Collects a row for each step in which the loop balances; call `note` after each step.

    Parameters
    ----------
    loop
        Whose steps.

    Attributes
    ----------
    rows
        Of the channels, so far.
    """

    def __init__(self, loop: RobotLoop) -> None:
        self.loop = loop
        self.rows: list[dict[str, Any]] = []

    def note(self, loop: RobotLoop) -> None:
        """See a step of the loop."""
        state, last = loop.estimate, loop.watch.last
        if loop.mode in CONTROLLED and state is not None and state.forces is not None and last is not None:
            touching = np.array(state.contact)
            # estimates are noisy where a foot has just landed
            pushing = touching & (state.forces[:, 2] > 0.0)
            self.rows.append({
                "time": loop.time, "q": state.q, "v": state.v, "torques": last.torques,
                "forces": state.forces * pushing[:, None], "contact_estimated": touching,
            })  # fmt: skip

    def log(self) -> Log:
        """Return the log: forces are the estimator's, in world axes, on feet that touch and push by it."""
        arrays = {name: np.array([row[name] for row in self.rows]) for name in self.rows[0]}
        robot = self.loop.robot
        facts = {"mass": robot.mass, "robot": robot.name, "effort_limits": robot.effort_limits.tolist()}
        return log_from_arrays(
            arrays, quaternion="xyzw", frames={"forces": "world"}, feet=robot.foot_names,
            joints=robot.joint_names, facts=facts,
        )  # fmt: skip
