"""acados: path constraints of an `AcadosOcp`, phase by phase."""

from __future__ import annotations

from surefoot.interop.sequence import ContactSequence
from surefoot.interop.targets.target import header, python_data

BODY = '''
UNBOUNDED = 1e10
"""What acados takes for no bound."""


def add_contact_constraints(ocp, phase, forces):
    """Set con_h_expr of ocp.model and its bounds: A @ forces <= b for the (dim,) SX or MX forces of a phase.

    Constraints that the model has already are kept above them.
    """
    data = PHASES[phase]
    if not data["b"]:
        return
    rows = ca.mtimes(ca.DM(data["A"]), forces)
    had = ocp.model.con_h_expr
    keep = had is not None and not isinstance(had, list) and had.numel() > 0
    ocp.model.con_h_expr = ca.vertcat(had, rows) if keep else rows
    low, high = np.full(len(data["b"]), -UNBOUNDED), np.array(data["b"])
    ocp.constraints.lh = np.concatenate([ocp.constraints.lh, low]) if keep else low
    ocp.constraints.uh = np.concatenate([ocp.constraints.uh, high]) if keep else high
'''


class Acados:
    """A module with `add_contact_constraints(ocp, phase, forces)`."""

    name = "acados"
    meaning = "a module that sets con_h_expr, lh and uh of an AcadosOcp"

    def files(self, sequence: ContactSequence) -> dict[str, str]:
        """Return contacts_acados.py."""
        how = "add_contact_constraints(ocp, phase, forces) bounds the forces of a phase."
        imports = "import casadi as ca\nimport numpy as np\n\n"
        return {
            "contacts_acados.py": header(sequence, "acados", how) + imports + python_data(sequence) + BODY
        }


TARGET = Acados()
