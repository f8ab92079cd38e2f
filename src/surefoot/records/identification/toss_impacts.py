"""Impacts one by one: how far a law's velocities after the first touch are from those that were recorded.

Velocities before and after a touch are those of the flights on either side, each fitted to its frames. What
noise of the recording leaves open of the first, a few draws carry through the simulated impact; with what it
leaves open of the second this is the floor that no law can go below. A law's likelihood is that of its errors
under Student's distribution (three degrees of freedom: some land on another corner first) of a variance
that is the floor's and the law's own; the second is fitted to some tosses and judged on others.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import stats
from scipy.optimize import minimize_scalar

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.records.identification.ground_plane import GroundPlane
from surefoot.records.identification.thrown_body import ThrownBody
from surefoot.records.identification.thrown_body_tree import sphere_places
from surefoot.records.identification.toss_errors import LOST
from surefoot.records.identification.toss_model import TossModel, TossScene
from surefoot.records.identification.toss_start import FEWEST, TossFlight, flying_frames
from surefoot.records.identification.tosses import Tosses

WITHIN = 6
"""Frames in which a touch must be over to count as one impact."""
AFTER = 8
"""Frames of the flight after it that are used, at most."""
CLEAR = 0.01
"""Height of the lowest corner that counts as flight after a touch, in widths."""
DRAWS = 8
LEAST = 8
"""Impacts that a law can be judged by."""
FREEDOM = 3.0


class ImpactFit(NamedTuple):
    """First impacts that a law was judged by: median errors of velocity [m/s] and spin [rad/s] after them.

    The floors are what noise alone would leave; `log_likelihood` (I,) is that of each impact.
    """

    impacts: int
    velocity_error_median: float
    velocity_floor: float
    spin_error_median: float
    spin_floor: float
    log_likelihood: FloatArray
    log_likelihood_mean: float


@dataclass(frozen=True)
class Impacts:
    """Errors of a law in the first impacts of tosses.

    Attributes
    ----------
    which
        (I,) tosses whose first touch is over at once.
    errors
        (I, nv) simulated less recorded velocity after it: [m/s], [rad/s], joints' rates [rad/s].
    floor
        (I, nv) standard deviations of what noise alone would leave.
    """

    which: IntArray
    errors: FloatArray
    floor: FloatArray

    def median(self, part: slice) -> tuple[float, float]:
        """Return the median error of some velocities, and that of noise alone: 0 to 3 [m/s], then [rad/s]."""
        error, noise = (np.median(np.linalg.norm(x[:, part], axis=1)) for x in (self.errors, self.floor))
        return float(error), float(noise)

    def spreads(self) -> FloatArray:
        """Return the law's own standard deviations (nv,) that are likeliest, alike for one kind."""
        out = np.empty(self.errors.shape[1])
        for part in (slice(0, 3), slice(3, 6), slice(6, None)):
            if self.errors[:, part].size:
                out[part] = np.exp(
                    minimize_scalar(
                        lambda x, part=part: -self._logs(np.exp(x))[:, part].sum(), bounds=(-9.0, 3.0)
                    ).x
                )
        return out

    def likelihood(self, spreads: FloatArray) -> FloatArray:
        """Return the log-likelihood (I,) of each impact for a law's own standard deviations (nv,)."""
        return np.asarray(self._logs(spreads).sum(axis=1))

    def _logs(self, spreads: FloatArray | float) -> FloatArray:
        scale = np.sqrt(self.floor**2 + np.square(spreads))
        return np.asarray(stats.t.logpdf(self.errors, FREEDOM, scale=scale))


