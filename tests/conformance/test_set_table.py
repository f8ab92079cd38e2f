"""Every solver for contacts of any kind, on every kind, under every law, against judges of another make.

The laws are written out kind by kind from forces and velocities; the convex law is also solved as the cone
program that it is, by Clarabel, with each set typed in by hand; small problems by SciPy.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sparse
from scipy.optimize import minimize, nnls
from set_judge import check_laws

import surefoot as sf
from surefoot.contact.sets import ContactKind
from surefoot.contact.sets.contact_set import ContactSet

C = sf.contact_sets
KINDS: dict[str, ContactKind] = {
    "frictionless": C.Frictionless(),
    "planar": C.Planar(0.5),
    "point": C.Point(0.5),
    "soft finger": C.SoftFinger(0.5, 0.03),
    "rolling": C.Rolling(0.5, 0.02),
    "patch": C.DecoupledSole(0.5, 0.2, 0.1, 0.03),
    "pyramid": C.Pyramid(0.5, 6),
    "bilateral": C.Bilateral(2),
}
SOLVERS = {"auto": 1.0, "admm": 1.0, "newton": 0.9}
"""Share of the problems below that each must solve to 1e-8."""
HALF = sf.laws.Law("half dilatant", shift=0.5)
LAWS = (sf.laws.COULOMB, sf.laws.CONVEX, HALF)


def problem_of(
    contacts: list[ContactKind], seed: int, law: str, rank: int | None = None
) -> sf.ContactProblem:
    """A problem whose contacts press, slide, tip and take off; of full rank, or of a rank."""
    rng = np.random.default_rng(seed)
    s = ContactSet(contacts)
    J = rng.normal(size=(s.rows, rank or 2 * s.rows)) / s.lengths[:, None]
    G = J @ J.T / J.shape[1]
    if rank is None:
        G[np.diag_indices(s.rows)] += 0.3 / s.lengths**2
        g = rng.normal(size=s.rows) / s.lengths
        g[s.normal_rows] -= 0.7
    else:
        g = J @ rng.normal(size=rank) / math.sqrt(rank)
    return sf.ContactProblem(G, g, contacts=contacts, law=law)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("kind", list(KINDS))
@pytest.mark.parametrize("solver", list(SOLVERS))
@pytest.mark.sampled(18)
def test_solves_its_share_by_the_laws_themselves(solver: str, kind: str, law: str) -> None:
    solved, total = 0, 24
    for seed in range(total):
        contacts = [KINDS[kind]] * (1 + seed % 4) + [C.Frictionless()] * (seed % 2)
        rank = None if seed % 3 else 6  # the motion of one body: redundant from the second contact on
        problem = problem_of(contacts, seed, law, rank)
        found = sf.solve(problem, solver, max_time=5.0)
        worst = found.residuals.worst
        assert found.solved == (worst <= 1e-8)
        assert np.allclose(found.velocities, problem.velocity(found.forces), atol=1e-12 * 100)
        solved += found.solved
        if found.solved:
            scale = float(np.abs(problem.g * problem.contact_set.lengths).max())
            parts = problem.contact_set.split
            for contact, f, u in zip(contacts, parts(found.forces), parts(found.velocities), strict=True):
                check_laws(contact, f, u, law.shift, 1e-6 * max(scale, 1.0))
    assert solved >= SOLVERS[solver] * total, f"solved {solved} of {total}"


def cone_rows(contact: ContactKind) -> list[np.ndarray]:
    """The second-order cones of a set by hand: a matrix's first row times f bounds the norm of the others."""
    E = np.eye(contact.rows)
    z = E[contact.normal]
    name = type(contact).__name__
    if name == "Frictionless":
        return [z[None, :]]
    if name == "Planar":
        return [np.array([contact.mu * z, E[0]])]
    if name == "Pyramid":
        cone = sf.FrictionCone(contact.mu).polyhedral(contact.facets, contact.fit)
        return [-row[None, :] for row in cone.halfspaces]
    slide = [contact.mu * z, E[0], E[1]]
    if name == "SoftFinger":
        return [np.array([*slide, E[3] / contact.radius])]
    rows = [np.array(slide)]
    if name == "Rolling":
        rows.append(np.array([z, E[3] / contact.resistance, E[4] / contact.resistance]))
    if name == "DecoupledSole":
        for row, limit in ((3, 0.5 * contact.width), (4, 0.5 * contact.length), (5, contact.torsion)):
            rows.append(np.array([z, E[row] / limit]))
    return rows


