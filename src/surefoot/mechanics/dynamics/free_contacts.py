"""Contacts of bodies that no joint ties together: each moves two of them at most, its Jacobian is two blocks.

With Y = J L⁻ᵀ of such blocks the Delassus operator G = Y Yᵀ has a block for every two contacts that share a
body, and no others: it is sparse, and so is Y.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import kernel
from surefoot.base.numerics.cholesky import solve_lower, solve_upper
from surefoot.base.numerics.rotations import rotation_of
from surefoot.contact import COMPILED_CONTACTS
from surefoot.mechanics.dynamics import arithmetic
from surefoot.mechanics.dynamics.detection import GroundBelow
from surefoot.mechanics.dynamics.pair_detection import PairDetection
from surefoot.mechanics.terrain import Terrain


@dataclass(frozen=True)
class BlockRows:
    """Rows (3k, nv) of contacts of free bodies; a sparse matrix where one is asked for.

    Attributes
    ----------
    bodies
        (k, 2) which two bodies each contact moves; -1 for what does not move.
    blocks
        (k, 2, 3, 6) its columns for either of them.
    nv
        Velocities of all bodies.
    """

    bodies: IntArray
    blocks: FloatArray
    nv: int

    @cached_property
    def matrix(self) -> Any:
        """The rows (3k, nv), sparse."""
        moved = self.bodies >= 0
        starts = np.concatenate([[0], np.cumsum(moved.sum(axis=1))])
        shape = 3 * len(self.bodies), self.nv
        return sp.bsr_matrix((self.blocks[moved], self.bodies[moved], starts), shape=shape)

    @property
    def T(self) -> Any:
        """Their transpose (nv, 3k), sparse."""
        return self.matrix.T


class FreeContacts(NamedTuple):
    """The p contacts of free bodies, in the place of `Contacts`.

    Attributes
    ----------
    gaps, positions, frames
        See `Contacts`.
    bodies
        (p, 2) the body that each contact is of, and the one it is on; -1 for what does not move, and for
        slots that are not in use.
    blocks
        (p, 2, 3, 6) maps from their velocities to the contact's, rows in contact axes.
    nv
        Velocities of all bodies.
    """

    gaps: FloatArray
    positions: FloatArray
    frames: FloatArray
    bodies: IntArray
    blocks: FloatArray
    nv: int

    @property
    def J(self) -> FloatArray:
        """The dense (3p, nv) map from v to the points' velocities, made when it is asked for."""
        return np.asarray(BlockRows(self.bodies, self.blocks, self.nv).matrix.toarray())

    def kept(self) -> FreeContacts:
        """Return the same in arrays of their own."""
        return self._replace(frames=self.frames.copy())

    def velocities(self, v: FloatArray) -> FloatArray:
        """Return the velocities (p, 3) of the points in contact axes for (nv,) v [m/s]."""
        return block_velocities(self.bodies, self.blocks, v)

    def effort(self, forces: FloatArray) -> FloatArray:
        """Return the generalised forces (nv,) [N, N m] of (p, 3) forces in contact axes [N]."""
        return np.asarray(BlockRows(self.bodies, self.blocks, self.nv).T @ forces.ravel())

    def near(self, v: FloatArray, free: FloatArray, dt: float, reach: float) -> IntArray:
        """Return the contacts that may touch within the step, see `arithmetic.near_ground`: (k,)."""
        # As `arithmetic.near_ground` does, for blocks.
        speed = np.minimum(self.velocities(v)[:, 2], self.velocities(free)[:, 2])
        return np.flatnonzero(self.gaps + dt * speed < reach)

    def swerves(
        self, v: FloatArray, leaving: FloatArray, last: FloatArray, foot: IntArray, least: float
    ) -> tuple[FloatArray, FloatArray] | None:
        """Return velocities (p, 3) [m/s] before impulses and the guess of how they turn, see `arithmetic`."""
        return arithmetic.turned(self.velocities(v), leaving, last, foot, self.frames, least)

    def assemble(
        self, L: FloatArray, v: FloatArray, free: FloatArray, gaps: FloatArray, near: IntArray, dt: float,
        pull: float, restitution: FloatArray | None = None, rest_speed: float = np.inf,
    ) -> tuple[Any, Any, FloatArray]:  # fmt: skip
        """Return rows (3k, nv), G [1/kg] and g [m/s] of the near contacts, see `Contacts.assemble`.

        `L` (bodies, 6, 6) are the factors of the bodies' own inertias. The rows are in blocks; of many
        contacts G is sparse.
        """
        g = self.velocities(free)[near]
        e = np.zeros(near.size) if restitution is None else restitution[near]
        before = self.velocities(v)[near, 2] if restitution is not None else np.zeros(near.size)
        g[:, 2] += arithmetic.normal_shifts(gaps[near], before, g[:, 2], dt, e, rest_speed, pull)[0]
        rows = BlockRows(self.bodies[near], weigh_blocks(self.bodies[near], self.blocks[near], L), self.nv)
        if near.size <= COMPILED_CONTACTS:
            return rows, square_blocks(rows.bodies, rows.blocks), g.ravel()
        return rows, rows.matrix @ rows.T, g.ravel()

    def factor(self, rows: BlockRows) -> Any:
        """Return the sparse rows (3k, nv) whose square G is."""
        return rows.matrix

    def apply(self, L: FloatArray, rows: BlockRows, impulses: FloatArray, free: FloatArray) -> FloatArray:
        """Return v⁺ = free + L⁻ᵀ Yᵀ λ, (nv,), after (k, 3) impulses, of the rows Y [N s]."""
        return push_blocks(rows.bodies, rows.blocks, L, impulses, free)


