"""Crocoddyl: friction and wrench cones of every phase, and the costs that keep forces inside them."""

from __future__ import annotations

import math

from surefoot.app.export.sequence import ContactSequence
from surefoot.app.export.targets.target import script
from surefoot.base.errors import ProblemError
from surefoot.mechanics.stance import PointContact

BODY = '''
HUGE = np.finfo(float).max
COS, SIN = np.cos(TURNED), np.sin(TURNED)
TURN = np.array([[COS, -SIN, 0.0], [SIN, COS, 0.0], [0.0, 0.0, 1.0]])
"""Crocoddyl's first facet faces along x; the sequence's is turned from there about the normal."""


def cone(contact, axes=np.eye(3)):
    """Return the FrictionCone of a point or WrenchCone of a sole; `axes` turns it from contact axes."""
    low, high = contact["normal_min"], min(contact["normal_max"], HUGE)
    if contact["patch"] is None:
        return crocoddyl.FrictionCone(axes @ TURN, contact["mu"], FACETS, INNER, low, high)
    return crocoddyl.WrenchCone(axes, contact["mu"], np.array(contact["patch"]), 4, INNER, low, high)


def cones(phase):
    """Return the cones of a phase, by frame."""
    return {contact["frame"]: cone(contact) for contact in PHASES[phase]["contacts"]}


def contact_model(state, actuation, phase, gains=(0.0, 50.0)):
    """Return the ContactModelMultiple of a phase: points by 3-D, soles by 6-D contacts."""
    import pinocchio

    models = crocoddyl.ContactModelMultiple(state, actuation.nu)
    for contact in PHASES[phase]["contacts"]:
        frame, where = state.pinocchio.getFrameId(contact["frame"]), np.array(contact["position"])
        turn = np.array(contact["rotation"])
        world = pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
        if contact["patch"] is None:
            model = crocoddyl.ContactModel3D(state, frame, where, world, actuation.nu, np.array(gains))
        else:
            pose = pinocchio.SE3(turn, where)
            model = crocoddyl.ContactModel6D(state, frame, pose, world, actuation.nu, np.array(gains))
        models.addContact(contact["frame"], model)
    return models


def cone_costs(state, actuation, phase, weight=1e1):
    """Return a CostModelSum that keeps the forces of a phase inside their cones by a quadratic barrier."""
    costs = crocoddyl.CostModelSum(state, actuation.nu)
    for contact in PHASES[phase]["contacts"]:
        frame = state.pinocchio.getFrameId(contact["frame"])
        own = cone(contact, np.array(contact["rotation"]))
        point = contact["patch"] is None
        kinds = crocoddyl.ResidualModelContactFrictionCone, crocoddyl.ResidualModelContactWrenchCone
        residual = kinds[0 if point else 1](state, frame, own, actuation.nu)
        barrier = crocoddyl.ActivationModelQuadraticBarrier(crocoddyl.ActivationBounds(own.lb, own.ub))
        costs.addCost(contact["frame"], crocoddyl.CostModelResidual(state, barrier, residual), weight)
    return costs
'''


def files(sequence: ContactSequence) -> dict[str, str]:
    """Return contacts_crocoddyl.py, with `cones(phase)`, `contact_model(...)` and `cone_costs(...)`.

    Raises
    ------
    ProblemError
        For an odd number of facets.
    """
    if sequence.facets % 2:
        raise ProblemError(f"Crocoddyl's cones have an even number of facets, got {sequence.facets}")
    how = "cones(phase) are Crocoddyl's own cones; contact_model and cone_costs make its models."
    first = PointContact((0.0, 0.0, 0.0)).sides(sequence.facets, sequence.fit)[0]
    turned = math.atan2(first[1], first[0])
    setup = "import crocoddyl\nimport numpy as np\n\n"
    setup += f"FACETS, INNER, TURNED = {sequence.facets}, {sequence.fit == 'inner'}, {turned!r}\n"
    return {"contacts_crocoddyl.py": script(sequence, "Crocoddyl", how, setup, BODY)}
