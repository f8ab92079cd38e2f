"""Contact Jacobians, their drift, and the power identity.

A contact is a point that a frame of the robot carries (`attach`). Its velocity can be written in four
ways, all linear in the robot's velocity, u = J(q) v:

==================== ======================== =========================== ============================
reference            velocity of              along the axes of           drift J̇ v
==================== ======================== =========================== ============================
local                the contact point        the body                    spatial acceleration
world                the body's point that    the world                   spatial acceleration
                     is at the world's origin
local_world_aligned  the contact point        the world                   classical acceleration
contact              the contact point        the contact frame           classical acceleration
==================== ======================== =========================== ============================

J̇ v is always the rate of change of the *components* of J v at v̇ = 0. Where the axes and the point do
not turn with the body, that is the classical acceleration of the point, p̈. In the two others it is the
spatial one: local components turn with the body, R ᵀ(p̈ - ω x ṗ), and the world's origin is reached by
ever new points of the body, p̈ + ṗ x ω + p x ω̇. They agree only for a contact that does not move.

References
----------
.. [1] R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, sections 2.10 to 2.11.
.. [2] J. Baumgarte, "Stabilization of constraints and integrals of motion in dynamical systems",
   Computer Methods in Applied Mechanics and Engineering 1, 1972.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, real_number
from surefoot.base.errors import ModelError, ProblemError, check_name, unknown_name
from surefoot.base.spatial import rotation_log
from surefoot.mechanics.robot.frames import frame_index
from surefoot.mechanics.robot.robot import Robot
from surefoot.mechanics.stance import Contact, Stance

Reference = Literal["contact", "local", "world", "local_world_aligned"]
REFERENCES: tuple[Reference, ...] = get_args(Reference)


@dataclass(frozen=True)
class Attachment:
    """A contact point that a frame of the robot carries, and where it was when it was attached.

    Attributes
    ----------
    name
        Name of the contact.
    frame
        Pinocchio's index of the frame that it is fixed to.
    offset
        (3,) the point in that frame [m].
    dim
        3 for a point, 6 for a sole.
    position, rotation_world_frame
        (3,) [m] and (3, 3): the point and that frame's axes when attached, the anchor of
        `contact_error`.
    rotation_world_contact
        (3, 3) axes of the surface.
    radius
        Radius of the sphere that touches here [m]; 0 for a flat foot or any other frame.
    """

    name: str
    frame: int
    offset: FloatArray
    dim: int
    position: FloatArray
    rotation_world_frame: FloatArray
    rotation_world_contact: FloatArray
    radius: float = 0.0


Contacts = Stance | Sequence[Attachment]
"""A stance (then the points are those at its positions for the given q) or points attached before."""


def attach(robot: Robot, q: ArrayLike, stance: Stance) -> tuple[Attachment, ...]:
    """Return the points of the robot that are at the contacts of a stance.

    Parameters
    ----------
    robot
        Each contact's name must be one of its frames (`Robot.stance` names them so; corners of a sole,
        "foot.0", belong to "foot") or a foot's short name.
    q
        (nq,) configuration [m, -, rad]; a hand on a wall is a contact like any other.
    stance
        Contacts in world axes.

    Raises
    ------
    ModelError
        If a contact is named like no frame of the robot.
    """
    import pinocchio

    pinocchio.framesForwardKinematics(robot.model, robot.data, robot.configuration(q))
    return tuple(_attach(robot, contact) for contact in stance)


def _attach(robot: Robot, contact: Contact) -> Attachment:
    frame = _frame_of(robot, contact.name)
    pose = robot.data.oMf[frame]
    radius = next((f.radius for f in robot.feet if f.frame == frame and not f.flat), 0.0)
    return Attachment(
        contact.name,
        frame,
        np.array(pose.actInv(contact.position)),
        contact.dim,
        contact.position.copy(),
        np.array(pose.rotation),
        contact.rotation_world_contact.copy(),
        radius,
    )


def _frame_of(robot: Robot, name: str) -> int:
    """Return the index of the frame that a contact's name stands for."""
    for foot in robot.feet:
        if foot.name == name:
            return foot.frame  # a sole may have a frame of its own
    for candidate in (name, name.rpartition(".")[0]):
        if candidate and robot.model.existFrame(candidate):
            return frame_index(robot.model, candidate)
    with contextlib.suppress(ModelError):
        return robot.foot(name).frame  # short names, "FL" for "FL_foot"
    raise ModelError(unknown_name(f"frame of {robot.name}", name, (f.name for f in robot.model.frames)))


def contact_jacobian(
    robot: Robot, q: ArrayLike, contacts: Contacts, reference: Reference = "contact"
) -> FloatArray:
    """Return the stacked contact Jacobian J with u = J v.

    Parameters
    ----------
    robot, q
        Robot and (nq,) configuration.
    contacts
        A stance, or what `attach` returned.
    reference
        See the table at the top of this module. Points have three rows (linear velocity), soles six
        [linear; angular].

    Returns
    -------
    FloatArray
        (sum of dims, nv), contacts in order [m/s, rad/s per unit of v].

    Raises
    ------
    ProblemError
        For an unknown reference.
    """
    import pinocchio

    check_name("reference", reference, REFERENCES)
    configuration = robot.configuration(q)
    points = attach_contacts(robot, configuration, contacts)
    pinocchio.computeJointJacobians(robot.model, robot.data, configuration)
    rows = [np.zeros((0, robot.model.nv))]
    for point in points:
        J = pinocchio.getFrameJacobian(
            robot.model, robot.data, *_carrier(robot, point), _kind(pinocchio, reference)
        )
        rows.append(_in_axes(np.array(J), point, reference)[: point.dim])
    return np.vstack(rows)


