"""Symptoms of contact itself: forces that no contact with the ground gives."""

from __future__ import annotations

import numpy as np

from surefoot.records.audit.episode import Episode
from surefoot.records.audit.log_context import DEEP
from surefoot.records.audit.symptoms.fits import fitted_pyramid
from surefoot.records.audit.symptoms.symptom import Evidence, symptom

ALL, HALF = 0.99, 0.5
"""A log starts in the ground if it is never deeper than at first, and at the end by half at most."""


@symptom(
    "pull",
    "pull",
    cause="a row f_n >= 0 is missing, or z is not the surface normal",
    confirm="print the normal and the smallest normal force",
    cure="add the row; turn the frame so that z leaves the ground",
)
def pull(e: Episode) -> Evidence | None:
    """Tell whether the ground pulls."""
    return Evidence(0.97, f"normal force down to {float(e.force[:, 2].min()):.3g} N")


@symptom(
    "coarse facets",
    "friction",
    cause="an outer pyramid of too few facets: 41 % more friction on its corners for four, 8 % for eight",
    confirm="plot f_t / f_n: the points fill a square or an octagon, not a circle",
    cure="use the exact cone, or an inner pyramid of eight facets or more",
)
def coarse_facets(e: Episode) -> Evidence | None:
    """Tell whether the force sits in the corner of a friction pyramid outside the cone."""
    if not e.sideways:
        return None
    shape = fitted_pyramid(e.force, e.mu, e.weight)
    if shape is None:
        return None
    turned = f", turned by {np.degrees(shape[1]):.0f} deg" if shape[1] else ""
    return Evidence(0.995, f"forces lie on the edge of a pyramid of {shape[0]} facets about the cone{turned}")


@symptom(
    "too much friction",
    "friction",
    cause="the simulated friction is higher than the material's, or the log's mu is not the ground's",
    confirm="pull the robot sideways with a spring balance until it slides",
    cure="measure mu, and lower it in training and in the controller",
)
def too_much_friction(e: Episode) -> Evidence | None:
    """Tell whether more friction than the material has."""
    needed = np.hypot(e.force[:, 0], e.force[:, 1]) / np.maximum(e.force[:, 2], 1e-12)
    over = (needed > 1.001 * e.mu) & (e.force[:, 2] > e.rows.setting.threshold)
    if not over.any():
        return None
    worst = float(needed[over].max())
    return Evidence(
        0.985 if e.sideways else 0.9,
        f"needs mu of {worst:.3g} where the ground has {float(e.mu[over].min()):.3g}",
    )


@symptom(
    "friction in the air",
    "distance",
    cause="friction is computed from a stale or padded contact, or from a foot's speed near the ground",
    confirm="plot f_t against the gap",
    cure="tie the friction to the normal force of the same instant",
)
def friction_in_the_air(e: Episode) -> Evidence | None:
    """Tell whether a force across the ground where there is no contact."""
    air = (e.gap > 1e-3) & (e.force[:, 2] <= 0.005 * e.weight)
    side = np.hypot(e.force[:, 0], e.force[:, 1])
    if (air & (side > e.rows.setting.threshold)).mean() < 0.5:
        return None
    return Evidence(
        0.98,
        f"{float(side[air].max()):.3g} N across the ground, {1e3 * float(e.gap[air].max()):.3g} mm above it",
    )


@symptom(
    "friction drives",
    "work",
    cause="the sign of the tangential force or of the velocity, or a conveyor that the log does not know",
    confirm="f_t . v_t of a sliding foot must be negative",
    cure="check the sign; give the ground's own velocity",
)
def friction_drives(e: Episode) -> Evidence | None:
    """Tell whether friction works with the slip and not against it."""
    if e.has("distance"):
        return None
    return Evidence(0.992, f"{e.failed['work'].value:.3g} J given by friction in 50 ms")


@symptom(
    "frictionless slide",
    "dissipation",
    cause="friction is missing: creep of a soft contact, unknown ice, or a regularised law",
    confirm="compare f_t with mu f_n while it slides",
    cure="a stiffer friction (impratio, stiction), or the true mu",
)
def frictionless_slide(e: Episode) -> Evidence | None:
    """Tell whether a loaded foot slides and hardly anything brakes it."""
    if e.has("distance"):
        return None
    return Evidence(0.986, f"{1e3 * e.failed['dissipation'].value:.3g} mm without friction")


