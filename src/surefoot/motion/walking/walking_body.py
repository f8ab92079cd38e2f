"""Where a walking body should be: wanted velocity over time, and the pose that follows the ground."""

from __future__ import annotations

import math
from dataclasses import InitVar, dataclass, field, replace
from pathlib import Path

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY, rotation_about
from surefoot.base.text_files import read_text
from surefoot.motion.control.body_motion import BodyReference
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.walking.body_settings import BODY_MOTION
from surefoot.motion.walking.walking_kernels import (
    advance_body,
    body_rise,
    cruise,
    plane_through,
    slope_frames,
)


@dataclass(frozen=True)
class VelocityCommand:
    """Wanted velocity and posture over time, held from each time on; the velocity is in the heading frame.

    Attributes
    ----------
    times
        (k,) rising, the first at 0 [s].
    values
        (k, 3) forward, left [m/s], yaw rate [rad/s].
    postures
        (k, 3) how much higher than usual the body is [m], its pitch over the ground's, nose down [rad], and
        how much more than usual feet are lifted [m]; None for zeros.

    Examples
    --------
    >>> command = VelocityCommand.constant(0.5, 0.0, 0.2, height=-0.05)
    >>> command.at(3.0), command.posture_at(3.0)
    (array([0.5, 0. , 0.2]), array([-0.05,  0.  ,  0.  ]))
    """

    times: FloatArray
    values: FloatArray
    postures: FloatArray = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        times = finite_array("command times", self.times, (None,))
        values = finite_array("command values", self.values, (len(times), 3))
        postures = np.zeros((len(times), 3)) if self.postures is None else self.postures
        postures = finite_array("command postures", postures, (len(times), 3))
        if (np.abs(postures[:, 1]) > BODY_MOTION.steepest_pitch).any():
            raise ProblemError(
                f"pitch must be within ±{BODY_MOTION.steepest_pitch:g} rad, got {postures[:, 1]}"
            )
        for name, array in (("times", times), ("values", values), ("postures", postures)):
            object.__setattr__(self, name, array)
        if len(times) == 0 or times[0] != 0.0 or (np.diff(times) <= 0.0).any():
            raise ProblemError(f"command times must rise from 0, got {times.tolist()}")

    @staticmethod
    def constant(
        forward: float,
        left: float = 0.0,
        turn: float = 0.0,
        *,
        height: float = 0.0,
        pitch: float = 0.0,
        clearance: float = 0.0,
    ) -> VelocityCommand:
        """Return the command that never changes: forward, left [m/s], turn [rad/s]; see `postures`.

        Raises
        ------
        ProblemError
            For what is not a finite number each.
        """
        given = {
            "forward": forward, "left": left, "turn": turn, "height": height, "pitch": pitch,
            "clearance": clearance,
        }  # fmt: skip
        numbers = np.array([real_number(name, value) for name, value in given.items()])
        return VelocityCommand(np.zeros(1), numbers[None, :3], numbers[None, 3:])

    @staticmethod
    def read(path: Path) -> VelocityCommand:
        """Read lines of ``time vx vy yaw_rate`` and ``height pitch clearance`` where they are wanted.

        They are separated by blanks or commas; # starts a comment, a header is passed over.

        Raises
        ------
        ProblemError
            If the file cannot be read or a line does not hold four numbers or seven; the message names it.
        """
        rows = []
        for number, line in enumerate(read_text(path, "the velocity file").splitlines(), 1):
            words = line.split("#")[0].replace(",", " ").split()
            if not words:
                continue
            try:
                rows.append([float(w) for w in words])
            except ValueError:
                if rows:
                    raise ProblemError(
                        f"{path} line {number}: expected four numbers or seven, got {line!r}"
                    ) from None
                continue  # a header
            if len(rows[-1]) not in (4, 7):
                raise ProblemError(
                    f"{path} line {number}: expected time vx vy yaw_rate [height pitch clearance], "
                    f"got {line!r}"
                )
            rows[-1] += [0.0] * (7 - len(rows[-1]))
        if not rows:
            raise ProblemError(f"{path} holds no line of time vx vy yaw_rate")
        table = np.array(rows)
        return VelocityCommand(table[:, 0], table[:, 1:4], table[:, 4:])

    def at(self, time: float) -> FloatArray:
        """Return (3,) forward, left [m/s] and yaw rate [rad/s] at a time [s]."""
        return np.asarray(self.values[_row(self.times, time)])

    def posture_at(self, time: float) -> FloatArray:
        """Return (3,) height over the usual [m], pitch [rad], clearance over the usual [m] at a time [s]."""
        return np.asarray(self.postures[_row(self.times, time)])


