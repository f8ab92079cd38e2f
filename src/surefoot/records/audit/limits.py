"""The limits of an audit: every number that decides a verdict or ranks a symptom, as one frozen value.

`LIMITS` is what audits judge by unless they are given another value; `python -m benchmarks.limits` varies one
limit at a time over logs with seeded faults and clean ones, and says which values find as much.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from surefoot.base.loaded import ACTS, CARRIES, UNLOADED
from surefoot.base.settings import DescribedSetting, Settings, describe, setting
from surefoot.records.audit.run_limits import ContactTimeLimits, EstimateLimits, MotorLimits, StandLimits
from surefoot.records.audit.run_limits import WalkLimits as WalkLimits
from surefoot.records.audit.symptom_limits import (
    BodyLimits,
    ContactLimits,
    FitLimits,
    MeasuredLimits,
    RankLimits,
)


@dataclass(frozen=True)
class LawLimits(Settings):
    """Limits of the three laws of contact."""

    penetration: float = setting(
        1e-3, "m", "deepest penetration that counts as touching, widest gap across which a force may act",
        low=0.0,
    )  # fmt: skip
    slide: float = setting(
        1e-3, "m", "longest way of a contact without friction that counts as sticking", low=0.0
    )
    swing_depth: float = setting(
        1.6, "-", "factor on the depth of a soft contact while its body tumbles from corner to corner",
        low=1.0,
    )  # fmt: skip
    hard_touchdown: float = setting(
        0.7, "m/s", "speed into the ground from which a landing sets soft contacts swinging", low=0.0
    )
    pull: float = setting(1e-3, "m g", "largest pull that counts as rounding", low=0.0)
    cone: float = setting(1.0 + 1e-3, "-", "highest use of the friction cone that counts as inside", low=0.0)
    loaded: float = setting(
        ACTS,
        "m g",
        "normal force above which a contact is loaded; below it its use of friction is noise",
        low=0.0,
    )
    least_friction: float = setting(
        1e-4, "-", "friction that a ground with less counts as having: simulators know no exact zero",
        low=1e-12,
    )  # fmt: skip
    sliding_speed: float = setting(
        1e-2, "m/s", "tangential speed from which a contact slides at an instant", low=0.0
    )
    slide_piece: float = setting(
        1e-4, "m", "length of the pieces of a slide; shaking within less is no way", low=1e-9
    )
    release: float = setting(
        UNLOADED, "s", "time without load that ends a stance; a shorter one is a bounce", low=0.0
    )
    lag: float = setting(
        0.05, "-", "share of the friction's work that may be missing throughout a slide: 18 degrees of lag",
        low=0.0, high=1.0,
    )  # fmt: skip


@dataclass(frozen=True)
class SoftnessLimits(Settings):
    """The most that a world may declare of its softness: beyond it anything could hide."""

    sinking: float = setting(0.05, "m", "depth to which contacts may sink", low=0.0)
    creep: float = setting(0.1, "m/s", "speed at which loaded contacts may creep", low=0.0)
    stopping: float = setting(0.1, "m", "way on which a sliding contact may be stopped", low=0.0)
    settling: float = setting(0.1, "s", "time after a touchdown within which a contact may swing", low=0.0)


@dataclass(frozen=True)
class RecordLimits(Settings):
    """Limits of what a log says of itself, before any law is judged."""

    least_rows: int = setting(4, "-", "rows without which no log is lawful", low=2)
    lost_step: float = setting(5.5, "dt", "step of the clock from which rows are lost", low=1.0)
    known_step_low: float = setting(0.2, "dt", "shortest step over which an acceleration is known", low=0.0)
    known_step_high: float = setting(5.0, "dt", "longest step over which an acceleration is known", low=1.0)
    same_dt: float = setting(
        0.02, "dt", "difference of the declared step from that of the time stamps that is a contradiction",
        low=0.0,
    )  # fmt: skip
    same_mass: float = setting(
        1e-3, "-", "share by which a recording's mass may differ from that of the robot of its name", low=0.0
    )
    unit_length: float = setting(
        0.02, "-", "difference of a normal's squared length from one that makes it no direction", low=0.0
    )
    unit_quaternion: float = setting(
        1e-3, "-", "difference of a quaternion's length from one that makes it none", low=0.0
    )
    fastest_gap: float = setting(
        5.0, "m/s", "rate of a gap beyond which a foot passes an edge and tells nothing of the clock", low=0.0
    )
    creep: float = setting(
        0.1, "m/s", "most that is allowed of the creep a world declares, whatever a row's own is", low=0.0
    )
    deep: float = setting(5e-3, "m", "declared sinking from which a world is called soft", low=0.0)
    join: float = setting(0.02, "s", "time between two violations that are one", low=0.0)
    sticking: float = setting(
        0.05, "rad/s", "joint speed below which dry friction may be anything up to its size", low=0.0
    )


@dataclass(frozen=True)
class CheckLimits(Settings):
    """Limits of the measures that are taken of every row."""

    slide_window: float = setting(0.05, "s", "time over which friction's work is added up", low=1e-6)
    drive_share: float = setting(
        0.05, "-", "share of the friction's largest work that it may give by turning late", low=0.0, high=1.0
    )
    brake_share: float = setting(
        0.9, "-", "share of the friction's largest work that a slide has to be braked by", low=0.0, high=1.0
    )
    chatter_window: float = setting(0.1, "s", "time over which contact switches are counted", low=1e-6)
    chatter_switches: float = setting(
        8.0, "-", "switches between loaded and unloaded in that time that are chatter", low=1.0
    )
    ringing: float = setting(
        0.15, "m g", "mean jump of a normal force back and forth, row by row, that is chatter", low=1e-9
    )
    spike: float = setting(
        1.5, "m g", "excess of one or two rows' force over the rows on both sides that is a blow", low=0.0
    )
    idle_time: float = setting(0.1, "s", "time without any force from which nothing carries a robot", low=0.0)
    idle_share: float = setting(0.95, "-", "share of that time without any force", low=0.0, high=1.0)
    idle_gap: float = setting(1e-4, "m", "gap up to which a foot touches the ground while idle", low=0.0)
    idle_force: float = setting(
        0.3, "m g", "force missing from the motion that shows that the robot does not fall", low=0.0
    )
    frozen_time: float = setting(
        0.03, "s", "time in which a measured force changes by rounding at least", low=0.0
    )
    frozen_share: float = setting(
        0.95, "-", "share of that time without any change that is frozen", low=0.0, high=1.0
    )
    frozen_rows: int = setting(8, "-", "rows in that time up to which nothing is called frozen", low=0)
    lean_time: float = setting(0.1, "s", "time over which loads of the diagonals are compared", low=0.0)
    lean: float = setting(
        0.25, "m g", "load of one diagonal of feet beyond the other's that is asymmetry", low=0.0
    )


@dataclass(frozen=True)
class BalanceLimits(Settings):
    """Limits of the force and moment that the motion leaves unexplained."""

    smooth: float = setting(0.01, "s", "time over which forces are compared with the motion", low=0.0)
    ringing_time: float = setting(0.05, "s", "time of the root mean square of what is left over", low=0.0)
    force: float = setting(0.05, "m g", "mean force that may be left over", low=1e-9)
    ringing: float = setting(0.1, "m g", "root mean square of the force that may be left over", low=1e-9)
    arm: float = setting(0.02, "m", "arm of m g that makes the moment which may be left over", low=1e-9)


@dataclass(frozen=True)
class ContinuityLimits(Settings):
    """Limits of the difference between positions and what velocities lead to."""

    time: float = setting(0.05, "s", "time over which steps of positions are added up", low=0.0)
    smooth: float = setting(0.01, "s", "time over which contact velocities are averaged", low=0.0)
    way: float = setting(2e-3, "m", "way by which positions may be beside their velocities", low=1e-9)
    lever: float = setting(0.1, "m/rad", "lever that makes an angle a way", low=1e-9)
    drift: float = setting(
        0.05, "-", "share of the way gone by which positions may be beside velocities", low=0.0
    )
    gap_time: float = setting(0.02, "s", "time over which steps of gaps are added up", low=0.0)
    gap: float = setting(
        5e-3, "m", "way by which gaps may be beside velocities: contacts wander over a round foot", low=0.0
    )
    velocity: float = setting(
        0.05, "m/s", "difference of a contact's velocity from that of the joints", low=0.0
    )
    velocity_share: float = setting(0.05, "-", "the difference as a share of the speed", low=0.0)


@dataclass(frozen=True)
class ReboundLimits(Settings):
    """Limits of the energy that a touch gives back beyond what it took."""

    way: float = setting(5e-5, "m", "way on which m g does the work that a touch may return", low=0.0)
    share: float = setting(
        0.03, "-", "share of the energy taken that a touch may return: restitution 1.015", low=0.0
    )
    return_time: float = setting(
        0.01, "s", "time within which the rows at fault give back a part of the limit", low=0.0
    )
    return_share: float = setting(0.5, "-", "that part of the limit", low=0.0, high=1.0)
    longest_row: float = setting(
        5e-3, "s", "step from row to row beyond which a touch is over between two", low=0.0
    )


@dataclass(frozen=True)
class FrictionLimits(Settings):
    """Limits of what a log tells of the ground's friction, see `friction`."""

    enough: float = setting(
        CARRIES, "m g", "normal force from which a foot's force tells of friction", low=0.0
    )
    least_slide: float = setting(
        0.02,
        "s",
        "shortest slide that bounds friction from above; half of it is cut off at each end",
        low=0.0,
    )
    bins: int = setting(2000, "-", "bins in which friction is counted", low=10)
    top: float = setting(4.0, "-", "friction of the last bin", low=0.1)
    share: float = setting(
        0.995, "-", "share of rows that use no more than the lower bound", low=0.0, high=1.0
    )
    window: float = setting(0.1, "s", "time in which the ground is taken to be the same", low=1e-6)
    change: float = setting(
        0.15, "-", "share by which one bound must be beyond the other for a change of ground", low=0.0
    )
    least_time: float = setting(0.01, "s", "time of friction used that contradicts slides", low=0.0)
    least_rows: int = setting(3, "-", "rows within slides that contradict the friction used", low=1)


