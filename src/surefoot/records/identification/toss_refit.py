"""The body and its surroundings fitted again under the law that is judged, on all frames of all tosses.

A body that was found under a first law, from the frames just after the first touch, is not the best one for
another law or for what follows. From there every parameter, the law's and the body's, is moved alone until
no move pays (`toss_search`). What free flight and rest tell, gravity and slopes, stays in its interval. Where
tosses were levelled one by one rest tells no slope, and touches on the way only about: it is fitted like the
ground's height.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.records.identification.ground_plane import GroundPlane
from surefoot.records.identification.thrown_body import ThrownBody, TossParameter
from surefoot.records.identification.toss_fit import SLOPES, BodyFit, Estimate, plane_at
from surefoot.records.identification.toss_model import ThrownModel, TossModel, TossScene
from surefoot.records.identification.toss_search import SearchResult, search
from surefoot.records.identification.toss_start import TossFlight
from surefoot.records.identification.tosses import Tosses

MEASURED = {"gravity": 0.02, SLOPES[0]: 5e-4, SLOPES[1]: 5e-4}
"""Numbers that are measured without a law, and a step of each that shows [m/s², -, -]."""
RISE, STEEPEST = 2e-3, 0.2
"""A step of a slope that is not measured, and the largest one."""


class Refit(NamedTuple):
    """A law's values (d,) with their intervals by name, the body found with them, and the search."""

    values: FloatArray
    estimates: dict[str, Estimate]
    found: BodyFit
    result: SearchResult


def scene_at(tosses: Tosses, body: ThrownBody, flight: TossFlight, now: dict[str, float]) -> TossScene:
    """Return the scene of a body and a ground whose numbers are these, by name."""
    starts = flight.corrected(body.tree, now["gravity"])
    return TossScene(starts, tosses.frames, tosses.dt, plane_at(now), now["gravity"], body)


def ground_parameters(plane: GroundPlane, levelled: bool) -> tuple[TossParameter, ...]:
    """Return what is fitted of the ground: its height, and its slopes where resting places do not tell."""
    height = TossParameter("ground", plane.height, 2e-4, -1e3, 1e3, "m")
    if not levelled:
        return (height,)
    rises = zip(SLOPES, plane.slope.tolist(), strict=True)
    return (height, *(TossParameter(name, rise, RISE, -STEEPEST, STEEPEST) for name, rise in rises))


def tilts(values: dict[str, float], draws: dict[str, FloatArray]) -> dict[str, Estimate]:
    """Return the ground's tilts [deg], from its slopes and their draws (S,) by name."""
    out = {}
    for tilt, slope in zip(("tilt_x", "tilt_y"), SLOPES, strict=True):
        degrees = np.degrees(np.arctan([values[slope], *draws[slope]]))
        out[tilt] = estimate_of(degrees[0], degrees[1:], "deg")
    return out


def estimate_of(value: float, draws: FloatArray, unit: str, *others: FloatArray) -> Estimate:
    """Return a value and the 95 % interval of its draws (S,), which holds it, and those of others (R,)."""
    low, high = np.transpose([np.percentile(each, [2.5, 97.5]) for each in (draws, *others)])
    return Estimate(float(value), float(min(value, *low)), float(max(value, *high)), unit)


