from __future__ import annotations

import copy
import pickle
from collections.abc import Callable

import numpy as np
import pytest
import scipy.sparse as sp

import surefoot as sf
from surefoot.contact.problem import blocks
from surefoot.contact.problem.matrix import spectral_norm


def random_matrix(seed: int, contacts: int, dof: int) -> np.ndarray:
    J = np.random.default_rng(seed).normal(size=(3 * contacts, dof))
    return J @ J.T


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"g": [0.0, 0.0]}, "three entries per contact"),
        ({"g": [0.0, np.nan, 0.0, 0.0, 0.0, 0.0]}, r"g\[1\] is NaN"),
        ({"mu": -0.1}, r"mu\[0\] must be >= 0, got -0.1"),
        ({"mu": [0.5, 1e151]}, "mu must be finite"),
        ({"mu": [0.5, 0.5, 0.5]}, "mu must be a number or have shape"),
        ({"normal_min": [0.0, 3.0], "normal_max": 2.0}, "at contact 1"),
        ({"normal_min": np.inf}, "normal_min must be finite"),
        ({"facets": 2}, "facets must be a whole number >= 3"),
        ({"compliance": -1.0}, "compliance"),
        ({"compliance": [1.0, 2.0, 3.0, 4.0]}, "compliance must be a number or have shape"),
        ({"bilateral": [True]}, "bilateral must be a mask"),
        ({"bilateral": np.array([True, False]), "normal_max": 3.0}, "takes no normal bounds"),
        ({"G": np.eye(5)}, r"G must have shape \(6, 6\)"),
        ({"G": np.full((6, 6), np.inf)}, "is infinite"),
        ({"G": np.triu(np.ones((6, 6)))}, r"G\[\d, \d\] = "),
        ({"G": sp.csr_matrix(np.triu(np.ones((6, 6))))}, r"G must be symmetric"),
        ({"G": sp.eye(4)}, r"G must have shape \(6, 6\)"),
    ],
)
def test_bad_input_names_what_is_wrong(changes: dict[str, object], words: str) -> None:
    arguments: dict[str, object] = {"G": np.eye(6), "g": np.zeros(6), "mu": 0.5}
    with pytest.raises(sf.ProblemError, match=words):
        sf.ContactProblem(**(arguments | changes))  # type: ignore[arg-type]


def test_rounding_asymmetry_is_taken_and_the_argument_left_alone() -> None:
    G = random_matrix(0, 2, 6)
    crooked = G.copy()
    crooked[0, 1] *= 1 + 1e-10
    before = crooked.copy()
    problem = sf.ContactProblem(crooked, np.ones(6), 0.5)
    assert np.array_equal(problem.G, problem.G.T)
    assert np.array_equal(crooked, before)


def test_sparse_and_dense_are_the_same_problem() -> None:
    J = sp.random(24, 30, density=0.1, random_state=1).tocsr()
    G = (J @ J.T + 0.1 * sp.eye(24)).tocsr()
    g = np.random.default_rng(1).normal(size=24)
    dense, sparse = sf.ContactProblem(G.toarray(), g, 0.5), sf.ContactProblem(G, g, 0.5)
    assert np.allclose(dense.G, sparse.G, rtol=0, atol=1e-15)
    assert dense.norm == pytest.approx(sparse.norm, rel=1e-9)
    force = np.random.default_rng(2).normal(size=(8, 3))
    assert np.allclose(dense.velocity(force), sparse.velocity(force), atol=1e-13)
    for problem in (dense, sparse):
        b = problem.blocks
        product = blocks.block_product(b.starts, b.columns, b.values, force.ravel())
        assert np.allclose(product, G @ force.ravel(), atol=1e-13)
    assert dense.blocks.density < 1.0


def _spoiled(G: np.ndarray, kind: str) -> np.ndarray:
    """Return a semidefinite G (24, 24) with something wrong in it; what to zero is zero on one side alone."""
    out = G.copy()
    if kind == "one side":
        out[3, 20], out[20, 3] = 0.7, 0.0
    elif kind == "diagonal":
        out[7, 7] = -0.5
    elif kind == "pair":
        out[3, 20] = out[20, 3] = 1e3
    elif kind == "block":
        out[6:9, 6:9] = [[1.0, 0.9, 0.9], [0.9, 1.0, -0.9], [0.9, -0.9, 1.0]]
    return out


@pytest.mark.parametrize("kind", ["one side", "diagonal", "pair", "block"])
@pytest.mark.parametrize("size", [1e-60, 1.0, 1e60])
def test_a_sparse_matrix_is_refused_in_the_words_of_a_dense_one(kind: str, size: float) -> None:
    J = sp.random(24, 30, density=0.1, random_state=1).toarray()
    G = size * _spoiled(J @ J.T + 0.1 * np.eye(24), kind)
    said = []
    for matrix in (G, sp.csr_matrix(G), sp.coo_matrix(G), sp.bsr_matrix(G, blocksize=(3, 3))):
        with pytest.raises(sf.ProblemError) as told:
            sf.ContactProblem(matrix, np.zeros(24), 0.5)
        said.append(str(told.value))
    assert len(set(said)) == 1, said