def by_clarabel(problem: sf.ContactProblem, contacts: list[ContactKind]) -> np.ndarray:
    """The forces of least energy, by an interior point of other people."""
    clarabel = pytest.importorskip("clarabel")
    blocks: list[Any] = []
    cones = []
    at = 0
    for contact in contacts:
        for rows in [] if contact.bilateral else cone_rows(contact):
            whole = np.zeros((len(rows), problem.g.size))
            whole[:, at : at + contact.rows] = rows
            blocks.append(-whole)
            cones.append(
                clarabel.NonnegativeConeT(1) if len(rows) == 1 else clarabel.SecondOrderConeT(len(rows))
            )
        at += contact.rows
    A = sparse.csc_matrix(np.vstack(blocks)) if blocks else sparse.csc_matrix((0, problem.g.size))
    options = clarabel.DefaultSettings()
    options.verbose = False
    options.tol_gap_abs = options.tol_gap_rel = 1e-11
    options.tol_feas = 1e-11
    P = sparse.csc_matrix(np.triu(problem.G))
    solver = clarabel.DefaultSolver(P, problem.g, A, np.zeros(A.shape[0]), cones, options)
    return np.asarray(solver.solve().x)


@pytest.mark.parametrize("kind", list(KINDS))
@pytest.mark.parametrize("solver", list(SOLVERS))
def test_the_convex_law_is_the_cone_program(solver: str, kind: str) -> None:
    for seed in range(6):
        contacts = [KINDS[kind], C.Planar(0.3), KINDS[kind]]
        problem = problem_of(contacts, 100 + seed, "convex")
        found = sf.solve(problem, solver, 1e-10)
        assert found.solved
        lengths = problem.contact_set.lengths
        expected = by_clarabel(problem, contacts)
        assert np.allclose(found.forces.ravel() / lengths, expected / lengths, atol=1e-5)
        ours, theirs = (0.5 * f @ problem.G @ f + problem.g @ f for f in (found.forces.ravel(), expected))
        assert ours <= theirs + 1e-10


def test_small_programs_by_scipy() -> None:
    """Frictionless contacts as non-negative least squares, planar ones by SLSQP."""
    for seed in range(5):
        problem = problem_of([C.Frictionless()] * 4, seed, "coulomb")
        L = np.linalg.cholesky(problem.G)
        expected = nnls(L.T, -np.linalg.solve(L, problem.g))[0]
        assert np.allclose(sf.solve(problem, tol=1e-10).forces[:, 0], expected, atol=1e-8)
        problem = problem_of([C.Planar(0.4)] * 2, seed, "convex")
        limits = [
            {"type": "ineq", "fun": lambda f, k=k, s=s: 0.4 * f[2 * k + 1] + s * f[2 * k]}
            for k in range(2)
            for s in (1.0, -1.0)
        ]
        program = minimize(
            lambda f, p=problem: 0.5 * f @ p.G @ f + p.g @ f, np.ones(4), constraints=limits,
            options={"ftol": 1e-15, "maxiter": 500},
        )  # fmt: skip
        assert np.allclose(sf.solve(problem, tol=1e-10).forces.ravel(), program.x, atol=1e-5)


