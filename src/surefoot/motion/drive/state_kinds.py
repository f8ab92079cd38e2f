"""Classes of which the states of controllers and estimators consist, by the names in their files."""

from __future__ import annotations

from surefoot.contact import Status
from surefoot.motion.control.controller import Command, JointTargets
from surefoot.motion.drive.watchdog import WatchedCommand
from surefoot.motion.estimation.state_estimator import Health
from surefoot.motion.state import HeightScan, RobotState
from surefoot.motion.walking.walk_state import KINDS
from surefoot.motion.walking.walking_settings import WalkCommand

STATE_KINDS: dict[str, type] = KINDS | {
    kind.__name__: kind
    for kind in (Command, HeightScan, Health, JointTargets, RobotState, Status, WalkCommand, WatchedCommand)
}
"""Those of a walk, of what is around its controller, and of the estimate of a robot's state."""
