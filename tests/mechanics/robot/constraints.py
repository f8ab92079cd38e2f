"""Attached contacts as Pinocchio's own constraint models, and how far two arrays are apart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio

import surefoot as sf
from surefoot.mechanics.robot.jacobians import Attachment


def relative(a: np.ndarray, b: np.ndarray) -> float:
    """Return the largest difference over the largest entry."""
    return float(np.abs(a - b).max() / max(np.abs(b).max(), 1e-300))


def constraints(robot: sf.Robot, q: np.ndarray, points: Sequence[Attachment]) -> tuple[Any, Any, Any]:
    """Return a Data at q, and Pinocchio's models and data of contacts, along the contacts' axes there."""
    data = robot.model.createData()
    pinocchio.computeJointJacobians(robot.model, data, q)
    pinocchio.updateFramePlacements(robot.model, data)
    models, datas = pinocchio.StdVec_RigidConstraintModel(), pinocchio.StdVec_RigidConstraintData()
    for point in points:
        frame = robot.model.frames[point.frame]
        axes = data.oMf[point.frame].rotation.T @ point.rotation_world_contact
        place = frame.placement * pinocchio.SE3(axes, point.offset)
        kind = pinocchio.ContactType.CONTACT_3D if point.dim == 3 else pinocchio.ContactType.CONTACT_6D
        local = pinocchio.ReferenceFrame.LOCAL
        models.append(pinocchio.RigidConstraintModel(kind, robot.model, frame.parentJoint, place, local))
        datas.append(models[-1].createData())
    return data, models, datas
