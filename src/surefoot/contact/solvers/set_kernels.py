"""Contacts of any kind in compiled code: projection, generalised Jacobian, De Saxcé shift, natural map.

A problem's contacts are packed into three arrays, in scaled variables where moments are counted over their
lengths: `offset` (n + 1,), `group` (m,) with the disc of each row (-1 for the normal one), `table` (n, WIDTH)
with what the columns below name. Kernels dispatch on its first column.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.laws import Law
from surefoot.contact.sets import ContactSet
from surefoot.contact.sets.contact import APPROACH
from surefoot.contact.solvers.pyramid_projection import project_any, sector, shift_any

DISCS, CONE, FREE = 0, 1, 2
"""Codes: a section of discs, a cone or pyramid of three rows, any force."""
CODE, LOW, HIGH, SHIFT, MU, SIDES, INNER, RADIUS, FRICTION, NORM = 0, 1, 2, 3, 4, 5, 6, 7, 11, 15
"""Columns: the code, normal bounds, θ of the law, a cone's mu, sides (0 for a round one) and fit, radii of up
to four discs, whether each is friction, and room for the norms of their rows."""
MOST_DISCS, WIDEST, WIDTH = 4, 6, 19
"""Discs of a section and rows of a contact, at most; columns of the table."""
Packing = tuple[IntArray, IntArray, FloatArray]
"""offset, group and table."""


def pack(contacts: ContactSet, law: Law, unit: FloatArray) -> Packing:
    """Return offset, group and table, the bounds over the (n,) unit of each contact's force."""
    group = np.full(contacts.rows, -1, dtype=np.int64)
    table = np.zeros((len(contacts), WIDTH))
    for k, contact in enumerate(contacts):
        row, start = table[k], contacts.offsets[k]
        row[LOW], row[HIGH] = contact.normal_min / unit[k], contact.normal_max / unit[k]
        row[MU], row[SHIFT] = contact.coefficient, law.shift_at(contact.coefficient)
        row[CODE] = FREE if contact.bilateral else DISCS if contact.short_form is None else CONE
        if contact.polygon is not None:
            row[SIDES], row[INNER] = contact.polygon
        for b, disc in enumerate(contact.factors):
            group[start + np.array(disc.rows)] = b
            row[RADIUS + b], row[FRICTION + b] = disc.radius, disc.friction
    return contacts.offsets, group, table


@kernel
def pack_cones(
    vectors: FloatArray, scales: FloatArray, shift: float, sides: int, inner: bool, D: FloatArray,
    offset: IntArray, group: IntArray, table: FloatArray, measure: FloatArray,
) -> None:  # fmt: skip
    """Do for a problem's short form what `pack`, `scaled.scaling` and `scaled.measure_of` do for any.

    The vectors (2, 3n) and scales (4, n) are those of `ContactProblem`. Filled: the scale D (3n,) of each
    row, offset (n + 1,), group (3n,), table (n, WIDTH), and the step and weight of `natural_sets`, measure
    (2, n).
    """
    n = table.shape[0]
    top = 0.0
    for k in range(n):
        top = max(top, scales[2, k] / 3.0)
    offset[0] = 0
    for k in range(n):
        mu, low, high = vectors[1, k], vectors[1, n + k], vectors[1, 2 * n + k]
        w, s = scales[0, k], scales[1, k]
        # blocks of trace 3
        trace = scales[2, k] / 3.0
        # a block that all but vanishes beside the largest would get a
        # unit without bounds: it takes that one's
        if not trace > 1e-12 * top:
            trace = top if top > 0.0 else 1.0
        unit = 1.0 / math.sqrt(trace)
        D[3 * k] = D[3 * k + 1] = D[3 * k + 2] = unit
        offset[k + 1] = 3 * k + 3
        group[3 * k] = group[3 * k + 1] = 0 if sides == 0 else -1
        group[3 * k + 2] = -1
        table[k, CODE] = FREE if low == -np.inf else CONE
        table[k, LOW], table[k, HIGH], table[k, SHIFT] = low / unit, high / unit, shift
        table[k, MU], table[k, SIDES], table[k, INNER] = mu, sides, 1.0 if inner else 0.0
        table[k, RADIUS], table[k, FRICTION] = mu, 1.0
        if not w > 0.0:
            w = s if s > 0.0 else 1.0
        # λ = unit λ' and u' = unit u: 1 / w becomes 1 / (w unit²), and a gap in λ' is w unit / s
        # times a velocity over s. A part that no velocity moves (s = 0) weighs nothing: its
        # forces are known, see `stopping.settle`
        measure[0, k], measure[1, k] = 1.0 / (w * unit * unit), w * unit / s if s > 0.0 else 0.0


