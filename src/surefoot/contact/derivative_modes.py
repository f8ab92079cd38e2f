"""How the law of one contact moves: its free force directions and equations, mode by mode.

Near a solution every contact keeps to one mode: its normal force is free or held by a bound, and its
tangential force sticks, slides along the curved cone, or (pyramids) lies on a face or an edge. A mode is
linear in what changes::

    λ' = columns y + jump_mu mu' + jump_bound bound'
    rows u' + weight y = target_mu mu'

with few unknowns y: 3 for a contact that sticks, 2 for one that slides, none for one that is open. The
curvature of the cone is the weight of a slide: turning its force by y takes a velocity turned as much.

Source: P. Alart, A. Curnier, CMAME 92, 1991 (the projection whose derivative this is).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.problem import ContactProblem

FREE, LOW, HIGH, HELD = "free", "low", "high", "held"
STICK, SLIDE, FACE, EDGE = "stick", "slide", "face", "edge"


@dataclass(frozen=True)
class Section:
    """The polygon that a pyramid cuts at unit height and mu = 1; round cones have none.

    Attributes
    ----------
    corners, normals
        (facets, 2); face i lies between the corners i and i + 1 and has the unit normal i.
    apothem
        Distance of the faces from the middle.
    """

    corners: FloatArray
    normals: FloatArray
    apothem: float

    @classmethod
    def of(cls, facets: int, inner: bool) -> Section:
        """Return the section of a pyramid; an inner one has a corner on the first tangent."""
        half = np.pi / facets
        first = (0.0 if inner else half) + 2.0 * half * np.arange(facets)
        size = 1.0 if inner else 1.0 / np.cos(half)
        middle = first + half
        return cls(
            size * np.column_stack([np.cos(first), np.sin(first)]),
            np.column_stack([np.cos(middle), np.sin(middle)]),
            float(size * np.cos(half)),
        )

    def project(self, w: FloatArray, radius: float) -> tuple[str, int]:
        """Return on which part of `radius` times the section the nearest point to w (2,) lies, and which."""
        if radius > 0.0:
            over = self.normals @ w - radius * self.apothem
            if over.max() <= 0.0:
                return STICK, 0
            i = int(np.argmax(over))
            ends = radius * self.corners[[i, (i + 1) % len(self.corners)]]
            along = ends[1] - ends[0]
            if 0.0 < float((w - ends[0]) @ along) < float(along @ along):
                return FACE, i
        return EDGE, int(np.argmax(self.corners @ w))


@dataclass(frozen=True)
class ContactState:
    """One contact of a problem at a solution: its law, force λ, velocity u, and the weight w = ||G_kk||."""

    mu: float
    low: float
    high: float
    convex: bool
    section: Section | None
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
        if self.section is None:
            return float(u[2] - self.mu * np.hypot(u[0], u[1]))
        return float(u[2] - self.mu * np.max(-self.section.corners @ u[:2]))

    def at(self, force: FloatArray, velocity: FloatArray) -> ContactState:
        """Return the same contact with another force (3,) [N s] and velocity (3,) [m/s]."""
        return replace(self, force=force, velocity=velocity)


@dataclass(frozen=True)
class Mode:
    """One linear piece of a contact's law; see the module.

    Attributes
    ----------
    normal, tangent, index
        Which piece: the normal force free, at a bound or bilateral; the tangential one sticking, sliding, or
        on a face or edge of so many.
    columns, rows, weight, jump_mu, jump_bound, target_mu
        (3, c), (c, 3), (c,), (3,), (3,), (c,); see the module.
    direction
        (2,) the direction of the sliding force.
    """

    normal: str
    tangent: str
    index: int
    columns: FloatArray
    rows: FloatArray
    weight: FloatArray
    jump_mu: FloatArray
    jump_bound: FloatArray
    target_mu: FloatArray
    direction: FloatArray

    @property
    def key(self) -> tuple[str, str, int]:
        """What tells modes of one contact apart."""
        return self.normal, self.tangent, self.index

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
    section = None if problem.facets is None else Section.of(problem.facets, problem.fit == "inner")
    weights = problem.scales[0]
    convex = problem.law == "convex"
    return [
        ContactState(
            float(problem.mu[k]), float(problem.normal_min[k]), float(problem.normal_max[k]), convex,
            section, forces[k], velocities[k], float(weights[k]) if weights[k] > 0.0 else 1.0,
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
    height = {LOW: contact.low, HIGH: contact.high, FREE: max(float(contact.force[2]), 0.0)}[normal]
    radius = contact.mu * height
    w = contact.force[:2] - contact.velocity[:2] / contact.weight
    if contact.section is not None:
        tangent, index = contact.section.project(w, radius)
        return piece(contact, normal, tangent, index)
    length = float(np.hypot(*w))
    if length <= radius and radius > 0.0:
        return stick_mode(normal)
    direction = w / length if length > 0.0 else np.array([1.0, 0.0])
    return slide_mode(contact, normal, direction, radius / length if length > 0.0 else 0.0)


def piece(contact: ContactState, normal: str, tangent: str, index: int) -> Mode:
    """Return a mode of a pyramid, or a stick, by its names."""
    if tangent == STICK:
        return stick_mode(normal)
    return face_mode(contact, normal, index) if tangent == FACE else edge_mode(contact, normal, index)


def _mode(
    contact: ContactState, normal: str, tangent: str, index: int, ray: FloatArray, slope: FloatArray,
    own: tuple[FloatArray, FloatArray, float] | None,
) -> Mode:  # fmt: skip
    """Build a mode whose force moves along a ray (slope, 1) if its normal is free, and in one direction more.

    `slope` is the (2,) change of the tangential force per mu and unit of normal force, `ray` mu times that;
    `own` the (2,) direction, row and weight of the further unknown.
    """
    up = np.array([*ray, 1.0])
    columns, rows, weight, target = [], [], [], []
    if normal == FREE:
        columns.append(up)
        rows.append(up if contact.convex else np.array([0.0, 0.0, 1.0]))
        weight.append(0.0)
        # of the convex law's u_n + ray·u_t = 0
        target.append(-float(slope @ contact.velocity[:2]) if contact.convex else 0.0)
    if own is not None:
        columns.append(np.array([*own[0], 0.0]))
        rows.append(np.array([*own[1], 0.0]))
        weight.append(own[2])
        target.append(0.0)
    count = len(columns)
    return Mode(
        normal, tangent, index, np.array(columns).reshape(count, 3).T, np.array(rows).reshape(count, 3),
        np.array(weight), np.array([*(float(contact.force[2]) * slope), 0.0]), up, np.array(target), slope,
    )  # fmt: skip


def stick_mode(normal: str) -> Mode:
    """Return the mode of a contact that does not slip: its tangential force is free, its velocity zero."""
    count = 3 if normal in (FREE, HELD) else 2
    up = np.array([0.0, 0.0, 0.0 if normal == HELD else 1.0])
    eye = np.eye(3)[:count]
    none = np.zeros(count)
    return Mode(normal, STICK, 0, eye.T, eye, none, np.zeros(3), up, none, np.zeros(2))


def slide_mode(contact: ContactState, normal: str, direction: FloatArray, ratio: float) -> Mode:
    """Return the mode of a contact whose force lies on the round cone, in a (2,) unit direction e.

    λ_t = mu λ_n e with e against u_t: its part across e obeys ratio e⊥·u_t' + w (1 - ratio) e⊥·λ_t' = 0, with
    ratio = mu λ_n / ||λ_t - u_t / w||.
    """
    across = np.array([-direction[1], direction[0]])
    own = across, ratio * across, (1.0 - ratio) * contact.weight
    return _mode(contact, normal, SLIDE, 0, contact.mu * direction, direction, own)


def face_mode(contact: ContactState, normal: str, index: int) -> Mode:
    """Return the mode of a contact on a pyramid's face: it slips against the face's normal only."""
    section = contact.section
    assert section is not None
    m = section.normals[index]
    along, slope = np.array([-m[1], m[0]]), section.apothem * m
    return _mode(contact, normal, FACE, index, contact.mu * slope, slope, (along, along, 0.0))


def edge_mode(contact: ContactState, normal: str, index: int) -> Mode:
    """Return the mode of a contact on a pyramid's edge: its force only grows or shrinks."""
    assert contact.section is not None
    corner = contact.section.corners[index]
    return _mode(contact, normal, EDGE, index, contact.mu * corner, corner, None)


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
        target[-1] = (ratio - 1.0) * float(mode.columns[:2, -1] @ contact.velocity[:2])
    elif mode.tangent == FACE and contact.section is not None:
        m = contact.section.normals[mode.index]
        step[:2] = (contact.mu * contact.section.apothem * height - float(force[:2] @ m)) * m
    elif mode.tangent == EDGE:
        step[:2] = contact.mu * height * mode.direction - force[:2]
    return step, target