@symptom(
    "pyramid bias",
    "bias",
    cause="the world's friction is a pyramid: across its edges it has 71 % of mu, and bends the slide",
    confirm="turn the direction of the slide by 45 degrees: it is braked otherwise",
    cure="an elliptic cone (MuJoCo: cone='elliptic', with impratio for stiff friction)",
)
def pyramid_bias(e: Episode) -> Evidence | None:
    """Tell whether a slide is braked by a pyramid's friction where the round cone has more."""
    return Evidence(
        0.91, f"{1e3 * e.failed['bias'].value:.3g} mm of the way as if without friction, by the round cone"
    )


@symptom(
    "invisible geometry",
    "distance",
    cause="it leans on what is not the ground: a wide contact margin, a collision shape, a wrong map",
    confirm="draw the collision geometry at that instant",
    cure="set margins to zero, and measure the gap to what really touches",
)
def invisible_geometry(e: Episode) -> Evidence | None:
    """Tell whether something carries the foot above the ground that the log knows."""
    if e.has("motion"):
        return None
    real = "and the motion needs it" if e.consistent else "and nothing contradicts it"
    height = 1e3 * float(e.gap[e.loaded].max(initial=0.0))
    margin = np.asarray(e.rows.log.facts.get("contact_margin", np.zeros(len(e.rows.setting.names))))
    wide = 1e3 * float(margin[e.column])
    modelled = f"; in the model contacts push from {wide:.3g} mm on (margin)" if wide > 0.0 else ""
    return Evidence(0.95, f"{float(e.force[:, 2].max()):.3g} N at a gap of {height:.3g} mm, {real}{modelled}")


@symptom(
    "sinking",
    "penetration",
    cause="contact stiffness too low for the load, or the step too long",
    confirm="halve the step; the depth of a soft contact stays, that of a missed one halves",
    cure="stiffer with a shorter step, or a pressure-field contact",
)
def sinking(e: Episode) -> Evidence | None:
    """Tell whether the foot sinks into the ground."""
    depth = 1e3 * e.failed["penetration"].value
    return Evidence(0.95, f"{depth:.3g} mm deep" + (", more than 5 mm" if depth > 5.0 else ""))


@symptom(
    "starts in the ground",
    "penetration",
    cause="the run was begun below the ground: a keyframe or reset that no contact would lead to",
    confirm="look at the gaps of the first row",
    cure="lift the start by that depth",
)
def starts_in_the_ground(e: Episode) -> Evidence | None:
    """Tell whether the log begins in the ground and comes out of it."""
    first = -float(e.gap[0])
    deepest = e.failed["penetration"].value
    if e.rows.core.start != 0 or first < ALL * deepest or -float(e.gap[-1]) > HALF * deepest:
        return None
    return Evidence(0.998, f"{1e3 * first:.3g} mm deep in the first row")


@symptom(
    "deep contact",
    "depth",
    cause="the contact is soft: what its world declares lawful hides what a policy gains from depth",
    confirm="halve the contact's time constant: does the motion survive?",
    cure="a stiffer contact (solref, stiffness) with a shorter step",
)
def deep_contact(e: Episode) -> Evidence | None:
    """Tell whether a contact that is declared soft is deep in the ground."""
    if e.rows.setting.sinking < DEEP:
        return None
    return Evidence(0.9925, f"{1e3 * e.failed['depth'].value:.3g} mm deep, as its world declares")


@symptom(
    "push off penetration",
    "penetration",
    cause="the engine turns depth into speed (projection, a stiff spring), and the policy uses it",
    confirm="add up f_n v_n over the contact: it must not be positive",
    cure="limit the depenetration speed, shorten the step, punish depth in training",
)
def push_off_penetration(e: Episode) -> Evidence | None:
    """Tell whether the ground gives back more than it took: the foot is thrown out of it."""
    power = e.force[:, 2] * e.velocity[:, 2] * e.dt
    gained, rising = float(power[e.gap < 0.0].sum()), e.gap < -1e-3
    speed = float(e.velocity[rising, 2].max(initial=0.0))
    if gained < 2e-4 * e.weight or speed < 0.05:
        return None
    return Evidence(
        0.97,
        f"{gained:.3g} J won while it left {-1e3 * float(e.gap.min()):.3g} mm of depth at {speed:.2g} m/s",
    )


