"""Robots of any length: floating chains of links, as Pinocchio models."""

from __future__ import annotations

from typing import Any

import numpy as np


def chain(links: int) -> Any:
    """Return a Pinocchio model of a floating chain of `links` bodies on joints about x and y by turns."""
    import pinocchio

    model = pinocchio.Model()
    body = pinocchio.Inertia.FromCylinder(0.5, 0.03, 0.1)
    joint = model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), "base")
    model.appendBodyToJoint(joint, body, pinocchio.SE3.Identity())
    hinges = (pinocchio.JointModelRX(), pinocchio.JointModelRY())
    step = pinocchio.SE3(np.eye(3), np.array([0.0, 0.0, 0.1]))
    for k in range(links - 1):
        joint = model.addJoint(joint, hinges[k % 2], step, f"joint{k}")
        model.appendBodyToJoint(joint, body, pinocchio.SE3.Identity())
    return model