@inline_kernel
def _norms(group: IntArray, start: int, end: int, x: FloatArray, row: FloatArray) -> int:
    """Fill the norms of a contact's discs' rows of x; return its normal row, -1 for none."""
    normal = -1
    for b in range(NORM, NORM + MOST_DISCS):
        row[b] = 0.0
    for i in range(start, end):
        if group[i] < 0:
            normal = i
        else:
            row[NORM + group[i]] += x[i] * x[i]
    for b in range(NORM, NORM + MOST_DISCS):
        row[b] = math.sqrt(row[b])
    return normal


@inline_kernel
def _height(group: IntArray, start: int, end: int, row: FloatArray, x: FloatArray) -> float:
    """Return the normal force of the nearest point; fill the norms of the discs' rows.

    s - z = Σ r_b (||x_b|| - r_b s)₊ is concave in s where it counts: Newton's method from s = 0 rises to the
    root, one disc let go at a time.
    """
    # ½ (s - z)² + ½ Σ (||x_b|| - r_b s)²₊ is the squared distance to the
    # section at height s; its slope vanishes
    normal = _norms(group, start, end, x, row)
    z = x[normal] if normal >= 0 else 0.0
    s = 0.0
    for _ in range(MOST_DISCS + 1):
        # the root for the discs that hold at s: (z + Σ r_b ||x_b||) / (1 + Σ r_b²)
        push, slope = z, 1.0
        for b in range(MOST_DISCS):
            radius = row[RADIUS + b]
            if row[NORM + b] > radius * s:
                push += radius * row[NORM + b]
                slope += radius * radius
        if push / slope <= s:
            break
        s = push / slope
    # the distance is convex in s, so that the nearest height within bounds is the clamped one
    return float(min(max(s, row[LOW], 0.0), row[HIGH]))


@inline_kernel
def project_sets(
    offset: IntArray, group: IntArray, table: FloatArray, x: FloatArray, out: FloatArray
) -> None:
    """Fill out (m,) with the nearest admissible forces of flat x (m,), in scaled variables; see `pack`.

    They may be one array.
    """
    for k in range(table.shape[0]):
        start, end = offset[k], offset[k + 1]
        if table[k, CODE] == CONE:
            out[start], out[start + 1], out[start + 2] = project_any(
                x[start], x[start + 1], x[start + 2], table[k, MU], table[k, LOW], table[k, HIGH],
                int(table[k, SIDES]), table[k, INNER] != 0.0,
            )  # fmt: skip
        elif table[k, CODE] == FREE:
            for i in range(start, end):
                out[i] = x[i]
        else:
            row = table[k]
            s = _height(group, start, end, row, x)
            for i in range(start, end):
                b = group[i]
                if b < 0:
                    out[i] = s
                else:
                    # the norms stand in `row` since `_height`: x may be `out`,
                    # and its first rows overwritten by now
                    limit = row[RADIUS + b] * s
                    out[i] = x[i] * (limit / row[NORM + b]) if row[NORM + b] > limit else x[i]


@inline_kernel
def add_shift(
    offset: IntArray, group: IntArray, table: FloatArray, u: FloatArray, sense: float, out: FloatArray
) -> None:
    """Add sense θ Γ(sense u) to the normal rows of out (m,), for flat u (m,) in scaled variables."""
    for k in range(table.shape[0]):
        start, end = offset[k], offset[k + 1]
        if table[k, SHIFT] == 0.0 or table[k, CODE] == FREE:
            continue
        gamma, normal = 0.0, start + 2
        if table[k, CODE] == CONE:
            # u = -y of ADMM comes with sense = -1, without a copy; for a
            # pyramid of odd facets Γ(-u) is not Γ(u)
            p, q = sense * u[start], sense * u[start + 1]
            gamma = shift_any(p, q, table[k, MU], int(table[k, SIDES]), table[k, INNER] != 0.0)
        else:
            row = table[k]
            normal = _norms(group, start, end, u, row)
            for b in range(MOST_DISCS):
                # Γ(u) = sup of -λ_t·u_t over friction's discs at λ_n = 1: Σ r_b ||u_b||
                gamma += row[FRICTION + b] * row[RADIUS + b] * row[NORM + b]
        out[normal] += sense * (table[k, SHIFT] * gamma)


