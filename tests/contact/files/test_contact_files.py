from __future__ import annotations

import contextlib
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

import surefoot as sf
from benchmarks.problems.contacts import problem_set
from surefoot.contact.files.formats import holds_lcp, read_lcp, read_problem, write_problem

SHARED = Path(__file__).resolve().parents[4] / "shared" / "data"
needs_shared = pytest.mark.skipif(not SHARED.is_dir(), reason=f"no data files in {SHARED}")


def some_problem(contacts: int = 4) -> sf.ContactProblem:
    rng = np.random.default_rng(contacts)
    J = np.kron(np.eye(contacts), np.ones((3, 2))) + 0.2 * rng.normal(size=(3 * contacts, 2 * contacts)) * (
        np.kron(np.eye(contacts) + np.eye(contacts, k=1), np.ones((3, 2)))
    )
    return sf.ContactProblem(J @ J.T, rng.normal(size=3 * contacts), rng.uniform(0.2, 0.9, size=contacts))


@pytest.mark.parametrize("ending", [".npz", ".dat", ".hdf5", ".h5"])
@pytest.mark.parametrize("contacts", [1, 4, 20])
def test_what_is_written_is_read_back(tmp_path: Path, ending: str, contacts: int) -> None:
    problem = some_problem(contacts)
    solution = sf.solve(problem).raise_if_failed()
    path = write_problem(problem, tmp_path / f"p{ending}", solution.forces)
    again = read_problem(path)
    assert np.array_equal(again.G, problem.G)
    assert np.array_equal(again.g, problem.g)
    assert np.array_equal(again.mu, problem.mu)
    if ending == ".dat":
        assert again.reference is None
    else:
        assert np.array_equal(again.reference, solution.forces)
    with pytest.raises(sf.ProblemError, match="nothing is overwritten"):
        write_problem(problem, path)


def test_npz_holds_everything(tmp_path: Path) -> None:
    base = some_problem(3)
    problem = sf.ContactProblem(
        base.G, base.g, base.mu, [0.1, 0.0, 0.0], [3.0, np.inf, 0.0], "convex", 6, "outer",
        bilateral=np.array([False, True, False]),
    )  # fmt: skip
    again = read_problem(write_problem(problem, tmp_path / "p.npz"))
    for name in ("g", "mu", "normal_min", "normal_max", "bilateral"):
        assert np.array_equal(getattr(again, name), getattr(problem, name)), name
    assert (again.law, again.facets, again.fit) == ("convex", 6, "outer")


