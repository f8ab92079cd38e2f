"""Forces that rise at touchdown and fall before lift-off: bounds on normal forces over a stance.

A foot that carries its share of the weight from one millisecond to the next asks its motors for a step in
torque, and drops the body when it leaves. So the most that a foot may push grows along a line from the moment
it touches, and falls along one to the moment it is planned to lift; the predictive controller knows it and
moves the load to the other feet in time. A foot that has been taken to stand for an instant and feels nothing
any more waits with its ramp: pushed down in the air it would strike the ground.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.kernels import kernel
from surefoot.stance.contact_schedule import ContactSchedule

SAMPLES = 4
"""Instants within a step of the horizon that its mean bound is taken from."""
LANDED = 1e-3
"""A foot that touches has used this much of its ramp: it may push at once, if little [s]."""


class ForceRamps:
    """Shares of the largest normal force that feet may use, from touchdown to lift-off.

    Parameters
    ----------
    schedule
        When feet are planned to lift and land.
    length
        Of a ramp [s]; 0 for none.
    """

    def __init__(self, schedule: ContactSchedule, length: float) -> None:
        self.schedule, self.length = schedule, max(length, 1e-9)
        self._landed = np.full(schedule.feet, -math.inf)
        self._carrying: BoolArray = np.ones(schedule.feet, dtype=bool)
        self._shares = np.ones(schedule.feet)
        self._time = math.inf  # no time has passed before the first step

    def now(self, time: float, carrying: BoolArray, felt: BoolArray | None = None) -> FloatArray:
        """Return the shares at a time of the schedule [s] for (n,) feet that carry: (n,), 0 to 1.

        To be called at every step: a foot's ramp begins when it first carries, and goes on while the foot
        feels the ground, (n,); None where that is not known, and all do.
        """
        shares, schedule = self._shares, self.schedule
        elapsed = max(time - self._time, 0.0)
        self._time = time
        early = ramp_shares(
            schedule.phases(time), carrying, carrying if felt is None else felt, self._carrying, self._landed,
            time, elapsed, LANDED, self.length, shares,
        )  # fmt: skip
        for k in range(len(shares)) if early else ():
            if early >> k & 1:
                left = (self._lift_off(k, time) - time) / self.length
                shares[k] = min(shares[k], max(left, 0.0))
        return shares.copy()

    def ahead(self, time: float, step: float, count: int) -> FloatArray:
        """Return the mean shares over `count` coming steps of `step` [s]: (count, n).

        Feet that carry now keep the ramp of their touchdown; later stances are those of the schedule.
        """
        fine = time + step * (np.arange(count * SAMPLES) + 0.5) / SAMPLES
        last, stances = float(fine[-1]), []
        for k in range(self.schedule.feet):
            if self._carrying[k]:
                begin, end = float(self._landed[k]), self._lift_off(k, time)
            else:
                begin, end = self._next_stance(k, time)
            while begin <= last:
                stances.append((k, begin, end))
                if end > last:
                    break
                begin, end = self._next_stance(k, end)
        out = np.empty((count, self.schedule.feet))
        mean_shares(np.array(stances, dtype=np.float64).reshape(-1, 3), fine, self.length, out)
        return out

    def _lift_off(self, k: int, time: float) -> float:
        """Return when a foot that carries is planned to lift; one that landed early, after its stance."""
        planned, _, end = self.schedule.phase(k, time)
        return end if planned else self.schedule.phase(k, end)[2]

    def _next_stance(self, k: int, time: float) -> tuple[float, float]:
        """Return begin and end of the stance that a foot in the air lands for."""
        planned, begin, end = self.schedule.phase(k, time)
        if planned:  # late: its stance has begun
            return max(begin, time), end
        return end, self.schedule.phase(k, end)[2]


@kernel
def ramp_shares(
    phases: FloatArray, carrying: BoolArray, felt: BoolArray, carried: BoolArray, landed: FloatArray,
    time: float, elapsed: float, step: float, length: float, shares: FloatArray,
) -> int:  # fmt: skip
    """Fill (n,) shares of the largest normal force; return as a sum of 2^k the feet that landed early.

    Parameters
    ----------
    phases
        (n, 3) see `ContactSchedule.phases`.
    carrying, felt
        (n,) which feet carry now, and which feel the ground.
    carried, landed
        (n,) which feet carried at the last step, and (n,) when they began to [s]: brought up.
    time, elapsed, step, length
        Now, since the last step, what is counted as carried already at a touchdown, and a ramp's length [s].
    shares
        1 for feet that do not carry. Those of feet that landed early have no end yet.
    """
    early = 0
    for k in range(shares.shape[0]):
        if carrying[k] and not carried[k]:
            landed[k] = time
        elif carrying[k] and not felt[k] and time - landed[k] + step < length:
            landed[k] += elapsed  # it may hang in the air still: more force would throw it at the ground
        carried[k] = carrying[k]
        shares[k] = 1.0
        if carrying[k]:
            used = time - landed[k] + step
            if phases[k, 0] > 0.0:
                used = min(used, phases[k, 2] - time)
            else:
                early |= 1 << k
            shares[k] = min(max(used / length, 0.0), 1.0)
    return early


@kernel
def mean_shares(stances: FloatArray, times: FloatArray, length: float, out: FloatArray) -> None:
    """Fill (count, n) means of the feet's shares, 0 to 1, over equally many of the times; 1 outside stances.

    Parameters
    ----------
    stances
        (m, 3) foot, begin and end of stances in order, none overlapping another of its foot [-, s, s].
    times
        (k count,) rising [s].
    length
        Of a ramp [s].
    """
    count, samples = len(out), len(times) // len(out)
    out[:] = 1.0
    for i in range(len(stances)):
        foot, begin, end = int(stances[i, 0]), stances[i, 1], stances[i, 2]
        for t in range(count * samples):
            if begin <= times[t] < end:
                share = min(max(min(times[t] - begin, end - times[t]) / length, 0.0), 1.0)
                out[t // samples, foot] -= (1.0 - share) / samples