@dataclass(frozen=True)
class CommandLimits(Settings):
    """Limits of what the controller asked for and what came of it."""

    window: float = setting(0.05, "s", "time over which the command is judged", low=1e-6)
    at_once: float = setting(
        0.025, "s", "time without a foot that pushes, longer than a lift-off or a late touchdown", low=0.0
    )
    nearly_all: float = setting(
        0.9, "-", "share of the window in which a command is impossible", low=0.0, high=1.0
    )
    touching: float = setting(1e-3, "m", "gap up to which a foot touches that is asked for nothing", low=0.0)
    mismatch: float = setting(
        0.06, "m g", "mean force beside the commanded one (clean walks: 0.015 measured, 0.005 by torques)",
        low=0.0,
    )  # fmt: skip
    torque_mismatch: float = setting(
        0.05, "-", "mean difference of applied and commanded torques over the largest commanded", low=0.0
    )
    explained: float = setting(
        0.8, "-", "share of a mismatch that a turn or a mirror must explain to be named", low=0.0, high=1.0
    )
    least_turn: float = setting(3.0, "deg", "turn of commanded forces that is named", low=0.0)
    leans: float = setting(60.0, "deg", "lean of the base at the end from which a robot fell", low=0.0)
    low: float = setting(
        0.4, "-", "height at the end, as a share of the first, below which a robot fell", low=0.0
    )


