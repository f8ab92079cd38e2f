"""Rules on masses and inertias: what no body can have, and what does not go with the robot's other bodies."""

from __future__ import annotations

import math
from collections.abc import Iterator
from statistics import median

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics.robot.lint.facts import LinkFacts, limb_twin
from surefoot.mechanics.robot.lint.finding import Offence, Rule
from surefoot.mechanics.robot.lint.subject import Subject, kin_of

UNLIKE = 30.0
"""Ratio to the same part of another limb from which a mass or inertia is a slip, not a design [-]."""
HEAVY = 50.0
"""A body that outweighs all others together so many times [-]; pedestals of arms do so 10 times."""
WEIGHTLESS = 1e-7
"""Mass of a body that moves, over the median of all bodies' [-], that only a slip has; catalogue: >= 1e-4."""
ROUNDING = 1e-3
"""Excess of a moment over the sum of the others that five printed digits may cause [-]."""
GROSS = 10.0
"""Moment over the sum of the others from which the dynamics is another robot's [-]; the catalogue has 5."""
SPREAD = 1.2
"""Radius of gyration over the robot's whole reach that no body of it has [-]; half its size is the most."""
BARE = 30.0
"""Radius of gyration over the robot's reach where its mass is at fault [-]; dummy links have 2."""
LIGHT = 0.05
"""Share of the robot's mass below which a link's placeholder of an inertia changes no walk [-]."""
POINT = 1e-3
"""Radius of gyration over the robot's reach below which a body counts as a point [-]."""
SHARE = 0.1
"""Of the robot's mass: a body that has as much decides how the robot turns [-]."""


def _moments(link: LinkFacts) -> FloatArray:
    """Return the principal moments of inertia (3,), ascending; NaN where the inertia has any."""
    tensor = link.inertia
    if not np.isfinite(tensor).all():
        return np.full(3, math.nan)
    return np.asarray(np.linalg.eigvalsh(0.5 * (tensor + tensor.T)), dtype=np.float64)


def _place(link: LinkFacts) -> str:
    return f"link {link.name}"


def _negative_masses(subject: Subject) -> Iterator[Offence]:
    for link in subject.facts.links:
        if link.mass < 0.0:
            yield Offence(_place(link), f"mass {link.mass:g} kg", "no body has a mass below zero")


def _missing_masses(subject: Subject) -> Iterator[Offence]:
    masses = {link.name: link.mass for link in subject.facts.links}
    for joint in subject.facts.joints:
        if joint.moves and joint.child in masses:
            moved = sum(max(masses.get(name, 0.0), 0.0) for name in subject.facts.below(joint.child))
            if moved == 0.0:
                detail = f"joint {joint.name} moves no mass at all, and a simulated world refuses the robot"
                severity = "error" if joint.name in subject.leg_joints else ""
                yield Offence(f"link {joint.child}", "mass 0 kg", detail, severity)
    for link, usual, kin in kin_of(subject.facts.links, limb_twin, lambda link: link.mass):
        if link.mass == 0.0 and usual > 1e-3 * subject.facts.mass:
            yield Offence(_place(link), "mass 0 kg", f"{kin[0].name} has {kin[0].mass:g} kg", "error")


def _unlike_masses(subject: Subject) -> Iterator[Offence]:
    links = [link for link in subject.facts.links if link.inertial and link.mass > 0.0]
    if not links:
        return
    named, middle = set[str](), median(link.mass for link in links)
    for link, usual, kin in kin_of(links, limb_twin, lambda link: link.mass):
        ratio = link.mass / usual
        if 1.0 / UNLIKE < ratio < UNLIKE:
            continue
        if len(kin) == 1 and _oddness(link.mass, middle) < _oddness(kin[0].mass, middle):
            continue
        named.add(link.name)
        yield Offence(_place(link), f"mass {link.mass:g} kg", f"{ratio:.3g} times that of {kin[0].name}")
    for link in links:
        radius = math.sqrt(0.5 * max(_trace(link), 0.0) / link.mass)
        if link.name not in named and radius > BARE * subject.reach > 0.0 and link.mass < middle:
            named.add(link.name)
            detail = f"its inertia is that of a heavier body: a radius of gyration of {radius:.3g} m"
            yield Offence(_place(link), f"mass {link.mass:g} kg", detail)
    bodies = [(group[0], sum(max(one.mass, 0.0) for one in group), group) for group in subject.facts.groups()]
    weights = [mass for _, mass, _ in bodies if mass > 0.0]
    total, usual = sum(weights), median(weights)
    for first, mass, group in bodies:
        heaviest = max(group, key=lambda one: one.mass)
        if len(weights) > 2 and mass > HEAVY * (total - mass) and heaviest.name not in named:
            detail = f"{mass / (total - mass):.3g} times all other bodies together"
            still = "" if subject.robot is None or subject.robot.floating else "warning"
            yield Offence(_place(heaviest), f"mass {heaviest.mass:g} kg", detail, still)
        elif 0.0 < mass < WEIGHTLESS * usual and heaviest.name not in named and first.name != "world":
            yield Offence(
                _place(heaviest), f"mass {mass:g} kg", f"{mass / usual:.3g} times that of usual bodies"
            )


def _oddness(value: float, usual: float) -> float:
    return abs(math.log(value / usual)) if value > 0.0 and usual > 0.0 else math.inf


