"""`identify`: what recorded tosses say about friction, restitution, stiffness and the ground, with intervals.

In order: the ground from where the cube came to rest, gravity and the first state of every toss from free
flight, and then the contact law by `toss_search`, which simulates the tosses from first state to end.
Every interval is a bootstrap over tosses, the same resamples for all of them.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import stats

from surefoot.arrays import FloatArray, whole_number
from surefoot.errors import ProblemError
from surefoot.estimation.cube_model import CubeModel
from surefoot.estimation.free_flight import (
    SURE,
    TossFlight,
    fit_free_flight,
    flying_frames,
    gravity_of,
    gravity_terms,
)
from surefoot.estimation.ground_plane import GroundPlane, ground_points
from surefoot.estimation.toss_errors import TossErrors, resample, toss_errors
from surefoot.estimation.toss_model import TossModel, TossScene
from surefoot.estimation.toss_search import search, spread_evenly
from surefoot.estimation.tosses import Tosses, read_tosses
from surefoot.spatial import GRAVITY

LEAST = 8
"""Tosses that a fit needs."""
SCALE = 0.005
"""Share by which free fall must miss the standard gravity before a note says so."""


@dataclass(frozen=True)
class Estimate:
    """A fitted number and its 95 % interval, in `unit`."""

    value: float
    low: float
    high: float
    unit: str = ""


@dataclass(frozen=True)
class TossFit:
    """What `identify` found.

    Attributes
    ----------
    model
        Name of the contact law or simulator.
    parameters
        By name: those of the law, then ground [m], tilt_x and tilt_y [deg], gravity [m/s²].
    train, test
        Errors on the tosses it was fitted to, and on the others (None without any).
    train_poses, test_poses
        (N, 7) the simulated positions [m] and quaternions (x, y, z, w) behind them.
    position_noise, rotation_noise
        Standard deviations of a recorded coordinate [m] and angle [rad], from free flight.
    evaluations, seconds
        How often all tosses were simulated [-], and how long the fit took [s].
    notes
        What to know about the result, a line each.
    """

    model: str
    parameters: dict[str, Estimate]
    train: TossErrors
    test: TossErrors | None
    train_poses: FloatArray
    test_poses: FloatArray | None
    position_noise: float
    rotation_noise: float
    evaluations: float
    seconds: float
    notes: tuple[str, ...]

    def __getitem__(self, name: str) -> Estimate:
        return self.parameters[name]


@dataclass(frozen=True)
class Surroundings:
    """What is known before a contact law is fitted: the ground and gravity, with their bootstrap draws."""

    plane: GroundPlane
    gravity: float
    planes: FloatArray
    gravities: FloatArray
    flight: TossFlight
    notes: tuple[str, ...]

    def scene(self, tosses: Tosses) -> TossScene:
        """Return the scene of tosses, these or others on the same ground."""
        frames = flying_frames(tosses, self.plane)
        flight = fit_free_flight(tosses, frames, self.gravity)
        return TossScene(flight.starts, tosses.frames, tosses.dt, self.plane, self.gravity, tosses.cube)


def surroundings(tosses: Tosses, draws: FloatArray) -> Surroundings:
    """Find ground, gravity and first states; `draws` are (S, B) weights [-] of bootstrap samples."""
    notes = []
    points = ground_points(tosses)
    every = np.ones((1, len(tosses)))
    height, *slope = points.planes(every)[0]
    plane = GroundPlane(float(height), np.array(slope))
    if not points.resting:
        notes.append(
            "few tosses come to rest: the ground is taken from the lowest places that corners reached"
        )
    frames = flying_frames(tosses, plane)
    terms = gravity_terms(tosses, frames)
    gravity, gravities = float(gravity_of(terms, every)[0]), gravity_of(terms, draws)
    if not gravities.std() < SURE or not 0.5 < gravity / GRAVITY < 2.0:
        gravity, gravities = GRAVITY, np.full(len(draws), GRAVITY)
        notes.append("too little free flight to tell gravity: the standard one is taken")
    elif abs(gravity / GRAVITY - 1.0) > SCALE:
        notes.append(
            f"free fall at {gravity:.3f} m/s² instead of {GRAVITY:g}: lengths, or times, are "
            f"{100.0 * abs(gravity / GRAVITY - 1.0):.1f} % off"
        )
    flight = fit_free_flight(tosses, frames, gravity)
    grounded = int((flight.frames == 0).sum())
    if grounded:
        notes.append(f"{grounded} tosses start too near the ground: their first recorded velocity is used")
    planes = _widened(points.planes(draws), np.array([height, *slope]), int(points.use.sum()))
    return Surroundings(plane, gravity, planes, gravities, flight, tuple(notes))


def _widened(draws: FloatArray, fitted: FloatArray, tosses: int) -> FloatArray:
    """Return (S, d) bootstrap draws as wide as Student's interval of a fit of d numbers to so many tosses.

    Residuals are smaller than errors, by sqrt((n - d) / n), and the bootstrap takes the ones for the others.
    """
    free = max(1, tosses - fitted.size)
    wider = np.sqrt(tosses / free) * stats.t.ppf(0.975, free) / stats.norm.ppf(0.975)
    return np.asarray(fitted + wider * (draws - fitted))


def identify(
    tosses: Tosses | str | Path,
    law: str | TossModel = "rigid",
    *,
    test: Tosses | str | Path | None = None,
    most: int | None = None,
    resamples: int = 1000,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> TossFit:
    """Fit friction, restitution or stiffness and damping, and the ground, to recorded tosses of a cube.

    Parameters
    ----------
    tosses
        What to fit, or a file of it (`read_tosses`).
    law
        "rigid", "spring-damper" or "hunt-crossley"; or any `TossModel`, such as a rival simulator.
    test
        Other tosses of the same cube on the same ground, which the fit does not see.
    most
        Tosses that the law is fitted to, evenly spread, for a slow simulator; None for all. The
        ground, gravity and the errors are of all of them in any case.
    resamples
        Bootstrap samples of tosses behind the 95 % intervals.
    seed
        Of the resampling and of the points that are tried; the same seed gives the same fit.
    progress
        Told the number of tosses simulated so far, now and then.

    Returns
    -------
    TossFit

    Raises
    ------
    ProblemError
        If a file is none of tosses, there are fewer than eight, or the law's name is unknown.
    """
    begin = time.perf_counter()
    model = CubeModel(law) if isinstance(law, str) else law
    tosses = tosses if isinstance(tosses, Tosses) else read_tosses(tosses)
    others = read_tosses(test) if isinstance(test, (str, Path)) else test
    if len(tosses) < LEAST:
        raise ProblemError(f"a fit needs {LEAST} tosses or more, got {len(tosses)}")
    draws = resample(len(tosses), whole_number("resamples", resamples, low=20), whole_number("seed", seed))
    found = surroundings(tosses, draws)
    scene, count = found.scene(tosses), 0.0

    def tick(simulated: float) -> None:
        nonlocal count
        count += simulated
        if progress is not None:
            progress(count)

    notes, fitted = list(found.notes), [p.name for p in model.parameters]
    which = spread_evenly(tosses, len(tosses) if most is None else whole_number("most", most, low=LEAST))
    if which.size < len(tosses):
        notes.append(f"{model.name}: fitted to {which.size} of {len(tosses)} tosses")
        chosen = resample(which.size, resamples, seed)
        best = search(model, tosses.subset(which), scene.subset(which), chosen, seed, tick)
    else:
        best = search(model, tosses, scene, draws, seed, tick)
    if "stiffness" in fitted:
        notes.append(
            f"{model.name}: several minima in stiffness and damping; the intervals are those of this one"
        )
    if not best.settled:
        notes.append(f"{model.name}: the search did not settle; take the intervals as too narrow")
    poses = model.rollout(best.values, scene)
    test_poses = None if others is None else model.rollout(best.values, found.scene(others))
    return TossFit(
        model.name,
        _estimates(model, best.values, best.draws, found),
        toss_errors(tosses, poses),
        None if others is None or test_poses is None else toss_errors(others, test_poses),
        poses, test_poses, found.flight.position_noise, found.flight.rotation_noise, best.evaluations,
        time.perf_counter() - begin, tuple(notes),
    )  # fmt: skip


def _estimates(
    model: TossModel, values: FloatArray, draws: FloatArray, found: Surroundings
) -> dict[str, Estimate]:
    """Return all fitted numbers by name."""
    out = {p.name: _estimate(values[k], draws[:, k], p.unit) for k, p in enumerate(model.parameters)}
    out["ground"] = _estimate(found.plane.height, found.planes[:, 0], "m")
    for k, name in enumerate(("tilt_x", "tilt_y")):
        angles = np.degrees(np.arctan(found.planes[:, 1 + k]))
        out[name] = _estimate(float(np.degrees(np.arctan(found.plane.slope[k]))), angles, "deg")
    out["gravity"] = _estimate(found.gravity, found.gravities, "m/s²")
    return out


def _estimate(value: float, draws: FloatArray, unit: str) -> Estimate:
    low, high = np.percentile(draws, [2.5, 97.5])
    return Estimate(float(value), min(float(low), float(value)), max(float(high), float(value)), unit)