@dataclass(frozen=True)
class EpisodeLimits(Settings):
    """Limits of what belongs to one episode, and of what its forces say."""

    near: float = setting(0.05, "s", "time between failures of one contact that are one episode", low=0.0)
    at_once: float = setting(
        0.03, "s", "time after an episode's begin from which a wrong motion is its consequence", low=0.0
    )
    all: float = setting(0.75, "-", "share of the contacts from which a finding is one of all", low=0.0)
    at_rest: float = setting(1e-6, "m/s, rad/s", "speed below which nothing has moved", low=0.0)
    known: float = setting(
        0.5, "-", "share of the rows in which joint torques must tell a foot's force", low=0.0, high=1.0
    )
    landing: float = setting(
        2.0, "m v", "impulse up to which the largest force is the blow of a landing", low=0.0
    )
    consistent: float = setting(
        0.03, "m g", "mean difference up to which joint torques and forces agree", low=0.0
    )
    sideways: float = setting(
        0.05, "-", "share of the squared mismatch along the normal of one that lies across it", low=0.0
    )
    amiss: float = setting(0.01, "m g", "mismatch up to which there is nothing to explain", low=0.0)


@dataclass(frozen=True)
class AuditLimits(Settings):
    """All limits of an audit, by what they are limits of."""

    laws: LawLimits = field(default_factory=LawLimits)
    softness: SoftnessLimits = field(default_factory=SoftnessLimits)
    records: RecordLimits = field(default_factory=RecordLimits)
    checks: CheckLimits = field(default_factory=CheckLimits)
    balance: BalanceLimits = field(default_factory=BalanceLimits)
    continuity: ContinuityLimits = field(default_factory=ContinuityLimits)
    rebound: ReboundLimits = field(default_factory=ReboundLimits)
    friction: FrictionLimits = field(default_factory=FrictionLimits)
    command: CommandLimits = field(default_factory=CommandLimits)
    episodes: EpisodeLimits = field(default_factory=EpisodeLimits)
    fits: FitLimits = field(default_factory=FitLimits)
    body: BodyLimits = field(default_factory=BodyLimits)
    contact: ContactLimits = field(default_factory=ContactLimits)
    measured: MeasuredLimits = field(default_factory=MeasuredLimits)
    ranks: RankLimits = field(default_factory=RankLimits)
    times: ContactTimeLimits = field(default_factory=ContactTimeLimits)
    stand: StandLimits = field(default_factory=StandLimits)
    walk: WalkLimits = field(default_factory=WalkLimits)
    estimate: EstimateLimits = field(default_factory=EstimateLimits)
    motors: MotorLimits = field(default_factory=MotorLimits)

    def described(self) -> tuple[DescribedSetting, ...]:
        """Return every limit with its dotted name, unit, meaning and source."""
        return describe(self)

    def lines(self) -> list[str]:
        """Return a line for each limit: name, value, unit and meaning."""
        return [f"{one.name} = {one.value:g} {one.info.unit}: {one.info.meaning}" for one in describe(self)]


LIMITS = AuditLimits()
"""What audits judge by unless they are told otherwise."""
