"""One-sided derivatives where contacts change their modes.

At a kink several modes hold the same state. In which of them a perturbation continues is a small
complementarity problem in the rates: a contact at the edge of its cone stays there and slips, or sticks and
leaves the edge; one that just touches takes load or lifts. Every choice of modes is a linear system, and the
right one keeps the rates' signs. From the present modes offenders are changed until none is left, all of them
or the worst; where that goes in circles, all choices are tried, as many as `CHOICES`.

A contact without force and without velocity obeys the whole law in its rates: the direction in which it
begins to slide is found by Newton steps.

Source: the B-derivative of a complementarity problem, J.-S. Pang, Math. Oper. Res. 15(2), 1990.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.contact.derivative.active_system import ActiveSystem, move
from surefoot.contact.derivative.modes import (
    FREE,
    HELD,
    HIGH,
    LOW,
    SLIDE,
    STICK,
    ContactState,
    Mode,
    slide_mode,
    stick_mode,
)
from surefoot.contact.problem.problem import ContactProblem

CONSISTENT = 1e-9
"""Rates of the wrong sign below this share of the largest are zero."""
TURNS, PIVOTS, CHOICES = 25, 100, 256
"""Newton steps on directions of sliding, changes of one contact's mode, and choices tried in all."""


@dataclass(frozen=True)
class Continuation:
    """The modes that a contact may continue in.

    Attributes
    ----------
    modes
        The present one first.
    distance
        The least misfit of a mode that is not the present one; see `Kink.distance`.
    point
        Whether neither a tangential force nor a slip gives the direction of sliding.
    unit, tol
        s_k [m/s] (1 where that is zero), and what is taken for zero in units of it.
    """

    modes: tuple[Mode, ...]
    distance: float
    point: bool
    unit: float
    tol: float


def choices_of(
    problem: ContactProblem, contacts: Sequence[ContactState], modes: Sequence[Mode], tol: float
) -> list[Continuation]:
    """Return the choice of every contact, whose present modes are given."""
    speeds = problem.scales[1]
    units = np.where(speeds > 0.0, speeds, 1.0)
    return [_choice(c, m, float(s), tol) for c, m, s in zip(contacts, modes, units, strict=True)]


def _choice(contact: ContactState, mode: Mode, unit: float, tol: float) -> Continuation:
    if mode.normal == HELD:
        return Continuation((mode,), np.inf, False, unit, tol)
    # every misfit as a velocity over the part's speed: a force counts as what it moves its contact by
    force = contact.weight / unit
    height, lift = float(contact.force[2]), abs(contact.lift) / unit
    misfits = {FREE: lift, LOW: (height - contact.low) * force, HIGH: (contact.high - height) * force}
    if mode.normal == FREE:
        misfits[FREE] = 0.0
    else:  # only where the bounds coincide may one take over from the other
        other = HIGH if mode.normal == LOW else LOW
        misfits[mode.normal], misfits[other] = 0.0, max(misfits[other], lift)
    normals = [name for name, misfit in misfits.items() if misfit <= tol]
    normals.sort(key=lambda name: name != mode.normal)
    distance = min(misfit for name, misfit in misfits.items() if name != mode.normal)
    ready = contact.radius * force > tol
    slip = float(np.hypot(*contact.velocity[:2])) / unit
    point = slip <= tol and not ready
    room = (contact.radius - float(np.hypot(*contact.force[:2]))) * contact.weight / unit
    pieces = {STICK: slip, SLIDE: max(room, 0.0)}
    pieces[mode.tangent] = 0.0
    near = sorted((t for t, misfit in pieces.items() if misfit <= tol), key=lambda t: t != mode.tangent)
    if ready:
        distance = min(distance, *(misfit for t, misfit in pieces.items() if t != mode.tangent))
    elif height * force > tol:  # no friction: which way it would act is open where nothing slips
        distance = min(distance, slip)
    found: list[Mode] = []
    for normal in normals:
        for tangent in near:
            if tangent == SLIDE and point:  # in no direction: `directional` finds one for every rate
                found.append(slide_mode(contact, normal, np.zeros(2), 0.0))
            elif (normal, tangent) == (mode.normal, mode.tangent) and not (tangent == SLIDE and slip <= tol):
                found.append(mode)
            elif tangent == SLIDE:
                found.append(slide_mode(contact, normal, *_heading(contact, ready)))
            else:
                found.append(stick_mode(normal))
    return Continuation(tuple(found), distance, point, unit, tol)


