"""What forces leave of what is needed, and the bound that a certificate proves, apart from the solver."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel
from surefoot.records.certificates.contact_cones import Contacts


@inline_kernel
def left_over(contacts: Contacts, count: int, b: FloatArray, forces: FloatArray) -> float:
    """Return the size of what (count, 3) contact forces leave of the (6,) wrench [m g]."""
    total = 0.0
    for i in range(6):
        left = b[i]
        for c in range(count):
            first = 2 if contacts.mu[c] <= 0.0 else 0
            for a in range(first, 3):
                left -= contacts.maps[c, a, i] * forces[c, a]
        total += left * left
    size: float = np.sqrt(total)
    return size


@inline_kernel
def proven_bound(contacts: Contacts, count: int, d: int, b: FloatArray, r: FloatArray) -> float:
    """Move (d,) r into the polar of all cones, but for rounding, and return r.b / |r| [m g].

    A push down takes what is left over from every contact on ground that is not a wall; what a contact on a
    wall, or a ray of torque, still has makes the bound worthless, which is what it returns: 0.
    """
    push = 0.0
    for c in range(count):
        over = largest_product(contacts, c, d, r)
        down = contacts.frames[c, 2, 2] if contacts.maps[c, 2, 2] != 0.0 else 0.0
        side = 0.0
        if contacts.mu[c] > 0.0:
            side = contacts.mu[c] * np.hypot(contacts.frames[c, 2, 0], contacts.frames[c, 2, 1])
        if over > 0.0:
            if down - side > 0.05:
                push = max(push, 1.000001 * over / (down - side))
            elif contacts.maps[c, 2, 2] == 0.0:  # a ray of torque: take what is over from its own entry
                for i in range(6, d):
                    r[i] -= over * contacts.maps[c, 2, i]
            else:
                return 0.0
    r[2] -= push
    size, product = 0.0, 0.0
    for i in range(d):
        size += r[i] * r[i]
        product += r[i] * b[i]
    for c in range(count):
        if largest_product(contacts, c, d, r) > 1e-9 * np.sqrt(size):
            return 0.0
    return max(product / np.sqrt(size), 0.0) if size > 0.0 else 0.0


@inline_kernel
def largest_product(contacts: Contacts, c: int, d: int, r: FloatArray) -> float:
    """Return the largest product of (d,) r with the forces of a cone per newton along its axis."""
    u0, u1, u2 = 0.0, 0.0, 0.0
    for i in range(d):
        u2 += contacts.maps[c, 2, i] * r[i]
    if contacts.mu[c] <= 0.0:
        return u2
    for i in range(d):
        u0 += contacts.maps[c, 0, i] * r[i]
        u1 += contacts.maps[c, 1, i] * r[i]
    most: float = u2 + contacts.mu[c] * np.hypot(u0, u1)
    return most
