"""The robot of a log as its equations of motion need it: a tree, and what carries each contact point.

It is a robot that is given or named, or the model that a recording keeps (facts ``model_...``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.errors import SurefootError
from surefoot.mechanics import Robot
from surefoot.records.audit.model_changes import masses_changed
from surefoot.records.log import Log

WHIRL, BEYOND, FASTEST = 0.02, 1.2, 40.0
"""A joint that turns by so much within a row [rad], so many times as fast as its motor can, whirls; motors of
legs turn no faster than the last, whatever their model says [rad/s]."""


@dataclass(frozen=True, eq=False)
class LoggedRobot:
    """A floating robot of nv velocities, whose log has p contact points on n feet or other links.

    Attributes
    ----------
    name, model
        Its name, and Pinocchio's model: a free base, then joints.
    joint_names
        Of the joints behind the base.
    owner
        (p,) index of the foot of each contact point.
    support
        (p, nv) which velocity components move each contact point.
    is_foot
        (p,) whether each is on a foot, and on no other link that touched.
    """

    name: str
    model: Any
    joint_names: tuple[str, ...]
    owner: IntArray
    support: BoolArray
    is_foot: BoolArray

    @property
    def base_dof(self) -> int:
        """Velocity components of the base."""
        return 6

    @property
    def joints(self) -> int:
        """Number of joints behind the base."""
        return int(self.model.nv) - self.base_dof

    @property
    def mass(self) -> float:
        """Of all links [kg]."""
        return float(sum(inertia.mass for inertia in self.model.inertias))

    def whirls(self, v: FloatArray, dt: FloatArray | float) -> BoolArray:
        """Return in which rows of velocities (T, nv) a joint whirls: (T,).

        A limb that nothing drives, thrown in a fall, is elsewhere at the end of a row than at its start;
        which of the places on its way a step takes for its forces, nobody knows.
        """
        most = np.minimum(BEYOND * np.asarray(self.model.velocityLimit)[self.base_dof :], FASTEST)
        speed = np.abs(np.nan_to_num(np.asarray(v)[:, self.base_dof :]))
        return np.asarray((self._turned(v, dt) & (speed > most) & (most > 0.0)).any(axis=1))

    def turned(self, v: FloatArray, dt: FloatArray | float) -> BoolArray:
        """Return in which rows of velocities (T, nv) a joint goes far: (T,)."""
        return np.asarray(self._turned(v, dt).any(axis=1))

    def _turned(self, v: FloatArray, dt: FloatArray | float) -> BoolArray:
        speed = np.abs(np.nan_to_num(np.asarray(v)[:, self.base_dof :]))
        return np.asarray(speed * np.reshape(dt, (-1, 1)) > WHIRL)

    def leg(self, foot: int) -> BoolArray:
        """Return which velocity components move a foot: (nv,)."""
        return np.asarray(self.support[self.owner == foot].any(axis=0))


def from_robot(robot: Robot, log: Log, owner: IntArray) -> LoggedRobot | str:
    """Return a robot with a log's (p,) contact points on it, or why they are not its own.

    `owner` (p,) is the index of the foot of each. A recording's are matched by the names of feet, else by
    those of links; another log's are the robot's, in its order.
    """
    points = robot.contact_points
    if log.facts.get("kind") != "recording":
        support = points.support
    else:
        names, links = log.facts.get("feet", ()), log.facts.get("contact_body", ())
        rows = []
        for k, foot in enumerate(owner.tolist()):
            row = _support_of(robot, str(names[foot]), str(links[k]) if k < len(links) else "")
            if row is None:
                return f"the recording's {names[foot]} is no foot and no link of {robot.name}"
            rows.append(row)
        support = np.array(rows, dtype=bool).reshape(len(rows), int(robot.model.nv))
    support = np.asarray(support, dtype=bool)
    names = tuple(robot.joint_names)
    return LoggedRobot(robot.name, robot.model, names, owner, support, _feet_of(log, len(support)))


def _support_of(robot: Robot, foot: str, link: str) -> BoolArray | None:
    """Return which velocities (nv,) move a foot, else a link; None where the robot has neither."""
    try:
        at = robot.foot_names.index(robot.foot(foot).name)
    except SurefootError:
        joints = [int(f.parentJoint) for f in robot.model.frames if link and f.name == link]
        if not joints:
            return None
        return _moves(robot.model, joints[-1])  # a link's frame comes after that of a joint of its name
    return np.asarray(robot.contact_points.foot_support[at])


def _moves(model: Any, joint: int) -> BoolArray:
    """Return which velocities (nv,) move what hangs on a joint."""
    out = np.zeros(int(model.nv), dtype=bool)
    for k in model.supports[joint]:
        first = model.joints[k].idx_v
        if k:
            out[first : first + model.joints[k].nv] = True
    return out


NEEDED = (
    "model_bodies", "model_parents", "model_masses", "model_inertias", "model_centres", "model_inertia_axes",
    "model_positions", "model_orientations", "model_joint_bodies", "model_joint_axes", "model_joint_places",
    "model_joint_kinds", "contact_body",
)  # fmt: skip
"""Facts without which a recording's model cannot be built."""


