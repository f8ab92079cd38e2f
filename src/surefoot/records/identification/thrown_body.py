"""What is thrown: links, joints and shapes of a URDF or MJCF file, or a cube, and what of it can be fitted.

Of each link the centre of mass and the spread of its mass along each axis are fitted, the square roots of the
diagonal of Σ = ½ tr(I) 1 - I, over the mass. Stretching a distribution of mass leaves one: whatever is found,
the pseudo-inertia [1]_ stays positive definite. Contacts tell ratios of masses alone. Hinges may give.

References
----------
.. [1] P. M. Wensing, S. Kim, J.-J. E. Slotine, "Linear matrix inequalities for physically consistent inertial
   parameter identification", IEEE RA-L 2018.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Box, Robot, Solid, fitted, load_robot
from surefoot.records.identification.thrown_body_bending import BentBody, bend
from surefoot.records.identification.thrown_body_tree import FallingBody
from surefoot.records.identification.tosses import Cube

AXES = "xyz"
SOFTEST = 0.1
"""Turn across a hinge under the body's own weight that is tried at most [rad]."""


@dataclass(frozen=True)
class TossParameter:
    """A number that can be fitted: where the search begins, a step that shows, its range and its unit."""

    name: str
    start: float
    step: float
    low: float
    high: float
    unit: str = ""


@dataclass(frozen=True, eq=False)
class ThrownBody:
    """A free or jointed body.

    Attributes
    ----------
    tree
        Its links, and the corners of its shapes as spheres.
    inward
        (k, 3) where a corner goes, in the link's axes, for each metre that it is rounded by.
    solids
        Its shapes; link i is joint i + 1.
    joints
        Names of the joints.
    scale
        What the shapes' lengths are multiplied by.
    compliance
        (n,) of the hinge that each link hangs on, across its axis [rad/(N m)], see `thrown_body_bending`.
    """

    tree: FallingBody
    inward: FloatArray
    solids: tuple[Solid, ...]
    compliance: FloatArray
    joints: tuple[str, ...] = ()
    scale: float = 1.0

    @property
    def width(self) -> float:
        """Longest extent of a shape along its own axes [m]."""
        return float(max(2.0 * (s.shape.core.max() + s.shape.radius) for s in self.solids))

    @property
    def arm(self) -> float:
        """Length [m] that makes the angle of a turn the root mean square way of the corners."""
        return float(np.sqrt(2.0 / 3.0 * np.mean(np.sum(self.tree.points**2, axis=1))))

    def rounded(self, radius: float) -> FallingBody:
        """Return the links with sharp edges and corners rounded to a radius [m]."""
        sharp = np.any(self.inward != 0.0, axis=1)
        points, radii = self.tree.points + radius * self.inward, self.tree.radii + radius * sharp
        return self.tree._replace(points=points, radii=radii)

    def bend_hinges(self, radius: float = 0.0) -> BentBody:
        """Return the links with edges rounded to a radius [m], and hinges that give."""
        return bend(self.rounded(radius), self.compliance)

    @property
    def parameters(self) -> tuple[TossParameter, ...]:
        """What can be fitted of it; the first link is called after nothing, others after their joints."""
        out = [TossParameter("scale", 1.0, 2e-3, 0.8, 1.25)]
        reach, tree = 0.3 * self.width, self.tree
        for i, end in enumerate(self._ends):
            for k, axis in enumerate(AXES):
                c = float(tree.centres[i, k])
                out.append(TossParameter(f"com_{axis}{end}", c, 3e-4, c - reach, c + reach, "m"))
            for axis, r in zip(AXES, _spreads(tree, i)[0].tolist(), strict=True):
                out.append(TossParameter(f"spread_{axis}{end}", r, 0.03 * r, 0.3 * r, 3.0 * r, "m"))
            if i > 0:
                m = float(tree.masses[i])
                out.append(TossParameter(f"mass{end}", m, 0.02 * m, 0.2 * m, 5.0 * m, "kg"))
                out.append(TossParameter(f"friction{end}", 0.0, 5e-4, 0.0, 1.0, "N m"))
                out.append(TossParameter(f"damping{end}", 0.0, 5e-5, 0.0, 1.0, "N m s"))
            if i > 0 and not tree.sliding[i]:
                # in turns under the body's own weight at the end of an arm as long as it is wide
                turn = 1.0 / (GRAVITY * self.width * float(tree.masses.sum()))
                ends = 0.0, SOFTEST * turn
                out.append(TossParameter(f"compliance{end}", 0.0, 5e-4 * turn, *ends, "rad/(N m)"))
        return tuple(out)

    def at(self, values: Mapping[str, float]) -> ThrownBody:
        """Return the body with some of its parameters, by name, at these values."""
        tree, scale = self.tree, values.get("scale", 1.0)
        centres, inertias = tree.centres.copy(), tree.inertias.copy()
        masses, friction, damping = tree.masses.copy(), tree.friction.copy(), tree.damping.copy()
        compliance = self.compliance.copy()
        for i, end in enumerate(self._ends):
            spreads, sigma = _spreads(tree, i)
            wanted = [values.get(f"spread_{a}{end}", s) for a, s in zip(AXES, spreads, strict=True)]
            stretch = np.asarray(wanted) / spreads
            masses[i] = values.get(f"mass{end}", masses[i])
            sigma = masses[i] * sigma * np.outer(stretch, stretch)
            inertias[i] = np.trace(sigma) * np.eye(3) - sigma
            centres[i] = [values.get(f"com_{a}{end}", c) for a, c in zip(AXES, centres[i], strict=True)]
            friction[i] = values.get(f"friction{end}", friction[i])
            damping[i] = values.get(f"damping{end}", damping[i])
            compliance[i] = values.get(f"compliance{end}", compliance[i])
        tree = tree._replace(
            points=scale * tree.points, radii=scale * tree.radii, places=scale * tree.places, masses=masses,
            centres=centres, inertias=inertias, friction=friction, damping=damping,
        )  # fmt: skip
        return replace(self, tree=tree, scale=scale, compliance=compliance)

    @property
    def _ends(self) -> tuple[str, ...]:
        return ("", *(f"_{name}" for name in self.joints))