@inline_kernel
def _disc_jacobian(
    group: IntArray, start: int, end: int, row: FloatArray, x: FloatArray, J: FloatArray
) -> None:
    """Fill the Jacobian of one contact's projection onto a section of discs; J is zero before."""
    # the projection is (r_b s x̂_b, s) on the discs that hold, x_b within the others, so
    # that its Jacobian is p ds/dx + the turn of x̂_b: with p = (r_b x̂_b, 1) the gradient of
    # s is p over the slope, and J symmetric
    s = _height(group, start, end, row, x)
    slope = 1.0
    for b in range(MOST_DISCS):
        if row[NORM + b] > row[RADIUS + b] * s:
            slope += row[RADIUS + b] ** 2
    # ds/dz, zero where a bound holds the height
    moves = 1.0 / slope if max(row[LOW], 0.0) < s < row[HIGH] else 0.0
    for i in range(start, end):
        b = group[i]
        p, held, size = 1.0, True, row[NORM + b]  # row i is p s where it is held
        if b >= 0:
            held = size > row[RADIUS + b] * s
            p = row[RADIUS + b] * x[i] / size if held else 0.0
        for j in range(start, end):
            c = group[j]
            q = 1.0
            if c >= 0:
                q = row[RADIUS + c] * x[j] / row[NORM + c] if row[NORM + c] > row[RADIUS + c] * s else 0.0
            value = p * moves * q if held else 0.0
            if b >= 0 and held and b == c:
                # turning x_b within its disc: r_b s / ||x_b|| (1 - x̂ x̂ᵀ)
                bend = row[RADIUS + b] * s / size
                value += bend * ((1.0 if i == j else 0.0) - x[i] * x[j] / (size * size))
            if not held and i == j and row[RADIUS + b] * s > 0.0:  # inside its disc; one of radius 0 has none
                value = 1.0
            J[i - start, j - start] = value


@inline_kernel
def _polygon_jacobian(start: int, row: FloatArray, x: FloatArray, J: FloatArray) -> None:
    """Fill the Jacobian of one contact's projection onto a pyramid; see `pyramid.project_any`."""
    c, s, slope, corner, out, side = sector(
        x[start], x[start + 1], row[MU], int(row[SIDES]), row[INNER] != 0.0
    )
    # one half of the sector serves for both: the pyramid is symmetric about the middle of a face
    sign = 1.0 if side >= 0.0 else -1.0
    side, z = abs(side), x[start + 2]
    # rows of the map in (out, side, normal)
    P = np.zeros((3, 3))
    h = z
    P[0, 0] = P[1, 1] = P[2, 2] = 1.0
    # beyond a face: onto its plane, and beyond its edge onto the ray through the corner
    if out > slope * z:
        length = 1.0 + slope * slope
        h = z + slope * (out - slope * z) / length
        outside = side > corner * h
        if outside:
            length += corner * corner
            h = (slope * out + corner * side + z) / length
        # onto the plane out = slope z: its two directions are the ray up the middle of the face and the
        # side's axis; onto the edge: the ray through the corner alone
        ray = (slope, corner if outside else 0.0, 1.0)
        for a in range(3):
            for b in range(3):
                P[a, b] = ray[a] * ray[b] / length
        if not outside:
            P[1, 1] = 1.0
    # a bound holds the height: what is left is the polygon's section
    if h <= 0.0 or h < row[LOW] or h > row[HIGH]:
        height = 0.0 if h <= 0.0 and row[LOW] <= 0.0 else min(max(h, row[LOW]), row[HIGH])
        for a in range(3):
            for b in range(3):
                P[a, b] = 0.0
        P[0, 0] = 1.0 if out < slope * height else 0.0
        P[1, 1] = 1.0 if side < corner * height else 0.0
    # back to the contact's axes: Tᵀ P T
    T = np.zeros((3, 3))
    T[0, 0], T[0, 1], T[1, 0], T[1, 1], T[2, 2] = c, s, -s * sign, c * sign, 1.0
    for i in range(3):
        for j in range(3):
            total = 0.0
            for a in range(3):
                for b in range(3):
                    total += T[a, i] * P[a, b] * T[b, j]
            J[i, j] = total


@kernel
def jacobian_sets(offset: IntArray, group: IntArray, table: FloatArray, x: FloatArray, J: FloatArray) -> None:
    """Fill a generalised Jacobian of `project_sets`, (n, 6, 6), zero beyond a contact's rows."""
    for k in range(table.shape[0]):
        for a in range(WIDEST):
            for b in range(WIDEST):
                J[k, a, b] = 0.0
        if table[k, CODE] == FREE:
            for a in range(offset[k + 1] - offset[k]):
                J[k, a, a] = 1.0
        elif table[k, SIDES] > 0.0:
            _polygon_jacobian(offset[k], table[k], x, J[k])
        else:
            _disc_jacobian(group, offset[k], offset[k + 1], table[k], x, J[k])