class FreeDetection(PairDetection):
    """Finds the contacts of bodies without joints between them; see `PairDetection` for the arguments.

    Attributes
    ----------
    turns, places
        (joints, 3, 3) and (joints, 3) of the bodies as of the last `at`; joint 0 does not move.
    """

    def _look(self, model: Any, terrain: Terrain) -> None:
        knots, count = self.points, model.njoints
        self._below = GroundBelow(terrain, knots.radii)
        self.turns, self.places = np.zeros((count, 3, 3)), np.zeros((count, 3))
        self.turns[0], self._nv = np.eye(3), model.nv

    def at(self, q: FloatArray) -> FreeContacts:  # type: ignore[override]
        """Return the contacts at (7 bodies,) q [m, -]; `frames` is a work array until the next call."""
        joints, pairs = self.points.joints, self.pairs
        place_bodies(q, self.turns[1:], self.places[1:])
        centres = self.places[joints] + np.einsum("pij,pj->pi", self.turns[joints], self.points.places)
        gaps, frames = self._below.below(centres)
        pairs.update_free(self.turns, self.places)
        gaps, positions, frames = self._together(gaps, self._below.nearest(centres), frames)
        ends = np.stack([pairs.second, pairs.first], axis=1)
        ends[~pairs.on] = 0
        bodies = np.concatenate([np.stack([joints, 0 * joints], axis=1), ends]) - 1
        blocks = body_blocks(bodies, positions, frames, self.turns[1:], self.places[1:])
        return FreeContacts(gaps, positions, frames, bodies, blocks, self._nv)

    def twists(self, q: FloatArray) -> FloatArray:
        """See `TerrainDetection.twists`: (6, nv)."""
        self.at(q)
        out, turns, places = np.zeros((6, self._nv)), self.turns[1:], self.places[1:]
        for k in range(3):
            out[:3, k::6] = out[3:, 3 + k :: 6] = turns[:, :, k].T
            out[:3, 3 + k :: 6] = np.cross(places, turns[:, :, k]).T
        return out


@kernel
def place_bodies(q: FloatArray, turns: FloatArray, places: FloatArray) -> None:
    """Write rotations (n, 3, 3) and places (n, 3) of free bodies at (7n,) q: place, (x, y, z, w)."""
    for b in range(places.shape[0]):
        rotation_of(q[7 * b : 7 * b + 7], turns[b])
        for k in range(3):
            places[b, k] = q[7 * b + k]