def _row(times: FloatArray, time: float) -> int:
    """Return which of (k,) rows holds at a time [s]."""
    if len(times) == 1:
        return 0
    return max(int(np.searchsorted(times, time + 1e-9, side="right")) - 1, 0)


def first_stance(schedule: ContactSchedule) -> float:
    """Return the longest time from the beginning of a schedule until a foot lifts first [s].

    Examples
    --------
    >>> from surefoot.motion.gaits.library import named_gait
    >>> [round(first_stance(named_gait(name, 4)), 3) for name in ("trot", "walk", "stand")]
    [0.22, 0.624, 0.0]
    """
    phases = schedule.phases(0.0)
    ends = phases[phases[:, 0] > 0.0, 2]
    return float(ends[np.isfinite(ends)].max(initial=0.0))


@dataclass
class BodyPlan:
    """Follows the command: integrates the wanted place and heading, and fits the ground under the feet.

    Attributes
    ----------
    height
        Of the centre of mass above the ground, along its normal [m].
    position, yaw
        (3,) wanted centre of mass [m], wanted heading [rad].
    velocity
        (3,) wanted velocity of the centre of mass now, after the ramp: forward, left, yaw rate.
    swerve
        (3,) velocity of the centre of mass in a base that turns on the spot, over its rate [m, m, -]:
        commands are velocities of the base.
    slope
        (2,) slope of the ground along world x and y, smoothed.
    ground
        Height of the ground below the wanted place [m], smoothed.
    acceleration, change
        Largest change of the wanted velocity, in the last step and on ground that holds any [m/s²].
    lowered
        How far the body has come down to the height that suits the slope, from 0 at the start to 1.
    dip
        Share of the height that it comes down by over the slope that it descends [-].
    stance
        Longest time that a foot stands [s].
    ceiling
        The highest that the centre of mass may be now, as `height` [m].
    posture
        (3,) how much higher than usual the body is wanted now [m], its pitch over the ground's [rad], and
        how much higher feet are lifted [m].
    """

    height: float
    position: FloatArray
    yaw: float
    velocity: FloatArray = field(default_factory=lambda: np.zeros(3))
    swerve: FloatArray = field(default_factory=lambda: np.zeros(3))
    slope: FloatArray = field(default_factory=lambda: np.zeros(2))
    ground: float = 0.0
    lowered: float = 0.0
    dip: float = 0.0
    stance: InitVar[float] = 0.0
    ceiling: float = math.inf
    posture: FloatArray = field(default_factory=lambda: np.zeros(3))
    change: float = field(init=False)
    acceleration: float = field(init=False)

    def __post_init__(self, stance: float) -> None:
        self.change = BODY_MOTION.acceleration * GRAVITY
        longest = BODY_MOTION.long_stance * math.sqrt(self.height / GRAVITY)
        if stance > longest:
            self.change *= (longest / stance) ** 2
        self.acceleration = self.change

    def advance(
        self, command: FloatArray, com: FloatArray, dt: float, acceleration: float | None = None,
        ceiling: float = math.inf, velocity: FloatArray | None = None,
    ) -> None:  # fmt: skip
        """Move the wanted pose by one step.

        Parameters
        ----------
        command
            (3,) wanted velocity of the base.
        com
            (3,) centre of mass [m].
        dt
            Step [s].
        acceleration
            Largest change of the wanted velocity in this step [m/s²]; None for `change`.
        ceiling
            The highest that the centre of mass may be from this step on, as `height` [m].
        velocity
            (3,) wanted velocity from which this step begins; None for the one that it has.
        """
        self.acceleration, self.ceiling = self.change if acceleration is None else acceleration, ceiling
        if velocity is not None:
            self.velocity[:] = velocity
        if command[2] != 0.0:
            command = command + command[2] * self.swerve
        height = min(self.height + float(self.posture[0]), self.ceiling)
        self.yaw, self.ground, self.lowered = advance_body(
            self.position, self.velocity, self.slope, command, com, dt, height,
            self.yaw, self.ground, self.lowered, self.acceleration, self.dip, BODY_MOTION.lead_time,
            BODY_MOTION.lowering_time,
        )  # fmt: skip

    @property
    def base_velocity(self) -> FloatArray:
        """(3,) wanted velocity of the base now, as `velocity`."""
        (x, y, turn), (ahead, aside, about) = self.velocity.tolist(), self.swerve.tolist()
        return np.array([x - turn * ahead, y - turn * aside, turn - turn * about])

    def take_posture(self, posture: FloatArray, dt: float) -> None:
        """Come nearer to a commanded (3,) posture in a step of dt [s], see `VelocityCommand`."""
        given, now = posture.tolist(), self.posture.tolist()
        if not any(now + given):
            return
        wanted = (
            min(max(given[0], -BODY_MOTION.lowest * self.height), BODY_MOTION.highest * self.height),
            given[1],
        )
        most = BODY_MOTION.crouch_rate * self.height * dt, BODY_MOTION.pitch_rate * dt
        self.posture[:2] = [a + min(max(b - a, -c), c) for a, b, c in zip(now, wanted, most, strict=False)]
        self.posture[2] = given[2]

    def rise(self, way: float, highest: float) -> None:
        """Rise by a way [m], up to a height of the centre of mass [m]."""
        self.height = min(self.height + way, highest)

    def recentre(self, moved: FloatArray, way: FloatArray) -> None:
        """Take another place for the centre of mass: (3,) how it moves in the body, and in the world [m]."""
        self.height += float(moved[2])
        self.position += way

    def fit_ground(self, feet: FloatArray, dt: float) -> None:
        """Follow the ground under (n, 3) places where feet last stood [m], `dt` after the last time [s]."""
        level, *slope = plane_through(feet, self.position[:2], BODY_MOTION.flattening)
        self.follow_plane(level, np.array(slope), dt)

    def follow_plane(self, level: float, slope: FloatArray, dt: float) -> None:
        """Follow a plane of height `level` [m] below the wanted place, with a (2,) `slope`."""
        share = 1.0 - math.exp(-dt / BODY_MOTION.ground_time)
        self.slope = self.slope + share * (slope - self.slope)
        self.ground += share * (level - self.ground)
        height = min(self.height + float(self.posture[0]), self.ceiling)
        self.position[2] = self.ground + body_rise(self.slope, self.yaw, height, self.dip, self.lowered)

    def flow(self) -> FloatArray:
        """Return the (2,) wanted velocity along x and y of the world [m/s]."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        vx, vy = float(self.velocity[0]), float(self.velocity[1])
        return np.array([c * vx - s * vy, s * vx + c * vy])

    def places(self, times: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return yaw (k,), centre of mass (k, 3) and its velocity (k, 3) at times from now [s]."""
        return cruise(self.position, self.yaw, self.velocity, self.slope, times)

    def reference(self, steps: int, dt: float, ahead: float = 0.0) -> BodyReference:
        """Return the reference of `steps` steps of `dt` [s], which begin `ahead` of now [s]."""
        yaw, places, flow = self.places(ahead + dt * np.arange(steps + 1, dtype=np.float64))
        spin = np.zeros((steps + 1, 3))
        spin[:, 2] = self.velocity[2]
        frames = slope_frames(yaw, self.slope)
        if self.posture[1] != 0.0:
            frames = frames @ rotation_about([0.0, 1.0, 0.0], float(self.posture[1]))
        return BodyReference(frames, places, flow, spin)