@kernel
def natural_sets(
    offset: IntArray, group: IntArray, table: FloatArray, step: FloatArray, weight: FloatArray,
    forces: FloatArray, velocities: FloatArray, point: FloatArray, gap: FloatArray,
) -> float:  # fmt: skip
    """Fill flat (m,) point = λ - step (u + θ Γ(u)) and gap = λ - P(point); return max_k weight_k ||gap_k||.

    With step 1 / w_k and weight w_k / s_k that is the velocity error, of which ||gap_k|| counts as at least
    `APPROACH` times the step times -u_n below the upper bound. A sum that is no number is infinite.
    """
    for i in range(point.size):
        point[i] = velocities[i]
    add_shift(offset, group, table, velocities, 1.0, point)
    for k in range(table.shape[0]):
        for i in range(offset[k], offset[k + 1]):
            point[i] = forces[i] - step[k] * point[i]
    project_sets(offset, group, table, point, gap)
    # `max` drops a NaN, a sum keeps it
    worst = total = 0.0
    for k in range(table.shape[0]):
        square = approach = 0.0
        for i in range(offset[k], offset[k + 1]):
            gap[i] = forces[i] - gap[i]
            square += gap[i] * gap[i]
            if group[i] < 0 and table[k, CODE] != FREE:  # the last such row is the normal's, of pyramids too
                approach = APPROACH * min(-step[k] * velocities[i], table[k, HIGH] - forces[i])
        own = weight[k] * (approach if approach * abs(approach) > square else math.sqrt(square))
        worst = max(worst, own)
        total += own
    return worst if total >= 0.0 else np.inf


@inline_kernel
def _corner_slope(p: float, q: float, row: FloatArray, slope: FloatArray) -> None:
    """Fill the derivative of θ Γ for a pyramid: that of the corner against which friction pulls."""
    half, inner = math.pi / row[SIDES], row[INNER] != 0.0
    first = 0.0 if inner else half  # bearing of a corner
    # the corner nearest to the direction -u_t
    turn = first + 2.0 * half * math.floor((math.atan2(-q, -p) - first) / (2.0 * half) + 0.5)
    radius = row[SHIFT] * (row[MU] if inner else row[MU] / math.cos(half))
    slope[0], slope[1], slope[2] = -radius * math.cos(turn), -radius * math.sin(turn), 0.0


@kernel
def newton_matrix(
    G: FloatArray, offset: IntArray, group: IntArray, table: FloatArray, step: FloatArray, u: FloatArray,
    J: FloatArray, A: FloatArray,
) -> None:  # fmt: skip
    """Fill A (m, m) = I - J (I - step (I + N) G), the natural map's derivative; N is that of the shift."""
    m = G.shape[0]
    row_of_shift, moved = np.empty(WIDEST), np.empty((WIDEST, m))
    for k in range(table.shape[0]):
        start, end, row = offset[k], offset[k + 1], table[k]
        # N = θ ∂Γ/∂u; at u_b = 0, where Γ has a kink, zero is one of its subgradients
        normal = _norms(group, start, end, u, row)
        # N has one row, the normal's: θ ∂Γ/∂u_b = θ r_b u_b / ||u_b||
        for i in range(start, end):
            b, value = group[i], 0.0
            if row[CODE] != FREE and b >= 0 and row[NORM + b] > 0.0:
                value = row[FRICTION + b] * row[RADIUS + b] * u[i] / row[NORM + b]
            row_of_shift[i - start] = row[SHIFT] * value
        if row[SIDES] > 0.0:
            _corner_slope(u[start], u[start + 1], row, row_of_shift)
        # (I + N) G, the rows of this contact
        for i in range(start, end):
            for j in range(m):
                moved[i - start, j] = G[i, j]
        if normal >= 0:
            for i in range(start, end):
                # the normal row takes θ ∂Γ/∂u G along
                for j in range(m):
                    moved[normal - start, j] += row_of_shift[i - start] * G[i, j]
        for i in range(start, end):
            for j in range(m):
                # I - J + step J (I + N) G
                total = 0.0
                for a in range(start, end):
                    total += J[k, i - start, a - start] * moved[a - start, j]
                A[i, j] = step[k] * total
            for j in range(start, end):
                A[i, j] += (1.0 if i == j else 0.0) - J[k, i - start, j - start]
