"""Rays to half-spaces and back, redundancy removed, for cones of any shape.

By duality one direction is enough: the rays of {x : A x <= 0} are the half-space normals of the cone that
the rows of A generate. A cone is split into its linear hull, its lineality space (the directions
that it holds both ways) and a pointed rest; a section of the rest is a polytope, and Qhull finds its
facets. Double description, the other way, is cddlib's.

Every decision is made on rays of length one in whitened coordinates, so that neither the length of a
ray nor the unit of a component matters.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.errors import check_name, needs

Method = Literal["qhull", "cdd"]

_FLAT = 1e-9
"""Singular values and section heights below this share count as zero."""


def convert(rays: FloatArray, method: Method = "qhull") -> tuple[FloatArray, IntArray]:
    """Return irredundant half-spaces of the cone that rays generate, and which of the rays suffice for it.

    By duality the other way round, too: the rays of {x : halfspaces @ x <= 0} are `convert(halfspaces)[0]`,
    a direction that the cone holds both ways being a pair of opposite ones.

    Parameters
    ----------
    rays
        (r, dim), of any length; none at all generate the cone {0}.
    method
        "qhull" (SciPy) or "cdd" (cddlib).

    Returns
    -------
    tuple[FloatArray, IntArray]
        (m, dim) with m >= 0: rows of length one, outward; an equation is a pair of opposite rows. The whole
        space has no rows. And the indices (k,) of rays that generate the cone; where it is not pointed, the
        generators of its lineality space are all kept.

    Raises
    ------
    ProblemError
        For an unknown method.
    MissingExtra
        If cddlib is asked for and not installed.

    Examples
    --------
    >>> rows, kept = convert(np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]))
    >>> sorted((rows.round(9) + 0.0).tolist()), kept.tolist()  # no zero is negative
    ([[-1.0, 0.0], [0.0, -1.0]], [0, 2])
    """
    check_name("method", method, get_args(Method))
    V, index = _directions(rays)
    dim = rays.shape[1]
    if not len(V):
        return np.vstack([np.eye(dim), -np.eye(dim)]), index
    if method == "cdd":
        return _unit_rows(_cddlib(V)), index
    # units out, then directions of equal weight: rays of a flat cone span all of its space alike
    column = np.abs(V).max(axis=0)
    column[column == 0.0] = 1.0
    W = _unit_rows(V / column)
    singular, basis, rank = _row_space(W)
    whiten = basis[:rank].T / singular[:rank]
    X = _unit_rows(W @ whiten)
    facets, kept = _facets(X)
    flat = basis[rank:]
    # n · whitenᵀ (x / column): facets in the given coordinates; what the
    # rays do not span is held by equations
    H = np.vstack([facets @ whiten.T, flat, -flat]) / column
    return _unit_rows(H) + 0.0, index[kept]


def _directions(rays: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the rays at length one, without zeros, and their indices."""
    size = np.abs(rays).max(axis=1, initial=0.0)
    index = np.flatnonzero(size > 0.0)
    return _unit_rows(rays[index] / size[index, None]), index


def _unit_rows(rows: FloatArray) -> FloatArray:
    """Return rows divided by their lengths."""
    return np.asarray(rows / np.sqrt(np.einsum("ij,ij->i", rows, rows))[:, None])


def _row_space(rows: FloatArray) -> tuple[FloatArray, FloatArray, int]:
    """Return singular values and an orthonormal basis whose first `rank` rows span the rows, and the rank."""
    _, singular, basis = np.linalg.svd(rows, full_matrices=True)
    return singular, basis, int(np.sum(singular > _FLAT * singular[0]))


