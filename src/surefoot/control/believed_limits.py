"""Commands on ground that is only believed in: slowed to what the ground allows once it is known.

Limits of a command on known ground are set before the walk (`command_limits`). A slope that feet have found
and stairs that come into view take the same: friction's margin on the slope, the speeds at which steps are
taken in step with their treads.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.control.adaptive_gait import AdaptiveGait
from surefoot.control.command_limits import slope_speed, step_speed
from surefoot.control.gait import ContactSchedule
from surefoot.control.gait_library import named_gait
from surefoot.control.stair_gait import speed_in_step
from surefoot.control.terrain_knowledge import GroundBelief

SLACK = 1.08
"""What is believed may be off by so much: a command at the limit should not be slowed by it."""
FOLLOW = 0.5
"""Time constant with which the slope of the plane under the feet is followed [s]."""


class BelievedLimits:
    """Slows commands as the belief about the ground asks for; call `learn` at every step.

    Parameters
    ----------
    belief
        What is believed of the ground.
    mu
        Friction that may be used [-].
    height
        Of the centre of mass above the ground [m].
    radius
        Distance of the feet from the middle [m].
    schedule
        The gait; a trot that follows the speed walks in step with stairs.
    dt
        Time between steps [s].
    """

    def __init__(
        self,
        belief: GroundBelief,
        mu: float,
        height: float,
        radius: float,
        schedule: ContactSchedule,
        dt: float,
    ) -> None:
        self.belief, self.mu, self.height, self.radius = belief, mu, height, radius
        in_step = isinstance(schedule, AdaptiveGait) and schedule.name == "trot" and schedule.feet == 4
        self._period = named_gait("trot", 4, height).period if in_step else 0.0
        self._share = 1.0 - math.exp(-dt / FOLLOW)
        self.reset()

    def reset(self) -> None:
        """Forget what has been learned."""
        self._slope, self._begun = np.zeros(2), False

    def learn(self) -> None:
        """Follow the slope that the feet have found, from that of the stance at the start."""
        self._slope += (self._share if self._begun else 1.0) * (self.belief.slope - self._slope)
        self._begun = True

    def limit(self, command: FloatArray) -> FloatArray:
        """Return a (3,) velocity (forward, left [m/s], turn rate [rad/s]) slowed to what is possible now."""
        command = self.belief.allowed(command)
        size = math.hypot(command[0], command[1]) + abs(command[2]) * self.radius
        steps = self.belief.highest_step > 0.0
        if steps:
            fastest = SLACK * step_speed(self.belief, self.height)
        else:
            steepness = math.hypot(self._slope[0], self._slope[1])
            fastest = SLACK * slope_speed(steepness, self.mu, self.height)
        if size > fastest:
            command = command * (fastest / size)
        if steps and self._period > 0.0:
            forward = abs(float(command[0]))
            most = speed_in_step(self.belief, forward, self.height, self._period)
            if most < forward * (1.0 - 1e-6):
                command = command * (most / forward)
        return command