def test_rounding_on_one_side_alone_is_halved_in_a_sparse_matrix() -> None:
    G = sp.eye(24).tolil()
    G[3, 20] = 1e-10
    given = G.tocsr()
    problem = sf.ContactProblem(given, np.zeros(24), 0.5)
    assert problem.G[3, 20] == problem.G[20, 3] == 5e-11
    assert given[20, 3] == 0.0


@pytest.mark.parametrize("kind", ["number", "contact", "row"])
def test_compliance_goes_on_the_diagonal(kind: str) -> None:
    G, g = random_matrix(3, 2, 6), np.ones(6)
    R = {"number": 0.3, "contact": np.array([0.1, 0.2]), "row": np.arange(6.0)}[kind]
    full = {"number": np.full(6, 0.3), "contact": np.repeat([0.1, 0.2], 3), "row": np.arange(6.0)}[kind]
    for matrix in (G, sp.csr_matrix(G)):
        problem = sf.ContactProblem(matrix, g, 0.5, compliance=R)
        assert np.allclose(problem.G, G + np.diag(full))


@pytest.mark.parametrize("seed", range(12))
def test_norm_is_the_spectral_norm(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 80))
    J = rng.normal(size=(3 * n, int(rng.integers(1, 4 * n + 2)))) * 10 ** rng.uniform(-3, 3, size=(3 * n, 1))
    G = (J @ J.T) * (-1.0 if seed % 3 == 0 else 1.0)
    G = 0.5 * (G + G.T)
    for matrix in (G, sp.csr_matrix(G)):
        assert spectral_norm(matrix) == pytest.approx(np.linalg.norm(G, 2), rel=1e-8)
    if seed % 3:
        assert sf.ContactProblem(G, np.ones(3 * n), 0.5).norm == spectral_norm(G)


@pytest.mark.parametrize("kind", ["clustered", "two-sided", "diagonal", "low-rank"])
def test_norm_of_awkward_matrices(kind: str) -> None:
    """Eigenvalues that nearly coincide, both ends nearly as long, and spaces that end early."""
    rng = np.random.default_rng(5)
    for n in (1, 4, 20, 70):
        q, _ = np.linalg.qr(rng.normal(size=(3 * n, 3 * n)))
        d = {
            "clustered": 1.0 + 1e-9 * rng.uniform(-1.0, 1.0, 3 * n),
            "two-sided": np.concatenate([[1.0, -1.0001], rng.uniform(-1.0, 1.0, 3 * n - 2)]),
            "diagonal": rng.uniform(0.0, 1.0, 3 * n),
            "low-rank": np.where(np.arange(3 * n) < 2, 1.0 + np.arange(3 * n), 0.0),
        }[kind]
        G = np.diag(d) if kind == "diagonal" else (q * d) @ q.T
        for matrix in (0.5 * (G + G.T), sp.csr_matrix(0.5 * (G + G.T))):
            assert spectral_norm(matrix) == pytest.approx(np.abs(d).max(), rel=1e-8)


@pytest.mark.parametrize("sparse", [False, True])
@pytest.mark.parametrize("way", ["itself", "pickle", "deepcopy"])
def test_vectors_changed_in_place_are_seen_by_compiled_solvers(way: str, sparse: bool) -> None:
    G, g = random_matrix(3, 3, 12), np.tile([0.1, -0.2, -1.0], 3)
    problem = sf.ContactProblem(sp.csr_matrix(G) if sparse else G, np.ones(9), 0.5)
    assert sf.solve(problem).solved
    if way != "itself":
        problem = pickle.loads(pickle.dumps(problem)) if way == "pickle" else copy.deepcopy(problem)
    problem.g[:] = g
    problem.mu[:] = 0.3
    expected = sf.solve(sf.ContactProblem(G, g, 0.3), tol=1e-12)
    assert np.allclose(sf.solve(problem, tol=1e-12).forces, expected.forces, atol=1e-9)
    assert expected.forces.any()


def test_norm_of_nothing() -> None:
    assert sf.ContactProblem(np.zeros((3, 3)), np.ones(3), 0.5).norm == 0.0
    assert sf.ContactProblem(np.zeros((0, 0)), np.zeros(0), 0.5).norm == 0.0


