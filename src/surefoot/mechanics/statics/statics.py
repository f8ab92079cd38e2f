"""Can it stand here, and how much friction does it need: the questions and their entry points.

Every answer carries its proof: forces when it can, a separating wrench when it cannot. An answer without one
is "undecided".
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import LARGEST, FloatArray, finite_array, numbers, of_kind, real_number
from surefoot.base.errors import ProblemError, shown
from surefoot.base.spatial import GRAVITY
from surefoot.contact import Fit
from surefoot.mechanics.stance import Stance
from surefoot.mechanics.statics.limits import (
    ForceLimits,
    Question,
    all_limits,
    equations,
    normal_limits,
    squeeze_limit,
)
from surefoot.mechanics.statics.margin import (
    BAND,
    ENDLESS,
    FEASIBLE,
    REACH,
    RUNAWAY,
    UNDECIDED,
    most_margin,
    proof_reach,
)
from surefoot.mechanics.statics.point_contacts import axis_scale, load_scale, spread, stand
from surefoot.mechanics.statics.verdict import Verdict

_SQUEEZES = (10.0, 100.0, 1000.0)
"""Total normal forces, in loads, that `friction_needed` counts with where less friction needs ever more."""
_STEEP = 1e-6
"""Share of the friction needed that takes the forces out of the band, unless they stay at zero margin."""
MOST_MU = 1e4
"""A stance that needs more friction than this counts as one that no friction saves; where rounding leaves
more friction no answer, forces are looked for within this much."""


def can_stand(
    stance: Stance,
    com: ArrayLike,
    mass: float,
    external_wrench: ArrayLike | float = 0.0,
    facets: int | None = None,
    fit: Fit = "inner",
    limits: ForceLimits | None = None,
) -> Verdict:
    """Tell whether contact forces can hold a robot at rest, and prove it.

    Parameters
    ----------
    stance
        Contacts; none at all cannot stand.
    com
        (3,) centre of mass, world axes [m].
    mass
        > 0 [kg].
    external_wrench
        (6,) [force; moment about the centre of mass] on the robot besides gravity, world axes
        [N, N m]; 0 for none. Minus the mass times an acceleration stands for a motion.
    facets, fit
        None for the exact friction cones; a number for pyramids with so many sides, inside
        (never promises force that the ground cannot give) or around the cones.
    limits
        Further bounds on the contact forces; those on the contacts' normal forces always count.

    Returns
    -------
    Verdict
        `.status`, `.feasible`, `.forces`, `.world_forces`, `.margin` [N], `.certificate`, `.reach` [N];
        truthy when it can stand.

    Raises
    ------
    ProblemError
        For a mass that is not positive, values that are not finite or shapes that do not fit.

    Notes
    -----
    The verdict is exact outside a band of 1e-9 of the load around the boundary, and so is the margin.
    "possible" comes with forces that are in their cones and give the load within that band, "impossible"
    with a proof that rules out every set of forces up to a total of ten thousand loads at least; where
    arithmetic finds neither, the status is "undecided", and the verdict is falsy.
    Joint torques are another question: see `surefoot.mechanics.statics.actuation`.

    Examples
    --------
    >>> from surefoot import PointContact, Stance
    >>> feet = [[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.15, 0], [-0.2, -0.15, 0]]
    >>> stance = Stance([PointContact(p, mu=0.6) for p in feet])
    >>> can_stand(stance, com=[0.0, 0.0, 0.3], mass=15.0)
    Verdict(possible, margin=18.9 N, 4 contacts)
    >>> verdict = can_stand(stance, com=[0.25, 0.0, 0.3], mass=15.0)
    >>> bool(verdict), float(verdict.certificate @ verdict.load) < 0.0
    (False, True)
    """
    of_kind("stance", stance, Stance)
    about = _vector("com", com, 3)
    load = needed_wrench(mass, external_wrench)
    if limits is not None or facets is not None or stance.bounded or not stance.contacts:
        return _general(Question(stance, about, load, all_limits(normal_limits(stance), limits), facets, fit))
    question, points = Question(stance, about, load), stance.points()
    outcome, margin, x, y, reach = stand(points.positions, points.rotations, points.mu, about, load)
    if outcome == UNDECIDED and float(points.mu.max()) > MOST_MU:
        less = np.minimum(points.mu, MOST_MU)
        again = stand(points.positions, points.rotations, less, about, load)
        if again[0] in (FEASIBLE, ENDLESS):  # forces in a part of the cones; a proof would not hold
            outcome, margin, x, _, _ = again
    if outcome in (FEASIBLE, ENDLESS):
        forces = x if points is stance else stance.corner_map @ x
        return Verdict(question, "possible", margin, forces, None, x.reshape(-1, 3))
    if outcome == UNDECIDED:
        return Verdict(question, "undecided", margin)
    return Verdict(question, "impossible", margin, certificate=y, reach=reach)


def _general(question: Question) -> Verdict:
    """Answer with bounds or pyramids, or without contacts that are on."""
    stance, load, bounds = question.stance, question.load, question.limits
    if not (stance.normal_max > 0.0).any():
        size = float(np.linalg.norm(load))
        if size == 0.0:
            none = np.zeros((len(stance.points()), 3))
            return Verdict(question, "possible", math.inf, np.zeros(stance.dim), None, none)
        return Verdict(question, "impossible", -math.inf, certificate=-load / size, reach=math.inf)
    eq = equations(question)
    outcome, margin, x, y, _ = most_margin(eq.A, eq.e, eq.w, eq.lorentz, eq.blocks)
    # Where bounded contacts stand beside ones that squeeze without limit, forces with the most margin run
    # away, and rounding in them hides what the bounded ones do.
    runaway = outcome in (FEASIBLE, ENDLESS, UNDECIDED) and np.abs(x).max() > RUNAWAY
    if bounds is not None and runaway:
        held = equations(_held_back(question, bounds))
        again = most_margin(held.A, held.e, held.w, held.lorentz, held.blocks)
        if again[0] in (FEASIBLE, ENDLESS):
            eq, (outcome, margin, x, y, _) = held, again
    margin *= eq.scale
    if outcome in (FEASIBLE, ENDLESS):
        corners = eq.force @ x
        forces = stance.corner_map @ corners
        return Verdict(question, "possible", margin, forces, None, corners.reshape(-1, 3))
    # Multipliers of bounds are >= 0; one that rounding made negative would prove nothing.
    y[6:] = np.maximum(y[6:], 0.0)
    reach = proof_reach(eq.A, eq.w, y, eq.lorentz)
    if reach < REACH:
        if float(stance.points().mu.max()) > MOST_MU:  # arithmetic can deal with a part of the cones
            less = stance.with_friction(np.minimum(stance.mu, MOST_MU))
            held_by_less = _general(replace(question, stance=less))
            if held_by_less:
                return replace(held_by_less, question=question)
        return Verdict(question, "undecided", margin)
    multipliers = np.zeros(0) if bounds is None else eq.limit_multipliers(y, len(bounds))
    return Verdict(
        question, "impossible", margin, certificate=eq.wrench_multiplier(y), multipliers=multipliers,
        reach=reach * eq.scale,
    )  # fmt: skip


def _held_back(question: Question, bounds: ForceLimits) -> Question:
    """Bound the total normal force too: some contacts are bounded, and others squeeze without limit."""
    reach = np.abs(bounds.bound) / np.maximum(np.linalg.norm(bounds.rows, axis=1), 1e-300)
    most = RUNAWAY * float(np.linalg.norm(question.load)) + 10.0 * float(reach.max())
    return replace(question, limits=bounds.and_also(squeeze_limit(question.stance, most)))


def friction_needed(
    stance: Stance,
    com: ArrayLike,
    mass: float,
    external_wrench: ArrayLike | float = 0.0,
    force_limit: float | None = None,
) -> float:
    """Return the least friction coefficient, the same at every contact, that holds the robot.

    Parameters
    ----------
    stance
        Contacts; their own coefficients are not looked at.
    com, mass, external_wrench
        As for `can_stand`.
    force_limit
        Largest sum of all normal forces [N]. None for ten loads where less friction would need more (contacts
        that squeeze each other, as in a chimney, hold with hardly any friction by endless forces), a hundred
        and a thousand where ten are never enough (long levers); infinite for no limit: then the result is
        an infimum that finite forces may come near to and not reach.

    Returns
    -------
    float
        The coefficient [-]: 0 where the contacts hold without friction, infinite where none (up to 10000)
        helps.

    Raises
    ------
    ProblemError
        As for `can_stand`, or for a force limit that is negative.

    Examples
    --------
    >>> from surefoot import PointContact, SlopeTerrain, Stance
    >>> ground = SlopeTerrain(30.0)
    >>> feet = [[x, y] for x in (0.2, -0.2) for y in (0.15, -0.15)]
    >>> stance = Stance([PointContact([*p, ground.height(p)], ground.normal(p)) for p in feet])
    >>> round(friction_needed(stance, com=[0, 0, 0.3], mass=15.0), 6)  # tan 30 deg
    0.57735
    """
    of_kind("stance", stance, Stance)
    about = _vector("com", com, 3)
    load = needed_wrench(mass, external_wrench)
    most = math.inf if force_limit is None else real_number("force_limit", force_limit, low=0.0)
    points = stance.points()
    if not stance.contacts:
        return math.inf if float(np.linalg.norm(load)) > 0.0 else 0.0
    size = load_scale(load, spread(points.positions, about))
    least, total = _friction_within(stance, about, load, most)
    if force_limit is not None or math.isinf(least):
        return least
    for loads in _SQUEEZES:
        if total <= loads * size:
            return least
        held, _ = _friction_within(stance, about, load, loads * size)
        if held < math.inf:
            return held
    return least


def _friction_within(stance: Stance, about: FloatArray, load: FloatArray, most: float) -> tuple[float, float]:
    """Return the least friction with normal forces that add up to `most` [N] at the most, and that sum.

    The sum [N] is that of the forces found with this friction, infinite where none were.
    """
    limit = None if math.isinf(most) else squeeze_limit(stance, most)
    bounds, points = all_limits(normal_limits(stance), limit), stance.points()
    places, rotations, same = points.positions, points.rotations, np.empty(len(points))
    held: FloatArray | None = None
    held_at = math.nan

    def depth(mu: float) -> float:
        """Return how far the cones' apices may rise: its sign says whether mu is enough."""
        nonlocal held, held_at
        held_at = mu
        if bounds is not None:
            verdict = _general(Question(stance.with_friction(mu), about, load, bounds))
            held = verdict.corner_forces
            return verdict.margin
        same.fill(mu)
        outcome, margin, x, _, _ = stand(places, rotations, same, about, load)
        held = x.reshape(-1, 3) if outcome in (FEASIBLE, ENDLESS) else None
        return float(margin * axis_scale(mu))

    least = _least_root(depth, BAND * float(np.linalg.norm(load)))
    if held_at != least and least < math.inf:
        depth(least)
    return least, math.inf if held is None else float(held[:, 2].sum())