def _spreads(tree: FallingBody, link: int) -> tuple[FloatArray, FloatArray]:
    """Return the spreads (3,) of a link's mass [m], and Σ / m (3, 3) [m²]."""
    inertia = tree.inertias[link]
    sigma = (0.5 * np.trace(inertia) * np.eye(3) - inertia) / tree.masses[link]
    if not np.linalg.eigvalsh(sigma)[0] > 0.0:
        raise ProblemError(f"no distribution of mass has the inertia of link {link}: {np.diag(inertia)}")
    return np.sqrt(np.diag(sigma)), sigma


def cube_body(cube: Cube) -> ThrownBody:
    """Return a cube as a body."""
    edge = cube.width
    return _body((Solid("cube", Box((edge, edge, edge)), 1),), FallingBody(
        np.array([-1]), np.eye(3)[None].copy(), np.zeros((1, 3)), np.zeros((1, 3)), np.zeros(1, dtype=bool),
        np.array([cube.mass]), np.zeros((1, 3)), cube.inertia * np.eye(3)[None], np.zeros(1),
        np.zeros(1), np.zeros(1), np.zeros(0, dtype=np.int64), np.zeros((0, 3)), np.zeros(0),
    ), {})  # fmt: skip


def thrown_body(model: Robot | str | Path) -> ThrownBody:
    """Return the body of a model: its first joint is free, the others turn about or slide along an axis.

    Boxes, spheres and capsules are taken as they are, meshes by the corners of their hull, other shapes by
    the box or capsule that fits best.

    Raises
    ------
    ProblemError
        If a joint is of another kind, or nothing has a shape.
    """
    robot = model if isinstance(model, Robot) else load_robot(model)
    free, *joints = list(robot.model.joints)[1:]
    if free.nv != 6 or any(joint.nv != 1 for joint in joints):
        raise ProblemError(f"{robot.name}: a thrown body has a free base, and hinges and slides for joints")
    count = 1 + len(joints)
    turns, places, axes = np.zeros((count, 3, 3)), np.zeros((count, 3)), np.zeros((count, 3))
    sliding = np.zeros(count, dtype=bool)
    turns[0] = np.eye(3)
    for i, joint in enumerate(joints, start=1):
        place, motion = robot.model.jointPlacements[i + 1], _motion(joint)
        turns[i], places[i] = place.rotation, place.translation
        sliding[i] = not motion[3:].any()
        axes[i] = motion[:3] if sliding[i] else motion[3:]
    inertias = list(robot.model.inertias)[1:]
    solids: list[Solid] = []
    hulls: dict[int, FloatArray] = {}
    for item in robot.collision.geometryObjects:
        made, place = fitted(item.geometry), item.placement
        if made is None or item.parentJoint == 0:
            continue
        rotation, position = place.rotation @ made[1], place.rotation @ made[2] + place.translation
        points = _vertices(item.geometry)
        if points is not None:
            hulls[len(solids)] = points @ place.rotation.T + place.translation
        solids.append(Solid(item.name, made[0], int(item.parentJoint), rotation, position))
    if not solids:
        raise ProblemError(f"{robot.name}: nothing of it has a shape that could touch the ground")
    parents = np.array([int(p) - 1 for p in list(robot.model.parents)[1:]])
    return _body(tuple(solids), FallingBody(
        parents, turns, places, axes, sliding, np.array([m.mass for m in inertias]),
        np.array([m.lever for m in inertias]), np.array([m.inertia for m in inertias]), np.zeros(count),
        np.zeros(count), np.zeros(count), np.zeros(0, dtype=np.int64), np.zeros((0, 3)), np.zeros(0),
    ), hulls, tuple(list(robot.model.names)[2:]))  # fmt: skip