def test_replace_keeps_what_it_is_not_told() -> None:
    held = np.array([False, True])
    problem = sf.ContactProblem(random_matrix(4, 2, 6), np.ones(6), 0.4, bilateral=held, compliance=0.1)
    other = problem.replace(law="convex")
    assert other.law == "convex"
    assert np.array_equal(other.G, problem.G)
    assert np.array_equal(other.normal_min, [0.0, -np.inf])
    assert other.polyhedral(6, "outer").facets == 6


def robot_like(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A Jacobian and a mass matrix with a condition number of 1e5, as a humanoid's."""
    rng = np.random.default_rng(seed)
    Q, _ = np.linalg.qr(rng.normal(size=(18, 18)))
    return rng.normal(size=(12, 18)), (Q * np.geomspace(1e-3, 1e2, 18)) @ Q.T


@pytest.mark.parametrize("form", ["single", "double", "sparse"])
def test_products_of_single_precision_are_symmetric_enough(form: str) -> None:
    """J M⁻¹ Jᵀ computed in single precision, also where it was turned to double precision afterwards."""
    asymmetries = []
    for seed in range(20):
        J, M = (x.astype(np.float32) for x in robot_like(seed))
        G = J @ np.linalg.inv(M) @ J.T
        asymmetries.append(np.abs(G - G.T).max() / np.abs(G).max())
        given = {"single": G, "double": G.astype(float), "sparse": sp.csr_matrix(G)}[form]
        problem = sf.ContactProblem(given, np.zeros(12), 0.5)
        assert np.array_equal(problem.G, 0.5 * (G.astype(float) + G.T.astype(float)))
        crooked = G.copy()
        crooked[0, 5] += 1e-3 * np.abs(G).max()
        with pytest.raises(sf.ProblemError, match=r"G must be symmetric.*up to 1e-05 of the largest"):
            sf.ContactProblem(crooked, np.zeros(12), 0.5)
    assert 1e-8 < max(asymmetries) < 1e-5
    G = np.random.default_rng(0).normal(size=(6, 6))
    G = G @ G.T
    G[0, 1] += 1e-6 * np.abs(G).max()  # not of single precision: no excuse
    with pytest.raises(sf.ProblemError, match=r"up to 1e-08 of the largest"):
        sf.ContactProblem(G, np.zeros(6), 0.5)


@pytest.mark.parametrize("form", [np.asarray, sp.csr_matrix])
def test_what_is_visibly_indefinite_is_refused(form: Callable[[np.ndarray], object]) -> None:
    J, M = robot_like(0)
    G = J @ np.linalg.solve(M, J.T)
    G = 0.5 * (G + G.T)
    with pytest.raises(sf.ProblemError, match=r"semidefinite, but G\[0, 0\] = -"):
        sf.ContactProblem(form(-G), np.zeros(12), 0.5)
    crossed = np.eye(12)
    crossed[7, 2] = crossed[2, 7] = -1.5
    with pytest.raises(sf.ProblemError, match=r"G\[7, 2\] = -1.5 with G\[7, 7\] = 1 and G\[2, 2\] = 1"):
        sf.ContactProblem(form(crossed), np.zeros(12), 0.5)


@pytest.mark.parametrize("form", [np.asarray, sp.csr_matrix])
def test_a_diagonal_block_that_is_indefinite_is_refused(form: Callable[[np.ndarray], object]) -> None:
    G = np.eye(6)
    G[3:, 3:] = [[1.0, -0.9, -0.9], [-0.9, 1.0, -0.9], [-0.9, -0.9, 1.0]]  # minors of pairs are fine
    with pytest.raises(sf.ProblemError, match=r"contact 1 \(rows 3 to 5\) has a negative eigenvalue"):
        sf.ContactProblem(form(G), np.zeros(6), 0.5)


def test_semidefinite_matrices_are_never_refused() -> None:
    """Low rank, repeated contacts, mass ratios of 1e12, tiny and huge units, zero: all are taken."""
    for seed in range(300):
        rng = np.random.default_rng(seed)
        n, rank = int(rng.integers(1, 6)), int(rng.integers(0, 7))
        J = rng.normal(size=(3 * n, rank)) * 10.0 ** rng.uniform(-6, 6, size=rank)
        J[3 * (n - 1) :] = J[:3] * rng.choice([1.0, -1.0, 1.0 + 1e-15])
        G = (J @ J.T) * 10.0 ** rng.uniform(-100, 100)
        single = J.astype(np.float32) @ J.T.astype(np.float32)
        for given, matrix in ((G, G), (sp.csr_matrix(G), G), (single, single.astype(float))):
            problem = sf.ContactProblem(given, np.zeros(3 * n), 0.5)
            taken = problem.G.toarray() if sp.issparse(problem.G) else problem.G
            assert np.array_equal(taken, 0.5 * (matrix + matrix.T))
            assert problem.norm == pytest.approx(np.linalg.norm(taken, 2), rel=1e-8, abs=0.0)
