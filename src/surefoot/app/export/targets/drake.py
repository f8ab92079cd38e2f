"""Drake: constraints of a `MathematicalProgram`, linear or second-order."""

from __future__ import annotations

from surefoot.app.export.sequence import ContactSequence
from surefoot.app.export.targets.target import script

BODY = '''

def new_forces(prog, phase):
    """Return new decision variables for the stacked forces of a phase."""
    dim = sum(contact["dim"] for contact in PHASES[phase]["contacts"])
    return prog.NewContinuousVariables(dim, "force")


def add_linear(prog, forces, phase):
    """Add A @ forces <= b and return the binding; None for a phase without contacts."""
    data = PHASES[phase]
    if not data["b"]:
        return None
    A, b = np.array(data["A"]), np.array(data["b"])
    return prog.AddLinearConstraint(A, np.full(len(b), -np.inf), b, forces)


def add_exact(prog, forces, phase):
    """Add the round cones of point contacts and their bounds; return the bindings."""
    out, at = [], 0
    for contact in PHASES[phase]["contacts"]:
        if contact["patch"] is not None:
            raise ValueError(contact["frame"] + " is a sole: its wrench cone has half-spaces only")
        force = forces[at : at + 3]
        rows = np.array([[0.0, 0.0, contact["mu"]], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
        out.append(prog.AddLorentzConeConstraint(rows, np.zeros(3), force))
        out.append(prog.AddBoundingBoxConstraint(contact["normal_min"], contact["normal_max"], force[2:]))
        at += 3
    return out
'''


def files(sequence: ContactSequence) -> dict[str, str]:
    """Return contacts_drake.py, with `new_forces`, `add_linear` and `add_exact`."""
    how = "add_linear(prog, forces, phase) and add_exact(prog, forces, phase) constrain them."
    return {"contacts_drake.py": script(sequence, "Drake", how, "import numpy as np\n\n", BODY)}
