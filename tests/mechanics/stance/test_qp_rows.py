"""Rows of a stance in other people's QP solvers, and their update in place."""

import numpy as np
import pytest
from scipy import sparse

import surefoot as sf

FEET = [[0.2, 0.15, 0.0], [0.2, -0.15, 0.0], [-0.2, 0.15, 0.0], [-0.2, -0.15, 0.0]]
NAMES = ["FL", "FR", "RL", "RR"]


def tilted(angle, mu=0.6, low=5.0, high=np.inf):
    normal = [np.sin(angle), 0.1, np.cos(angle)] / np.linalg.norm([np.sin(angle), 0.1, np.cos(angle)])
    points = [
        sf.PointContact(p, normal, mu, name, low, high) for p, name in zip(FEET[:3], NAMES[:3], strict=True)
    ]
    sole = sf.Sole(0.2, 0.1, mu)
    return sf.Stance([*points, sf.SoleContact(FEET[3], sole, normal, "RR", low, high)])


def program(stance):
    """A wrench shared by least squares: P, q."""
    G = stance.grasp_map([0.0, 0.0, 0.3]) @ world(stance).T
    wanted = np.array([30.0, 5.0, 150.0, 0.0, 0.0, 2.0])
    return G.T @ G + 1e-3 * np.eye(stance.dim), -G.T @ wanted


def world(stance):
    """Block rotations (dim, dim) from contact to world axes."""
    parts = [c.rotation_world_contact for c in stance for _ in range(c.dim // 3)]
    out = np.zeros((stance.dim, stance.dim))
    for k, R in enumerate(parts):
        out[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = R
    return out


SOLVERS = {
    "osqp": "osqp",
    "scs": "scs",
    "ecos": "ecos",
    "piqp": "piqp",
    "proxqp": "proxsuite",
    "clarabel": "clarabel",
}


@pytest.mark.filterwarnings("ignore:The default value of raise_error:PendingDeprecationWarning")
@pytest.mark.parametrize("name", list(SOLVERS))
def test_solvers_take_the_rows_as_they_are(name):
    """Without an upper bound: infinite rows made ECOS raise, SCS give up and PIQP warn."""
    qpsolvers = pytest.importorskip("qpsolvers")
    pytest.importorskip(SOLVERS[name])
    stance = tilted(0.2)
    rows = stance.halfspaces(8, axes="world", swing=["FR"])
    assert np.isfinite(rows.b).all()
    assert np.isfinite(rows.A).all()
    P, q = program(stance)
    loose = {"eps_abs": 1e-8, "eps_rel": 1e-8} if name in ("osqp", "scs", "proxqp") else {}
    more = {"max_iter": 200_000} if name == "osqp" else {}
    csc = sparse.csc_matrix
    found = qpsolvers.solve_qp(
        csc(P), q, rows.sparse(), rows.b, csc(rows.E), rows.e, solver=name, **loose, **more
    )
    assert found is not None
    assert rows.violation(found) < 1e-4
    assert np.abs(found[3:6]).max() < 1e-5
    best = qpsolvers.solve_qp(P, q, rows.A, rows.b, rows.E, rows.e, solver="daqp")
    assert abs(0.5 * found @ P @ found + q @ found - 0.5 * best @ P @ best - q @ best) < 1e-3


def two_sided_osqp(P, q, rows):
    osqp = pytest.importorskip("osqp")
    solver = osqp.OSQP()
    solver.setup(
        sparse.csc_matrix(np.triu(P)), q, rows.sparse(), rows.lower, rows.upper, verbose=False, eps_abs=1e-9,
        eps_rel=1e-9, max_iter=100_000,
    )  # fmt: skip
    return solver.solve(raise_error=True).x


def two_sided_piqp(P, q, rows):
    piqp = pytest.importorskip("piqp")
    solver = piqp.DenseSolver()
    solver.settings.verbose = False
    if "h_l" not in str(getattr(solver.setup, "__doc__", "")):
        pytest.skip("this PIQP has one-sided rows only")
    solver.setup(P, q, None, None, rows.A, rows.lower, rows.upper)
    solver.solve()
    return solver.result.x


def two_sided_proxqp(P, q, rows):
    proxsuite = pytest.importorskip("proxsuite")
    solver = proxsuite.proxqp.dense.QP(len(q), 0, len(rows.A))
    solver.settings.eps_abs = 1e-9
    solver.init(P, q, None, None, rows.A, rows.lower, rows.upper)
    solver.solve()
    return solver.results.x


@pytest.mark.parametrize("solve", [two_sided_osqp, two_sided_piqp, two_sided_proxqp])
def test_both_bounds_at_once(solve):
    pytest.importorskip("qpsolvers")
    import qpsolvers

    stance = tilted(0.2)
    P, q = program(stance)
    one = stance.halfspaces(8, axes="world", swing=["FR"])
    found = solve(P, q, stance.two_sided(8, axes="world", swing=["FR"]))
    best = qpsolvers.solve_qp(P, q, one.A, one.b, one.E, one.e, solver="daqp")
    assert np.abs(found - best).max() < 1e-3


@pytest.mark.parametrize("axes", ["contact", "world"])
@pytest.mark.parametrize("form", ["halfspaces", "two_sided"])
def test_an_update_is_the_rows_anew(form, axes):
    first, then = tilted(0.1, 0.6, 5.0, 300.0), tilted(0.4, 0.3, 7.0, 200.0)
    rows = getattr(first, form)(6, axes=axes, swing=["RL"])
    new = getattr(then, form)(6, axes=axes, swing=["RL"])
    csc, data = rows.sparse(), None
    data, own = csc.data, rows.A
    rows.update(csc, then)
    assert csc.data is data
    assert csc.toarray() == pytest.approx(new.A, abs=1e-15)
    rows.update(own, then)
    assert own == pytest.approx(new.A, abs=1e-15)
    large = np.full((len(own) + 5, first.dim + 4), 7.0)
    rows.update(large, then, row=2, column=4)
    inner = large[2 : 2 + len(own), 4:]
    assert inner[new.A != 0.0] == pytest.approx(new.A[new.A != 0.0], abs=1e-15)
    assert (large[:2] == 7.0).all()
    assert (large[:, :4] == 7.0).all()
    if form == "halfspaces":
        assert np.array_equal(rows.b, new.b)
    else:
        assert np.array_equal(rows.lower, new.lower)
        assert np.array_equal(rows.upper, new.upper)


def test_an_update_with_other_contacts_is_refused():
    stance = tilted(0.1)
    rows = stance.halfspaces(6)
    before = rows.A.copy()
    refused = {
        "the rows are of 4 contacts": tilted(0.1).without("FL"),
        r"contacts\[0\] now has an upper bound": tilted(0.1, high=100.0),
        r"contacts\[3\] has another shape": sf.Stance(
            [*stance.contacts[:3], sf.PointContact(FEET[3], name="RR")]
        ),
    }
    for said, other in refused.items():
        with pytest.raises(sf.ProblemError, match=said):
            rows.update(rows.A, other)
    with pytest.raises(sf.ProblemError, match="do not fit"):
        rows.update(np.zeros((3, 3)), stance)
    with pytest.raises(sf.ProblemError, match="must be of floats in C order"):
        rows.update(np.asfortranarray(rows.A), stance)
    with pytest.raises(sf.ProblemError, match="sparse"):
        rows.update(sparse.csc_matrix(np.eye(3)), stance)
    assert np.array_equal(rows.A, before)
