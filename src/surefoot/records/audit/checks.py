"""What is measured of every row against a limit: the laws, and signs that break none but tell something.

A check is a function from rows to its measure, its limit and where the limit is exceeded; one line in the
table makes it part of every audit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.numerics.windows import sliding_mean, sliding_sum
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.balance import balance
from surefoot.records.audit.cones import friction_needed, grip
from surefoot.records.audit.consistency import (
    acceleration,
    centre_of_mass,
    momentum,
    pressing,
    sliding_max,
    uneven,
)  # fmt: skip
from surefoot.records.audit.continuity import contact_velocity, gap_rate, no_kinematics, no_plane, state
from surefoot.records.audit.depths import depth, penetration
from surefoot.records.audit.flights import flights, what_drives
from surefoot.records.audit.log_context import Setting
from surefoot.records.audit.places import gap_place, jump, no_feet, no_ground
from surefoot.records.audit.restitution import rebound, sparse, throw
from surefoot.records.audit.rows import Measured, Rows, on_body, over
from surefoot.records.audit.soles import has_soles, soles
from surefoot.records.audit.within_row import limb_turns, turn_speed, way_to_touch, whirling
from surefoot.records.log import Log


@dataclass(frozen=True)
class Check:
    """A law or a sign.

    Attributes
    ----------
    name, title
        Key, and what people read.
    unit
        Of its measure.
    law
        Whether breaking it makes a log unlawful; else it is a sign, for symptoms to read.
    needs
        Channels without which it cannot be judged.
    measure
        From rows to what was measured.
    doubt
        Why a log that has the channels cannot be judged all the same; empty where it can.
    applies
        Whether a log has what the check is about; one that has not is not asked for it.
    by_contact
        Whether it looks at each contact, or each robot's contacts, alone: several robots may then be judged
        as one, side by side, see `surefoot.records.audit.batch`.
    """

    name: str
    title: str
    unit: str
    law: bool
    needs: tuple[str, ...]
    measure: Callable[[Rows], Measured]
    doubt: Callable[[Log, Setting], str] = lambda log, setting: ""
    applies: Callable[[Log], bool] = lambda log: True
    by_contact: bool = False

    def judge(self, rows: Rows) -> Measured:
        """Return measure, limit and where it is exceeded in the rows that are asked for, and are finite."""
        core = rows.core
        value, limit, bad = self.measure(rows)
        if rows.all_finite:
            return value[core], limit[core], bad[core]
        lost = rows.not_finite[core, : bad.shape[1]] | rows.not_finite[core, -1:]
        return value[core], limit[core], bad[core] & ~lost


def _pull(rows: Rows) -> Measured:
    return over(-rows.normal, rows.setting.limits.laws.pull * rows.setting.weight)


def _friction(rows: Rows) -> Measured:
    """Friction that a force needs; one of hardly any normal force may have the noise of it."""
    limits = rows.setting.limits.laws
    return over(friction_needed(rows), limits.cone * np.maximum(rows.mu, limits.least_friction))


def _distance(rows: Rows) -> Measured:
    """Force across a gap, along the normal or across it; a gap may close within its row."""
    pushed = np.maximum(np.abs(rows.normal), rows.tangential) > rows.setting.threshold
    value = np.where(pushed, rows.gaps, 0.0)
    limit = max(rows.setting.limits.laws.penetration, rows.setting.sinking)
    margin = np.asarray(rows.log.facts.get("contact_margin", np.zeros(rows.points)))
    most = rows.setting.limits.softness.sinking
    return over(value, limit + np.clip(margin, 0.0, most) + rows.once(way_to_touch))


def _without_settling(rows: Rows, value: FloatArray) -> FloatArray:
    """Return (T, p) values of windows, zero for those in which soft contacts swing from a hard touchdown."""
    window = rows.window(rows.setting.limits.checks.slide_window)
    hit = sliding_sum(rows.swinging.astype(np.float64), window + 2)
    return np.where(hit > 0.0, 0.0, value)


def _work(rows: Rows) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return way [m], friction's work [J] and the most that it could take [J], over windows: (T, p) each."""
    friction = rows.once(grip)
    own = rows.knows_creep  # else the limit knows the creep
    w = rows.window(rows.setting.limits.checks.slide_window)
    on = rows.loaded.copy()
    on[1:] &= rows.loaded[:-1]  # not the row of a touchdown: its force is the blow that stops the foot
    slip = rows.slip if own else rows.velocities
    taken = np.where(on, rows.dt[:, None], 0.0)
    x, y = slip[..., 0] * taken, slip[..., 1] * taken
    way = np.hypot(sliding_sum(x, w), sliding_sum(y, w))
    work = sliding_sum(rows.forces[..., 0] * x + rows.forces[..., 1] * y, w)
    most = sliding_sum(friction * rows.normal * np.hypot(x, y), w)
    return way, work, most


