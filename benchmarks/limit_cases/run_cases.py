"""What a whole run came to: stands, walks, estimates and motors."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from benchmarks.limit_cases.made import arrays_of, changed_log
from benchmarks.limit_cases.verdict import STAND, CleanLogs, Verdict
from surefoot.base.arrays import FloatArray
from surefoot.records.audit.limits import AuditLimits
from surefoot.records.audit.summary.estimate_summary import estimate_errors, load_estimate
from surefoot.records.audit.summary.motor_summary import motor_use
from surefoot.records.audit.summary.stand_summary import displaced, summarise_stand
from surefoot.records.audit.summary.walk_summary import velocity_tracking
from surefoot.records.log import Log

DT = 2e-3


def run_cases(logs: CleanLogs) -> Iterator[Verdict]:
    """Yield the cases of runs."""
    yield from _stands(logs(STAND))
    yield from _walks()
    yield from _estimates()
    yield from _motors()


def _stands(stand: Log) -> Iterator[Verdict]:
    for way, outcome, why in (
        (3e-3, "stood", "a rubber foot shears by a tenth of its 3 cm"),
        (0.05, "slipped", "a foot that slid by its own width and more"),
    ):
        yield Verdict(f"a foot went {1e3 * way:g} mm", why, partial(_stood, _slid(stand, way), outcome))
    height = 0.3
    for away, lean, wrong, why in (
        (0.01, 0.0, False, "1 cm: joints of a leg of 0.3 m that give way by 2 degrees"),
        (0.09, 0.0, True, "a base a third of its height aside is over the edge of its feet"),
        (0.0, 5.0, False, "feet on ground that is uneven by 3 cm under 0.4 m between them"),
        (0.0, 25.0, True, "a base that lies on two feet of four leans by 20 degrees and more"),
    ):
        log = _standing(away, lean, height)
        said = partial(_displaced, log, wrong)
        yield Verdict(f"a base {100 * away:g} cm aside that leans {lean:g} deg", why, said)


def _stood(log: Log, outcome: str, limits: AuditLimits) -> bool:
    return summarise_stand(log, limits).outcome == outcome


def _displaced(log: Log, wrong: bool, limits: AuditLimits) -> bool:
    return displaced(log, limits=limits) is wrong


def _slid(stand: Log, way: float) -> Log:
    """Return a stand in which a foot goes so far over the ground [m], with the rest as it was."""
    arrays = arrays_of(stand)
    arrays["contact_velocities"][:, :, :2] = 0.0
    rows = slice(300, 400)
    arrays["contact_velocities"][rows, 0, 0] = way / (100 * float(stand.fact("dt")))
    return changed_log(stand, arrays)


def _standing(away: float, lean: float, height: float) -> Log:
    """Return a base of a height [m] that goes aside [m] and leans [deg]."""
    count = 100
    q = np.zeros((count, 7))
    q[:, 2] = height
    q[:, 0] = np.linspace(0.0, away, count)
    half = 0.5 * np.radians(np.linspace(0.0, lean, count))
    q[:, 3], q[:, 6] = np.sin(half), np.cos(half)
    return Log({"time": DT * np.arange(count), "q": q, "contact_positions": np.zeros((count, 4, 3))}, {})


def _walks() -> Iterator[Verdict]:
    """Yield walks of 5 s that speed up at 0.33 m/s², and what their summary says of the velocity."""
    tracked = (
        (0.5, 0.5, True, "reaches 0.5 m/s after 1.5 s, at a third of what a trot's friction allows"),
        (1.0, 0.95, True, "a leg 5 % shorter than modelled: strides as much shorter"),
        (1.0, 0.75, False, "a quarter of the speed is missing"),
        (0.0, 0.01, True, "a body that sways drifts by a centimetre in a second"),
        (0.0, 0.1, False, "marching on the spot that goes a metre in ten seconds"),
    )
    followed = (
        (1.0, 0.7, True, "heavy going: a third of the speed is lost on a slope"),
        (1.0, 0.2, False, "feet that slip under it: a fifth of the speed is left"),
        (0.0, 0.02, True, "it should stay and drifts by 2 cm in a second"),
        (0.0, 0.13, False, "it should stay and goes its own length in three seconds"),
    )
    for asked, gone, right, why in tracked:
        said = partial(_tracks, _walk(asked, gone), right)
        yield Verdict(f"a walk at {gone:g} of {asked:g} m/s is{'' if right else ' not'} on speed", why, said)
    for asked, gone, right, why in followed:
        said = partial(_follows, _walk(asked, gone), right)
        yield Verdict(f"a walk at {gone:g} of {asked:g} m/s follows{'' if right else ' not'}", why, said)


def _tracks(log: Log, right: bool, limits: AuditLimits) -> bool:
    return velocity_tracking(log, limits).within is right


def _follows(log: Log, right: bool, limits: AuditLimits) -> bool:
    return velocity_tracking(log, limits).followed_within(limits) is right


def _walk(asked: float, gone: float) -> Log:
    time = np.arange(0.0, 5.0, 0.01)
    q, v, command = np.zeros((len(time), 7)), np.zeros((len(time), 6)), np.zeros((len(time), 3))
    q[:, 6], v[:, 0], command[:, 0] = 1.0, gone * np.minimum(time / 1.5, 1.0), asked
    return Log({"time": time, "q": q, "v": v, "command": command}, {})


def _estimates() -> Iterator[Verdict]:
    for way, told, why in (
        (0.2, False, "in half a stride, 1 cm of a foot's rolling alone is a drift of 5 %"),
        (1.2, True, "several strides: a foot's rolling is below 1 %"),
    ):
        said = partial(_drift_told, _estimate(way), told)
        yield Verdict(f"drift over {way:g} m is{'' if told else ' not'} a share", why, said)
    yield Verdict(
        "a payload of 2 kg is told to 0.1 kg",
        "an estimator of 0.3 s swings by 0.3 kg with a trot's steps, four in a second",
        _payload_told,
    )
    for mass, told, why in (
        (0.2, False, "0.2 N m of hip torque noise would be a place 10 cm aside"),
        (1.5, True, "the same noise is 1.4 cm"),
    ):
        said = partial(_place_told, _load(mass), told)
        yield Verdict(f"the place of {mass:g} kg is{'' if told else ' not'} told", why, said)


def _drift_told(log: Log, told: bool, limits: AuditLimits) -> bool:
    return (estimate_errors(log, limits).drift_share is not None) is told


def _place_told(log: Log, told: bool, limits: AuditLimits) -> bool:
    return (load_estimate(log, limits).place is not None) is told


def _payload_told(limits: AuditLimits) -> bool:
    return abs(load_estimate(_load(2.0), limits).mass - 2.0) < 0.1


def _estimate(way: float) -> Log:
    count = 100
    q, v = np.zeros((count, 7)), np.zeros((count, 6))
    q[:, 6], q[:, 0] = 1.0, np.linspace(0.0, way, count)
    guess = q.copy()
    guess[:, 0] += np.linspace(0.0, 0.01, count)
    return Log({"time": DT * np.arange(count), "q": q, "v": v, "q_estimated": guess, "v_estimated": v}, {})


def _load(mass: float) -> Log:
    time = np.arange(0.0, 4.0, DT)
    load = np.zeros((len(time), 4))
    load[:, 0] = mass * (1.0 - np.exp(-time / 0.3)) + 0.15 * mass * np.sin(2.0 * np.pi * 4.0 * time)
    arrays = {"time": time, "load_estimated": load, "wrench_estimated": np.zeros((len(time), 6))}
    return Log(arrays, {"dt": DT, "mass_controller": 15.0})


def _motors() -> Iterator[Verdict]:
    for speed, beyond, why in (
        (20.009, False, "a speed held at its limit, in a driver's units of 0.05 %"),
        (20.4, True, "2 %: a ripple that no reading of an encoder makes"),
    ):
        said = partial(_speeds, _joint(speed, 0.0), beyond)
        yield Verdict(f"{speed:g} rad/s of 20 are{'' if beyond else ' not'} too fast", why, said)
    for torque, beyond, why in (
        (10.02, False, "a current of 12 bits is known to 0.2 % of a motor's torque"),
        (10.5, True, "5 % more than the motor has: copper that is 13 K colder"),
    ):
        said = partial(_torques, _joint(0.0, torque), beyond)
        yield Verdict(f"{torque:g} N m of 10 are{'' if beyond else ' not'} beyond", why, said)


def _speeds(log: Log, beyond: bool, limits: AuditLimits) -> bool:
    use = motor_use(log, limits)
    return use is not None and (use.over_speed_share > 0.0) is beyond


def _torques(log: Log, beyond: bool, limits: AuditLimits) -> bool:
    use = motor_use(log, limits)
    return use is not None and (use.beyond_curve_share > 0.0) is beyond


def _joint(speed: float, torque: float) -> Log:
    """Return two rows of a joint of 10 N m and 20 rad/s."""
    v: FloatArray = np.zeros((2, 7))
    v[:, 6] = speed if speed else 1e-3
    facts = {"joints": ["knee"], "effort_limits": [10.0], "speed_limits": [20.0], "actuators": "real"}
    torques = np.full((2, 1), torque)
    return Log({"time": DT * np.arange(2), "v": v, "torques": torques}, facts)