def _least_root(depth: Callable[[float], float], band: float) -> float:
    """Return the least mu with depth(mu) >= -band; infinite if there is none.

    The depth rises with mu; where a contact can carry nothing it stays at zero, up to rounding, from some mu
    on: then all that counts is on which side of the band it is.
    """
    if depth(0.0) >= -band:
        return 0.0
    low, high = 0.0, 1.0
    while (at_high := depth(high)) < -band:
        if high >= MOST_MU:
            return math.inf
        low, high = high, 10.0 * high
    if at_high > band:
        from scipy.optimize import brentq

        most = band / BAND  # of a depth, which is infinite where the load is out of reach or contacts squeeze
        high = float(brentq(lambda mu: min(max(depth(mu), -most), most), low, high, rtol=BAND))
        if depth((1.0 - _STEEP) * high) < -band:
            return high
    while high - low > BAND * high > 1e-300:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if depth(middle) >= -band else (middle, high)
    return high


def needed_wrench(mass: float, external_wrench: ArrayLike | float = 0.0) -> FloatArray:
    """Return the (6,) wrench about the centre of mass that the contacts have to give [N, N m].

    Raises
    ------
    ProblemError
        If the mass is not positive and finite or the wrench is not (6,) and finite.
    """
    if not isinstance(mass, (int, float, np.integer, np.floating)):
        raise ProblemError(f"mass must be a number [kg], got {shown(mass)}")
    if not 0.0 < mass <= LARGEST:
        raise ProblemError(f"mass must be positive and up to {LARGEST:g} kg, got {shown(mass)}")
    load = np.zeros(6)
    load[2] = mass * GRAVITY
    if not (isinstance(external_wrench, (int, float)) and external_wrench == 0.0):
        load -= _vector("external_wrench", external_wrench, 6)
    return load


def _vector(name: str, value: ArrayLike, size: int) -> FloatArray:
    """Return a finite vector, at little cost when it is one already."""
    vector = np.array(numbers(name, value))
    if vector.shape == (size,) and math.hypot(*vector.tolist()) <= LARGEST:
        return vector  # no entry is larger; others are looked at one by one
    vector = finite_array(name, value, (size,))
    if np.abs(vector).max() > LARGEST:
        raise ProblemError(f"{name} must be within {LARGEST:g}, got {vector[np.abs(vector).argmax()]:g}")
    return vector