def first_impacts(
    tosses: Tosses, scene: TossScene, model: TossModel, values: FloatArray, noise: tuple[float, float],
    known: tuple[ThrownBody, GroundPlane],
) -> Impacts | None:  # fmt: skip
    """Return the errors of a model in the first impacts, None where none is over at once.

    Parameters
    ----------
    tosses, scene
        What was recorded, and its scene.
    model, values
        What is judged, and its (k,) parameters.
    noise
        Standard deviations of a recorded coordinate [m] and angle [rad].
    known
        Body and ground that say when it touches: the same for all laws, which are paired impact by impact.
    """
    chosen, begins, counts, before = _find_impacts(tosses, *known)
    if not chosen.size:
        return None
    tree, nv = scene.body.tree, scene.body.tree.masses.size + 5
    rows = np.concatenate([a + np.arange(n) for a, n in zip(begins, counts, strict=True)])
    ends = np.concatenate([[0], np.cumsum(counts)])
    after = Tosses(tosses.states[rows], ends, tosses.dt)
    flight = TossFlight(after, counts, tree, scene.gravity)
    frames = begins + counts - tosses.starts[chosen]
    part = scene._replace(starts=scene.starts[chosen], frames=frames)
    taken = np.concatenate([end - n + np.arange(n) for end, n in zip(np.cumsum(frames), counts, strict=True)])
    arrival = TossFlight(tosses.subset(chosen), before, tree, scene.gravity)

    def apart(starts: FloatArray) -> FloatArray:
        poses = model.rollout(values, part._replace(starts=starts))[taken]
        good = np.isfinite(poses).all(axis=1)
        found = flight.apart(np.where(good[:, None], poses, after.poses))[:, nv:]
        found[~np.logical_and.reduceat(good, ends[:-1])] = LOST
        return found

    # What the noise of the arrival does to the velocity after, by simulation: an impact is no linear function
    # of it. The median over a chi-squared one's median is the variance, corners that change their order left
    # aside.
    errors, random = apart(part.starts), np.random.default_rng(0)
    shaken = [apart(arrival.shaken(part.starts, noise, random)) - errors for _ in range(DRAWS)]
    carried = np.median(np.square(shaken), axis=0) / stats.chi2.median(1)
    own = flight.deviations(noise)[:, nv:]
    return Impacts(chosen, errors, np.sqrt(carried + own**2))


def _find_impacts(
    tosses: Tosses, body: ThrownBody, plane: GroundPlane
) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Return the tosses whose first touch is over at once, with the flights after and before it.

    Of the one after the first row and the number of frames, of the one before the number of frames; all (I,).
    """
    places = sphere_places(body.tree, tosses.poses)
    before = flying_frames(tosses, places, plane, body.width)
    low = plane.above(places).min(axis=1) / body.width
    which, begins, lengths = [], [], []
    for k, (a, b) in enumerate(zip(tosses.starts[:-1], tosses.starts[1:], strict=True)):
        if before[k] < FEWEST:
            continue
        clear = low[a + before[k] : b] > CLEAR
        touched = np.flatnonzero(~clear & (np.minimum.accumulate(low[a + before[k] : b]) < 2.0 * CLEAR))
        if not touched.size:
            continue
        up = np.flatnonzero(clear[touched[0] :])
        if not up.size or up[0] > WITHIN:
            continue
        first = int(touched[0] + up[0])
        length = int(np.argmin(np.append(clear[first:], False)))
        if length >= FEWEST:
            which.append(k)
            begins.append(a + before[k] + first)
            lengths.append(min(length, AFTER))
    chosen = np.array(which, dtype=np.int64)
    return chosen, np.array(begins, dtype=np.int64), np.array(lengths, dtype=np.int64), before[chosen]


def judged_impacts(
    fitted: tuple[Tosses, TossScene], others: tuple[Tosses, TossScene], simulator: TossModel,
    values: FloatArray, noise: tuple[float, float], known: tuple[ThrownBody, GroundPlane],
) -> ImpactFit | None:  # fmt: skip
    """Judge a law by impacts in other tosses, or the same; its own spread is that in the fitted ones.

    Parameters
    ----------
    fitted, others
        Tosses and their scenes; None comes back where few first impacts are over at once.
    simulator, values
        What is judged, and its (k,) parameters.
    noise
        Standard deviations of a recorded coordinate [m] and angle [rad].
    known
        See `first_impacts`.
    """
    if not noise[0] > 0.0:
        return None
    seen = first_impacts(*fitted, simulator, values, noise, known)
    judged = seen if others[0] is fitted[0] else first_impacts(*others, simulator, values, noise, known)
    if seen is None or judged is None or len(seen.which) < LEAST:
        return None
    logs = judged.likelihood(seen.spreads())
    medians = (*judged.median(slice(0, 3)), *judged.median(slice(3, 6)))
    return ImpactFit(len(logs), *medians, logs, float(logs.mean()))
