"""Symptoms of contact itself: forces that no contact with the ground gives."""

from __future__ import annotations

import numpy as np

from surefoot.records.audit.episode import Episode
from surefoot.records.audit.soles import worst_sole
from surefoot.records.audit.symptoms.fits import fitted_pyramid
from surefoot.records.audit.symptoms.symptom import Evidence, symptom


@symptom(
    "pull",
    "pull",
    cause="a row f_n >= 0 is missing, or z is not the surface normal",
    confirm="print the normal and the smallest normal force",
    cure="add the row; turn the frame so that z leaves the ground",
)
def pull(e: Episode) -> Evidence | None:
    """Tell whether the ground pulls."""
    return Evidence(e.limits.ranks.pull, f"normal force down to {float(e.force[:, 2].min()):.3g} N")


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
    shape = fitted_pyramid(e.force, e.mu, e.weight, e.limits.fits)
    if shape is None:
        return None
    turned = f", turned by {np.degrees(shape[1]):.0f} deg" if shape[1] else ""
    text = f"forces lie on the edge of a pyramid of {shape[0]} facets about the cone{turned}"
    return Evidence(e.limits.ranks.coarse_facets, text)


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
    over = (needed > e.limits.contact.excess * e.mu) & (e.force[:, 2] > e.rows.setting.threshold)
    if not over.any():
        return None
    worst, ranks = float(needed[over].max()), e.limits.ranks
    return Evidence(
        ranks.too_much_friction if e.sideways else ranks.too_much_doubtful,
        f"needs mu of {worst:.3g} where the ground has {float(e.mu[over].min()):.3g}",
    )


@symptom(
    "beyond the sole",
    "sole",
    cause="the moment is about another point, or in other axes, than the corners (an ankle's sensor)",
    confirm="at rest the foot presses at (-m_y, m_x) / f_z: draw that point against the corners",
    cure="move the moment to the corners' origin, m - r x f; give the sole that the foot has",
)
def beyond_the_sole(e: Episode) -> Evidence | None:
    """Tell which limit of a flat foot its wrench leaves."""
    worst, says = worst_sole(e.rows, e.column)
    # a force that looks lawful alone: no other symptom explains it
    return Evidence(e.limits.ranks.too_much_friction, says) if worst > 0.0 else None


