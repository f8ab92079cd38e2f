"""Simple bodies for the rigid world and for flights: a ball, a box, and a cat of two halves."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array, positive_number, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.libraries import import_pinocchio
from surefoot.mechanics import Foot, Robot


def ball(mass: float = 1.0, radius: float = 0.1) -> Robot:
    """Return a homogeneous ball of `mass` [kg] and `radius` [m]; it touches with its whole surface.

    >>> ball(2.0, 0.1).mass
    2.0
    """
    m, r = positive_number("mass", mass), positive_number("radius", radius)
    return _body("ball", m, np.full(3, 0.4 * m * r * r), np.zeros((1, 3)), r)


def box(
    mass: float = 1.0, size: tuple[float, float, float] = (0.2, 0.2, 0.2), rounding: float = 0.0
) -> Robot:
    """Return a homogeneous box of `mass` [kg] and edge lengths `size` [m].

    It touches with its eight corners, which are spheres of radius `rounding` [m] inside the box.
    """
    m, edges = positive_number("mass", mass), finite_array("size", size, (3,))
    radius = real_number("rounding", rounding, low=0.0)
    if (edges <= 2.0 * radius).any():
        raise ProblemError(f"size must be above twice the rounding ({2.0 * radius:g}), got {edges.min():g}")
    squares = edges**2
    corners = (0.5 * edges - radius) * np.array(list(product((1.0, -1.0), repeat=3)))
    return _body("box", m, m / 12.0 * (squares.sum() - squares), corners, radius)


def falling_cat(half_mass: float = 1.0, half_inertia: float = 0.003, leg_mass: float = 0.4) -> Robot:
    """Return two halves on a twisting spine, each with two legs that slide out to either side.

    Joints: the twist of the rear half against the front one [rad], then the reach of the two front and
    the two rear legs [m]. The front half is the base; x runs along the spine. Legs that reach out
    alike keep the centre of mass on the spine and the spine a principal axis.

    Parameters
    ----------
    half_mass
        Of each half without legs [kg].
    half_inertia
        Of each half about the spine [kg m^2].
    leg_mass
        Of each leg, a ball of 1 cm radius [kg].
    """
    pinocchio = import_pinocchio()
    model: Any = pinocchio.Model()
    moments = np.array([half_inertia, 2.0 * half_inertia, 2.0 * half_inertia])
    half = pinocchio.Inertia(positive_number("half_mass", half_mass), np.zeros(3), np.diag(moments))
    leg = pinocchio.Inertia.FromSphere(positive_number("leg_mass", leg_mass), 0.01)
    here = pinocchio.SE3.Identity()
    front = model.addJoint(0, pinocchio.JointModelFreeFlyer(), here, "front")
    spine = pinocchio.SE3(np.eye(3), np.array([-0.2, 0.0, 0.0]))
    rear = model.addJoint(front, pinocchio.JointModelRX(), spine, "twist")
    for body, name in ((front, "front"), (rear, "rear")):
        model.appendBodyToJoint(body, half, here)
        for side, turn in (("left", 1.0), ("right", -1.0)):
            place = pinocchio.SE3(np.diag([1.0, turn, turn]), np.zeros(3))
            slide = model.addJoint(body, pinocchio.JointModelPY(), place, f"{name}_{side}")
            model.appendBodyToJoint(slide, leg, here)
    empty = pinocchio.GeometryModel()
    return Robot("cat", model, empty, empty, (), np.array(pinocchio.neutral(model)), True)


def _body(name: str, mass: float, moments: FloatArray, centres: FloatArray, radius: float) -> Robot:
    """Return a free body with the given contact spheres, standing on z = 0 in its nominal pose."""
    pinocchio = import_pinocchio()
    model: Any = pinocchio.Model()
    joint = model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), "root_joint")
    inertia = pinocchio.Inertia(mass, np.zeros(3), np.diag(moments))
    model.appendBodyToJoint(joint, inertia, pinocchio.SE3.Identity())
    frame = model.addBodyFrame(name, joint, pinocchio.SE3.Identity(), 0)
    nominal = np.array(pinocchio.neutral(model))
    nominal[2] = radius - centres[:, 2].min()
    empty = pinocchio.GeometryModel()
    body = Robot(name, model, empty, empty, (), nominal, True)
    body.feet = (Foot(name, frame, centres, radius),)
    return body
