"""The feet's state machine where nothing happens, which is nearly always, and the ramps of their forces."""

from __future__ import annotations

from surefoot.arrays import BoolArray, FloatArray
from surefoot.kernels import kernel


@kernel
def follow_phases(
    phases: FloatArray, time: float, wait: float, sensed: BoolArray, early: float, lost_time: float,
    stance: BoolArray, planned: BoolArray, late: BoolArray, share: FloatArray, sensed_at: FloatArray,
    retry: FloatArray, lifted: FloatArray,
) -> int:  # fmt: skip
    """Bring the feet up to a time, but for those that something happens to; return these as a sum of 2^k.

    Parameters
    ----------
    phases
        (n, 3) see `ContactSchedule.phases`.
    time, wait
        On the schedule's clock, and by how much that has been held up [s].
    sensed
        (n,) which feet feel the ground.
    early, lost_time
        Share of the swing from which touch is touchdown; time without touch in stance that is borne [s].
    stance, planned, late, share
        (n,) each: see `Feet`.
    sensed_at, retry, lifted
        (n,) when each foot last touched the ground; (n, 2) when its interrupted swing began anew and ends;
        (n,) when its last swing began [s].
    """
    events = 0
    for k in range(phases.shape[0]):
        on, begin, end = phases[k, 0] > 0.0, phases[k, 1], phases[k, 2]
        planned[k] = on
        if sensed[k]:
            sensed_at[k] = time
        if not stance[k] and time + wait < retry[k, 1]:
            events |= 1 << k
        elif on:
            if not (stance[k] and time - sensed_at[k] <= lost_time):
                events |= 1 << k
        else:
            late[k] = False
            share[k] = (time - begin) / (end - begin)
            if stance[k]:
                if begin > lifted[k]:
                    events |= 1 << k
            elif sensed[k] and share[k] > early:
                events |= 1 << k
    return events


@kernel
def set_timing(
    timing: FloatArray, share: FloatArray, late: BoolArray, late_from: FloatArray, now: float
) -> None:
    """Fill the columns of `swing_paths`' timing (n, 6) that change from step to step.

    Parameters
    ----------
    timing
        The duration of the swings, its third column, is read [s].
    share, late, late_from
        (n,) of the swing; (n,) which feet are late, and (n,) from when on [s].
    now
        On the clock of `late_from` [s].
    """
    for k in range(timing.shape[0]):
        timing[k, 1], timing[k, 4] = share[k], -1.0
        if late[k]:
            overdue = max(now - late_from[k], 0.0)
            timing[k, 1], timing[k, 4] = 1.0 + overdue / timing[k, 2], overdue