def _motion(joint: Any) -> FloatArray:
    """Return the twist (6,) of a joint at unit rate, in its own axes."""
    data = joint.createData()
    joint.calc(data, np.array([1.0, 0.0]) if joint.nq == 2 else np.zeros(joint.nq))
    return np.asarray(data.S, dtype=np.float64).ravel().round(12)


def _vertices(geometry: Any) -> FloatArray | None:
    """Return the corners (n, 3) of a mesh's hull; None for what is no mesh."""
    from scipy.spatial import ConvexHull

    if not type(geometry).__name__.startswith(("BVHModel", "Convex")):
        return None
    count = geometry.num_vertices if hasattr(geometry, "num_vertices") else geometry.num_points
    vertex = geometry.vertex if hasattr(geometry, "vertex") else geometry.point
    points = np.array([vertex(k) for k in range(count)], dtype=np.float64)
    return np.asarray(points[ConvexHull(points).vertices])


def _body(
    solids: tuple[Solid, ...], tree: FallingBody, hulls: Mapping[int, FloatArray],
    joints: tuple[str, ...] = (),
) -> ThrownBody:  # fmt: skip
    """Return a body with the corners of its shapes, or of hulls (n, 3) by the number of the shape."""
    links, points, radii, inward = [], [], [], []
    for number, solid in enumerate(solids):
        shape = solid.shape
        places = hulls.get(number, shape.knots() @ solid.rotation.T + solid.position)
        away = (solid.position - places) @ solid.rotation
        corner = np.sign(away) if number not in hulls else away * np.sqrt(3.0) / np.linalg.norm(
            away, axis=1, keepdims=True
        )  # fmt: skip
        radius = 0.0 if number in hulls else shape.radius
        points.append(places)
        inward.append((corner if radius == 0.0 else 0.0 * corner) @ solid.rotation.T)
        links.append(np.full(len(places), solid.joint - 1, dtype=np.int64))
        radii.append(np.full(len(places), radius))
    tree = tree._replace(
        links=np.concatenate(links), points=np.concatenate(points), radii=np.concatenate(radii)
    )
    return ThrownBody(tree, np.concatenate(inward), solids, np.zeros(tree.masses.size), joints)
