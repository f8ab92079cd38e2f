"""The symptoms: a function each, with its words, and a place in the table."""

from __future__ import annotations

from surefoot.records.audit.symptoms import body, contact, measured
from surefoot.records.audit.symptoms.symptom import Evidence, Symptom

__all__ = ["SYMPTOMS", "Evidence", "Symptom"]

SYMPTOMS: tuple[Symptom, ...] = (
    body.no_forces, body.infeasible, body.held_rows, body.teleport, body.other_velocities, body.velocity_jump,
    measured.wrong_frame, measured.mirrored, measured.reversed_force, measured.dead_torque,
    contact.pull, contact.coarse_facets, contact.too_much_friction,
    contact.beyond_the_sole, contact.friction_in_the_air,
    contact.invisible_geometry, measured.phantom_force, contact.sinking,
    contact.starts_in_the_ground, contact.deep_contact, contact.push_off_penetration,
    contact.energy_gain, contact.other_contact_velocity, contact.other_gap,
    contact.chatter, contact.skating, contact.one_step_impulse, contact.solver_asymmetry, measured.joint_stop,
    measured.dropout, measured.frozen, measured.clipped, measured.wrong_scale, measured.bias,
    measured.delayed, measured.swapped_feet, contact.friction_drives, contact.frictionless_slide,
    body.outside_force, body.unconverged_solver, body.wrong_mass, contact.pyramid_bias,
    measured.wrong_torques, measured.unexplained_motion,
)  # fmt: skip
"""In the order of the table on the page; what explains an episode best is named, whatever its place.

`Evidence.strength` is that order, worked out from how much a symptom explains; it is no probability.
"""