def _heading(contact: ContactState, ready: bool) -> tuple[FloatArray, float]:
    """Return the direction of sliding at a kink and how far the force follows it; see `slide_mode`."""
    force, slip = contact.force[:2], contact.velocity[:2]
    if ready:
        size, speed = float(np.hypot(*force)), float(np.hypot(*slip))
        # ratio = mu λ_n / ||λ_t - u_t / w|| where λ_t is on the rim and opposes
        # u_t: radius / (radius + ||u_t|| / w)
        reach = contact.radius * contact.weight
        return (force / size if size > 0.0 else np.array([1.0, 0.0])), reach / (reach + speed)
    speed = float(np.hypot(*slip))
    return (-slip / speed if speed > 0.0 else np.array([1.0, 0.0])), 0.0


def directional(
    G: FloatArray,
    contacts: Sequence[ContactState],
    choices: Sequence[Continuation],
    b: FloatArray,
    rates: tuple[FloatArray, ...],
) -> tuple[list[Mode], bool]:
    """Return the modes in which a perturbation continues, and whether they are consistent.

    G is (3n, 3n), `b` (3n,) the rate of u at fixed forces, `rates` those of mu, normal_min and normal_max,
    (n,) each.
    """
    open_ones = [k for k, c in enumerate(choices) if len(c.modes) > 1 or c.point]
    picked = [0] * len(choices)
    best: tuple[float, list[Mode]] | None = None
    seen: set[tuple[int, ...]] = set()
    rest = product(*(range(len(choices[k].modes)) for k in open_ones))
    for step in range(PIVOTS + CHOICES):
        seen.add(tuple(picked))
        modes, faults = _judge(G, contacts, choices, picked, b, rates)
        worst = max(faults, default=0.0)
        if best is None or worst < best[0]:
            best = worst, modes
        # all signs right: for a regular system that is the B-derivative
        if worst <= CONSISTENT:
            return modes, True
        trial = None if step >= PIVOTS else _change_choice(choices, picked, faults, seen)
        if trial is None:
            following = next(rest, None)
            if following is None:
                break
            trial = [0] * len(choices)
            for k, index in zip(open_ones, following, strict=True):
                trial[k] = index
        picked = trial
    assert best is not None
    return best[1], False


def _change_choice(
    choices: Sequence[Continuation],
    picked: Sequence[int],
    faults: Sequence[float],
    seen: set[tuple[int, ...]],
) -> list[int] | None:
    """Return the choice with all offenders changed, or one, the worst first; None if all were seen."""
    offenders = [k for k in np.argsort(faults)[::-1].tolist() if faults[k] > CONSISTENT]
    # all offenders at once first, as in principal pivoting: then singly, the worst first
    for group in (offenders, *([k] for k in offenders)):
        trial = list(picked)
        for k in group:
            trial[k] = (trial[k] + 1) % len(choices[k].modes)
        if tuple(trial) not in seen:
            return trial
    return None