@pytest.mark.parametrize("law", ["coulomb", "convex"])
def test_points_by_the_general_path_are_points(law: str) -> None:
    """The certificate and the forces agree with those of the compiled path, whose code is another."""
    for seed in range(10):
        rng = np.random.default_rng(seed)
        J = rng.normal(size=(12, 24))
        G, g = J @ J.T / 24 + 0.3 * np.eye(12), rng.normal(size=12)
        points = sf.ContactProblem(G, g, 0.5, law=law)
        turn = np.kron(np.eye(4), np.eye(4)[:, :3])  # a soft finger without radius has one more row
        spin = np.diag(np.tile([0.0, 0.0, 0.0, 1.0], 4))
        fingers = sf.ContactProblem(
            turn @ G @ turn.T + spin, turn @ g, contacts=[C.SoftFinger(0.5, 0.0)] * 4, law=law
        )
        a, b = sf.solve(points, tol=1e-11), sf.solve(fingers, tol=1e-11)
        assert np.allclose(a.forces, b.forces[:, :3], atol=1e-9)
        assert not b.forces[:, 3].any()
        trial = rng.normal(size=(4, 3)) + np.array([0.0, 0.0, 1.0])
        one = sf.residuals(points, trial)
        other = sf.residuals(fingers, np.column_stack([trial, np.zeros(4)]))
        for name in (
            "velocity_error",
            "energy_gap",
            "cone_violation",
            "penetration_velocity",
            "complementarity",
            "dissipation",
        ):
            assert getattr(one, name) == pytest.approx(getattr(other, name), rel=1e-6), name
        for solver in ("admm", "newton"):
            assert np.allclose(sf.solve(points, solver, 1e-11).forces, a.forces, atol=1e-9)


def test_planar_is_a_point_that_cannot_leave_its_plane() -> None:
    for seed in range(10):
        planar = problem_of([C.Planar(0.5)] * 3, seed, "coulomb")
        spread = np.zeros((9, 6))
        spread[[0, 2, 3, 5, 6, 8], range(6)] = 1.0
        G = spread @ planar.G @ spread.T
        G[[1, 4, 7], [1, 4, 7]] = 1.0
        points = sf.ContactProblem(G, spread @ planar.g, 0.5)
        a, b = sf.solve(planar, tol=1e-11).forces, sf.solve(points, tol=1e-11).forces
        assert np.allclose(a, b[:, [0, 2]], atol=1e-9)


def sole(position: np.ndarray) -> np.ndarray:
    """The (6, 6) Jacobian of a sole at a position of a rigid body: twist [linear; angular] to its own."""
    x, y, z = position
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.block([[np.eye(3), -skew], [np.zeros((3, 3)), np.eye(3)]])


@pytest.mark.parametrize("law", ["coulomb", "convex"])
@pytest.mark.parametrize("speed", [0.0, 0.4, 3.0])
@pytest.mark.parametrize("rate", [0.0, 0.3, 4.0])
def test_a_patch_is_its_four_corners(speed: float, rate: float, law: str) -> None:
    """A block that sticks, slides or tips in its plane of symmetry, where no yaw is in play: one wrench."""
    length, width, height, mass = 0.2, 0.1, 0.15, 4.0
    inverse = np.diag(1.0 / np.array([mass, mass, mass, 0.05, 0.06, 0.08]))
    v = np.array([speed, 0.0, -0.5, 0.0, rate, 0.0])
    P = sole(np.array([0.0, 0.0, -height]))
    corners = [np.array([a * length / 2, b * width / 2, -height]) for a in (1, -1) for b in (1, -1)]
    J = np.vstack([sole(corner)[:3] for corner in corners])
    patch = sf.ContactProblem(
        P @ inverse @ P.T, P @ v, contacts=[C.DecoupledSole(0.6, length, width, torsion=0.05)], law=law
    )
    points = sf.ContactProblem(J @ inverse @ J.T, J @ v, 0.6, law=law)
    one = sf.solve(patch, tol=1e-10).raise_if_failed().forces.ravel()
    four = sf.solve(points, tol=1e-10).raise_if_failed().forces
    if law == "coulomb" or speed == 0.0:
        assert np.allclose(P.T @ one, J.T @ four.ravel(), atol=1e-6 * mass)
    assert np.abs(one[5]) < 1e-8