@symptom(
    "energy gain",
    "restitution",
    cause="restitution above one, an undamped contact in explicit steps, or depth turned into speed",
    confirm="drop a ball: does it come back higher?",
    cure="restitution of one at most; damp the contact, shorten the step",
)
def energy_gain(e: Episode) -> Evidence | None:
    """Tell whether a touch returns more energy than it took."""
    real = not e.has("motion") and not e.has("penetration") and not e.has("distance")
    return Evidence(
        0.994 if real else 0.965, f"{e.failed['restitution'].value:.3g} J more than the touch took"
    )


@symptom(
    "other contact velocity",
    "contact velocity",
    cause="velocities of another point or frame than the contact's, or of another motion",
    confirm="compare J v with the logged velocity while a foot swings",
    cure="take the velocity of the material at the contact point, in the contact's axes",
)
def other_contact_velocity(e: Episode) -> Evidence | None:
    """Tell whether the contact does not move as the joints say."""
    return Evidence(0.9, f"{e.failed['contact velocity'].value:.3g} m/s beside what the joints give")


@symptom(
    "other gap",
    "gap rate",
    cause="gaps of another point, surface or time than the contact velocities",
    confirm="add up the normal velocity of a swing foot and compare with its gap",
    cure="measure gap and velocity at the same point, at the same time",
)
def other_gap(e: Episode) -> Evidence | None:
    """Tell whether the gap does not change as the contact moves."""
    return Evidence(
        0.89, f"{1e3 * e.failed['gap rate'].value:.3g} mm beside what its velocity gives in 20 ms"
    )


@symptom(
    "chatter",
    "chatter",
    cause="contact too stiff for an explicit integrator, or a threshold without hysteresis",
    confirm="halve the step: the frequency doubles",
    cure="implicit integration, damping, a softer contact",
)
def chatter(e: Episode) -> Evidence | None:
    """Tell whether the contact opens and closes, or its force rings, at high frequency."""
    return Evidence(0.993 if e.breaks else 0.89, f"as if {e.failed['chatter'].value:.0f} switches in 0.1 s")


@symptom(
    "skating",
    "chatter",
    cause="between blows nothing brakes the foot, and the policy has learnt to travel on that",
    confirm="add up the way of a foot while its force switches on and off",
    cure="average the contact over a few steps in the reward; damp the contact",
)
def skating(e: Episode) -> Evidence | None:
    """Tell whether the foot travels by chattering."""
    if e.has("restitution"):
        return None  # it is thrown
    way = e.velocity[:, :2] * e.dt[:, None]
    gone = float(np.hypot(*way.sum(axis=0)))
    free = e.force[:, 2] < 0.1 * float(e.force[:, 2].max(initial=0.0))
    if gone < 2e-3 or float(np.hypot(*way[free].sum(axis=0))) < 0.3 * gone:
        return None  # it slides under load, which friction may allow
    return Evidence(0.995 if e.breaks else 0.9, f"{1e3 * gone:.3g} mm while it chattered")


@symptom(
    "one step impulse",
    "blow",
    cause="a contact resolved in one step: a missed collision, a reset, or a force read as impulse over dt",
    confirm="halve the step: the force doubles and its impulse stays",
    cure="restitution zero, shorter steps, limit forces before they enter a reward",
)
def one_step_impulse(e: Episode) -> Evidence | None:
    """Tell whether a blow of one step that no foot gives."""
    if e.failed["blow"].rows > 6 or e.impact:
        return None
    return Evidence(0.975, f"{e.failed['blow'].value:.3g} m g above the rows on both sides")


@symptom(
    "solver asymmetry",
    "lean",
    cause="the solver favours the contacts that it visits first: too few sweeps",
    confirm="change the order of the contacts, or the number of sweeps: the share moves",
    cure="more iterations, a solver that converges, or contacts in random order",
)
def solver_asymmetry(e: Episode) -> Evidence | None:
    """Tell whether one diagonal of feet carries more than the other, for no reason of the motion's."""
    text = f"one diagonal carries {e.failed['lean'].value:.2g} m g more than the other"
    return Evidence(0.9 if e.consistent else 0.6, text)
