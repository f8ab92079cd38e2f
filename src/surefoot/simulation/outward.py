"""What a robot senses of the world around it, beside its own state: the ground, and forces on its feet."""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.control.controller import RobotState
from surefoot.simulation.height_scan import ActiveRangeSensor, RangeSensor
from surefoot.simulation.world import ContactReading, World
from surefoot.terrain.frames import surface_frames


class Outward:
    """Adds to a state what a range sensor saw, and forces on the feet where no estimator has found them.

    Parameters
    ----------
    world
        Where the robot is.
    scanner
        Its range sensor; None for none.
    seed
        Of the sensor's random numbers.
    """

    def __init__(self, world: World, scanner: RangeSensor | None, seed: int | None) -> None:
        self._terrain, self._foot, self._feet = world.terrain, world.contact_foot, len(world.robot.feet)
        self._scanner = None
        if scanner is not None:
            self._scanner = ActiveRangeSensor(scanner, world.robot, world.terrain, world.dt, seed)

    def add(self, state: RobotState, q: FloatArray, reading: ContactReading) -> RobotState:
        """Return the state with forces (n, 3) [N] and a scan, if there are any, at the true (nq,) q."""
        if state.forces is None:
            state = state._replace(forces=self._forces(reading))
        if self._scanner is not None:
            scan = self._scanner.look(q, state.time)
            if scan is not None:
                state = state._replace(scan=scan)
        return state

    def _forces(self, reading: ContactReading) -> FloatArray:
        """Return the true forces on the feet, world axes."""
        frames = np.empty((len(self._foot), 3, 3))
        surface_frames(reading.normals_on(self._terrain), frames)
        forces = np.zeros((self._feet, 3))
        np.add.at(forces, self._foot, np.einsum("pij,pj->pi", frames, reading.forces))
        return forces
