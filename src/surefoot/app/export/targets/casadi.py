"""CasADi: constraints of contact forces as functions of SX, MX or numbers."""

from __future__ import annotations

from surefoot.app.export.sequence import ContactSequence
from surefoot.app.export.targets.target import script

BODY = '''

def dim(phase):
    """Return the number of force components of a phase."""
    return sum(contact["dim"] for contact in PHASES[phase]["contacts"])


def linear(phase, forces):
    """Return h (m, 1) with h <= 0 where the stacked forces are within the pyramids and bounds."""
    if dim(phase) == 0:
        return ca.DM.zeros(0, 1)
    return ca.mtimes(ca.DM(PHASES[phase]["A"]), forces) - ca.DM(PHASES[phase]["b"])


def exact(phase, forces):
    """Return h (m, 1) with h <= 0 where the forces of point contacts are within the round cones and bounds.

    Polynomial, so that it is smooth everywhere: f_x^2 + f_y^2 - mu^2 f_z^2, -f_z, and the bounds.
    """
    rows, at = [], 0
    for contact in PHASES[phase]["contacts"]:
        if contact["patch"] is not None:
            raise ValueError(contact["frame"] + " is a sole: its wrench cone has half-spaces only")
        x, y, z = forces[at], forces[at + 1], forces[at + 2]
        rows += [x * x + y * y - contact["mu"] ** 2 * z * z, contact["normal_min"] - z]
        if contact["normal_max"] < float("inf"):
            rows += [z - contact["normal_max"]]
        at += 3
    return ca.vertcat(*rows) if rows else ca.DM.zeros(0, 1)
'''


def files(sequence: ContactSequence) -> dict[str, str]:
    """Return contacts_casadi.py, with `linear(phase, forces)` and `exact(phase, forces)`."""
    how = "linear(phase, forces) and exact(phase, forces) are <= 0 where forces are allowed."
    return {"contacts_casadi.py": script(sequence, "CasADi", how, "import casadi as ca\n\n", BODY)}
