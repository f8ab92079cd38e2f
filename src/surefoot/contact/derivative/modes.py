"""How the law of one contact moves: its free force directions and equations, mode by mode.

Near a solution every contact keeps to one mode: its normal force is free or held by a bound, and its
tangential force sticks, or slides along the curved cone. A mode is linear in what changes::

    λ' = columns y + jump_mu mu' + jump_bound bound'
    rows u' + weight y = target_mu mu'

with few unknowns y: 3 for a contact that sticks, 2 for one that slides, none for one that is open. The
curvature of the cone is the weight of a slide: turning its force by y takes a velocity turned as much.

Source: P. Alart, A. Curnier, CMAME 92, 1991 (the projection whose derivative this is).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.contact.problem.problem import ContactProblem

FREE, LOW, HIGH, HELD = "free", "low", "high", "held"
STICK, SLIDE = "stick", "slide"


@dataclass(frozen=True)
class ContactState:
    """One contact of a problem at a solution: its law, force λ, velocity u, and the weight w = ||G_kk||."""

    mu: float
    low: float
    high: float
    convex: bool
    force: FloatArray
    velocity: FloatArray
    weight: float

    @property
    def radius(self) -> float:
        """Largest tangential force [N]."""
        return self.mu * float(self.force[2])

    @property
    def lift(self) -> float:
        """The normal velocity [m/s] that the unilateral law sees, less the convex law's separation."""
        u = self.velocity
        if not self.convex:
            return float(u[2])
        return float(u[2] - self.mu * np.hypot(u[0], u[1]))


@dataclass(frozen=True)
class Mode:
    """One linear piece of a contact's law; see the module.

    Attributes
    ----------
    normal, tangent
        Which piece: the normal force free, at a bound or bilateral; the tangential one sticking or sliding.
    columns, rows, weight, jump_mu, jump_bound, target_mu
        (3, c), (c, 3), (c,), (3,), (3,), (c,); see the module.
    direction
        (2,) the direction of the sliding force.
    """

    normal: str
    tangent: str
    columns: FloatArray
    rows: FloatArray
    weight: FloatArray
    jump_mu: FloatArray
    jump_bound: FloatArray
    target_mu: FloatArray
    direction: FloatArray

    def name(self, contact: ContactState) -> str:
        """Return the mode in words."""
        if self.normal == HELD:
            return "bilateral"
        if self.normal == FREE:
            return self.tangent
        bound = contact.low if self.normal == LOW else contact.high
        if bound == 0.0:
            return "open" if self.normal == LOW else "off"
        return f"{self.tangent} at normal_{'min' if self.normal == LOW else 'max'}"


def contacts_of(problem: ContactProblem, forces: FloatArray, velocities: FloatArray) -> list[ContactState]:
    """Return the contacts of a problem with (n, 3) forces [N s] and velocities [m/s]."""
    weights = problem.scales[0]
    convex = problem.law == "convex"
    return [
        ContactState(
            float(problem.mu[k]), float(problem.normal_min[k]), float(problem.normal_max[k]), convex,
            forces[k], velocities[k], float(weights[k]) if weights[k] > 0.0 else 1.0,
        )
        for k in range(problem.contacts)
    ]  # fmt: skip


def normal_state(contact: ContactState) -> str:
    """Return which piece of the unilateral law the state lies on: the projection of λ_n - v / w."""
    if contact.low == -np.inf:
        return HELD
    lifted = float(contact.force[2]) - contact.lift / contact.weight
    if lifted <= contact.low:
        return LOW
    return HIGH if lifted >= contact.high else FREE


def natural_mode(contact: ContactState) -> Mode:
    """Return the mode that the natural map is on: where λ - u / w is projected to."""
    normal = normal_state(contact)
    if normal == HELD:
        return stick_mode(HELD)
    # the disc's radius is that of the height the normal force is projected to, as in the natural map itself
    height = {LOW: contact.low, HIGH: contact.high, FREE: max(float(contact.force[2]), 0.0)}[normal]
    radius = contact.mu * height
    w = contact.force[:2] - contact.velocity[:2] / contact.weight
    length = float(np.hypot(*w))
    if length <= radius and radius > 0.0:
        return stick_mode(normal)
    direction = w / length if length > 0.0 else np.array([1.0, 0.0])
    return slide_mode(contact, normal, direction, radius / length if length > 0.0 else 0.0)


def stick_mode(normal: str) -> Mode:
    """Return the mode of a contact that does not slip: its tangential force is free, its velocity zero."""
    count = 3 if normal in (FREE, HELD) else 2
    up = np.array([0.0, 0.0, 0.0 if normal == HELD else 1.0])
    eye = np.eye(3)[:count]
    none = np.zeros(count)
    return Mode(normal, STICK, eye.T, eye, none, np.zeros(3), up, none, np.zeros(2))


def slide_mode(contact: ContactState, normal: str, direction: FloatArray, ratio: float) -> Mode:
    """Return the mode of a contact whose force lies on the round cone, in a (2,) unit direction e.

    λ_t = mu λ_n e with e against u_t: its part across e obeys ratio e⊥·u_t' + w (1 - ratio) e⊥·λ_t' = 0, with
    ratio = mu λ_n / ||λ_t - u_t / w||.
    """
    across = np.array([-direction[1], direction[0]])
    up = np.array([*(contact.mu * direction), 1.0])
    columns, rows = [np.array([*across, 0.0])], [np.array([*(ratio * across), 0.0])]
    weight, target = [(1.0 - ratio) * contact.weight], [0.0]
    if normal == FREE:  # it moves along its ray (e, 1), too; under the convex law u_n + mu e·u_t = 0
        columns.insert(0, up)
        rows.insert(0, up if contact.convex else np.array([0.0, 0.0, 1.0]))
        weight.insert(0, 0.0)
        # d(u_n + mu e·u_t) / dmu = e·u_t at a fixed e, on the other side of the equation
        target.insert(0, -float(direction @ contact.velocity[:2]) if contact.convex else 0.0)
    # λ_t = mu λ_n e moves by λ_n e with mu
    jump = np.array([*(float(contact.force[2]) * direction), 0.0])
    return Mode(
        normal, SLIDE, np.array(columns).T, np.array(rows), np.array(weight), jump, up, np.array(target),
        direction,
    )  # fmt: skip


def defect(contact: ContactState, mode: Mode) -> tuple[FloatArray, FloatArray]:
    """Return the (3,) step of the force onto the mode's surface, and the (c,) targets of its equations."""
    step, target = np.zeros(3), np.zeros(mode.weight.size)
    force = contact.force
    height = float(force[2])
    if mode.normal in (LOW, HIGH):
        height = contact.low if mode.normal == LOW else contact.high
        step[2] = height - force[2]
    if mode.tangent == SLIDE:
        e = mode.direction
        step[:2] = (contact.mu * height - float(force[:2] @ e)) * e
        ratio = float(np.hypot(*mode.rows[-1, :2]))
        # (1 - ratio) w e⊥·λ_t + ratio e⊥·u = 0 at the mode, in what the natural
        # map's point leaves: e⊥·λ_t = e⊥·u / w
        target[-1] = (ratio - 1.0) * float(mode.columns[:2, -1] @ contact.velocity[:2])
    return step, target