def _impossible_moments(subject: Subject) -> Iterator[Offence]:
    for link in subject.facts.links:
        moments = _moments(link)
        if not link.inertial or not np.isfinite(moments).all() or link.mass <= 0.0:
            continue
        largest = float(np.abs(moments).max())
        if moments[0] < -1e-6 * max(largest, 1e-12):
            detail = f"principal moments {_list(moments)}: one is negative"
            yield Offence(_place(link), f"inertia {moments[0]:g} kg m²", detail)


def _broken_triangles(subject: Subject) -> Iterator[Offence]:
    for link in subject.facts.links:
        a, b, c = _moments(link)
        if not link.inertial or not (a > 0.0 and c > (1.0 + ROUNDING) * (a + b)):
            continue
        severity = "error" if subject.refusal or c > GROSS * (a + b) else ""
        detail = (
            f"of the moments {_list((a, b, c))} the largest is {c / (a + b):.3g} times the sum of the others"
        )
        yield Offence(_place(link), f"inertia {c:g} kg m²", detail, severity)


def _unlike_inertias(subject: Subject) -> Iterator[Offence]:
    links = [link for link in subject.facts.links if link.inertial and link.mass > 0.0 and _trace(link) > 0.0]
    named = set[str]()
    middle = median(_trace(link) / link.mass for link in links) if links else 0.0
    for link, usual, kin in kin_of(links, limb_twin, lambda link: _trace(link) / link.mass):
        ratio = _trace(link) / link.mass / usual
        odd = _oddness(_trace(link) / link.mass, middle), _oddness(_trace(kin[0]) / kin[0].mass, middle)
        alike = _trace(link) / median(_trace(one) for one in kin)  # where the mass alone is off it says so
        if any(1.0 / UNLIKE < one < UNLIKE for one in (ratio, alike)) or (len(kin) == 1 and odd[0] < odd[1]):
            continue
        named.add(link.name)
        share = 1e-3 if ratio > 1.0 else SHARE  # a limb's mass counts for more than its own inertia
        light = "" if link.mass > share * subject.facts.mass else "warning"
        detail = f"{ratio:.3g} times that of {kin[0].name}, by mass"
        yield Offence(_place(link), f"inertia {_list(_moments(link))} kg m²", detail, light)
    reach, mass = subject.reach, subject.facts.mass
    middle_mass = median(link.mass for link in links) if links else 0.0
    for link in links:
        radius = math.sqrt(0.5 * _trace(link) / link.mass)
        if link.name in named or reach <= 0.0 or (radius > BARE * reach and link.mass < middle_mass):
            continue
        value = f"inertia {_list(_moments(link))} kg m²"
        if radius > SPREAD * reach:
            detail = (
                f"its radius of gyration, {radius:.3g} m, is {radius / reach:.3g} times the robot's reach"
            )
            yield Offence(_place(link), value, detail, "" if link.mass > LIGHT * mass else "warning")
        elif radius < POINT * reach and link.mass > 1e-2 * mass:
            detail = (
                f"its radius of gyration is {1e3 * radius:.3g} mm, a point beside a reach of {reach:.3g} m"
            )
            yield Offence(_place(link), value, detail, "" if link.mass > SHARE * mass else "warning")


def _far_centres(subject: Subject) -> Iterator[Offence]:
    reach = sum(
        float(np.linalg.norm(joint.origin))
        for joint in subject.facts.joints
        if np.isfinite(joint.origin).all()
    )
    for link in subject.facts.links:
        far = float(np.linalg.norm(link.com))
        if (
            link.inertial
            and math.isfinite(far)
            and far > 3.0 * max(reach, 10.0 * subject.extent(link.name)) > 0.0
        ):
            detail = f"{far / reach:.3g} times all joint offsets of the robot together; is it in millimetres?"
            yield Offence(_place(link), f"centre of mass {_list(link.com)} m", detail)


def _trace(link: LinkFacts) -> float:
    return float(np.trace(link.inertia))


def _list(values: object) -> str:
    return "(" + ", ".join(f"{x:.3g}" for x in np.asarray(values, dtype=float)) + ")"


INERTIA_RULES = (
    Rule("mass-negative", "masses of links", "error", "Give it the mass of the part.", _negative_masses),
    Rule(
        "mass-missing",
        "masses that each joint moves",
        "warning",
        "Give the link an <inertial>, or weld it with a fixed joint.",
        _missing_masses,
    ),
    Rule(
        "mass-unlike-kin",
        "masses beside those of the other limbs and bodies",
        "error",
        "Compare with the other limbs and with the part on a scale; grams are 1e-3 kg.",
        _unlike_masses,
    ),
    Rule(
        "inertia-negative",
        "principal moments of inertia",
        "error",
        "Take the inertia from the CAD again, about the centre of mass and in the axes of its <origin>.",
        _impossible_moments,
    ),
    Rule(
        "inertia-triangle",
        "triangle inequality of the principal moments",
        "warning",
        "No body has it: take the inertia from the CAD again; a swapped moment or sign is the usual cause.",
        _broken_triangles,
    ),
    Rule(
        "inertia-unlike-kin",
        "inertia over mass beside other limbs and the robot's reach",
        "error",
        "Check the unit: g mm² are 1e-9 kg m², kg cm² are 1e-4.",
        _unlike_inertias,
    ),
    Rule(
        "com-far",
        "centres of mass beside the joint offsets",
        "error",
        "Check the unit of the <origin> of the inertial: metres.",
        _far_centres,
    ),
)
"""The family."""