def _driving(rows: Rows) -> Measured:
    """Work that friction gave [J]: never positive, but regularised friction turns late."""
    _, work, most = rows.once(_work)
    share = rows.setting.limits.checks.drive_share
    late = rows.setting.limits.laws.slide + 2.0 * rows.setting.stopping
    limit = np.maximum(share * late * rows.setting.weight, share * most)
    unsure = sliding_sum(rows.once(grip) * rows.normal * rows.unsure_way, rows.window(_slide_window(rows)))
    return over(_without_settling(rows, work), limit + np.maximum(unsure, 0.0))


def _sliding(rows: Rows) -> Measured:
    """Way of a contact as if without friction [m]."""
    way, work, most = rows.once(_work)
    limits = rows.setting.limits.checks
    share = np.clip((limits.brake_share * most + work) / np.maximum(most, 1e-12), 0.0, 1.0)
    value = np.where(most > 0.0, way * share, 0.0)
    creep = 0.0 if rows.knows_creep else rows.setting.creep
    unsure = rows.once(_unsure_ways)
    limit = rows.setting.slide_limit + creep * limits.slide_window + unsure
    return over(_without_settling(rows, value), limit)


def longest_unsure_way(rows: Rows) -> FloatArray:
    """Return the longest way of a window along the ground that velocities of rows leave open [m].

    (p,), that of each contact's robot.
    """
    longest = rows.once(_unsure_ways).max(axis=0, initial=0.0)
    robots = rows.setting.robots
    return np.repeat(longest.reshape(robots, -1).max(axis=1), len(longest) // robots)


def _unsure_ways(rows: Rows) -> FloatArray:
    """Return the ways of windows along the ground that velocities of rows leave open: (T, p) [m]."""
    return sliding_sum(rows.unsure_way, rows.window(_slide_window(rows)))


def _slide_window(rows: Rows) -> float:
    return rows.setting.limits.checks.slide_window


def _bias(rows: Rows) -> Measured:
    """Way on which a pyramid brakes less than the round cone, times the share that it lacks [m]."""
    limits, window = rows.setting.limits.laws, rows.window(rows.setting.limits.checks.slide_window)
    least = limits.least_friction
    lacks = np.where(rows.mu > least, 1.0 - rows.once(grip) / np.maximum(rows.mu, least), 0.0)
    way = np.hypot(rows.slip[..., 0], rows.slip[..., 1]) * rows.dt[:, None]
    return over(sliding_sum(np.where(rows.loaded, way * lacks, 0.0), window), limits.slide)


def _motion(rows: Rows) -> Measured:
    """Force that the motion leaves unexplained: at each foot, and on the body [N]."""
    rest, limits = rows.unexplained, rows.setting.limits.balance
    weight, w = rows.setting.weight, rows.window(limits.smooth)
    value = np.zeros((rows.count, rows.points + 1))
    if rest is not None:
        by_foot = np.linalg.norm(sliding_mean(rest.feet, w), axis=-1)
        value[:, :-1] = by_foot[:, rows.setting.owner]
        force = np.linalg.norm(sliding_mean(rest.force, w), axis=-1)
        moment = np.linalg.norm(sliding_mean(rest.moment, w), axis=-1)
        value[:, -1] = np.fmax(force, moment * (limits.force / limits.arm))
        rings = np.sqrt(sliding_mean((rest.force**2).sum(axis=1), rows.window(limits.ringing_time)))
        value[:, -1] = np.fmax(value[:, -1], rings * (limits.force / limits.ringing))
    limit = np.full(rows.count, limits.force * weight)
    if rows.setting.means:
        limit += sliding_max(_turned_forces(rows), w)
    limit[whirling(rows, max(w, rows.window(limits.ringing_time)))] = np.inf
    return over(np.nan_to_num(value), limit[:, None])


def _turned_forces(rows: Rows) -> FloatArray:
    """Return what is open of forces that come and go within a row of means, on links that turn: (T,) [N]."""
    robot = rows.setting.robot
    if robot is None:
        return np.zeros(rows.count)
    out = (np.linalg.norm(rows.forces, axis=2) * limb_turns(rows, robot)).sum(axis=1)
    if "other_forces" in rows.log:  # joints that run into their stops
        stops = np.abs(rows.numbers("other_forces")[:, robot.base_dof :]).sum(axis=1)
        out += stops / rows.setting.limits.continuity.lever * turn_speed(rows) * rows.dt
    return np.asarray(out)


def _chatter(rows: Rows) -> Measured:
    """Switches between loaded and unloaded in a window, or as many for a force that rings."""
    limits = rows.setting.limits.checks
    w, most = rows.window(limits.chatter_window), limits.chatter_switches
    switched = np.zeros(rows.loaded.shape)
    switched[1:] = rows.loaded[1:] != rows.loaded[:-1]
    step = np.zeros(rows.normal.shape)
    step[1:] = np.diff(rows.normal, axis=0)
    back = np.zeros(step.shape)
    back[1:] = np.where(step[1:] * step[:-1] < 0.0, np.minimum(np.abs(step[1:]), np.abs(step[:-1])), 0.0)
    ringing = sliding_sum(np.minimum(back, rows.setting.weight), w) / w
    value = np.maximum(sliding_sum(switched, w), ringing / (limits.ringing * rows.setting.weight) * most)
    out = over(value, most - 0.5)
    near = rows.window(rows.setting.limits.balance.smooth)
    return out[0], out[1], out[2] & (sliding_sum(switched + (back > 0.0), near) > 0.0)


def _blow(rows: Rows) -> Measured:
    """Force of one or two rows beyond those on both sides, over m g."""
    size = rows.force_sizes
    around = np.full(size.shape, np.inf)
    if rows.count >= 5:
        around[2:-2] = np.maximum(np.minimum(size[:-4], size[1:-3]), np.minimum(size[4:], size[3:-1]))
    value = np.where(np.isfinite(around), size - around, 0.0) / rows.setting.weight
    return over(value, rows.setting.limits.checks.spike)


def _spike(rows: Rows) -> Measured:
    """Force of one or two rows beyond those on both sides and beyond any landing's, over m g.

    A landing takes no more impulse than all of the robot at the speed of what lands, twice that where it
    bounces, and the friction that goes with it.
    """
    value, limit, _ = _blow(rows)
    if not rows.has("contact_velocities"):
        return over(value, limit)
    down = np.maximum(-rows.rising, 0.0)
    around = np.pad(down, ((2, 2), (0, 0)), mode="edge")
    near = reduce(np.maximum, (around[k : k + rows.count] for k in range(5)))
    speed = rows.over_robot(near, np.maximum)
    share = rows.setting.limits.episodes.landing * speed / (GRAVITY * rows.dt[:, None])
    return over(value, limit + share * np.hypot(1.0, rows.mu))


def _solver_error(rows: Rows) -> Measured:
    """Error of a contact force as the world's solver left it [N], a mean of some time."""
    limits = rows.setting.limits.balance
    value = sliding_mean(rows.numbers("solver_error"), rows.window(limits.smooth))
    return over(on_body(rows, value), limits.force * rows.setting.weight)


def _idle(rows: Rows) -> Measured:
    """Time during which nothing carries the robot though a foot touches the ground, or it does not fall."""
    limits = rows.setting.limits.checks
    w = rows.window(limits.idle_time)
    idle = np.zeros(rows.count, dtype=bool)
    if rows.has("gaps"):
        idle |= (rows.gaps <= limits.idle_gap).any(axis=1)
    if rows.unexplained is not None:
        force = np.nan_to_num(rows.unexplained.force)
        idle |= np.linalg.norm(force, axis=1) > limits.idle_force * rows.setting.weight
    idle &= np.abs(rows.forces).max(axis=(1, 2)) <= rows.setting.threshold
    value, limit, bad = over(on_body(rows, sliding_sum(idle.astype(np.float64), w) / w), limits.idle_share)
    return value, limit, bad & idle[:, None]


def _frozen(rows: Rows) -> Measured:
    """Share of a window in which a force does not change in the last digit."""
    limits = rows.setting.limits.checks
    w = rows.window(limits.frozen_time)
    same = np.zeros(rows.normal.shape)
    same[1:] = (rows.normal[1:] == rows.normal[:-1]) & (np.abs(rows.normal[1:]) > rows.setting.threshold)
    value = sliding_sum(same, w) / w
    out = over(value, limits.frozen_share)
    return out[0], out[1], out[2] & (w > limits.frozen_rows)


def _lean(rows: Rows) -> Measured:
    """Share of m g that one diagonal of four feet carries beyond the other, while all are loaded."""
    limits, value = rows.setting.limits.checks, np.zeros((rows.count, rows.points))
    if rows.points == 4:
        n = rows.normal
        lean = (n[:, 0] + n[:, 3] - n[:, 1] - n[:, 2]) / rows.setting.weight
        level = np.where(rows.loaded.all(axis=1), lean, np.nan)
        mean = np.abs(sliding_mean(level, rows.window(limits.lean_time)))
        value[:] = np.nan_to_num(mean)[:, None]
    return over(value, limits.lean)


FORCES, GAPS = ("forces",), ("forces", "gaps")
CHECKS = (
    Check(
        "penetration", "no contact sinks into the ground", "m", True, ("gaps",), penetration, by_contact=True
    ),
    Check("pull", "the ground pushes, it never pulls", "N", True, FORCES, _pull, by_contact=True),
    Check(
        "friction", "no more friction than the ground has", "mu", True, ("forces", "mu"), _friction,
        by_contact=True,
    ),
    Check("distance", "no force across a gap", "m", True, GAPS, _distance, by_contact=True),
    Check(
        "sole", "a sole's wrench is the sum of its corners' forces", "N", True,
        ("forces", "contact_moments", "mu"), soles, applies=has_soles,
    ),
    Check(
        "work", "friction never drives", "J", True, ("forces", "contact_velocities", "mu"), _driving,
        by_contact=True,
    ),
    Check(
        "dissipation", "what slides is braked in full", "m", True, ("forces", "contact_velocities", "mu"),
        _sliding, by_contact=True,
    ),
    Check(
        "motion", "forces explain the motion", "N", True, ("forces", "q", "v"), _motion,
        lambda _, setting: setting.why_no_motion,
    ),
    Check(
        "balance", "contacts carry all of the robot", "N", True,
        ("forces", "momentum_rate", "com", "contact_positions", "normals"), balance,
    ),
    Check(
        "restitution", "a touch returns no more than it took", "J", True, ("forces", "contact_velocities"),
        rebound, sparse, by_contact=True,
    ),
    Check(
        "flight", "what falls comes back no higher", "J", True, ("forces", "gaps", "contact_velocities"),
        flights, what_drives,
    ),
    Check("state", "positions follow from velocities", "m", True, ("q", "v"), state),
    Check(
        "gap rate", "gaps follow from velocities", "m", True, ("gaps", "contact_velocities"), gap_rate,
        no_plane, by_contact=True,
    ),
    Check(
        "contact velocity", "contacts move with the joints", "m/s", True, ("contact_velocities", "q", "v"),
        contact_velocity, no_kinematics,
    ),
    Check(
        "momentum", "momentum changes by its rate", "m/s", True, ("momentum", "momentum_rate"), momentum
    ),
    Check(
        "centre of mass", "the centre of mass moves by the momentum", "m", True, ("com", "momentum"),
        centre_of_mass,
    ),
    Check(
        "acceleration", "forces move the centre of mass", "N", True, ("com", "forces", "normals"),
        acceleration, uneven,
    ),
    Check(
        "pressing", "forces press at their contact points", "N m", True,
        ("forces", "momentum_rate", "com", "contact_positions", "normals"), pressing,
    ),
    Check(
        "gap place", "gaps are those of the contact points", "m", True,
        ("gaps", "contact_positions", "normals"), gap_place, no_ground, by_contact=True,
    ),
    Check(
        "contact jump", "contact points go on as their material does", "m", True,
        ("contact_positions", "contact_velocities", "normals"), jump, no_feet, by_contact=True,
    ),
    Check(
        "bias", "a pyramid brakes less than the round cone", "m", False,
        ("forces", "contact_velocities", "mu", "pyramid_turn"), _bias,
    ),
    Check("depth", "a soft contact", "m", False, ("gaps",), depth, by_contact=True),
    Check("chatter", "switches of contact in 0.1 s", "1", False, FORCES, _chatter, by_contact=True),
    Check("blow", "force of one row", "m g", False, FORCES, _blow, by_contact=True),
    Check("spike", "force of one row that no landing gives", "m g", False, FORCES, _spike, by_contact=True),
    Check(
        "throw", "contacts come out of the ground faster than declared", "J", False,
        ("forces", "gaps", "contact_velocities"), throw, by_contact=True,
    ),
    Check("unconverged", "the solver stopped early", "N", False, ("forces", "solver_error"), _solver_error),
    Check("idle", "nothing carries the robot", "share", False, FORCES, _idle),
    Check("frozen", "a force that does not change", "share", False, FORCES, _frozen, by_contact=True),
    Check("lean", "one diagonal of feet carries more", "m g", False, FORCES, _lean),
)  # fmt: skip
"""Laws first, then signs."""