def contact_drift(
    robot: Robot,
    q: ArrayLike,
    v: ArrayLike,
    contacts: Contacts,
    reference: Reference = "contact",
    *,
    rolling: bool = False,
) -> FloatArray:
    """Return the drift J̇ v: the rate of change of J v at v̇ = 0.

    Parameters
    ----------
    robot, q, v
        Robot, (nq,) configuration and (nv,) velocity.
    contacts
        A stance, or what `attach` returned.
    reference
        See the table at the top of this module.
    rolling
        Count the contact of a sphere as the lowest point of the sphere, which new points of the body
        keep reaching, in place of one point of the body that is carried up and away: this leaves out
        the centripetal acceleration of the radius. Only where the axes do not turn with the body
        ("contact", "local_world_aligned").

    Returns
    -------
    FloatArray
        (sum of dims,) [m/s^2, rad/s^2].

    Raises
    ------
    ProblemError
        For an unknown reference, or rolling in axes that turn.
    """
    import pinocchio

    check_name("reference", reference, REFERENCES)
    if rolling and reference in ("local", "world"):
        raise ProblemError(f"rolling needs reference 'contact' or 'local_world_aligned', got {reference!r}")
    configuration = robot.configuration(q)
    velocity = finite_array("v", v, (robot.model.nv,))
    points = attach_contacts(robot, configuration, contacts)
    pinocchio.forwardKinematics(robot.model, robot.data, configuration, velocity, np.zeros(robot.model.nv))
    turning, kind = reference in ("local", "world"), _kind(pinocchio, reference)
    rate_of = pinocchio.getFrameAcceleration if turning else pinocchio.getFrameClassicalAcceleration
    out = [np.zeros(0)]
    for point in points:
        carried = _carrier(robot, point)
        rate = np.array(rate_of(robot.model, robot.data, *carried, kind).vector)
        if rolling and point.radius > 0.0:
            w = pinocchio.getFrameVelocity(robot.model, robot.data, *carried, kind).angular
            rate[:3] += point.radius * np.cross(w, np.cross(w, point.rotation_world_contact[:, 2]))
        out.append(_in_axes(rate[:, None], point, reference)[: point.dim, 0])
    return np.concatenate(out)


def contact_error(robot: Robot, q: ArrayLike, contacts: Sequence[Attachment]) -> FloatArray:
    """Return how far attached points have left their anchors, in contact axes.

    Its rate of change is J v at the anchor.

    Returns
    -------
    FloatArray
        (sum of dims,): displacement [m] of each contact and, for a sole, the rotation vector [rad].
    """
    import pinocchio

    pinocchio.framesForwardKinematics(robot.model, robot.data, robot.configuration(q))
    out = [np.zeros(0)]
    for point in contacts:
        pose = robot.data.oMf[point.frame]
        axes = point.rotation_world_contact.T
        out.append(axes @ (pose.act(point.offset) - point.position))
        if point.dim == 6:
            out.append(axes @ rotation_log(pose.rotation @ point.rotation_world_frame.T))
    return np.concatenate(out)


@dataclass(frozen=True)
class Baumgarte:
    """Gains that pull a contact constraint back: error'' + 2 ζ ω error' + ω² error = 0.

    Parameters
    ----------
    frequency
        ω [rad/s], >= 0. With an explicit time step dt keep ω dt well below 1.
    damping_ratio
        ζ, >= 0; 1 returns without overshoot.

    Examples
    --------
    >>> Baumgarte(20.0).gains
    (400.0, 40.0)
    """

    frequency: float = 0.0
    damping_ratio: float = 1.0

    def __post_init__(self) -> None:
        real_number("frequency", self.frequency, low=0.0)
        real_number("damping_ratio", self.damping_ratio, low=0.0)

    @property
    def gains(self) -> tuple[float, float]:
        """Gains (kp, kd) on the error [1/s^2] and on its rate [1/s]."""
        return self.frequency**2, 2.0 * self.damping_ratio * self.frequency

    def acceleration(self, velocity: FloatArray, error: FloatArray) -> FloatArray:
        """Return the acceleration J v̇ + J̇ v (m,) [m/s²] to ask for, from J v [m/s] and the error [m]."""
        kp, kd = self.gains
        return -kd * velocity - kp * error


def attach_contacts(robot: Robot, q: FloatArray, contacts: Contacts) -> Sequence[Attachment]:
    """Return a stance's contacts attached at a configuration (nq,) [m, -, rad], attached ones as they are."""
    return attach(robot, q, contacts) if isinstance(contacts, Stance) else contacts


def _carrier(robot: Robot, point: Attachment) -> tuple[int, Any]:
    """Return the joint that carries a point, and the point's place in it with the axes of its frame."""
    import pinocchio

    frame = robot.model.frames[point.frame]
    return int(frame.parentJoint), frame.placement * pinocchio.SE3(np.eye(3), point.offset)


def _kind(pinocchio: Any, reference: str) -> Any:
    """Return Pinocchio's name of a reference; contact axes are turned from the world's."""
    return getattr(pinocchio, reference.upper().replace("CONTACT", "LOCAL_WORLD_ALIGNED"))


def _in_axes(rows: FloatArray, point: Attachment, reference: str) -> FloatArray:
    """Turn six rows [linear; angular] from world axes to those of the contact, if it is the reference."""
    if reference != "contact":
        return rows
    axes = point.rotation_world_contact.T
    return np.vstack([axes @ rows[:3], axes @ rows[3:]])