def refit_body(
    tosses: Tosses, simulator: TossModel, found: BodyFit, values: FloatArray, draws: FloatArray,
    tick: Callable[[float], None],
) -> Refit:  # fmt: skip
    """Fit a law and everything around it together.

    Parameters
    ----------
    tosses
        Upright, see `BodyFit.upright`.
    simulator, values
        The law, and (d,) where its parameters are.
    found
        The body so far; its `scale` and `growth` are the loss's.
    draws
        (S, B) weights of the tosses in each bootstrap sample.
    tick
        Called with the number of tosses of each simulation.
    """
    own, now = simulator.parameters, found.values
    around, parameters = _list_around(found), list_parameters(simulator, found)
    names, count = [p.name for p in parameters], len(own)
    throw = simulate_around(tosses, simulator, found)

    def simulate(point: FloatArray) -> FloatArray:
        tick(len(tosses))
        return throw(point)

    start = np.append(values, [now[name] for name in names[count:]])
    best = search(simulate, parameters, start, tosses.frames, draws, scale=found.scale, descents=2)
    spread = dict(zip(names, best.draws.T, strict=True))
    here = now | dict(zip(names, best.values.tolist(), strict=True))
    told = (*own, *around)
    # the body's first law was one of ours
    known = told if isinstance(simulator, ThrownModel) else around
    drawn, estimates = _widen(found, here, spread, told, {p.name for p in known})
    around_it = found.parameters | tilts(here, drawn)
    around_it["gravity"] = estimate_of(here["gravity"], drawn["gravity"], "m/s²")
    around_it |= {p.name: estimates[p.name] for p in around if p.name not in SLOPES}
    refitted = found.at(found.numbers._replace(values=here, draws=drawn, parameters=around_it))
    return Refit(best.values[:count], {p.name: estimates[p.name] for p in own}, refitted, best)


def _widen(
    found: BodyFit, here: dict[str, float], spread: dict[str, FloatArray], told: tuple[TossParameter, ...],
    known: set[str],
) -> tuple[dict[str, FloatArray], dict[str, Estimate]]:  # fmt: skip
    """Return draws (S,) and intervals by name, no narrower than those of the body before.

    Whole throws are steep in the numbers of body and law, where another corner lands first, and seem to tell
    them better than they do: what the frames after the first touch left open of those `known` is open still,
    and what they told remains possible.
    """
    drawn, estimates = dict(found.draws), {}
    for p in told:
        early = [found.draws[p.name]] if p.name in known and p.name in found.draws else []
        drawn[p.name] = spread[p.name]
        for draw in early:
            moved = np.clip(here[p.name] + draw - found.values[p.name], p.low, p.high)
            drawn[p.name] = wider_draws(drawn[p.name], moved)
        estimates[p.name] = estimate_of(here[p.name], drawn[p.name], p.unit, *early)
    return drawn, estimates


def wider_draws(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return of two numbers' draws (S,) those whose 95 % interval is wider."""
    return max(one, other, key=lambda draws: float(np.subtract(*np.percentile(draws, [97.5, 2.5]))))


def list_parameters(simulator: TossModel, found: BodyFit) -> list[TossParameter]:
    """Return what is fitted together: the law's, the ground's height, the body's, gravity and slopes."""
    return [*simulator.parameters, *_list_around(found), *_list_measured(found)]


def simulate_around(
    tosses: Tosses, simulator: TossModel, found: BodyFit
) -> Callable[[FloatArray], FloatArray]:
    """Return what maps values of `list_parameters` to deviations (N, m), weighed; tosses are upright."""
    count, names = len(simulator.parameters), [p.name for p in list_parameters(simulator, found)]
    flight = TossFlight(tosses, found.before(tosses), found.first[0].tree, found.first[2])
    measure = found.weighed_measure(tosses)

    def simulate(point: FloatArray) -> FloatArray:
        here = dict(zip(names[count:], point[count:].tolist(), strict=True))
        scene = scene_at(tosses, found.nominal.at(here), flight, here)
        return measure.deviations(tosses, simulator.rollout(point[:count], scene))

    return simulate


def _list_around(found: BodyFit) -> list[TossParameter]:
    """Return what is fitted of the ground and the body."""
    return [*ground_parameters(found.plane, found.levelled is not None), *found.nominal.parameters]


def _list_measured(found: BodyFit) -> list[TossParameter]:
    """Return gravity and slopes that are measured, each within its 95 % interval."""
    out, around = [], {p.name for p in _list_around(found)}
    for name, step in MEASURED.items():
        if name not in around:
            value = found.values[name]
            low, high = np.percentile(found.draws[name], [2.5, 97.5])
            out.append(TossParameter(name, value, step, min(float(low), value), max(float(high), value)))
    return out
