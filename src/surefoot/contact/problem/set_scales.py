"""Scales of errors for contacts of any kind: the definitions of `scales`, from `ContactSet`; plain NumPy."""

from __future__ import annotations

import math

import numpy as np
import scipy.sparse as sp

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.contact.problem.scales import LENT, NOISE, REST, ROUNDING
from surefoot.contact.sets.contact_set import ContactSet


def block_sizes(s: ContactSet, matrix: FloatArray) -> FloatArray:
    """Return the (n, n) Frobenius norms of the blocks of G in the contacts' metric [m/s/N]."""
    G = s.lengths[:, None] * matrix * s.lengths[None, :]
    top = float(np.abs(G).max(initial=0.0))
    # over the largest entry, so that no square vanishes
    squares = (G / (top or 1.0)) ** 2
    starts = s.offsets[:-1]
    sums = np.add.reduceat(np.add.reduceat(squares, starts, axis=0), starts, axis=1)
    return np.asarray(top * np.sqrt(sums))


def parts_of(sizes: FloatArray, on: BoolArray, noise: float) -> IntArray:
    """Return the number (n,) of each contact's part: joined by blocks above `noise`, of those that are on."""
    own = np.sqrt(np.diagonal(sizes))
    joined = (sizes > noise * own[:, None] * own[None, :]) & on[:, None] & on[None, :]
    return np.asarray(
        sp.csgraph.connected_components(sp.csr_matrix(joined.astype(np.int64)), directed=False)[1],
        dtype=np.int64,
    )


def set_scales(s: ContactSet, G: FloatArray, g: FloatArray) -> FloatArray:
    """Return the rows of `contact.problem.scales` (4, n): w, s, trace of G_kk, and the energy of the part."""
    n, L = len(s), s.lengths
    scales = np.zeros((4, n))
    if n == 0:
        return scales
    sizes = block_sizes(s, G)
    for k in range(n):
        i = slice(s.offsets[k], s.offsets[k + 1])
        block = L[i, None] * G[i, i] * L[None, i]
        scales[0, k], scales[2, k] = np.linalg.norm(block, 2), np.trace(block)
    nearest = s.nearest_to_zero().ravel()
    u = G @ nearest + g
    noise = np.abs(G) @ nearest + np.abs(g)
    speeds = np.zeros(n)
    on = np.array([c.normal_max > 0.0 for c in s])
    for k, (own, size) in enumerate(zip(s.split(u), s.split(noise), strict=True)):
        # preloads that hold each other up to rounding leave no motion, see `scales._drop_noise`
        preload_only = nearest.any() and np.abs(own).sum() <= ROUNDING * u.size * size.sum()
        speed = 0.0 if preload_only or not on[k] else math.hypot(*(own * s[k].lengths))
        speeds[k] = speed if speed > REST else 0.0
    for level, share in ((NOISE, 1.0), (0.0, LENT)):
        label = parts_of(sizes, on, level)
        most = np.zeros(n)
        np.maximum.at(most, label, speeds)
        scales[1] = np.maximum(scales[1], np.where(on, share * most[label], 0.0))
        if level == NOISE:
            energy, w = np.zeros(n), scales[0]
            np.add.at(energy, label, np.where(w > 0.0, scales[1] ** 2 / np.where(w > 0.0, w, 1.0), 0.0))
            scales[3] = energy[label]
    return scales