def from_recording(log: Log, owner: IntArray) -> LoggedRobot | str:
    """Return the robot of the model that a recording keeps, or why it cannot be built.

    `owner` (p,) is the index of the foot of each contact point.
    """
    lacking = [name for name in NEEDED if name not in log.facts]
    if lacking:
        return f"the log does not keep its model ({lacking[0]})"
    if masses_changed(log):
        return "the loop changed masses of its model"
    kinds = [str(kind) for kind in log.fact("model_joint_kinds")]
    if kinds[:1] != ["free"] or not set(kinds[1:]) <= {"hinge", "slide"}:
        return "the robot has no free base with hinges and slides behind it"
    model, joint_of = build_model(log, kinds)
    places = {str(name): k for k, name in enumerate(log.fact("model_bodies"))}
    links = [places.get(str(name), 0) for name in log.fact("contact_body")]
    support = np.array([_moves(model, joint_of[link]) for link in links], dtype=bool)
    names = tuple(map(str, log.facts.get("joints", ())))
    name, feet = str(log.facts.get("robot", "")), _feet_of(log, len(links))
    return LoggedRobot(name, model, names, owner, support.reshape(-1, model.nv), feet)


def _feet_of(log: Log, points: int) -> BoolArray:
    """Return which contact points (p,) are on feet: all where the log says nothing of other links."""
    return np.asarray(log.facts.get("contact_is_foot", np.ones(points))).astype(bool)


def build_model(log: Log, kinds: list[str]) -> tuple[Any, list[int]]:
    """Return Pinocchio's model of the facts of a recording, and the joint that carries each link.

    MuJoCo turns a link about axes through places in its own axes, one after the other: each is a joint of its
    own here, and the link hangs on the last.
    """
    import pinocchio as pin

    fact = {name: log.fact(name) for name in NEEDED}
    axes, places = (np.asarray(fact[f"model_joint_{n}"]).reshape(-1, 3) for n in ("axes", "places"))
    owners = np.asarray(fact["model_joint_bodies"], dtype=int).tolist()
    ranges = np.asarray(log.facts.get("model_joint_ranges", np.tile([-np.inf, np.inf], (len(axes), 1))))
    model = pin.Model()
    joint_of, offset = list[int](), list[Any]()
    for body, parent in enumerate(np.asarray(fact["model_parents"], dtype=int).tolist()):
        if body == 0:
            joint = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root")
            off = pin.SE3.Identity()
        else:
            joint = joint_of[parent]
            off = offset[parent] * _placement(fact["model_orientations"][body], fact["model_positions"][body])
        for k in (k for k, owner in enumerate(owners) if owner == body):
            hinge = kinds[1 + k] == "hinge"
            kind = pin.JointModelRevoluteUnaligned if hinge else pin.JointModelPrismaticUnaligned
            low, high = np.clip(ranges[k], -1e300, 1e300)
            big = np.array([1e300])
            shift = pin.SE3(np.eye(3), places[k])
            joint = model.addJoint(
                joint, kind(*axes[k]), off * shift, f"{body}:{k}", big, big, np.array([low]), np.array([high])
            )
            off = shift.inverse()
        inertia = _placement(fact["model_inertia_axes"][body], fact["model_centres"][body])
        mass, moments = float(fact["model_masses"][body]), np.diag(fact["model_inertias"][body])
        own = pin.Inertia(mass, np.zeros(3), moments)
        model.appendBodyToJoint(joint, own, off * inertia)
        joint_of.append(int(joint))
        offset.append(off)
    return model, joint_of


def _placement(quaternion: Any, position: Any) -> Any:
    """Return the placement of a quaternion w, x, y, z and a position (3,) [m]."""
    import pinocchio as pin

    w, x, y, z = np.asarray(quaternion, dtype=np.float64)
    return pin.SE3(pin.Quaternion(w, x, y, z).normalized().matrix(), np.asarray(position, dtype=np.float64))