def slowed_note(velocity: FloatArray, time: float, share: float) -> str:
    """Return the line that a (3,) velocity from a time [s] on is slowed to a share of it."""
    x, y, turn = velocity
    return (
        f"velocity ({x:g}, {y:g}, {turn:g}) from {time:g} s on is more than this gait can do: slowed to "
        f"{100.0 * share:.0f} %, ({x * share:.3g}, {y * share:.3g}, {turn * share:.3g})"
    )


def granted_share(asked: VelocityCommand, granted: VelocityCommand) -> float:
    """Return the least share of a velocity asked for that was granted, 1 for none that was cut [-]."""
    shares = [
        float(np.linalg.norm(granted.at(time)) / np.linalg.norm(wanted))
        for time, wanted in zip(asked.times.tolist(), asked.values, strict=True)
        if wanted.any()
    ]
    return min([1.0, *shares])


def limit_command(
    command: VelocityCommand, reach: float, stance_time: float, height: float, radius: float
) -> tuple[VelocityCommand, list[str]]:
    """Return the command slowed to what legs can do, and a line for everything that was slowed.

    A foot moves back by the speed times the stance time while it carries: at most `reach` either side of
    its middle. Turning moves it by the yaw rate times its distance `radius` from the middle.

    Parameters
    ----------
    command
        As given.
    reach
        How far a foot may be from below its hip [m].
    stance_time
        Length of the gait's stance [s].
    height
        Of the centre of mass [m]; no more than Froude number 1 is tried.
    radius
        Distance of the feet from the middle [m].
    """
    fastest = min(2.0 * reach / stance_time, math.sqrt(GRAVITY * height))
    values, notes = command.values.copy(), []
    for row, time in zip(values, command.times, strict=True):
        speed = math.hypot(row[0], row[1]) + abs(row[2]) * radius
        if speed > fastest:
            share = fastest / speed
            notes.append(slowed_note(row, time, share))
            row *= share
    return replace(command, values=values), notes