def _facets(X: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return facet normals and needed generators of cone(X), X of full rank with rows of length one."""
    section = _section(X)
    if section is not None:
        return _pointed_facets(X, section)
    lineal = lineality(X)
    if not np.any(lineal):  # too thin to tell: flat within the tolerance
        lineal = np.ones(len(X), dtype=np.bool_)
    _, basis, rank = _row_space(X[lineal])
    rest = basis[rank:]
    needed = list(np.flatnonzero(lineal))
    # the cone is a linear space: no facets
    if not len(rest):
        return np.zeros((0, X.shape[1])), np.array(needed, dtype=np.int64)
    others = np.flatnonzero(~lineal)
    # modulo the lineality space the cone is pointed, and its facets are the whole cone's
    Y = X[others] @ rest.T
    alive = np.linalg.norm(Y, axis=1) > _FLAT
    facets, kept = _facets(_unit_rows(Y[alive]))
    needed.extend(others[alive][kept])
    return facets @ rest, np.array(sorted(needed), dtype=np.int64)


def _section(X: FloatArray) -> FloatArray | None:
    """Return c with X @ c > 0 for every row, well inside, or None if the cone is not pointed."""
    c = X.mean(axis=0)
    length = float(np.linalg.norm(c))
    # the mean of the rays mostly serves, and saves the linear program
    if length > 0.1 and float((X @ c).min()) > 0.05 * length * length:
        return np.asarray(c / length)
    from scipy.optimize import linprog  # here as below: loading it takes longer than most programs need cones

    rows, dim = X.shape
    # maximise the least of X c over a box: positive exactly if the cone is pointed
    result = linprog(
        np.array([*np.zeros(dim), -1.0]),
        A_ub=np.hstack([-X, np.ones((rows, 1))]),
        b_ub=np.zeros(rows),
        bounds=[(-1.0, 1.0)] * dim + [(None, 1.0)],
        method="highs",
    )
    if result.status != 0 or result.x is None:
        return None
    c = result.x[:dim]
    if float((X @ c).min()) <= _FLAT:
        return None
    return np.asarray(c / np.linalg.norm(c))


def lineality(X: FloatArray) -> BoolArray:
    """Tell which rows of X (r, dim) lie in cone(X)'s lineality space, whose opposite is in it too: (r,)."""
    from scipy.optimize import linprog

    rows, dim = X.shape
    # maximise sum(s), s <= beta, 0 <= s <= 1, X' beta = 0: s is 1 on the rows of the space, else 0
    result = linprog(
        np.concatenate([-np.ones(rows), np.zeros(rows)]),
        A_eq=np.hstack([X.T, X.T]),
        b_eq=np.zeros(dim),
        bounds=[(0.0, 1.0)] * rows + [(0.0, None)] * rows,
        method="highs",
    )
    if result.x is None:
        return np.zeros(rows, dtype=np.bool_)
    return np.asarray(result.x[:rows] > 0.5)


def _pointed_facets(X: FloatArray, section: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return facets and extreme rays of a pointed cone of full dimension through its section."""
    dim = X.shape[1]
    if dim == 1:
        return -np.sign(X[:1]), np.array([0], dtype=np.int64)
    # rays to points of the section c·x = 1, a polytope of one dimension less; its facets are the cone's
    points = X / (X @ section)[:, None]
    plane = np.linalg.svd(section[None])[2][1:]
    q = points @ plane.T
    if dim == 2:
        low, high = int(np.argmin(q)), int(np.argmax(q))
        facets = np.array([plane[0] - q[high, 0] * section, q[low, 0] * section - plane[0]])
        return _unit_rows(facets), np.unique([low, high])
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(q, qhull_options="Qx" if dim > 5 else "")
    except QhullError:
        # joggled: points too flat for Qhull's own merging
        hull = ConvexHull(q, qhull_options="QJ")
    facets = _unit_rows(hull.equations[:, :-1] @ plane + hull.equations[:, -1:] * section)
    return _distinct(facets), np.asarray(hull.vertices, dtype=np.int64)


def _distinct(rows: FloatArray) -> FloatArray:
    """Drop rows that repeat another one: Qhull splits a facet into simplices with equal normals."""
    # a projection that separates different rows: equal ones are neighbours in its order
    mark = rows @ np.sin(np.arange(1.0, rows.shape[1] + 1.0))
    order = np.argsort(mark)
    new = np.append(True, (rows[order[1:]] != rows[order[:-1]]).any(axis=1))  # most repeat to the last bit
    mark, rows = mark[order[new]], rows[order[new]]
    keep = np.ones(len(rows), dtype=np.bool_)
    near = 1
    while near < len(rows):
        close = mark[near:] - mark[:-near] < 1e-9
        if not close.any():
            break
        same = np.flatnonzero(close)
        gap = np.abs(rows[same + near] - rows[same]).max(axis=1)
        keep[same[gap < 1e-9] + near] = False
        near += 1
    return np.asarray(rows[keep])


def _cddlib(V: FloatArray) -> FloatArray:
    """Return the half-spaces of cone(V) by cddlib's double description method."""
    with needs("pycddlib", "cdd"):
        import cdd
    rows = [[0.0, *ray] for ray in V.tolist()]
    generators = cdd.matrix_from_array(rows, rep_type=cdd.RepType.GENERATOR)
    found = cdd.copy_inequalities(cdd.polyhedron_from_matrix(generators))
    array = np.array([row[1:] for row in found.array]).reshape(-1, V.shape[1])
    equal = [array[k] for k in sorted(found.lin_set)]
    out = np.vstack([-array, *(e[None] for e in equal)]) if equal else -array
    return np.asarray(out[np.abs(out).max(axis=1, initial=0.0) > 0.0])
