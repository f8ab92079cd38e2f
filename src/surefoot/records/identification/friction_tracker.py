"""Friction while the robot goes: an interval for every foot that a controller can use at once.

A foot uses no more friction than there is, ||f_t|| <= mu f_n, which bounds mu below; a foot that goes on
sliding uses all of it, against its way. What a foot used counts as a bound only if it lasted (`SUSTAINED`): a
single reading proves nothing. What is known fades: after `memory` seconds an old bound is gone, and a newer
one that contradicts it ends it at once, for grounds change.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray, finite_array, real_number, whole_number
from surefoot.base.errors import ProblemError
from surefoot.base.kernels import kernel
from surefoot.base.loaded import UNLOADED
from surefoot.base.memory import Remembering

SUSTAINED = 0.01
"""A use of friction counts as a lower bound when no reading of so long was less [s]."""
SETTLING, SLIDE = 0.01, 0.01
"""A slide tells mu from its age `SETTLING` on: the mean over `SLIDE` to twice that, loaded time only [s]."""
OPPOSED = 0.9
"""Least cosine between a slide and what friction opposes: a sliding foot's friction is against its way, that
of a standing one, which only a drifting estimate moves, is anywhere."""
SLIDING_SPEED = 0.03
"""Speed from which a loaded foot slides [m/s]; a soft ground lets a sticking one creep slower than that."""
AGREE = 1.1
"""A lower bound this many times the friction of an older slide says that the ground has changed."""
BUCKETS = 8
"""Parts of the memory; the oldest is forgotten when a new one begins."""

IDLE, SLID, SUM, AT, COUNT = range(5)
"""Columns of a contact's state: rows without load, rows of the slide so far, the sum of use in it, place in
the ring of uses, and rows there."""


class FrictionBounds(NamedTuple):
    """What is known about friction.

    Attributes
    ----------
    low, high
        (p,) interval for each contact; 0 and infinite where nothing is known.
    sliding
        (p,) which contacts slide now.
    """

    low: FloatArray
    high: FloatArray
    sliding: BoolArray


class FrictionTracker(Remembering):
    """Bounds on the friction under each contact, step by step.

    Parameters
    ----------
    contacts
        How many.
    dt
        Time between updates [s], at most 5 ms.
    least
        Normal force from which a contact tells of friction [N]; a few per cent of m g.
    memory
        How long a bound lasts [s].
    sliding_speed
        Speed from which a loaded contact slides [m/s].

    Raises
    ------
    ProblemError
        If a number is out of range.

    Examples
    --------
    >>> tracker = FrictionTracker(1, 0.001, least=5.0)
    >>> for _ in range(30):  # 40 N sideways under 100 N, at rest
    ...     known = tracker.update([[40.0, 0.0, 100.0]], [[0.0, 0.0, 0.0]])
    >>> known.low, known.high
    (array([0.4]), array([inf]))
    >>> tracker.believed(0.3)  # more than was assumed
    array([0.4])
    """

    MEMORY = ("_ring", "_state", "_lows", "_highs", "_low", "_high", "_sliding", "_bucket", "_age")

    def __init__(
        self,
        contacts: int,
        dt: float,
        *,
        least: float,
        memory: float = 4.0,
        sliding_speed: float = SLIDING_SPEED,
    ) -> None:
        self.contacts = whole_number("contacts", contacts, low=1)
        self.dt = real_number("dt", dt, low=1e-6, high=0.5 * SUSTAINED)
        self.least = real_number("least", least, low=1e-12)
        self.memory = real_number("memory", memory, low=BUCKETS * self.dt)
        self.sliding_speed = real_number("sliding_speed", sliding_speed, low=1e-9)
        self._rows = max(2, round(SUSTAINED / self.dt))
        self._gap = max(1, round(UNLOADED / self.dt))
        self._settling, self._slide = max(1, round(SETTLING / self.dt)), max(2, round(SLIDE / self.dt))
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        p = self.contacts
        self._ring = np.zeros((p, self._rows))
        self._state = np.zeros((p, 5))
        self._lows, self._highs = np.zeros((p, BUCKETS)), np.full((p, BUCKETS), np.inf)
        self._low, self._high = np.zeros(p), np.full(p, np.inf)
        self._sliding = np.zeros(p, dtype=np.bool_)
        self._bucket, self._age = 0, 0.0

    def update(self, forces: ArrayLike, velocities: ArrayLike) -> FrictionBounds:
        """Return the bounds after one more step.

        Parameters
        ----------
        forces, velocities
            (p, 3) on the robot's contacts and of their material, contact frames (normal last) [N, m/s].

        Raises
        ------
        ProblemError
            For wrong shapes or numbers that are not finite; what was known is kept.
        """
        shape = (self.contacts, 3)
        f, u = finite_array("forces", forces, shape), finite_array("velocities", velocities, shape)
        self._age += self.dt
        if self._age > self.memory / BUCKETS:
            self._age, self._bucket = 0.0, (self._bucket + 1) % BUCKETS
            self._lows[:, self._bucket], self._highs[:, self._bucket] = 0.0, np.inf
        follow_friction(
            self._ring, self._state, self._lows, self._highs, self._bucket, f, u, self.least,
            self.sliding_speed, self._settling, self._slide, self._gap, self._sliding,
        )  # fmt: skip
        newest = (self._bucket - np.arange(BUCKETS)) % BUCKETS
        known = np.isfinite(self._highs[:, newest])
        first = newest[np.argmax(known, axis=1)]  # the latest slide counts
        high = np.where(known.any(axis=1), self._highs[np.arange(self.contacts), first], np.inf)
        self._low, self._high = np.minimum(self._lows.max(axis=1), high), high
        return FrictionBounds(self._low.copy(), high, self._sliding.copy())

    def believed(self, assumed: float, margin: float = 0.1) -> FloatArray:
        """Return (p,) friction [-] to plan with: what was assumed, within what is known.

        Parameters
        ----------
        assumed
            Friction [-] where nothing is known.
        margin
            Share that is left of the friction that a slide showed.

        Raises
        ------
        ProblemError
            If `assumed` is negative or `margin` not in [0, 1).
        """
        prior = real_number("assumed", assumed, low=0.0)
        keep = 1.0 - real_number("margin", margin, low=0.0, high=1.0)
        if keep <= 0.0:
            raise ProblemError(f"margin must be below 1, got {margin:g}")
        return np.asarray(np.minimum(np.maximum(prior, self._low), keep * self._high))


@kernel
def _is_opposed(force: FloatArray, velocity: FloatArray, sliding_speed: float) -> bool:
    """Return whether a foot is that fast and its friction against that, both (3,) in its contact frame."""
    speed = np.hypot(velocity[0], velocity[1])
    against = -(force[0] * velocity[0] + force[1] * velocity[1])
    return bool(speed > sliding_speed and against >= OPPOSED * np.hypot(force[0], force[1]) * speed)


@kernel
def follow_friction(
    ring: FloatArray,
    state: FloatArray,
    lows: FloatArray,
    highs: FloatArray,
    bucket: int,
    forces: FloatArray,
    velocities: FloatArray,
    least: float,
    sliding_speed: float,
    settling: int,
    slide: int,
    gap: int,
    sliding: BoolArray,
) -> None:
    """Move every contact's memory on by one row.

    Parameters
    ----------
    ring
        (p, rows) the last uses of friction.
    state
        (p, 5), see the columns above.
    lows, highs
        (p, buckets) bounds found in each part of the memory; `bucket` is the one that is written.
    forces, velocities
        (p, 3) contact frames [N, m/s].
    least, sliding_speed
        [N], [m/s].
    settling, slide, gap
        Rows of a slide that tell nothing, rows whose mean tells mu after them, and rows without load that
        end a slide.
    sliding
        (p,) out: which contacts slide.
    """
    rows = ring.shape[1]
    for k in range(forces.shape[0]):
        normal = forces[k, 2]
        sliding[k] = False
        # Without load the ratio of forces says nothing. A short gap does not end a slide: feet chatter on
        # ice.
        if normal < least:
            state[k, IDLE] += 1.0
            state[k, COUNT] = 0.0
            if state[k, IDLE] >= gap:
                state[k, SLID], state[k, SUM] = 0.0, 0.0
            continue
        state[k, IDLE] = 0.0
        use = np.hypot(forces[k, 0], forces[k, 1]) / normal
        sliding[k] = _is_opposed(forces[k], velocities[k], sliding_speed)
        at = int(state[k, AT])
        ring[k, at] = use
        state[k, AT] = (at + 1) % rows
        state[k, COUNT] = min(state[k, COUNT] + 1.0, float(rows))
        # Sticking: ||f_t|| <= mu f_n bounds mu from below by a use that lasted, the least in the ring.
        if not sliding[k]:
            state[k, SLID], state[k, SUM] = 0.0, 0.0
            if state[k, COUNT] < rows:
                continue
            lasted = ring[k, 0]
            for i in range(1, rows):
                lasted = min(lasted, ring[k, i])
            lows[k, bucket] = max(lows[k, bucket], lasted)
            for b in range(highs.shape[1]):  # more than an older slide showed: another ground
                if lasted > AGREE * highs[k, b]:
                    highs[k, b] = np.inf
            continue
        state[k, SLID] += 1.0
        if state[k, SLID] <= settling:
            continue
        state[k, SUM] += use
        if state[k, SLID] < settling + slide:
            continue
        mu = state[k, SUM] / (state[k, SLID] - settling)
        if state[k, SLID] >= settling + 2 * slide:  # the older half fades
            state[k, SUM] *= 0.5
            state[k, SLID] = settling + slide
        highs[k, bucket] = mu
        for b in range(lows.shape[1]):  # less than a foot used before: another ground
            lows[k, b] = min(lows[k, b], mu)