@kernel
def body_blocks(
    bodies: IntArray, points: FloatArray, frames: FloatArray, turns: FloatArray, places: FloatArray
) -> FloatArray:
    """Return the blocks (p, 2, 3, 6) of contacts: velocity of the first body's point against the second's.

    `bodies` (p, 2), `points` (p, 3) [m] and `frames` (p, 3, 3) are the contacts', `turns` (n, 3, 3) and
    `places` (n, 3) the bodies'. A body's point moves with R (v + ω x r) for its v and ω in its own axes.
    """
    out = np.zeros((bodies.shape[0], 2, 3, 6))
    r = np.empty(3)
    for c in range(bodies.shape[0]):
        for side in range(2):
            b = bodies[c, side]
            if b < 0:
                continue
            for k in range(3):  # the point in body axes
                r[k] = 0.0
                for i in range(3):
                    r[k] += turns[b, i, k] * (points[c, i] - places[b, i])
            block = out[c, side]
            for a in range(3):
                for k in range(3):  # contact axes by body axes
                    total = 0.0
                    for i in range(3):
                        total += frames[c, i, a] * turns[b, i, k]
                    block[a, k] = total if side == 0 else -total
                for k in range(3):  # row a of T times ω x r: (r x T_a) · ω
                    i, j = (k + 1) % 3, (k + 2) % 3
                    block[a, 3 + k] = r[i] * block[a, j] - r[j] * block[a, i]
    return out


@kernel
def block_velocities(bodies: IntArray, blocks: FloatArray, v: FloatArray) -> FloatArray:
    """Return the velocities (p, 3) [m/s] of contacts with blocks (p, 2, 3, 6) on bodies (p, 2) at v (6n,)."""
    out = np.zeros((bodies.shape[0], 3))
    for c in range(bodies.shape[0]):
        for side in range(2):
            b = bodies[c, side]
            # The ground and what is fixed are body -1, and do not move.
            if b >= 0:
                for a in range(3):
                    for k in range(6):
                        out[c, a] += blocks[c, side, a, k] * v[6 * b + k]
    return out


@kernel
def weigh_blocks(bodies: IntArray, blocks: FloatArray, L: FloatArray) -> FloatArray:
    """Return B L⁻ᵀ (k, 2, 3, 6) for blocks B (k, 2, 3, 6) on bodies (k, 2) with lower factors L (n, 6, 6)."""
    out = np.zeros(blocks.shape)
    for c in range(bodies.shape[0]):
        for side in range(2):
            b = bodies[c, side]
            if b >= 0:
                for a in range(3):
                    out[c, side, a] = blocks[c, side, a]
                    solve_lower(L[b], out[c, side, a])
    return out


@kernel
def square_blocks(bodies: IntArray, blocks: FloatArray) -> FloatArray:
    """Return Y Yᵀ (3k, 3k) of the rows Y that blocks (k, 2, 3, 6) on bodies (k, 2) are."""
    count = bodies.shape[0]
    out = np.zeros((3 * count, 3 * count))
    for c in range(count):
        for d in range(c + 1):
            for side in range(2):
                b = bodies[c, side]
                if b < 0:
                    continue
                for other in range(2):
                    if bodies[d, other] != b:
                        continue
                    for i in range(3):
                        for j in range(3 if d < c else i + 1):
                            total = 0.0
                            for k in range(6):
                                total += blocks[c, side, i, k] * blocks[d, other, j, k]
                            out[3 * c + i, 3 * d + j] += total
    for i in range(3 * count):
        for j in range(i):
            out[j, i] = out[i, j]
    return out


@kernel
def push_blocks(
    bodies: IntArray, blocks: FloatArray, L: FloatArray, impulses: FloatArray, free: FloatArray
) -> FloatArray:
    """Return free + L⁻ᵀ Yᵀ λ (6n,), see `weigh_blocks` and `square_blocks`; λ are impulses (k, 3) [N s]."""
    change = np.zeros((L.shape[0], 6))
    for c in range(bodies.shape[0]):
        for side in range(2):
            b = bodies[c, side]
            if b >= 0:
                for i in range(3):
                    for k in range(6):
                        change[b, k] += blocks[c, side, i, k] * impulses[c, i]
    out = free.copy()
    for b in range(L.shape[0]):
        solve_upper(L[b], change[b])
        for i in range(6):
            out[6 * b + i] += change[b, i]
    return out
