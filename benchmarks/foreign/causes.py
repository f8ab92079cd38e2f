"""Causes of failures by name: what each means, and whether it has a place that an audit has to name."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Cause:
    """A cause of failures.

    Attributes
    ----------
    name
        Its name, also in reports of the audit.
    meaning
        What happens, in a line.
    """

    name: str
    meaning: str


CAUSES = (
    Cause("weak actuator", "one or two motors are cut, or their gain falls, at a time"),
    Cause("delayed control", "commands are computed from measurements 15 to 60 ms old"),
    Cause("saturated actuator", "torque limits are too small for the task, or the motion too fast for them"),
    Cause("slope too steep", "the ground is tilted beyond the angle of friction"),
    Cause("slippery ground", "friction is low everywhere, or on a patch of ice in the way"),
    Cause("push", "a force of 0.05 to 0.3 s on a body, or a ball that hits it"),
    Cause("payload", "a body that falls onto the robot and stays, or mass that a link gains in mid-run"),
    Cause("wrong mass", "the controller compensates another mass or centre of mass than the model has"),
    Cause("terrain edge", "a step up or down that the motion does not know of"),
    Cause("foot placement", "touchdowns too far from where they belong, or too late"),
    Cause("slow gait", "a period too long for the speed"),
    Cause("chattering gains", "gains so high for the time step that torques alternate in sign"),
    Cause("sensor bias", "the base's orientation or a joint's angle is measured with an offset"),
    Cause("wrong contact frame", "the log's forces are turned, or have the other sign"),
    Cause("soft contact", "solref, solimp or the time step let bodies sink, or give them energy"),
    Cause("self-collision", "links hit each other and jam"),
    Cause("impossible command", "the reference is out of reach, or faster than the robot can move"),
)
"""All of them, in the order of the tables."""
