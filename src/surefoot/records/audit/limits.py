"""The limits of an audit: every number that decides a verdict or ranks a symptom, as one frozen value.

`LIMITS` is what audits judge by unless they are given another value; `python -m benchmarks.limits` varies one
limit at a time over logs with seeded faults and clean ones, and says which values find as much.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from surefoot.base.loaded import ACTS, UNLOADED
from surefoot.base.settings import DescribedSetting, Settings, describe, setting
from surefoot.records.audit.check_limits import (
    BalanceLimits,
    CheckLimits,
    CommandLimits,
    ContinuityLimits,
    FrictionLimits,
    ReboundLimits,
)
from surefoot.records.audit.consistency_limits import ConsistencyLimits
from surefoot.records.audit.limit_sources import RIVALS, VARIED
from surefoot.records.audit.rank_limits import RankLimits
from surefoot.records.audit.run_limits import (
    ContactTimeLimits,
    EstimateLimits,
    MotorLimits,
    StandLimits,
    WalkLimits,
)
from surefoot.records.audit.symptom_limits import BodyLimits, ContactLimits, FitLimits, MeasuredLimits


@dataclass(frozen=True)
class LawLimits(Settings):
    """Limits of the three laws of contact."""

    penetration: float = setting(
        1e-3,
        "m",
        "deepest penetration that counts as touching, widest gap across which a force may act",
        low=0.0,
        tuned=RIVALS + "0.001 to 0.001",
    )
    slide: float = setting(
        1e-3,
        "m",
        "longest way of a contact without friction that counts as sticking",
        low=0.0,
        tuned=VARIED + "0.001 to 0.003",
    )
    swing_depth: float = setting(
        1.6,
        "-",
        "factor on the depth of a soft contact while its body tumbles on corners (1.5 was seen)",
        low=1.0,
        tuned=VARIED + "1.6 to 1.6",
    )
    hard_touchdown: float = setting(
        0.7,
        "m/s",
        "speed into the ground from which a landing sets soft contacts swinging",
        low=0.0,
        tuned=VARIED + "0.2333 to 0.7",
    )
    pull: float = setting(
        1e-3, "m g", "largest pull that counts as rounding", low=0.0, tuned=VARIED + "3.333e-07 to 0.03"
    )
    cone: float = setting(
        1.0 + 1e-3,
        "-",
        "highest use of the friction cone that counts as inside",
        low=0.0,
        tuned=VARIED + "1 to 1.003",
    )
    loaded: float = setting(
        ACTS,
        "m g",
        "normal force above which a contact is loaded; below it its use of friction is noise",
        low=0.0,
        tuned=VARIED + "0.001 to 0.003",
    )
    least_friction: float = setting(
        1e-4,
        "-",
        "friction that a ground with less counts as having: simulators know no exact zero",
        low=1e-12,
        tuned=VARIED + "3.333e-05 to 0.003",
    )
    sliding_speed: float = setting(
        1e-2,
        "m/s",
        "tangential speed from which a contact slides at an instant",
        low=0.0,
        tuned=VARIED + "0.0003333 to 0.03",
    )
    slide_piece: float = setting(
        1e-4,
        "m",
        "length of the pieces of a slide; shaking within less is no way",
        low=1e-9,
        tuned=VARIED + "3.333e-05 to 0.3",
    )
    release: float = setting(
        UNLOADED,
        "s",
        "time without load that ends a stance; a shorter one is a bounce",
        low=0.0,
        tuned=VARIED + "0.006667 to 0.06",
    )
    lag: float = setting(
        0.05,
        "-",
        "share of the friction's work that may be missing throughout a slide: 18 degrees of lag",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.01667 to 0.15",
    )


@dataclass(frozen=True)
class SoftnessLimits(Settings):
    """The most that a world may declare of its softness: beyond it anything could hide."""

    sinking: float = setting(
        0.05, "m", "depth to which contacts may sink", low=0.0, tuned=VARIED + "0.001667 to 150"
    )
    creep: float = setting(
        0.1, "m/s", "speed at which loaded contacts may creep", low=0.0, tuned=VARIED + "0.003333 to 300"
    )
    stopping: float = setting(
        0.1, "m", "way on which a sliding contact may be stopped", low=0.0, tuned=VARIED + "0.0003333 to 300"
    )
    settling: float = setting(
        0.1,
        "s",
        "time after a touchdown within which a contact may swing",
        low=0.0,
        tuned=VARIED + "0.03333 to 3",
    )


@dataclass(frozen=True)
class RecordLimits(Settings):
    """Limits of what a log says of itself, before any law is judged."""

    least_rows: int = setting(4, "-", "rows without which no log is lawful", low=2, tuned=VARIED + "4 to 8")
    missing_step: float = setting(
        5.5, "dt", "step of the clock from which rows are lost", low=1.0, tuned=VARIED + "1.833 to 16.5"
    )
    known_step_low: float = setting(
        0.2,
        "dt",
        "shortest step over which an acceleration is known",
        low=0.0,
        tuned=VARIED + "0.006667 to 0.6",
    )
    known_step_high: float = setting(
        5.0, "dt", "longest step over which an acceleration is known", low=1.0, tuned=VARIED + "1.667 to 150"
    )
    same_dt: float = setting(
        0.02,
        "dt",
        "difference of the declared step from that of the time stamps that is a contradiction",
        low=0.0,
        tuned=VARIED + "0.006667 to 0.02",
    )
    same_mass: float = setting(
        1e-3,
        "-",
        "share by which a recording's mass may differ from that of the robot of its name",
        low=0.0,
        tuned=VARIED + "0.001 to 0.03",
    )
    unit_length: float = setting(
        0.02,
        "-",
        "difference of a normal's squared length from one that makes it no direction",
        low=0.0,
        tuned=VARIED + "0.02 to 0.06",
    )
    unit_quaternion: float = setting(
        1e-3,
        "-",
        "difference of a quaternion's length from one that makes it none",
        low=0.0,
        tuned=VARIED + "3.333e-05 to 3",
    )
    creep: float = setting(
        0.1,
        "m/s",
        "most that is allowed of the creep a world declares, whatever a row's own is",
        low=0.0,
        tuned=VARIED + "0.03333 to 0.3",
    )
    deep: float = setting(
        5e-3,
        "m",
        "declared sinking from which a world is called soft",
        low=0.0,
        tuned=RIVALS + "0.001667 to 0.005",
    )
    clear: float = setting(
        3.0,
        "-",
        "ratio of two misfits from which the smaller one tells whose velocities a row has",
        low=1.0,
        tuned=RIVALS + "3 to 90",
    )
    join: float = setting(
        0.02, "s", "time between two violations that are one", low=0.0, tuned=VARIED + "0.0006667 to 0.06"
    )
    sticking: float = setting(
        0.05,
        "rad/s",
        "joint speed below which dry friction may be anything up to its size",
        low=0.0,
        tuned=VARIED + "1.667e-05 to 1.5",
    )


@dataclass(frozen=True)
class EpisodeLimits(Settings):
    """Limits of what belongs to one episode, and of what its forces say."""

    near: float = setting(
        0.05,
        "s",
        "time between failures of one contact that are one episode",
        low=0.0,
        tuned=VARIED + "0.05 to 0.15",
    )
    at_once: float = setting(
        0.03,
        "s",
        "time after an episode's begin from which a wrong motion is its consequence",
        low=0.0,
        tuned=VARIED + "0.03 to 0.9",
    )
    all: float = setting(
        0.75,
        "-",
        "share of the contacts from which a finding is one of all",
        low=0.0,
        tuned=VARIED + "0.75 to 0.75",
    )
    at_rest: float = setting(
        1e-6,
        "m/s, rad/s",
        "speed below which nothing has moved",
        low=0.0,
        tuned=VARIED + "3.333e-08 to 0.0003",
    )
    known: float = setting(
        0.5,
        "-",
        "share of the rows in which joint torques must tell a foot's force",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.01667 to 0.5",
    )
    landing: float = setting(
        2.0,
        "m v",
        "impulse up to which the largest force is the blow of a landing",
        low=0.0,
        tuned=VARIED + "2 to 2",
    )
    sideways: float = setting(
        0.05,
        "-",
        "share of the squared mismatch along the normal of one that lies across it",
        low=0.0,
        tuned=RIVALS + "1.667e-05 to 0.15",
    )
    amiss: float = setting(
        0.01,
        "m g",
        "mismatch up to which there is nothing to explain",
        low=0.0,
        tuned=VARIED + "0.0003333 to 0.03",
    )


@dataclass(frozen=True)
class AuditLimits(Settings):
    """All limits of an audit, by what they are limits of."""

    laws: LawLimits = field(default_factory=LawLimits)
    softness: SoftnessLimits = field(default_factory=SoftnessLimits)
    records: RecordLimits = field(default_factory=RecordLimits)
    checks: CheckLimits = field(default_factory=CheckLimits)
    balance: BalanceLimits = field(default_factory=BalanceLimits)
    continuity: ContinuityLimits = field(default_factory=ContinuityLimits)
    consistency: ConsistencyLimits = field(default_factory=ConsistencyLimits)
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
