"""Limits of the symptoms of an audit, and the strengths by which they are ranked."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.settings import Settings, setting


@dataclass(frozen=True)
class FitLimits(Settings):
    """Limits of models of how a force may differ from the true one."""

    spread: float = setting(
        0.02,
        "-",
        "scatter of directions (one less their mean resultant) that is more than one place",
        low=0.0,
    )
    loaded: float = setting(0.005, "m g", "normal force below which the use of friction is noise", low=0.0)
    outside: float = setting(1.01, "-", "use of the cone from which a force is outside it", low=0.0)
    corner: float = setting(
        1.01, "-", "reach over a pyramid's corner up to which forces may fill it", low=0.0
    )
    edge_high: float = setting(
        1.005,
        "-",
        "distance of forces from the axis, over that of the edge, up to which they are on it",
        low=0.0,
    )
    edge_low: float = setting(
        0.98,
        "-",
        "distance of forces from the axis, over that of the edge, from which they are on it",
        low=0.0,
    )
    phase_step: float = setting(0.25, "deg", "step between the turns of a pyramid that are tried", low=1e-3)
    least_points: int = setting(3, "-", "forces outside the cone without which no pyramid is fitted", low=1)


@dataclass(frozen=True)
class BodyLimits(Settings):
    """Limits of symptoms of the robot as a whole."""

    held: float = setting(0.3, "m g", "unexplained force from which a body is held up", low=0.0)
    touching: float = setting(0.001, "m", "gap up to which the lowest foot touches the ground", low=0.0)
    mass_time: float = setting(0.2, "s", "shortest time of a wrong motion that shows another mass", low=0.0)
    mass_upright: float = setting(
        0.9,
        "-",
        "share of the mean missing force that is vertical where the mass is wrong",
        low=0.0,
        high=1.0,
    )
    mass_spread: float = setting(
        0.6, "-", "scatter of the missing force over its mean where the mass is wrong", low=0.0
    )
    held_rows: int = setting(5, "-", "repeated rows from which a state is held", low=1)
    teleport_share: float = setting(
        0.8, "-", "share of the squared slips of positions that two rows have in a jump", low=0.0, high=1.0
    )
    jump_force: float = setting(
        2.0, "m g", "unexplained force of one row that is a jump of the velocity", low=0.0
    )
    jump_share: float = setting(
        0.9, "-", "share of the squared unexplained force that two rows have in a jump", low=0.0, high=1.0
    )
    jump_logged: float = setting(
        0.5, "-", "part of that force by which a logged force may change, which is a blow otherwise", low=0.0
    )


@dataclass(frozen=True)
class ContactLimits(Settings):
    """Limits of symptoms of contact itself."""

    starts_deepest: float = setting(
        0.99, "-", "depth of the first row over the deepest in a log that starts in the ground", low=0.0
    )
    starts_left: float = setting(0.5, "-", "depth of the last row over the deepest in such a log", low=0.0)
    excess: float = setting(
        1.001, "-", "friction needed over the ground's from which it is too much", low=0.0
    )
    air_gap: float = setting(0.001, "m", "gap from which a contact is in the air", low=0.0)
    air_normal: float = setting(
        0.005, "m g", "normal force up to which a contact in the air carries nothing", low=0.0
    )
    air_share: float = setting(0.5, "-", "share of the rows with friction in the air", low=0.0, high=1.0)
    push_off_depth: float = setting(
        0.001, "m", "depth from which a foot is thrown out of the ground", low=0.0
    )
    push_off_work: float = setting(0.0002, "m g m", "work that such a foot wins", low=0.0)
    push_off_speed: float = setting(0.05, "m/s", "speed at which such a foot leaves", low=0.0)
    skating_free: float = setting(
        0.1, "-", "normal force over its largest, below which a foot that chatters is free", low=0.0
    )
    skating_way: float = setting(0.002, "m", "way of a foot that skates", low=0.0)
    skating_share: float = setting(0.3, "-", "share of that way that is gone while free", low=0.0, high=1.0)
    blow_rows: int = setting(6, "-", "rows up to which a blow is one step's", low=1)


@dataclass(frozen=True)
class MeasuredLimits(Settings):
    """Limits of symptoms of what was measured."""

    at_stop: float = setting(
        0.01, "rad, m", "distance from the end of a joint's range at which it is at its stop", low=0.0
    )
    stop_share: float = setting(
        0.3, "-", "share of the rows in which a joint is at its stop", low=0.0, high=1.0
    )
    flat: float = setting(0.01, "m g", "standard deviation of a force that no scale makes constant", low=0.0)
    turn: float = setting(3.0, "deg", "turn of forces that is a wrong frame", low=0.0)
    turn_share: float = setting(0.8, "-", "share of the mismatch that a turn explains", low=0.0, high=1.0)
    turn_amiss: float = setting(
        0.01, "m g", "mismatch of other feet below which they do not speak for a turn", low=0.0
    )
    turn_left: float = setting(
        0.1, "-", "share of the other feet's mismatch that may be left by the same turn", low=0.0, high=1.0
    )
    mirror_share: float = setting(0.9, "-", "share of the mismatch that a mirror explains", low=0.0, high=1.0)
    reversed_pull: float = setting(
        0.05, "m g", "mean pull from which forces are reversed where joint torques are not known", low=0.0
    )
    reversed_share: float = setting(
        0.9, "-", "share of the mismatch that the other sign explains", low=0.0, high=1.0
    )
    scale_least: float = setting(0.02, "-", "least factor of forces that is a scale", low=0.0)
    scale_change: float = setting(0.02, "-", "least difference of that factor from one", low=0.0)
    scale_share: float = setting(0.9, "-", "share of the mismatch that a factor explains", low=0.0, high=1.0)
    bias_share: float = setting(0.9, "-", "share of the mismatch that a constant explains", low=0.0, high=1.0)
    bias_air: float = setting(0.03, "m g", "force below which a foot is in the air", low=0.0)
    bias_flies: float = setting(
        0.1,
        "-",
        "share of the rows in the air from which a constant is told from a factor",
        low=0.0,
        high=1.0,
    )
    delay_most: float = setting(0.08, "s", "largest shift in time that is tried", low=0.0)
    delay_share: float = setting(0.8, "-", "share of the mismatch that a shift explains", low=0.0, high=1.0)
    delay_rows: int = setting(3, "-", "least shift", low=1)
    swap_share: float = setting(
        0.9, "-", "share of the mismatch that another foot's force explains", low=0.0, high=1.0
    )
    dropout_carried: float = setting(0.04, "m g", "true force from which a foot carries", low=0.0)
    dropout_share: float = setting(
        0.7, "-", "share of the rows in which a foot carries and reports nothing", low=0.0, high=1.0
    )
    frozen_share: float = setting(0.7, "-", "share of the rows in which no digit changes", low=0.0, high=1.0)
    frozen_gap: float = setting(
        0.001, "m", "median gap up to which a frozen force is that of a foot on the ground", low=0.0
    )
    clipped_share: float = setting(0.3, "-", "share of the rows at the largest value", low=0.0, high=1.0)
    clipped_below: float = setting(
        0.01, "m g", "true force below a clipped one that rounding and smoothing allow", low=0.0
    )
    phantom_gap: float = setting(0.001, "m", "gap from which a foot is in the air", low=0.0)
    phantom_true: float = setting(0.03, "m g", "true force below which a leg carries nothing", low=0.0)
    phantom_air: float = setting(0.5, "-", "share of the rows in the air", low=0.0, high=1.0)
    phantom_share: float = setting(
        0.8, "-", "share of those rows in which the leg carries nothing", low=0.0, high=1.0
    )
    dead_share: float = setting(
        0.9, "-", "share of the rows in which a dead joint has no torque", low=0.0, high=1.0
    )
    torques_body: float = setting(
        0.02, "m g", "unexplained force on the body below which the forces explain its motion", low=0.0
    )


@dataclass(frozen=True)
class RankLimits(Settings):
    """Strengths of symptoms, from 0 to 1: an order, in which what explains an episode best is first."""

    certain: float = setting(
        0.9995, "-", "what comes before all that contacts have in common", low=0.0, high=1.0
    )
    shared: float = setting(
        0.02, "-", "advantage of a finding of all contacts over one of a single contact", low=0.0, high=1.0
    )
    no_forces: float = setting(1.0, "-", "strength of no forces", low=0.0, high=1.0)
    infeasible: float = setting(0.99, "-", "strength of infeasible", low=0.0, high=1.0)
    outside_force: float = setting(
        0.8, "-", "strength of outside force that is told from the motion", low=0.0, high=1.0
    )
    unconverged_solver: float = setting(1.0, "-", "strength of unconverged solver", low=0.0, high=1.0)
    wrong_mass: float = setting(0.9, "-", "strength of wrong mass", low=0.0, high=1.0)
    held_rows: float = setting(1.0, "-", "strength of held rows", low=0.0, high=1.0)
    teleport: float = setting(0.999, "-", "strength of teleport", low=0.0, high=1.0)
    other_velocities: float = setting(0.998, "-", "strength of other velocities", low=0.0, high=1.0)
    velocity_jump: float = setting(0.997, "-", "strength of velocity jump", low=0.0, high=1.0)
    pull: float = setting(0.97, "-", "strength of pull", low=0.0, high=1.0)
    coarse_facets: float = setting(0.995, "-", "strength of coarse facets", low=0.0, high=1.0)
    too_much_friction: float = setting(
        0.985,
        "-",
        "strength of too much friction where the mismatch lies across the normal",
        low=0.0,
        high=1.0,
    )
    too_much_doubtful: float = setting(0.9, "-", "strength of too much friction otherwise", low=0.0, high=1.0)
    friction_in_the_air: float = setting(0.98, "-", "strength of friction in the air", low=0.0, high=1.0)
    friction_drives: float = setting(0.992, "-", "strength of friction drives", low=0.0, high=1.0)
    frictionless_slide: float = setting(0.986, "-", "strength of frictionless slide", low=0.0, high=1.0)
    pyramid_bias: float = setting(0.91, "-", "strength of pyramid bias", low=0.0, high=1.0)
    invisible_geometry: float = setting(0.95, "-", "strength of invisible geometry", low=0.0, high=1.0)
    sinking: float = setting(0.95, "-", "strength of sinking", low=0.0, high=1.0)
    starts_in_the_ground: float = setting(0.998, "-", "strength of starts in the ground", low=0.0, high=1.0)
    deep_contact: float = setting(0.9925, "-", "strength of deep contact", low=0.0, high=1.0)
    push_off_penetration: float = setting(0.97, "-", "strength of push off penetration", low=0.0, high=1.0)
    energy_gain: float = setting(
        0.994, "-", "strength of energy gain where nothing else is amiss", low=0.0, high=1.0
    )
    energy_doubtful: float = setting(0.965, "-", "strength of energy gain otherwise", low=0.0, high=1.0)
    other_contact_velocity: float = setting(0.9, "-", "strength of other contact velocity", low=0.0, high=1.0)
    other_gap: float = setting(0.89, "-", "strength of other gap", low=0.0, high=1.0)
    chatter: float = setting(0.993, "-", "strength of chatter that breaks a law", low=0.0, high=1.0)
    chatter_lawful: float = setting(0.89, "-", "strength of chatter that breaks none", low=0.0, high=1.0)
    skating: float = setting(0.995, "-", "strength of skating that breaks a law", low=0.0, high=1.0)
    skating_lawful: float = setting(0.9, "-", "strength of skating that breaks none", low=0.0, high=1.0)
    one_step_impulse: float = setting(0.975, "-", "strength of one step impulse", low=0.0, high=1.0)
    solver_asymmetry: float = setting(
        0.9, "-", "strength of solver asymmetry where torques agree with forces", low=0.0, high=1.0
    )
    asymmetry_doubtful: float = setting(0.6, "-", "strength of solver asymmetry otherwise", low=0.0, high=1.0)
    turn_of_many: float = setting(
        0.006, "-", "what a wrong frame loses that other feet share", low=0.0, high=1.0
    )
    turn_of_one: float = setting(
        0.03,
        "-",
        "what a wrong frame of one foot loses: more friction may look like a turn",
        low=0.0,
        high=1.0,
    )
    mirror: float = setting(0.005, "-", "what a mirror loses", low=0.0, high=1.0)
    reversed_pull: float = setting(
        0.9, "-", "strength of reversed forces where joint torques are not known", low=0.0, high=1.0
    )
    scale: float = setting(0.002, "-", "what a wrong scale loses", low=0.0, high=1.0)
    bias_in_flight: float = setting(0.02, "-", "what a bias loses", low=0.0, high=1.0)
    bias_on_ground: float = setting(
        0.15, "-", "what a bias loses whose foot never flies: a factor explains as much", low=0.0, high=1.0
    )
    delay: float = setting(0.004, "-", "what a delay loses", low=0.0, high=1.0)
    dropout: float = setting(0.999, "-", "strength of dropout", low=0.0, high=1.0)
    frozen: float = setting(1.0, "-", "strength of frozen", low=0.0, high=1.0)
    clipped: float = setting(0.998, "-", "strength of clipping whose true force varies", low=0.0, high=1.0)
    clipped_flat: float = setting(
        0.985, "-", "strength of clipping whose true force does not vary", low=0.0, high=1.0
    )
    phantom_force: float = setting(0.98, "-", "strength of phantom force", low=0.0, high=1.0)
    joint_stop: float = setting(1.0, "-", "strength of joint stop", low=0.0, high=1.0)
    dead_torque: float = setting(1.0, "-", "strength of dead torque", low=0.0, high=1.0)
    wrong_torques: float = setting(0.97, "-", "strength of wrong torques", low=0.0, high=1.0)
    unexplained_motion: float = setting(0.3, "-", "strength of unexplained motion", low=0.0, high=1.0)
