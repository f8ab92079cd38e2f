"""Strengths by which an audit ranks symptoms."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.settings import Settings, setting
from surefoot.records.audit.limit_sources import RIVALS, VARIED


@dataclass(frozen=True)
class RankLimits(Settings):
    """Strengths of symptoms, from 0 to 1: an order, in which what explains an episode best is first."""

    certain: float = setting(
        0.9995,
        "-",
        "what comes before all that contacts have in common",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.9995 to 1",
    )
    shared: float = setting(
        0.02,
        "-",
        "advantage of a finding of all contacts over one of a single contact",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.014 to 0.12",
    )
    no_forces: float = setting(
        1.0, "-", "strength of no forces", low=0.0, high=1.0, tuned=VARIED + "0.9 to 1"
    )
    infeasible: float = setting(
        0.99, "-", "strength of infeasible", low=0.0, high=1.0, tuned=VARIED + "0.984 to 1"
    )
    outside_force: float = setting(
        0.8,
        "-",
        "strength of outside force that is told from the motion",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0 to 0.806",
    )
    unconverged_solver: float = setting(
        1.0, "-", "strength of unconverged solver", low=0.0, high=1.0, tuned=RIVALS + "1 to 1"
    )
    wrong_mass: float = setting(
        0.9, "-", "strength of wrong mass", low=0.0, high=1.0, tuned=VARIED + "0.894 to 0.906"
    )
    held_rows: float = setting(1.0, "-", "strength of held rows", low=0.0, high=1.0, tuned=VARIED + "1 to 1")
    teleport: float = setting(
        0.999, "-", "strength of teleport", low=0.0, high=1.0, tuned=VARIED + "0.999 to 1"
    )
    other_velocities: float = setting(
        0.998, "-", "strength of other velocities", low=0.0, high=1.0, tuned=VARIED + "0.998 to 0.998"
    )
    velocity_jump: float = setting(
        0.997, "-", "strength of velocity jump", low=0.0, high=1.0, tuned=VARIED + "0.897 to 0.997"
    )
    pull: float = setting(0.97, "-", "strength of pull", low=0.0, high=1.0, tuned=RIVALS + "0.87 to 0.97")
    coarse_facets: float = setting(
        0.995, "-", "strength of coarse facets", low=0.0, high=1.0, tuned=VARIED + "0.989 to 1"
    )
    too_much_friction: float = setting(
        0.985,
        "-",
        "strength of too much friction where the mismatch lies across the normal",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.885 to 0.991",
    )
    too_much_doubtful: float = setting(
        0.9, "-", "strength of too much friction otherwise", low=0.0, high=1.0, tuned=VARIED + "0 to 0.906"
    )
    friction_in_the_air: float = setting(
        0.98, "-", "strength of friction in the air", low=0.0, high=1.0, tuned=VARIED + "0.974 to 1"
    )
    friction_drives: float = setting(
        0.992, "-", "strength of friction drives", low=0.0, high=1.0, tuned=RIVALS + "0.986 to 0.992"
    )
    frictionless_slide: float = setting(
        0.986, "-", "strength of frictionless slide", low=0.0, high=1.0, tuned=VARIED + "0.98 to 0.992"
    )
    pyramid_bias: float = setting(
        0.91, "-", "strength of pyramid bias", low=0.0, high=1.0, tuned=RIVALS + "0 to 0.916"
    )
    invisible_geometry: float = setting(
        0.95, "-", "strength of invisible geometry", low=0.0, high=1.0, tuned=VARIED + "0.944 to 0.956"
    )
    sinking: float = setting(
        0.95, "-", "strength of sinking", low=0.0, high=1.0, tuned=VARIED + "0.944 to 0.956"
    )
    starts_in_the_ground: float = setting(
        0.998, "-", "strength of starts in the ground", low=0.0, high=1.0, tuned=VARIED + "0.992 to 1"
    )
    deep_contact: float = setting(
        0.9925, "-", "strength of deep contact", low=0.0, high=1.0, tuned=RIVALS + "0.9925 to 1"
    )
    push_off_penetration: float = setting(
        0.97, "-", "strength of push off penetration", low=0.0, high=1.0, tuned=VARIED + "0.97 to 1"
    )
    energy_gain: float = setting(
        0.994,
        "-",
        "strength of energy gain where nothing else is amiss",
        low=0.0,
        high=1.0,
        tuned=RIVALS + "0.994 to 1",
    )
    energy_doubtful: float = setting(
        0.965, "-", "strength of energy gain otherwise", low=0.0, high=1.0, tuned=VARIED + "0 to 0.965"
    )
    other_contact_velocity: float = setting(
        0.9, "-", "strength of other contact velocity", low=0.0, high=1.0, tuned=VARIED + "0 to 0.906"
    )
    other_gap: float = setting(
        0.89, "-", "strength of other gap", low=0.0, high=1.0, tuned=VARIED + "0 to 0.896"
    )
    chatter: float = setting(
        0.993,
        "-",
        "strength of chatter that breaks a law",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.893 to 0.993",
    )
    chatter_lawful: float = setting(
        0.89, "-", "strength of chatter that breaks none", low=0.0, high=1.0, tuned=VARIED + "0.79 to 0.896"
    )
    skating: float = setting(
        0.995,
        "-",
        "strength of skating that breaks a law",
        low=0.0,
        high=1.0,
        tuned=RIVALS + "0.995 to 0.995",
    )
    skating_lawful: float = setting(
        0.9, "-", "strength of skating that breaks none", low=0.0, high=1.0, tuned=VARIED + "0 to 0.906"
    )
    one_step_impulse: float = setting(
        0.975, "-", "strength of one step impulse", low=0.0, high=1.0, tuned=VARIED + "0.875 to 1"
    )
    solver_asymmetry: float = setting(
        0.6, "-", "strength of solver asymmetry", low=0.0, high=1.0, tuned=RIVALS + "0 to 0.7"
    )
    turn_of_many: float = setting(
        0.006,
        "-",
        "what a wrong frame loses that other feet share",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.006 to 0.012",
    )
    turn_of_one: float = setting(
        0.03,
        "-",
        "what a wrong frame of one foot loses: more friction may look like a turn",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0 to 0.13",
    )
    mirror: float = setting(0.005, "-", "what a mirror loses", low=0.0, high=1.0, tuned=VARIED + "0 to 0.011")
    reversed_pull: float = setting(
        0.98,
        "-",
        "strength of reversed forces where joint torques are not known",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.974 to 1",
    )
    scale: float = setting(
        0.002, "-", "what a wrong scale loses", low=0.0, high=1.0, tuned=VARIED + "0 to 0.008"
    )
    bias_in_flight: float = setting(
        0.02, "-", "what a bias loses", low=0.0, high=1.0, tuned=VARIED + "0 to 0.12"
    )
    bias_on_ground: float = setting(
        0.15,
        "-",
        "what a bias loses whose foot never flies: a factor explains as much",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.05 to 1",
    )
    delay: float = setting(
        0.004, "-", "what a delay loses", low=0.0, high=1.0, tuned=VARIED + "0.004 to 0.01"
    )
    dropout: float = setting(
        0.999, "-", "strength of dropout", low=0.0, high=1.0, tuned=VARIED + "0.993 to 0.999"
    )
    frozen: float = setting(1.0, "-", "strength of frozen", low=0.0, high=1.0, tuned=VARIED + "0.994 to 1")
    clipped: float = setting(
        0.998,
        "-",
        "strength of clipping whose true force varies",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.992 to 1",
    )
    clipped_flat: float = setting(
        0.985,
        "-",
        "strength of clipping whose true force does not vary",
        low=0.0,
        high=1.0,
        tuned=RIVALS + "0.979 to 1",
    )
    phantom_force: float = setting(
        0.98, "-", "strength of phantom force", low=0.0, high=1.0, tuned=VARIED + "0.974 to 1"
    )
    joint_stop: float = setting(
        1.0, "-", "strength of joint stop", low=0.0, high=1.0, tuned=RIVALS + "1 to 1"
    )
    dead_torque: float = setting(
        1.0, "-", "strength of dead torque", low=0.0, high=1.0, tuned=VARIED + "0.994 to 1"
    )
    wrong_torques: float = setting(
        0.97, "-", "strength of wrong torques", low=0.0, high=1.0, tuned=VARIED + "0.87 to 0.976"
    )
    unexplained_motion: float = setting(
        0.3, "-", "strength of unexplained motion", low=0.0, high=1.0, tuned=VARIED + "0 to 0.4"
    )
