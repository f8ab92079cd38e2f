"""How contacts turn with the configuration: their velocities, generalised forces, gaps and frames."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.mechanics.dynamics.derivative.rate_kernels import centre_rates, force_rates, velocity_rates
from surefoot.mechanics.dynamics.detection import Contacts
from surefoot.mechanics.dynamics.pair_detection import PairDetection
from surefoot.mechanics.dynamics.stepper import Stepper
from surefoot.mechanics.robot import ContactPoints
from surefoot.mechanics.robot.contact_points import joint_support
from surefoot.mechanics.terrain import Terrain
from surefoot.mechanics.terrain.frames import frames_on

Shape = tuple[FloatArray, IntArray, BoolArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""The first arguments of `derivative_kernels.velocity_rates`."""
SPACING = 1e-5
"""Step of the central differences of a curved ground's normals and gaps [m]."""


def ground_turn(terrain: Terrain, contacts: Contacts, radii: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how the ground turns below contacts of radii (p,) [m], see `derivative_kernels`.

    Rates (2, p, 3, 3) of the frames along x and y [1/m], and (p, 3) of the gaps with the spheres' centres;
    by central differences where it is curved.
    """
    # Slopes of a plane's gap are its normal; terrains tell heights, not curvature, so curved ground is
    # differenced.
    frames = contacts.frames
    turns, slopes = np.zeros((2, *frames.shape)), frames[:, :, 2].copy()
    if terrain.planar or not len(frames):
        return turns, slopes
    centres = contacts.positions + radii[:, None] * frames[:, :, 2]
    for axis in range(2):
        aside = SPACING * np.eye(3)[axis]
        sides = centres + aside, centres - aside
        ends = [frames_on(terrain.normal(places[:, :2])) for places in sides]
        gaps = [terrain.gap(places) for places in sides]
        turns[axis] = (ends[0] - ends[1]) / (2.0 * SPACING)
        slopes[:, axis] = (gaps[0] - gaps[1]) / (2.0 * SPACING)
    return turns, slopes


class GroundRates:
    """Rates of the contacts of spheres with the ground, at one configuration.

    Parameters
    ----------
    stepper
        Whose contacts they are.
    points
        The spheres.
    first
        See `derivative_kernels.velocity_rates`.
    twists
        (nv, 6) of the configuration, see there.
    contacts
        Of the spheres.
    """

    def __init__(
        self, stepper: Stepper, points: ContactPoints, first: IntArray, twists: FloatArray, contacts: Contacts
    ) -> None:
        turns, self._slopes = ground_turn(stepper.terrain, contacts, points.radii)
        fixed = contacts.positions, points.radii, contacts.frames
        self._shape: Shape = twists, first, points.support, *fixed, turns

    def velocity(self, v: FloatArray) -> FloatArray:
        """Return the derivative (3p, nv) of the contact velocities J(q) v at fixed v (nv,)."""
        return velocity_rates(*self._shape, v)

    def force(self, impulses: FloatArray) -> FloatArray:
        """Return the derivative (nv, nv) of Jᵀ(q) λ at fixed impulses (p, 3) [N s]."""
        return force_rates(*self._shape, impulses)

    def _centres(self) -> FloatArray:
        """Return the rates of the spheres' centres with q: (p, 3, nv), world axes."""
        twists, _, support, positions, radii, frames, _ = self._shape
        return centre_rates(twists, support, positions, radii, frames)

    def gaps(self) -> FloatArray:
        """Return the derivative (p, nv) of the gaps [m]."""
        return np.asarray(np.einsum("ci,cik->ck", self._slopes, self._centres()))

    def frames(self, q: FloatArray) -> FloatArray:
        """Return the rates (p, 3, 3, c) of the contact frames with q (nv, c)."""
        moved = np.einsum("cik,kx->cix", self._centres()[:, :2], q)
        return np.asarray(np.einsum("dcia,cdx->ciax", self._shape[-1], moved))


class Side(NamedTuple):
    """One of the two bodies of k contacts: its sign in their velocities, and how it moves.

    `shape` are the first arguments of `derivative_kernels.velocity_rates` for contacts fixed to the body,
    `body` and `spin` (k, 3, nv) velocities of its points there and its angular velocities, world axes.
    """

    sign: float
    shape: Shape
    body: FloatArray
    spin: FloatArray


class PairRates(GroundRates):
    """Rates of contacts of a geometry: spheres on the ground, and pairs with a contact that is `near` (k,).

    Either body of a pair is taken by itself, with the contact fixed to it. What place and frame do beyond
    that is added: how the place moves against each body's point, δp - δb, and the turn φ of the frame::

        δu = ... + Rᵀ (Σ ± ω x (δp - δb) - φ x w),    δ(Jᵀλ) = ... + Σ ± (Bᵀ (φ x F) + Ωᵀ ((δp - δb) x F))
    """

    def __init__(
        self, stepper: Stepper, points: ContactPoints, first: IntArray, twists: FloatArray,
        contacts: Contacts, near: IntArray,
    ) -> None:  # fmt: skip
        ground, found = len(points), stepper.bodies.contacts
        assert isinstance(found, PairDetection)
        gaps, positions, frames = (a[:ground] for a in contacts[:3])
        below = Contacts(gaps, positions, frames, contacts.J[: 3 * ground])
        super().__init__(stepper, points, first, twists, below)
        pairs, group = found.pairs, found.group[ground:]
        slots = np.flatnonzero(pairs.on & np.isin(group, found.group[near]))
        self._J, self._near = contacts.J, ground + slots
        self._rows = (3 * self._near[:, None] + np.arange(3)).ravel()
        self._frames, places = contacts.frames[self._near], contacts.positions[self._near]
        support, none = joint_support(stepper.bodies.model), np.zeros(len(slots))
        self._sides = list[Side]()
        for sign, joints in ((-1.0, pairs.first[slots]), (1.0, pairs.second[slots])):
            moving = support[joints]
            fixed = places, none, self._frames
            shape = twists, first, moving, *fixed, np.zeros((2, *self._frames.shape))
            spin = np.where(moving[:, None], twists[:, 3:].T, 0.0)
            self._sides.append(Side(sign, shape, centre_rates(twists, moving, *fixed), spin))
        moves = np.concatenate([part for side in self._sides for part in side[2:]], axis=1)
        whole = pairs.rates(slots) @ moves
        self._place, turned, self._gaps = whole[:, :3], whole[:, 3:6], whole[:, 6]
        # the frame turns with its normal, and about it as `terrain.frames.surface_frames` says
        n, aside = self._frames[:, :, 2], self._frames[:, :, 1]
        heading = np.where(1.0 - n[:, 0] ** 2 >= 1e-12, 0, np.where(np.abs(n[:, 1]) <= np.abs(n[:, 2]), 1, 2))
        along = np.take_along_axis(n, heading[:, None], axis=1)
        about = -along / np.sqrt(1.0 - along**2) * np.einsum("ci,cik->ck", aside, turned)
        self._turn = np.cross(n[:, :, None], turned, axis=1) + n[:, :, None] * about[:, None]

    def velocity(self, v: FloatArray) -> FloatArray:
        """See `GroundRates.velocity`: (3p, nv)."""
        out = np.zeros(self._J.shape)
        ground = super().velocity(v)
        out[: len(ground)] = ground
        apart = self._sides[1].body @ v - self._sides[0].body @ v
        rates = np.cross(apart[:, :, None], self._turn, axis=1)
        for side in self._sides:
            out[self._rows] += side.sign * velocity_rates(*side.shape, v)
            rates += side.sign * np.cross((side.spin @ v)[:, :, None], self._place - side.body, axis=1)
        out[self._rows] += np.einsum("cia,cik->cak", self._frames, rates).reshape(-1, v.size)
        return out

    def force(self, impulses: FloatArray) -> FloatArray:
        """See `GroundRates.force`: (nv, nv)."""
        mine = np.ascontiguousarray(impulses[self._near])
        out = super().force(impulses)
        pushes = np.einsum("cia,ca->ci", self._frames, mine)[:, :, None]
        for side in self._sides:
            out += side.sign * force_rates(*side.shape, mine)
            rates = np.cross(self._turn, pushes, axis=1), np.cross(self._place - side.body, pushes, axis=1)
            for moves, rate in zip(side[2:], rates, strict=True):
                out += side.sign * moves.reshape(-1, len(out)).T @ rate.reshape(-1, len(out))
        return out

    def gaps(self) -> FloatArray:
        """See `GroundRates.gaps`: (p, nv)."""
        out, ground = np.zeros(self._J[2::3].shape), super().gaps()
        out[: len(ground)], out[self._near] = ground, self._gaps
        return out

    def frames(self, q: FloatArray) -> FloatArray:
        """See `GroundRates.frames`: (p, 3, 3, c)."""
        out, ground = np.zeros((len(self._J) // 3, 3, 3, q.shape[1])), super().frames(q)
        out[: len(ground)] = ground
        out[self._near] = np.cross((self._turn @ q)[:, :, None], self._frames[..., None], axis=1)
        return out
