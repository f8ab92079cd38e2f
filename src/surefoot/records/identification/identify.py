"""`identify`: what recorded tosses say about a body, its contact and the ground, with intervals.

In order: the ground from where the body came to rest; gravity, first states and centres of mass from free
flight; the body, with a first law, from the frames just after the first touch; and then a contact law from
all frames, and all of it together under that law (`toss_refit`). Each step is the same search (`toss_search`)
over simulated tosses. Every interval is a bootstrap over tosses, the same resamples for all of them.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray, whole_number
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot
from surefoot.records.identification.frame_weights import error_growth, frames_since
from surefoot.records.identification.ground_plane import CLEAR, GroundPlane, ground_points
from surefoot.records.identification.relevel_tosses import Levelling, find_levelled
from surefoot.records.identification.thrown_body import ThrownBody, TossParameter, cube_body, thrown_body
from surefoot.records.identification.thrown_body_tree import sphere_places
from surefoot.records.identification.toss_errors import TossMeasure, resample, toss_errors
from surefoot.records.identification.toss_fit import SLOPES, BodyFit, Estimate, TossFit, plane_at
from surefoot.records.identification.toss_impacts import judged_impacts
from surefoot.records.identification.toss_model import ThrownModel, TossModel, TossScene
from surefoot.records.identification.toss_refit import (
    Refit,
    estimate_of,
    ground_parameters,
    refit_body,
    scene_at,
    tilts,
)
from surefoot.records.identification.toss_search import SearchResult, search
from surefoot.records.identification.toss_start import TossFlight, flying_frames
from surefoot.records.identification.tosses import Tosses, read_tosses

LEAST = 8
"""Tosses that a fit needs."""
SCALE = 0.005
"""Share by which free fall must miss the standard gravity before a note says so."""
FEW = 128
"""Tosses, evenly spread, that tell the body."""
SOON, LATER = 8, 25
"""Frames after the first touch that tell the body: few, while the law is still wrong, then more."""
GIVES = "compliance"
"""How the numbers of hinges that give are called."""
SURE = 0.2
"""Standard error of gravity [m/s²] above which the standard value is taken."""
WIDE = 0.15
"""Height above a ground that levelled tosses tell, to a few mm, that counts as flight, in widths."""
UNKNOWN = 0.5
"""An interval as wide as this share of a parameter's range says that the data cannot tell it."""


