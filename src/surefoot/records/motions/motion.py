"""A motion reference: configurations of one robot over time, with what was guessed when they were read."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.base.arrays import positive_number
from surefoot.base.drawn import Drawn
from surefoot.base.errors import count_of, writing
from surefoot.base.text_files import free_path

if TYPE_CHECKING:
    from surefoot.base.arrays import FloatArray
    from surefoot.mechanics import Robot


@dataclass(frozen=True, eq=False)
class Motion(Drawn):
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
        Other arrays of the file under their own names (contact masks, positions of links), as they stand
        there.
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

    def __repr__(self) -> str:
        return f"Motion({self.name!r}, robot={self.robot.name!r}, frames={len(self)}, rate={self.rate:g})"

    def __str__(self) -> str:
        doubts = f"; {count_of(len(self.doubts), 'doubt')}, see .doubts" if self.doubts else ""
        frames = f"{count_of(len(self), 'frame')} at {self.rate:g} Hz, {max(self.duration, 0.0):.4g} s"
        return f"Motion {self.name} of {self.robot.name}: {frames}{doubts}."

    @property
    def duration(self) -> float:
        """Time from the first frame to the last [s]."""
        return (len(self.q) - 1) / self.rate

    @property
    def times(self) -> FloatArray:
        """(T,) times of the frames from the first one on [s]."""
        return np.arange(len(self.q)) / self.rate

    @property
    def doubts(self) -> tuple[str, ...]:
        """Notes of what is doubtful: readings of the file that contradict it, or that nothing tells apart."""
        return tuple(note.removeprefix("doubt: ") for note in self.notes if note.startswith("doubt: "))

    def to_npz(self, path: Path | str) -> Path:
        """Write the motion as a new .npz file that leaves `read_motion` nothing to guess; return its path.

        It has `fps`, `root_pos`, `root_quat_xyzw`, `joint_pos` and `joint_names`; of a robot that is bolted
        down no root.

        Raises
        ------
        ProblemError
            For a file that exists already, or cannot be written.
        """
        place = free_path(path)
        root = 7 if self.robot.floating else 0
        arrays: dict[str, Any] = {
            "fps": self.rate, "joint_pos": self.q[:, root:], "joint_names": np.array(self.robot.joint_names),
        }  # fmt: skip
        if root:
            arrays |= {"root_pos": self.q[:, :3], "root_quat_xyzw": self.q[:, 3:7]}
        with writing(place), place.open("wb") as file:
            np.savez_compressed(file, **arrays)
        return place

    def resample(self, rate: float) -> Motion:
        """Return the motion at another rate [Hz].

        Places and joints go linearly from frame to frame, rotations by the shortest turn (slerp), torques
        linearly. The first frame stays; the last one is at or before the old one's time. Arrays of `extra`
        have the old frames and are left out.

        Examples
        --------
        >>> from surefoot import Motion, load_robot
        >>> robot = load_robot("go2")
        >>> len(Motion(robot, [robot.nominal] * 31, 30.0).resample(50.0))
        51
        """
        from surefoot.records.motions.resampling import blend_configurations, blend_rows

        wanted = positive_number("rate", rate, "Hz")
        count = int(np.floor(self.duration * wanted * (1.0 + 1e-12) + 1e-9)) + 1
        at = np.minimum(np.arange(count) * (self.rate / wanted), len(self.q) - 1.0)
        torques = None if self.torques is None else blend_rows(self.torques, at)
        q = blend_configurations(self.robot, np.asarray(self.q, dtype=np.float64), at)
        return replace(self, q=q, rate=wanted, torques=torques, extra={})

    def velocities(self, window: float = 0.0) -> tuple[FloatArray, FloatArray]:
        """Return velocities [m/s, rad/s] and accelerations, (T, nv) each, in Pinocchio's order.

        Each is that of the parabola through the frames around one, by least squares on the robot's manifold:
        of three frames central differences, at the ends those of the nearest whole window.

        Parameters
        ----------
        window
            Time over which the parabola is fitted [s]; three frames at least.
        """
        from surefoot.records.motions.resampling import differentiate

        return differentiate(self.robot, np.asarray(self.q, dtype=np.float64), self.rate, window)
