"""Views of a walk for behaviours alone: a robot of Go2's size that stands on four feet."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.mechanics.terrain import FlatTerrain, Terrain
from surefoot.motion.control.controller import HeightScan, RobotState
from surefoot.motion.control.whole_body_tasks import Kinematics
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.gaits.library import named_gait
from surefoot.motion.walking.behaviours.behaviour import FootSearch, Recovery, Request, WalkFacts, WalkView

N, WEIGHT, HEIGHT, RADIUS, DT, MU = 4, 160.0, 0.3, 0.25, 1e-3, 0.6
HIPS = np.array([[0.19, 0.14], [0.19, -0.14], [-0.19, 0.14], [-0.19, -0.14]])
FRAMES, ALL, NONE = np.tile(np.eye(3), (N, 1, 1)), np.ones(N, dtype=bool), np.zeros(N, dtype=bool)


def walk_of(
    terrain: Terrain | None = None, schedule: ContactSchedule | None = None, *, watch_friction: bool = False
) -> WalkFacts:
    """Return what a behaviour is made for."""
    ground, gait = terrain or FlatTerrain(), schedule or named_gait("trot", 4, HEIGHT)
    return WalkFacts(ground, gait, np.full(N, 0.022), HEIGHT, RADIUS, WEIGHT, MU, DT, watch_friction, 0.9)


def motion(speed: float = 0.0, com_velocity: Any = (0.0, 0.0, 0.0)) -> Kinematics:
    """Return a robot whose first foot moves forward [m/s], its others at rest."""
    twists, z = np.zeros((N, 6)), np.zeros(3)
    twists[0, 0] = speed
    drifts = np.zeros((N, 6))
    return Kinematics(z, np.array(com_velocity), np.eye(3), z, np.zeros((N, 3)), twists, drifts)


def level(
    time: float = 0.0, x: float = 0.0, speed: float = 0.0, scan: HeightScan | None = None
) -> RobotState:
    """Return a robot that is level with its base 0.3 m above the ground and goes forward [m/s]."""
    q, v = np.zeros(19), np.zeros(18)
    q[0], q[2], q[6], v[0] = x, HEIGHT, 1.0, speed
    return RobotState(q, v, time, scan=scan)


class Wanting:
    """Asks for every quantity of a `Request` in each step."""

    name = "wanting"

    def __init__(self, walk: WalkFacts) -> None:
        self.height = walk.height

    def reset(self) -> None:
        """Forget nothing."""

    def propose(self, view: WalkView) -> Request:
        """Return the request."""
        slow = np.array([0.01, 0.0, 0.0])
        return Request(
            speed_cap=0.1, velocity=slow, at_most=slow, pace=0.5, step_times=slow, hold=True, clearance=0.01,
            foot_goals=lambda place, start: place, search=FootSearch(0.1),
            recovery=Recovery(1.0, slow, 1.0), mu=0.3, acceleration=0.5, height=0.98 * self.height,
        )  # fmt: skip


def view_of(command: Any = (0.0, 0.0, 0.0), **more: Any) -> WalkView:
    """Return a view of a robot that stands level, `more` in place of its own fields."""
    usual = WalkView(
        time=1.0, clock=0.7, state=level(1.0), now=motion(),
        command=np.array(command, dtype=np.float64), velocity=np.zeros(3), position=np.zeros(3), stance=ALL,
        ground=np.column_stack([HIPS, np.zeros(N)]), frames=FRAMES, fits=True, waiting=False,
    )  # fmt: skip
    return usual._replace(**more)
