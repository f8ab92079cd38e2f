"""Views of MuJoCo's data, and what the ground did to a robot's feet, read of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import entry_point
from surefoot.mechanics import Robot, Terrain, surface_frames
from surefoot.worlds.interface.world import ContactReading
from surefoot.worlds.mujoco.links import LinkContacts, generalised_force, owners
from surefoot.worlds.mujoco.readings import FACE_TYPES, LEAST_FORCE, OWN_TYPES, face_principal, read_contacts


class DataViews(NamedTuple):
    """Arrays of MuJoCo's data, which each of its steps fills anew; its own order, axes and quaternions.

    Attributes
    ----------
    qpos, qvel
        (nq,) [m, -, rad] and (nv,) [m/s, rad/s].
    effort
        (joints,) of qfrc_applied [N m].
    push
        (3,) force on the base's body [N].
    places, twists, centres
        geom_xpos (geoms, 3) [m], cvel (bodies, 6) [angular; linear], and subtree_com (bodies, 3) [m].
    contact
        MuJoCo's list of contacts.
    """

    qpos: FloatArray
    qvel: FloatArray
    effort: FloatArray
    push: FloatArray
    places: FloatArray
    twists: FloatArray
    centres: FloatArray
    contact: Any

    @classmethod
    def of(cls, data: Any, base_dof: int, base_body: int) -> DataViews:
        """Return the views of an MjData for a robot whose joints follow `base_dof` velocities."""
        return cls(
            data.qpos, data.qvel, data.qfrc_applied[base_dof:], data.xfrc_applied[base_body, :3],
            data.geom_xpos, data.cvel, data.subtree_com, data.contact,
        )  # fmt: skip


class FootGeoms(NamedTuple):
    """The spheres of a robot's feet in a MuJoCo model.

    Attributes
    ----------
    geoms, bodies
        (p,) numbers of the spheres and of their bodies, along the tree.
    owner
        (geoms,) number of a foot's sphere, -1 for the ground, -2 for anything else.
    spheres
        (p, 3) geom, body, and root of the body's tree.
    sizes
        (p, 2) radius, and the offset of plane ground along its normal [m].
    frames
        (p, 3, 3) of the terrain at its origin, world axes.
    """

    geoms: IntArray
    bodies: IntArray
    owner: IntArray
    spheres: IntArray
    sizes: FloatArray
    frames: FloatArray

    @classmethod
    def of(
        cls, model: Any, feet: IntArray, floors: Sequence[int], radii: FloatArray, terrain: Terrain
    ) -> FootGeoms:
        """Return (p,) feet of a model with radii [m], on a terrain whose geoms are the floors."""
        frames = np.array([terrain.frame([0.0, 0.0])] * len(feet)).reshape(-1, 3, 3)
        offset = float(frames[0, 2, 2] * terrain.height([0.0, 0.0])) if len(feet) else 0.0
        bodies = np.array(model.geom_bodyid)[feet]
        roots = np.array(model.body_rootid)[bodies]
        return cls(
            feet, bodies, owners(model.ngeom, feet, list(floors)),
            np.stack([feet, bodies, roots], axis=1).astype(np.int64),
            np.stack([radii, np.full(len(feet), offset)], axis=1), frames,
        )  # fmt: skip


class FootReading(NamedTuple):
    """What touched in a step of MuJoCo.

    Attributes
    ----------
    contacts
        At the feet's spheres.
    beside
        Whether any contact but those of feet with the ground pushed.
    """

    contacts: ContactReading
    beside: bool


class FootReader:
    """Reads what the ground did in MuJoCo's last step.

    Parameters
    ----------
    mujoco, model, data
        The module, and MuJoCo's own.
    robot, terrain
        Of the model.
    feet, floors
        (p,) geoms of the feet, and the ground's geoms.
    views
        Of the data.
    links
        Whether other links may touch.

    Attributes
    ----------
    feet
        The spheres of the feet.
    ahead
        How long after MuJoCo's places the gaps of contacts that press are, by their velocities [s]: exact
        impulses are tied to the gaps at a step's end, as its velocities are.
    """

    ahead = 0.0

    def __init__(
        self, mujoco: Any, model: Any, data: Any, robot: Robot, terrain: Terrain, feet: IntArray,
        floors: Sequence[int], views: DataViews, links: bool,
    ) -> None:  # fmt: skip
        self.feet = own = FootGeoms.of(model, feet, floors, robot.contact_points.radii, terrain)
        stops = bool(np.any(model.jnt_limited))
        self._links = LinkContacts(mujoco, model, own.owner) if links or stops else None
        self._mujoco, self._model, self._data = mujoco, model, data
        self._views, self._terrain = views, terrain
        self._planar = bool(terrain.planar)
        self._normals = np.ascontiguousarray(own.frames[:, :, 2])  # all that a plane needs, with its offset
        self._read = entry_point(read_contacts, *OWN_TYPES)
        self._face = entry_point(face_principal, *FACE_TYPES)

    def read(self, before: ContactReading | None = None) -> FootReading:
        """Return what the ground did.

        The ground that was near in the step `before`, a part of a millisecond ago, is near still.
        """
        feet, views, data, links = self.feet, self._views, self._data, self._links
        contact, frames, normals = views.contact, feet.frames, self._normals
        points, gaps = np.zeros((3, len(feet.geoms), 3)), np.zeros(len(feet.geoms))
        missed = np.zeros((len(feet.geoms), 3))
        forces, velocities, positions = points
        over = None
        if not self._planar:
            over = self._nearest(before)
            self._face(
                *over, contact.geom, contact.efc_address, contact.frame, contact.dist, data.efc_force,
                feet.owner, before is not None,
            )  # fmt: skip
            frames = np.empty_like(frames)
            surface_frames(over[1], frames)
        beside = bool(self._read(
            views.places, views.twists, views.centres, contact.geom, contact.efc_address, contact.frame,
            data.efc_force, feet.owner, feet.spheres, feet.sizes, frames, gaps, points, missed,
        ))  # fmt: skip
        if over is not None:
            gaps, normals = over
        if self.ahead:
            gaps += np.where(forces[:, 2] > 0.0, self.ahead * velocities[:, 2], 0.0)
        others = None
        if links is not None:
            # joints at their stops count, too
            others = links.force(data, frames) if beside or data.nl else np.zeros(self._model.nv)
            if np.abs(missed).max(initial=0.0) > LEAST_FORCE:
                places = np.asarray(views.places[feet.geoms])  # through which facets push
                others += generalised_force(self._mujoco, self._model, data, feet.bodies, places, missed)
        return FootReading(ContactReading(forces, gaps, velocities, positions, others, normals), beside)

    def _nearest(self, before: ContactReading | None) -> tuple[FloatArray, FloatArray]:
        """Return gaps (p,) [m] and normals (p, 3) of curved ground at the spheres, to be changed."""
        if before is not None and before.normals is not None:
            return before.gaps.copy(), before.normals.copy()
        distances, faces = self._terrain.nearest(self._views.places[self.feet.geoms])
        return distances - self.feet.sizes[:, 0], faces

    def touching(self) -> list[tuple[str, str]]:
        """Return the names of links, feet or ground that touched in MuJoCo's last step.

        Without feet on the ground.
        """
        return [] if self._links is None else self._links.names(self._data, self._model)
