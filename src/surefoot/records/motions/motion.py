"""A motion reference: configurations of one robot over time, with what was guessed when they were read."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from surefoot.base.arrays import FloatArray
    from surefoot.mechanics import Robot


@dataclass(frozen=True, eq=False)
class Motion:
    """Configurations of a robot, frame by frame, at an even rate.

    Attributes
    ----------
    robot
        The robot whose configurations these are.
    q
        (T, nq) Pinocchio's configurations: base position [m] in world axes, base quaternion (x, y, z, w),
        joints [rad] in the robot's order.
    rate
        Frames per second [Hz].
    name
        What the motion is called: its file's stem, or a key of a file that has several.
    source
        The file it was read from; None for arrays.
    absent
        Joints that the file does not have, held at the robot's nominal angle.
    torques
        (T, joints) [N m] what motors gave while a motion was executed; None for references.
    notes
        What was guessed and what is doubtful, a line each.
    extra
        Other arrays of the file under their own names (contact masks, positions of links), unchanged.
    """

    robot: Robot
    q: FloatArray
    rate: float
    name: str = "motion"
    source: Path | None = None
    absent: tuple[str, ...] = ()
    torques: FloatArray | None = None
    notes: tuple[str, ...] = ()
    extra: dict[str, Any] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.q)

    @property
    def duration(self) -> float:
        """Time from the first frame to the last [s]."""
        return (len(self.q) - 1) / self.rate