def _judge(
    G: FloatArray, contacts: Sequence[ContactState], choices: Sequence[Continuation], picked: Sequence[int],
    b: FloatArray, rates: tuple[FloatArray, ...],
) -> tuple[list[Mode], list[float]]:  # fmt: skip
    """Solve for the rates in the picked modes; return the modes, turned, and every contact's fault."""
    modes = [c.modes[i] for c, i in zip(choices, picked, strict=True)]
    turning = [
        k for k, (c, m) in enumerate(zip(choices, modes, strict=True)) if c.point and m.tangent == SLIDE
    ]
    for k in turning:  # first guess: against the rate without forces
        w = -b[3 * k : 3 * k + 2]
        size = float(np.hypot(*w))
        if size > 0.0:
            modes[k] = slide_mode(contacts[k], modes[k].normal, w / size, 1.0)
    for _ in range(TURNS if turning else 1):
        flat = move(ActiveSystem(G, modes), b, rates)
        forces, velocities = flat[0].reshape(-1, 3), flat[1].reshape(-1, 3)
        moved = 0.0
        for k in turning:
            # at rest and without force the law holds in the rates alone:
            # their own natural map turns the direction
            w = forces[k, :2] - velocities[k, :2] / contacts[k].weight
            size = float(np.hypot(*w))
            if size > 0.0:
                radius = max(_radius_rate(contacts[k], k, forces, rates), 0.0)
                moved = max(moved, float(np.abs(w / size - modes[k].direction).max()))
                modes[k] = slide_mode(contacts[k], modes[k].normal, w / size, min(radius / size, 1.0))
        if moved <= 1e-15:
            break
    scale = max(
        (float(np.abs(velocities).max(initial=0.0))),
        *(c.weight * float(np.abs(f).max()) for c, f in zip(contacts, forces, strict=True)),
        float(np.abs(b).max(initial=0.0)),
    )
    if not scale > 0.0:
        return modes, [0.0] * len(modes)
    faults = [
        _fault(contacts[k], choices[k], modes[k], forces[k], velocities[k], k, rates, forces) / scale
        for k in range(len(modes))
    ]
    return modes, faults


def _radius_rate(contact: ContactState, k: int, forces: FloatArray, rates: tuple[FloatArray, ...]) -> float:
    """Return the rate of mu λ_n."""
    return float(rates[0][k] * contact.force[2] + contact.mu * forces[k, 2])


def _fault(
    contact: ContactState, choice: Continuation, mode: Mode, force: FloatArray, velocity: FloatArray, k: int,
    rates: tuple[FloatArray, ...], forces: FloatArray,
) -> float:  # fmt: skip
    """Return by how much the rates of a contact have the wrong sign for its mode [m/s]."""
    if mode.normal == HELD:
        return 0.0
    w, faults = contact.weight, [0.0]
    normals = {m.normal for m in choice.modes}
    if len(normals) > 1:
        lift = _lift_rate(contact, choice, velocity, float(rates[0][k]))
        # Signorini in the rates: open, it must not approach; at the upper bound, not part;
        # between, its force must not leave the bounds
        if mode.normal == LOW:
            faults.append(-lift)
        elif mode.normal == HIGH:
            faults.append(lift)
        else:
            faults += [w * float(rates[1][k] - force[2])] if LOW in normals else []
            faults += [w * float(force[2] - rates[2][k])] if HIGH in normals else []
    radius = _radius_rate(contact, k, forces, rates)
    if len({m.tangent for m in choice.modes}) > 1:
        # Coulomb in the rates: sliding, friction must not push the slide;
        # sticking, the force must stay in the disc
        e = mode.direction if mode.tangent == SLIDE else _heading(contact, not choice.point)[0]
        if mode.tangent == SLIDE:
            faults.append(float(e @ velocity[:2]))
            faults.append(-w * radius if choice.point else 0.0)
        else:
            along = float(np.hypot(*force[:2])) if choice.point else float(e @ force[:2])
            faults.append(w * (along - radius))
    return max(faults)


def _lift_rate(contact: ContactState, choice: Continuation, velocity: FloatArray, mu_rate: float) -> float:
    """Return the rate of `ContactState.lift`, in the direction of the velocity's rate."""
    if not contact.convex:
        return float(velocity[2])
    slip, rate = contact.velocity[:2], velocity[:2]
    speed = float(np.hypot(*slip))
    if speed <= choice.tol * choice.unit:
        return float(velocity[2] - contact.mu * np.hypot(*rate))
    return float(velocity[2] - contact.mu * (slip @ rate) / speed - mu_rate * speed)