@pytest.mark.parametrize("changes", [{"law": "convex"}, {"facets": 4}, {"normal_max": 2.0}])
def test_foreign_formats_refuse_what_they_cannot_hold(tmp_path: Path, changes: dict[str, object]) -> None:
    with pytest.raises(sf.ProblemError, match=r"use \.npz"):
        write_problem(some_problem().replace(**changes), tmp_path / "p.dat")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("3 1 0 3 3 3 3 1 0 0 0 1", "ends before"),
        ("3 1 7 3 3", "storage must be 0 .dense. or 1 .blocks., got 7"),
        ("3 1 0 3 3 3 4 1 0 0 0 1 0 0 0 1 -1 0 0 0.5", "3x3 and then 3x4"),
        ("3 1 0 4 4 4 4 " + "1 " * 20, "not W of 1 contacts .3x3.; global problems"),
        ("3 1 0 3 3 3 3 1 0 0 0 1 0 0 0 1 -1 0 0 0.5 0.1", "left over.*rolling friction is not supported"),
        (
            "3 1 0 3 3 3 3 1 0 0 0 1 0 0 0 1 -1 0 0 0.5 0 0 0",
            "left over after the problem .2, the first is 0",
        ),
        ("5 1 0 5 5 5 5 " + "1 " * 32, "rolling friction .dimension 5."),
        ("3 inf 0 3 3 3 3", "whole numbers"),
        ("3 -1 0 3 3 3 3", "whole numbers"),
        ("3 1 1 3 3 1 1 1 3 9 2 1 0 1 0 0 1 0 0 0 1 0 0 0 1 -1 0 0 0.5", "contradicts itself"),
        ("3 1 1 3 3 1 1 1 3 3 2 1 0 1 5 0 1 0 0 0 1 0 0 0 1 -1 0 0 0.5", "contradicts itself"),
        ("3 1 0 3 3 3 3 one", "expected numbers"),
        ("4 1 0 4 4 4 4 " + "1 " * 21, "dimension must be 2 or 3"),
        ("3 1 0 3 3 3 3 1 9 0 0 1 0 0 0 1 0 0 0 0.5", "not symmetric"),
        ("3 1 0 3 3 3 3 1 0 0 0 1 0 0 0 1 0 0 0 -0.5", r"mu\[0\] must be >= 0"),
    ],
)
def test_broken_text_is_told_in_words(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "broken.dat"
    path.write_text(text)
    with pytest.raises(sf.ProblemError, match=words):
        read_problem(path)


def as_text(matrix: np.ndarray) -> str:
    """A dense matrix as Siconos writes it: column by column."""
    rows, columns = matrix.shape
    entries = " ".join(f"{x:.17g}" for x in matrix.T.ravel())
    return f"0\n{rows}\n{columns}\n{rows}\t{columns}\n{entries}\n"


def numbers(*vectors: Iterable[float]) -> str:
    return "".join(" ".join(f"{x:.17g}" for x in v) + "\n" for v in vectors)


@pytest.mark.parametrize("closing", ["", "0", "1", "A remark, with 3 numbers: 1 2 3"])
def test_local_text(tmp_path: Path, closing: str) -> None:
    problem = some_problem(3)
    back = [2, 0, 1, 5, 3, 4, 8, 6, 7]
    path = tmp_path / "local.dat"
    W = as_text(problem.G[np.ix_(back, back)])
    path.write_text(f"3\n3\n{W}{numbers(problem.g[back], problem.mu)}{closing}")
    again = read_problem(path)
    assert np.allclose(again.G, problem.G, rtol=1e-15, atol=0.0)
    assert np.array_equal(again.g, problem.g)
    assert np.array_equal(again.mu, problem.mu)


def test_lcp_matrices_run_column_by_column(tmp_path: Path) -> None:
    """As Siconos reads them."""
    M = np.array([[1.0, 2.0, 2.0], [0.0, 1.0, 2.0], [0.0, 0.0, 1.0]])
    path = tmp_path / "lcp.dat"
    path.write_text(f"3\n{as_text(M)}{numbers(-np.ones(3))}From a book, page 7")
    assert holds_lcp(path)
    assert np.array_equal(read_lcp(path).M, M)
    path.write_text(path.read_text().replace("From", "4 From"))
    with pytest.raises(sf.ProblemError, match="left over"):
        read_lcp(path)


def test_damaged_text_is_read_as_something_or_refused(tmp_path: Path) -> None:
    """Words dropped, doubled or replaced: a problem or a ProblemError, never another exception."""
    rng = np.random.default_rng(0)
    strange = ["nan", "-1", "1e9", "inf", "col", "x", "0.5", "2-by-2", "2", "7"]
    words = f"3 1 {as_text(np.diag([1.0, 2.0, 3.0]))} {numbers([-1.0, 0.1, 0.2], [0.5])}".split()
    for k in range(240):
        at = int(rng.integers(len(words)))
        put = [[], [words[at]] * 2, [strange[int(rng.integers(len(strange)))]]][k % 3]
        path = tmp_path / "damaged.dat"
        path.write_text(" ".join(words[:at] + put + words[at + 1 :]))
        for reader in (read_problem, read_lcp):
            with contextlib.suppress(sf.ProblemError):
                assert np.isfinite(getattr(reader(path), "g", 0.0)).all()


def test_rolling_friction_in_fclib_is_named(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "rolling.hdf5"
    with h5py.File(path, "w") as file:
        file.create_group("fclib_global_rolling")
    with pytest.raises(sf.ProblemError, match="rolling friction is not supported"):
        read_problem(path)


def test_a_small_file_claims_no_more_numbers_than_it_can_hold(tmp_path: Path) -> None:
    """A chunk that was never written takes no place in the file, and all its place in memory."""
    h5py = pytest.importorskip("h5py")
    path = write_problem(some_problem(), tmp_path / "huge.hdf5")
    with h5py.File(path, "r+") as file:
        del file["fclib_local/W/x"]
        file.create_dataset("fclib_local/W/x", shape=(10**13,), dtype="f8", chunks=(1024,))
    with pytest.raises(sf.ProblemError, match="claims 10000000000000 entries"):
        read_problem(path)


def test_missing_and_unknown_files(tmp_path: Path) -> None:
    with pytest.raises(sf.ProblemError, match="no such file"):
        read_problem(tmp_path / "none.dat")
    with pytest.raises(sf.ProblemError, match=r"unknown kind of file '\.txt'"):
        read_problem(tmp_path / "none.txt")
    for name, words in (("a.npz", "no .npz file"), ("a.hdf5", "no FCLIB file")):
        (tmp_path / name).write_text("nonsense")
        with pytest.raises(sf.ProblemError, match=words):
            read_problem(tmp_path / name)


def test_planar_problem_is_solved_in_its_plane(tmp_path: Path) -> None:
    """A block on a slope in 2-D: (normal, tangent) rows, friction too weak to hold it."""
    path = tmp_path / "planar.dat"
    path.write_text("2 1 0 2 2 2 2  1.0 0.0 0.0 1.0  -2.0 -3.0  0.5")
    problem = read_problem(path)
    assert problem.contacts == 1
    assert "planar" in problem.notes[0]
    force = sf.solve(problem).raise_if_failed().forces[0]
    assert force == pytest.approx([1.0, 0.0, 2.0], abs=1e-9)


def test_slight_asymmetry_is_noted(tmp_path: Path) -> None:
    path = tmp_path / "crooked.dat"
    path.write_text("3 1 0 3 3 3 3  1.0 0.001 0 0 1.0 0 0 0 1.0  -2.0 -3.0 0.0 0.5")
    problem = read_problem(path)
    assert "not symmetric as published (1.0e-03" in problem.notes[0]
    assert np.array_equal(problem.G, problem.G.T)


def test_global_fclib_problem_is_condensed(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    rng = np.random.default_rng(5)
    M = np.diag(rng.uniform(1.0, 3.0, size=6))
    H, f, w, mu = rng.normal(size=(6, 6)), rng.normal(size=6), rng.normal(size=6), np.array([0.3, 0.7])
    path = tmp_path / "global.hdf5"
    with h5py.File(path, "w") as file:
        group = file.create_group("fclib_global")
        group["spacedim"] = [3]
        for name, dense, kind in (("M", M, -1), ("H", H, 0)):
            part = group.create_group(name)
            matrix = sp.csc_matrix(dense) if kind == -1 else sp.coo_matrix(dense)
            part["m"], part["n"], part["nzmax"] = [6], [6], [matrix.nnz]
            part["nz"] = [-1 if kind == -1 else matrix.nnz]
            part["p"], part["i"] = (matrix.indptr, matrix.indices) if kind == -1 else (matrix.col, matrix.row)
            part["x"] = matrix.data
        group["vectors/f"], group["vectors/w"], group["vectors/mu"] = f, w, mu
    problem = read_problem(path)
    turned = [1, 2, 0, 4, 5, 3]
    assert np.allclose(problem.G, (H.T @ np.linalg.solve(M, H))[np.ix_(turned, turned)])
    assert np.allclose(problem.g, (H.T @ np.linalg.solve(M, f) + w)[turned])


@needs_shared
def test_every_shared_file_is_solved() -> None:
    """Up to 25 contacts to 1e-8 as published; larger ones to 1e-6, in less than a minute."""
    files = sorted((SHARED / "fc3d").iterdir())
    assert len(files) >= 16
    for path in files:
        problem = read_problem(path)
        tol = 1e-8 if problem.contacts <= 25 else 1e-6
        found = sf.solve(problem, tol=tol, max_time=30.0)
        assert found.solved, (path.name, found.status, found.residuals.velocity_error)


@needs_shared
def test_shared_lcp_files() -> None:
    """Lemke solves what it can in theory, proves what has no solution, and names the ray otherwise."""
    known = {  # solutions in the books that the examples are from, or in the files' own remarks
        "lcp_CPS_2.dat": [0.0, 1.0, 3.0],
        "lcp_Pang_isolated_sol.dat": [1.0, 0.0, 0.0],
        "lcp_deudeu.dat": [4.0 / 3.0, 7.0 / 3.0],
        "lcp_exp_murty2.dat": [0.0, 0.0, 0.0, 0.0, 0.0, 64.0],
    }
    infeasible = {"lcp_Pang_isolated_sol_perturbed.dat"}
    rays = {"lcp_CPS_3.dat"}  # a bimatrix game: M is not copositive-plus, and the first pivot meets a ray
    for path in sorted((SHARED / "lcp").iterdir()):
        found = sf.solve_lcp(read_lcp(path))
        if path.name in infeasible:
            assert found.status is sf.Status.INFEASIBLE, path.name
            assert found.proof is not None
            assert found.problem.proves_infeasible(found.proof)
        elif path.name in rays:
            assert found.status is sf.Status.STALLED
            assert "along a ray in z[3]" in found.message
        else:
            assert found.solved, (path.name, found.status, found.message)
            assert found.residual < 1e-12
        if path.name in known:
            assert found.z == pytest.approx(known[path.name]), path.name
    exponential = sf.solve_lcp(read_lcp(SHARED / "lcp" / "lcp_exp_murty2.dat"))
    assert exponential.iterations == 64
    dense, blocks = (read_lcp(SHARED / "lcp" / f"lcp_ortiz{kind}.dat") for kind in ("", "_block"))
    assert np.array_equal(dense.M, blocks.M)


def test_generated_problems_are_the_same_for_the_same_seed() -> None:
    a, b = problem_set("robot", seed=3, copies=0.25), problem_set("robot", seed=3, copies=0.25)
    other = problem_set("robot", seed=4, copies=0.25)
    assert [p.name for p in a] == [p.name for p in b]
    assert all(np.array_equal(p.problem.G, q.problem.G) for p, q in zip(a, b, strict=True))
    assert any(not np.array_equal(p.problem.g, q.problem.g) for p, q in zip(a, other, strict=True))
    assert max(p.problem.contacts for p in a) <= 25