def test_what_has_no_solution_is_proven_and_what_cannot_be_proven_is_not_claimed() -> None:
    press = [[1.0, -1.0], [-1.0, 1.0]]
    squeezed = sf.solve(sf.ContactProblem(press, [-1.0, -1.0], contacts=[C.Frictionless()] * 2))
    assert squeezed.status is sf.Status.INFEASIBLE
    d = squeezed.proof.direction.ravel()  # type: ignore[union-attr]
    assert np.allclose(np.array(press) @ d, 0.0)
    assert d @ [-1.0, -1.0] < 0.0
    assert sf.solve(sf.ContactProblem(press, [-1.0, 1.0], contacts=[C.Frictionless()] * 2)).solved
    # one body between two soles that face each other and close, or turn into each other
    J = np.vstack([np.eye(6), np.diag([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])])
    patch = C.DecoupledSole(0.5, 0.2, 0.1, 0.02)
    for law in ("coulomb", "convex"):
        for g in ([0, 0, -1, 0, 0, 0] * 2, [0, 0, -0.1, 3, 0, 0] * 2):
            problem = sf.ContactProblem(J @ J.T, np.array(g, float), contacts=[patch] * 2, law=law)
            found = sf.solve(problem, max_time=5.0)
            assert found.status is sf.Status.INFEASIBLE
            assert found.proof is not None
            d = found.proof.direction.ravel()
            assert np.abs(problem.G @ d).max() < 1e-12 * np.abs(problem.G).max()
            assert problem.g @ d < 0.0
        assert sf.solve(
            sf.ContactProblem(J @ J.T, J @ [0.1, 0.2, -1, 0.3, 0.4, 0.5], contacts=[patch] * 2)
        ).solved
    # only friction could hold it: no proof under Coulomb's law of what a jam may do
    jam = sf.ContactProblem(np.zeros((4, 4)), [1.0, 0.0, 0.2, 0.0], contacts=[C.SoftFinger(0.5, 0.1)])
    assert sf.solve(jam).solved  # it slides and leaves
    jam = jam.replace(law="convex")  # g is outside the dual cone: the energy falls for ever
    assert sf.solve(jam).status is sf.Status.INFEASIBLE


@pytest.mark.parametrize("solver", list(SOLVERS))
@pytest.mark.parametrize("unit", [1e-9, 1e-3, 1e3, 1e9])
def test_units_do_not_matter(unit: float, solver: str) -> None:
    contacts = [
        C.DecoupledSole(0.5, 0.2, 0.1, 0.02), C.SoftFinger(0.4, 0.01), C.Planar(0.3), C.Bilateral(2),
        C.Pyramid(0.4, 5, "outer"), C.Rolling(0.3, 0.01), C.Frictionless(normal_max=0.0), C.Point(0.4),
    ]  # fmt: skip
    for law in LAWS:
        problem = problem_of(contacts, 3, law)
        base = sf.solve(problem, solver, 1e-10)
        assert base.solved
        assert not problem.contact_set.split(base.forces)[6].any()
        heavy = sf.solve(problem.replace(G=unit * problem.G), solver, 1e-10)
        fast = sf.solve(problem.replace(g=unit * problem.g), solver, 1e-10)
        assert heavy.solved
        assert fast.solved
        lengths = problem.contact_set.lengths
        assert np.allclose(unit * heavy.forces / lengths, base.forces / lengths, atol=1e-7)
        assert np.allclose(fast.forces / unit / lengths, base.forces / lengths, atol=1e-7)


def test_bounds_and_warm_starts() -> None:
    contacts = [C.SoftFinger(0.4, 0.02, normal_min=0.2, normal_max=0.5), C.DecoupledSole(0.5, 0.2, 0.1, 0.02)]
    for law in LAWS:
        problem = problem_of(contacts, 5, law)
        cold = sf.solve(problem, tol=1e-10).raise_if_failed()
        assert 0.2 - 1e-9 <= cold.forces[2] <= 0.5 + 1e-9
        warm = sf.solve(problem, tol=1e-10, warm_start=cold.forces)
        assert warm.solved
        assert warm.iterations <= cold.iterations
        assert np.allclose(warm.forces, cold.forces, atol=1e-8)
    with pytest.raises(sf.ProblemError, match="warm_start must have shape"):
        sf.solve(problem, warm_start=np.zeros((2, 3)))


def test_forces_that_are_no_numbers_are_never_lawful() -> None:
    problem = problem_of([C.DecoupledSole(0.5, 0.2, 0.1, 0.02), C.Planar(0.3)], 1, "coulomb")
    forces = np.zeros(8)
    forces[3] = np.nan
    assert math.isnan(sf.residuals(problem, forces).worst)
    forces[3] = np.inf
    assert not sf.residuals(problem, forces).worst <= 1.0
    huge = 1e300 * np.ones(8)
    assert not sf.residuals(problem, huge).worst <= 1.0