def identify(
    tosses: Tosses | str | Path,
    law: str | TossModel = "rigid",
    *,
    model: Robot | str | Path | None = None,
    test: Tosses | str | Path | None = None,
    found: BodyFit | None = None,
    resamples: int = 1000,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> TossFit:
    """Fit a body, its friction and restitution, and the ground, to recorded tosses.

    Parameters
    ----------
    tosses
        What to fit, or a file of it (`read_tosses`).
    law
        "rigid", "newton", "tangential" or "growing-friction"; or any `TossModel`.
    model
        What was thrown: a URDF or MJCF file, or a robot; None for the cube that the tosses name.
    test
        Other tosses of the same body on the same ground, which the fit does not see.
    found
        The body as another fit to the same tosses found it; None to identify it.
    resamples
        Bootstrap samples of tosses behind the 95 % intervals.
    seed
        Of the resampling; the same seed gives the same fit.
    progress
        Called with the number of tosses simulated so far, now and then.

    Returns
    -------
    TossFit

    Raises
    ------
    ProblemError
        If a file is none of tosses, there are fewer than eight, the law's name is unknown, or the model has
        not the tosses' joints.
    """
    begin = time.perf_counter()
    simulator = ThrownModel(law) if isinstance(law, str) else law
    tosses = tosses if isinstance(tosses, Tosses) else read_tosses(tosses)
    others = read_tosses(test) if isinstance(test, (str, Path)) else test
    if len(tosses) < LEAST:
        raise ProblemError(f"a fit needs {LEAST} tosses or more, got {len(tosses)}")
    draws = resample(len(tosses), whole_number("resamples", resamples, low=20), whole_number("seed", seed))
    count = 0.0

    def tick(simulated: float) -> None:
        nonlocal count
        count += simulated
        if progress is not None:
            progress(count)

    if found is None:
        found = _find_body(tosses, _body_of_tosses(model, tosses, others), simulator, draws, tick)
    tosses = found.upright(tosses)
    values, found = _fit_law(tosses, simulator, found, draws, tick)
    refit = refit_body(tosses, simulator, found, values, draws, tick)
    notes = list(found.notes)
    if not refit.result.settled:
        notes.append(f"{simulator.name}: the search did not settle; take the intervals as too narrow")
    return _judge_fit(simulator, tosses, others, refit, notes, (count, begin))


def begin_fit(
    tosses: Tosses, simulator: TossModel, *, model: Robot | str | Path | None = None, resamples: int = 1000,
    seed: int = 0,
) -> BodyFit:  # fmt: skip
    """Return the body from which `identify` begins with a law; see there for the arguments."""
    draws = resample(len(tosses), resamples, seed)
    return _find_body(tosses, _body_of_tosses(model, tosses, None), simulator, draws, lambda _: None)


def _find_body(
    tosses: Tosses, body: ThrownBody, simulator: TossModel, draws: FloatArray, tick: Callable[[float], None]
) -> BodyFit:
    """Identify a body by the rigid law, in as many steps as the simulator takes if it is of this package."""
    first = replace(simulator, law="rigid") if isinstance(simulator, ThrownModel) else ThrownModel()
    return identify_body(tosses, body, first, draws, tick, find_levelled(tosses, body))


def _judge_fit(
    simulator: TossModel, tosses: Tosses, others: Tosses | None, refit: Refit, notes: list[str],
    effort: tuple[float, float],
) -> TossFit:  # fmt: skip
    """Return a fit with its errors; `effort` is how many tosses were simulated, and when it began [s]."""
    values, fitted, found, own = refit.values, refit.estimates, refit.found, simulator.parameters
    scene, before, (count, begin) = found.scene(tosses), found.before(tosses), effort
    wide = [p.name for p in own if fitted[p.name].high - fitted[p.name].low > UNKNOWN * (p.high - p.low)]
    if wide:
        notes.append(f"{simulator.name}: the tosses hardly tell {', '.join(wide)}")
    width, poses = found.body.width, simulator.rollout(values, scene)
    noise = found.flight.position_noise, found.flight.rotation_noise
    judged, test_scene, test_poses, test_errors = tosses, scene, None, None
    if others is not None:
        judged = found.upright(others)
        test_scene = found.scene(judged)
        test_poses = simulator.rollout(values, test_scene)
        test_errors = toss_errors(judged, test_poses, width, found.before(judged))
    return TossFit(
        simulator.name, fitted | found.parameters, toss_errors(tosses, poses, width, before), test_errors,
        poses, test_poses, found,
        judged_impacts((tosses, scene), (judged, test_scene), simulator, values, noise, found.first[:2]),
        *noise,
        refit.result.loss, count / len(tosses), time.perf_counter() - begin, tuple(notes),
    )  # fmt: skip


def _body_of_tosses(model: Robot | str | Path | None, tosses: Tosses, others: Tosses | None) -> ThrownBody:
    """Return the body of a model, or the cube that the tosses name; it has the joints of all of them."""
    body = cube_body(tosses.cube) if model is None else thrown_body(model)
    for one in (tosses, others):
        if one is not None and one.joints != len(body.joints):
            raise ProblemError(f"the model has {len(body.joints)} joints, the tosses have {one.joints}")
    return body


def _fit_law(
    tosses: Tosses, simulator: TossModel, found: BodyFit, draws: FloatArray, tick: Callable[[float], None]
) -> tuple[FloatArray, BodyFit]:
    """Return a law's values (d,) on all frames, the body held, and the body with the loss that they have."""
    own, scene, before = simulator.parameters, found.scene(tosses), found.before(tosses)
    first = values = np.array([found.values.get(p.name, p.start) for p in own])
    if not all(p.name in found.values for p in own):
        early = before + LATER
        start = found.measure, None
        values = _search_law(tosses, simulator, scene, early, (values, first), start, draws, tick).values
    if found.growth is None:
        rows = found.measure.deviations(tosses, simulator.rollout(values, scene))
        found = found._replace(growth=error_growth(rows, frames_since(tosses.frames, before)))
    whole = found.weighed_measure(tosses), found.scale
    best = _search_law(tosses, simulator, scene, tosses.frames, (values, first), whole, draws, tick)
    return best.values, found._replace(scale=best.scale)


def _search_law(
    tosses: Tosses, simulator: TossModel, scene: TossScene, ends: IntArray, starts: Sequence[FloatArray],
    judged: tuple[TossMeasure, FloatArray | None], draws: FloatArray, tick: Callable[[float], None],
) -> SearchResult:  # fmt: skip
    """Fit a law to the frames before (B,) ends, from several starts (d,); the body is held.

    It is judged by a measure, and robust from errors (G,) on, the median ones at the start without any.
    """
    part, (measure, scale) = tosses.until(ends), judged
    here = scene._replace(frames=part.frames)

    def simulate(values: FloatArray) -> FloatArray:
        tick(len(part.states) / len(tosses.states) * len(tosses))
        return measure.deviations(part, simulator.rollout(values, here))

    first, *others = starts
    return search(simulate, simulator.parameters, first, part.frames, draws, others=others, scale=scale)


def identify_body(
    tosses: Tosses, body: ThrownBody, law: ThrownModel, draws: FloatArray, tick: Callable[[float], None],
    levelled: Levelling | None = None,
) -> BodyFit:  # fmt: skip
    """Find body, ground, gravity, first states by a first law; `draws` (S, B) weigh bootstrap samples."""
    clear, notes = (CLEAR if levelled is None else WIDE), []
    if levelled is not None:
        tosses = levelled.upright(tosses)
        notes.append(levelled.note)
    corners = sphere_places(body.tree, tosses.poses)
    points = ground_points(tosses, corners, body.width) if levelled is None else levelled.touches
    height, *slope = (float(x) for x in points.planes(np.ones((1, len(tosses))))[0])
    plane = GroundPlane(height, np.array(slope), clear)
    if not points.resting:
        notes.append(
            "few tosses come to rest: the ground is taken from the lowest places that corners reached"
        )
    planes = points.draws(draws)
    chosen = np.unique(np.linspace(0, len(tosses) - 1, min(FEW, len(tosses))).round().astype(np.int64))
    before = flying_frames(tosses, corners, plane, body.width)
    fit = _BodySearch(tosses, body, law, plane, before, tick)
    gravity = fit.falls(draws, notes)
    told = {"gravity": fit.draws["gravity"], **dict(zip(SLOPES, planes[:, 1:].T, strict=True))}
    few, values = tosses.subset(chosen), fit.values
    # rigid hinges lie in a valley of their own, which a search with those that give may miss
    ways = (False, True) if any(p.name.startswith(GIVES) for p in body.parameters) else (False,)
    parts = [_BodySearch(few, body, law, plane, before[chosen], tick, values, told) for _ in ways]
    around, few_draws = ground_parameters(plane, levelled is not None), draws[:, chosen]
    losses = [part.lands(SOON, few_draws, around, way) for part, way in zip(parts, ways, strict=True)]
    part = parts[int(np.argmin(losses))]
    part.lands(LATER, few_draws, around)
    values = part.values
    known = body.at(values)
    flight = TossFlight(tosses, before, known.tree, gravity)
    grounded = int((flight.used == 0).sum())
    if grounded:
        notes.append(f"{grounded} tosses start too near the ground: their first recorded velocity is used")
    estimates = part.estimates | tilts(values, part.draws) | {"gravity": fit.estimates["gravity"]}
    ground = plane_at(values, clear)
    return BodyFit(
        known, ground, gravity, estimates, flight, values, part.draws, body, levelled, tuple(notes),
        (known, ground, gravity),
    )  # fmt: skip


class _BodySearch:
    """The steps that find a body: each goes on from the values, by name, that the last one left."""

    def __init__(
        self, tosses: Tosses, body: ThrownBody, law: ThrownModel, plane: GroundPlane, before: IntArray,
        tick: Callable[[float], None], values: dict[str, float] | None = None,
        draws: dict[str, FloatArray] | None = None,
    ) -> None:  # fmt: skip
        self._tosses, self._body, self._before = tosses, body, before
        self._tick, self._law = tick, law
        start = {"gravity": GRAVITY, "ground": plane.height}
        start |= dict(zip(SLOPES, plane.slope.tolist(), strict=True))
        start |= {p.name: p.start for p in (*body.parameters, *self._law.parameters)}
        self.values = start | (values or {})
        self.estimates: dict[str, Estimate] = {}
        self.draws = dict(draws or {})
        self._flight = TossFlight(tosses, before, body.at(self.values).tree, self.values["gravity"])

    def falls(self, draws: FloatArray, notes: list[str]) -> float:
        """Find gravity and centres of mass in free flight; return gravity [m/s²]."""
        gravity = TossParameter("gravity", GRAVITY, 0.05, 0.5 * GRAVITY, 2.0 * GRAVITY, "m/s²")
        in_flight = ("com_", "friction", "damping")
        own = [p for p in self._body.parameters if p.name.startswith(in_flight)]
        self._fit((gravity, *own), None, draws)
        found = self.estimates["gravity"]
        if not found.high - found.low < 4.0 * SURE:
            notes.append("too little free flight to tell gravity: the standard one is taken")
            self.values = {**self.values, **{p.name: p.start for p in (gravity, *own)}}
            self.draws["gravity"] = np.full(len(draws), GRAVITY)
            self.estimates["gravity"] = Estimate(GRAVITY, GRAVITY, GRAVITY, "m/s²")
        elif abs(found.value / GRAVITY - 1.0) > SCALE:
            notes.append(
                f"free fall at {found.value:.3f} m/s² instead of {GRAVITY:g}: lengths, or times, are "
                f"{100.0 * abs(found.value / GRAVITY - 1.0):.1f} % off"
            )
        return self.values["gravity"]

    def lands(
        self, horizon: int, draws: FloatArray, ground: Sequence[TossParameter], rigid: bool = False
    ) -> float:
        """Find everything else, in so many frames after the first touch; return the loss."""
        own = [p for p in self._body.parameters if not (rigid and p.name.startswith(GIVES))]
        return self._fit((*self._law.parameters, *ground, *own), horizon, draws)

    def _fit(self, parameters: Sequence[TossParameter], horizon: int | None, draws: FloatArray) -> float:
        law, names = [p.name for p in self._law.parameters], [p.name for p in parameters]
        given = [name for name in ("gravity", *SLOPES) if horizon and name not in names]
        part = self._tosses.until(np.maximum(self._before + (horizon or 0), 2))
        fixed, measure = self.values, TossMeasure(self._body.width, self._body.arm)

        def simulate(values: FloatArray) -> FloatArray:
            now = fixed | dict(zip([*names, *given], values.tolist(), strict=True))
            now["ground"] = now["ground"] if horizon is not None else -1e3
            scene = scene_at(part, self._body.at(now), self._flight, now)
            self._tick(len(part.states) / len(self._tosses.states) * len(self._tosses))
            poses = self._law.rollout(np.array([now[name] for name in law]), scene)
            return measure.deviations(part, poses)

        held = np.stack([self.draws[name] for name in given], axis=1) if given else None
        values = np.array([fixed[name] for name in (*names, *given)])
        best = search(simulate, parameters, values, part.frames, draws, held)
        self.values = fixed | dict(zip(names, best.values.tolist(), strict=True))
        for k, p in enumerate(parameters):
            self.draws[p.name] = best.draws[:, k]
            if p.name not in (*law, *SLOPES):  # told as tilts, and by each law
                self.estimates[p.name] = estimate_of(best.values[k], best.draws[:, k], p.unit)
        now = self._body.at(self.values)
        self._flight = TossFlight(self._tosses, self._before, now.tree, self.values["gravity"])
        return best.loss