@symptom(
    "friction in the air",
    "distance",
    cause="friction is computed from a stale or padded contact, or from a foot's speed near the ground",
    confirm="plot f_t against the gap",
    cure="tie the friction to the normal force of the same instant",
)
def friction_in_the_air(e: Episode) -> Evidence | None:
    """Tell whether a force across the ground where there is no contact."""
    limits = e.limits.contact
    air = (e.gap > limits.air_gap) & (e.force[:, 2] <= limits.air_normal * e.weight)
    side = np.hypot(e.force[:, 0], e.force[:, 1])
    if (air & (side > e.rows.setting.threshold)).mean() < limits.air_share:
        return None
    return Evidence(
        e.limits.ranks.friction_in_the_air,
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
    return Evidence(
        e.limits.ranks.friction_drives, f"{e.failed['work'].value:.3g} J given by friction in 50 ms"
    )


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
    way = 1e3 * e.failed["dissipation"].value
    return Evidence(e.limits.ranks.frictionless_slide, f"{way:.3g} mm without friction")


@symptom(
    "pyramid bias",
    "bias",
    cause="the world's friction is a pyramid: across its edges it has 71 % of mu, and bends the slide",
    confirm="turn the direction of the slide by 45 degrees: it is braked otherwise",
    cure="an elliptic cone (MuJoCo: cone='elliptic', with impratio for stiff friction)",
)
def pyramid_bias(e: Episode) -> Evidence | None:
    """Tell whether a slide is braked by a pyramid's friction where the round cone has more."""
    way = 1e3 * e.failed["bias"].value
    text = f"{way:.3g} mm of the way as if without friction, by the round cone"
    return Evidence(e.limits.ranks.pyramid_bias, text)


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
    text = f"{float(e.force[:, 2].max()):.3g} N at a gap of {height:.3g} mm, {real}{modelled}"
    return Evidence(e.limits.ranks.invisible_geometry, text)


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
    soft = 1e3 * e.limits.records.deep
    more = f", more than {soft:g} mm" if depth > soft else ""
    return Evidence(e.limits.ranks.sinking, f"{depth:.3g} mm deep{more}")


@symptom(
    "starts in the ground",
    "penetration",
    cause="the run was begun below the ground: a keyframe or reset that no contact would lead to",
    confirm="look at the gaps of the first row",
    cure="lift the start by that depth",
)
def starts_in_the_ground(e: Episode) -> Evidence | None:
    """Tell whether the log begins in the ground and comes out of it."""
    first, limits = -float(e.gap[0]), e.limits.contact
    deepest = e.failed["penetration"].value
    if e.rows.core.start != 0 or first < limits.starts_deepest * deepest:
        return None
    if -float(e.gap[-1]) > limits.starts_left * deepest:
        return None
    return Evidence(e.limits.ranks.starts_in_the_ground, f"{1e3 * first:.3g} mm deep in the first row")


@symptom(
    "deep contact",
    "depth",
    cause="the contact is soft: what its world declares lawful hides what is gained from depth",
    confirm="halve the contact's time constant: does the motion survive?",
    cure="a stiffer contact (solref, stiffness) with a shorter step",
)
def deep_contact(e: Episode) -> Evidence | None:
    """Tell whether a contact that is declared soft is deep in the ground."""
    if e.rows.setting.sinking < e.limits.records.deep:
        return None
    depth = 1e3 * e.failed["depth"].value
    return Evidence(e.limits.ranks.deep_contact, f"{depth:.3g} mm deep, as its world declares")


@symptom(
    "push off penetration",
    "penetration",
    cause="the engine turns depth into speed (projection, a stiff spring), and the motion lives on it",
    confirm="add up f_n v_n over the contact: it must not be positive",
    cure="limit the depenetration speed, shorten the step, punish depth in training",
)
def push_off_penetration(e: Episode) -> Evidence | None:
    """Tell whether the ground gives back more than it took: the foot is thrown out of it."""
    power, limits = e.force[:, 2] * e.velocity[:, 2] * e.dt, e.limits.contact
    gained, rising = float(power[e.gap < 0.0].sum()), e.gap < -limits.push_off_depth
    speed = float(e.velocity[rising, 2].max(initial=0.0))
    if gained < limits.push_off_work * e.weight or speed < limits.push_off_speed:
        return None
    return Evidence(
        e.limits.ranks.push_off_penetration,
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
    strength = e.limits.ranks.energy_gain if real else e.limits.ranks.energy_doubtful
    return Evidence(strength, f"{e.failed['restitution'].value:.3g} J more than the touch took")


@symptom(
    "other contact velocity",
    "contact velocity",
    cause="velocities of another point or frame than the contact's, or of another motion",
    confirm="compare J v with the logged velocity while a foot swings",
    cure="take the velocity of the material at the contact point, in the contact's axes",
)
def other_contact_velocity(e: Episode) -> Evidence | None:
    """Tell whether the contact does not move as the joints say."""
    text = f"{e.failed['contact velocity'].value:.3g} m/s beside what the joints give"
    return Evidence(e.limits.ranks.other_contact_velocity, text)


@symptom(
    "other gap",
    "gap rate",
    cause="gaps of another point, surface or time than the contact velocities",
    confirm="add up the normal velocity of a swing foot and compare with its gap",
    cure="measure gap and velocity at the same point, at the same time",
)
def other_gap(e: Episode) -> Evidence | None:
    """Tell whether the gap does not change as the contact moves."""
    text = f"{1e3 * e.failed['gap rate'].value:.3g} mm beside what its velocity gives in 20 ms"
    return Evidence(e.limits.ranks.other_gap, text)


@symptom(
    "chatter",
    "chatter",
    cause="contact too stiff for an explicit integrator, or a threshold without hysteresis",
    confirm="halve the step: the frequency doubles",
    cure="implicit integration, damping, a softer contact",
)
def chatter(e: Episode) -> Evidence | None:
    """Tell whether the contact opens and closes, or its force rings, at high frequency."""
    strength = e.limits.ranks.chatter if e.breaks else e.limits.ranks.chatter_lawful
    return Evidence(strength, f"as if {e.failed['chatter'].value:.0f} switches in 0.1 s")


@symptom(
    "skating",
    "chatter",
    cause="between blows nothing brakes the foot: it travels while it bounces",
    confirm="add up the way of a foot while its force switches on and off",
    cure="average the contact over a few steps in the reward; damp the contact",
)
def skating(e: Episode) -> Evidence | None:
    """Tell whether the foot travels by chattering."""
    if e.has("restitution"):
        return None  # it is thrown
    way, limits, ranks = e.velocity[:, :2] * e.dt[:, None], e.limits.contact, e.limits.ranks
    gone = float(np.hypot(*way.sum(axis=0)))
    free = e.force[:, 2] < limits.skating_free * float(e.force[:, 2].max(initial=0.0))
    if gone < limits.skating_way or float(np.hypot(*way[free].sum(axis=0))) < limits.skating_share * gone:
        return None  # it slides under load, which friction may allow
    return Evidence(
        ranks.skating if e.breaks else ranks.skating_lawful, f"{1e3 * gone:.3g} mm while it chattered"
    )


@symptom(
    "one step impulse",
    "blow",
    cause="a contact resolved in one step: a missed collision, a reset, or a force read as impulse over dt",
    confirm="halve the step: the force doubles and its impulse stays",
    cure="restitution zero, shorter steps, limit forces before they enter a reward",
)
def one_step_impulse(e: Episode) -> Evidence | None:
    """Tell whether a blow of one step that no foot gives."""
    if e.failed["blow"].rows > e.limits.contact.blow_rows or e.impact:
        return None
    text = f"{e.failed['blow'].value:.3g} m g above the rows on both sides"
    return Evidence(e.limits.ranks.one_step_impulse, text)


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
    return Evidence(e.limits.ranks.solver_asymmetry, text)
