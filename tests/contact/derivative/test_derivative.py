"""What `ContactSolution.derivative` promises besides its accuracy (tests/adversary/test_derivatives.py)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import NoSolution
from surefoot.contact.derivative import kinks
from surefoot.contact.derivative.central_path import central_path
from surefoot.contact.derivative.solution_derivative import BLOCKS


def a_problem(seed: int = 0, contacts: int = 4, **changes: Any) -> sf.ContactProblem:
    rng = np.random.default_rng(seed)
    m = 3 * contacts
    J = rng.normal(size=(m, m + 4))
    g = rng.normal(size=m)
    g[2::3] -= 0.7
    return sf.ContactProblem(**({"G": J @ J.T / m, "g": g, "mu": 0.5} | changes))


def rates(rng: np.random.Generator, n: int) -> dict[str, np.ndarray]:
    G = rng.normal(size=(3 * n, 3 * n))
    return {
        "G": G, "g": rng.normal(size=3 * n), "mu": rng.normal(size=n), "normal_min": rng.normal(size=n),
        "normal_max": rng.normal(size=n), "compliance": rng.normal(size=3 * n),
    }  # fmt: skip


@pytest.mark.parametrize("law", ["coulomb", "convex"])
@pytest.mark.parametrize("smoothing", [0.0, 1e-4])
def test_blocks_products_and_gradients_agree(law: str, smoothing: float) -> None:
    problem = a_problem(3, law=law, normal_max=[0.3, 0.4, np.inf, np.inf], normal_min=0.05)
    d = sf.solve(problem).derivative(smoothing=smoothing)
    rng = np.random.default_rng(1)
    given = rates(rng, 4)
    vectors = {name: given[name] for name in ("g", "mu", "normal_min", "normal_max")}
    found = d.jvp(**vectors)
    for what in ("forces", "velocities"):
        total = sum(getattr(d, f"d{what}_d{name}") @ rate for name, rate in vectors.items())
        np.testing.assert_allclose(total.reshape(4, 3), getattr(found, what), rtol=1e-11, atol=1e-12)
    found = d.jvp(**given)
    f, u = rng.normal(size=(2, 4, 3))
    back = d.vjp(forces=f, velocities=u)
    ahead = (f * found.forces).sum() + (u * found.velocities).sum()
    assert abs(sum((getattr(back, n) * r).sum() for n, r in given.items()) - ahead) < 1e-12 * max(
        1.0, abs(ahead)
    )
    np.testing.assert_array_equal(back.G, back.G.T)
    assert set(BLOCKS) <= set(dir(d))


def test_the_point_is_polished() -> None:
    problem = a_problem(7)
    d = sf.solve(problem, tol=1e-4).derivative()
    assert sf.residuals(problem, d.forces).worst < 1e-14
    np.testing.assert_allclose(d.forces, sf.solve(problem, tol=1e-14).forces, rtol=1e-12, atol=1e-13)


def test_the_condition_of_a_contact_that_sticks_is_that_of_its_matrix() -> None:
    d = sf.solve(sf.ContactProblem(np.diag([1.0, 2.0, 4.0]), [0.1, 0.0, -1.0], 0.5)).derivative()
    assert d.condition == pytest.approx(4.0)


def test_unsolved_problems_have_none() -> None:
    impossible = sf.ContactProblem(np.diag([1.0, 1.0, 0.0]), [0.0, 0.0, -1.0], 0.5)
    with pytest.raises(NoSolution):
        sf.solve(impossible).derivative()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"g": np.zeros(11)}, r"g must have shape \(12,\), got \(11,\)"),
        ({"G": np.zeros((12, 11))}, r"G must have shape \(12, 12\)"),
        ({"mu": np.zeros(3)}, r"mu must be a number or have shape \(4,\)"),
        ({"compliance": np.zeros(5)}, r"compliance must be a number or have shape \(4,\) or \(12,\)"),
        ({"normal_max": np.array([0.0, np.nan, 0.0, 0.0])}, r"normal_max\[1\] is NaN"),
    ],
)
def test_wrong_rates_are_named(arguments: dict[str, Any], words: str) -> None:
    d = sf.solve(a_problem()).derivative()
    with pytest.raises(sf.ProblemError, match=words):
        d.jvp(**arguments)


def test_wrong_weights_and_settings_are_named() -> None:
    solution = sf.solve(a_problem())
    with pytest.raises(sf.ProblemError, match=r"velocities must have shape \(4, 3\), got \(12,\)"):
        solution.derivative().vjp(velocities=np.zeros(12))
    with pytest.raises(sf.ProblemError, match="smoothing must be a number"):
        solution.derivative(smoothing=-1.0)


def test_kinks_are_named_with_their_distance() -> None:
    """A block at rest on the edge of its cone: pulled less it sticks, pulled more it slides."""
    forces = np.array([-0.5, 0.0, 1.0])
    d = sf.solve(sf.ContactProblem(np.eye(3), -forces, 0.5)).derivative()
    (kink,) = d.kinks
    assert (kink.contact, set(kink.modes)) == (0, {"stick", "slide"})
    assert kink.distance < 1e-12
    less, more = d.jvp(g=[-1.0, 0.0, 0.0]), d.jvp(g=[1.0, 0.0, 0.0])
    np.testing.assert_allclose(less.forces, [[1.0, 0.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(less.velocities, np.zeros((1, 3)), atol=1e-12)
    np.testing.assert_allclose(more.forces, np.zeros((1, 3)), atol=1e-12)
    np.testing.assert_allclose(more.velocities, [[1.0, 0.0, 0.0]], atol=1e-12)
    near = sf.solve(sf.ContactProblem(np.eye(3), -forces * [0.999, 1.0, 1.0], 0.5)).derivative()
    assert near.kinks == ()
    assert near.modes == ("stick",)
    (kink,) = sf.solve(near.problem).derivative(kink_tol=1e-2).kinks
    assert kink.distance == pytest.approx(5e-4 / np.linalg.norm(near.problem.g), rel=1e-6)


def test_a_body_that_touches_without_load_begins_to_slide_or_lifts() -> None:
    d = sf.solve(sf.ContactProblem(np.eye(3), np.zeros(3), 0.5)).derivative()
    assert d.modes == ("open",)
    slides = d.jvp(g=[3.0, 4.0, -2.0])
    np.testing.assert_allclose(slides.forces, [[-0.6, -0.8, 2.0]], atol=1e-12)
    sticks = d.jvp(g=[0.3, 0.4, -2.0])
    np.testing.assert_allclose(sticks.forces, [[-0.3, -0.4, 2.0]], atol=1e-12)
    lifts = d.jvp(g=[3.0, 4.0, 2.0])
    np.testing.assert_allclose(lifts.forces, np.zeros((1, 3)), atol=1e-12)


@pytest.mark.parametrize("pivots", [100, 0])
def test_rates_of_bodies_that_touch_without_load_are_a_contact_problem(
    pivots: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Cones know no size: the rates obey the law itself, however their modes are found."""
    monkeypatch.setattr(kinks, "PIVOTS", pivots)  # at 0 all choices are tried in turn
    J = np.random.default_rng(2).normal(size=(9, 12))
    d = sf.solve(sf.ContactProblem(J @ J.T, np.zeros(9), 0.5)).derivative()
    for seed in range(8):
        b = np.random.default_rng(seed).normal(size=9)
        wanted = sf.solve(sf.ContactProblem(J @ J.T, b, 0.5), tol=1e-12)
        found = d.jvp(g=b)
        np.testing.assert_allclose(found.forces, wanted.forces, atol=1e-9)
        np.testing.assert_allclose(found.velocities, wanted.velocities, atol=1e-9)


def test_friction_that_begins_is_a_kink_where_nothing_slips() -> None:
    """Ice under a block that is not pulled: friction has no direction yet."""
    d = sf.solve(sf.ContactProblem(np.eye(3), [0.0, 0.0, -1.0], 0.0)).derivative()
    assert [kink.contact for kink in d.kinks] == [0]
    np.testing.assert_array_equal(d.dforces_dmu, np.zeros((3, 1)))
    found = d.jvp(g=[3.0, 4.0, 0.0], mu=1.0)
    np.testing.assert_allclose(found.forces, [[-0.6, -0.8, 0.0]], atol=1e-12)
    pulled = sf.solve(sf.ContactProblem(np.eye(3), [3.0, 4.0, -1.0], 0.0)).derivative()
    assert pulled.kinks == ()
    np.testing.assert_allclose(pulled.dforces_dmu, [[-0.6], [-0.8], [0.0]], atol=1e-12)


def test_redundant_contacts_are_flagged_and_projected() -> None:
    """Two contacts of one point mass: their sum is determined, and they must be moved alike."""
    J = np.vstack([np.eye(3), np.eye(3)])
    g = J @ np.array([0.1, 0.0, -1.0])
    d = sf.solve(sf.ContactProblem(J @ J.T, g, 0.5)).derivative()
    assert d.redundant
    assert d.velocities_determined
    assert (d.rank, d.size) == (3, 6)
    together = d.jvp(g=J @ np.array([0.0, 0.0, -1.0]))
    assert together.removed < 1e-14
    np.testing.assert_allclose(together.forces.sum(axis=0), [0.0, 0.0, 1.0], atol=1e-14)
    apart = d.jvp(g=[0.0, 0.0, 1.0, 0.0, 0.0, -1.0])
    assert apart.removed == pytest.approx(np.sqrt(2.0))
    np.testing.assert_allclose(apart.velocities, np.zeros((2, 3)), atol=1e-14)


def test_redundant_contacts_that_slide_leave_velocities_open() -> None:
    """A spinning, sliding plate on four points: how they share the load turns the friction."""
    places = np.array([[1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0]])
    J = np.vstack([np.hstack([np.eye(3), [[0, z, -y], [-z, 0, x], [y, -x, 0]]]) for x, y, z in places])
    g = J @ np.array([0.3, 0.1, -1.0, 0.0, 0.0, 2.0])
    d = sf.solve(sf.ContactProblem(J @ J.T, g, 0.2)).derivative()
    assert d.redundant
    assert not d.velocities_determined


class TestSmoothing:
    """The derivative on the central path."""

    def test_tends_to_the_exact_one(self) -> None:
        solution = sf.solve(a_problem(2))
        exact = solution.derivative()
        gaps = []
        for smoothing in (1e-3, 1e-5, 1e-7):
            d = solution.derivative(smoothing=smoothing)
            gaps.append(float(np.abs(d.dforces_dg - exact.dforces_dg).max()))
        assert gaps[2] < 1e-4
        assert gaps[0] > gaps[1] > gaps[2]

    def test_is_on_the_path(self) -> None:
        problem = a_problem(2, law="convex")
        d = sf.solve(problem).derivative(smoothing=1e-3)
        np.testing.assert_allclose((d.forces * d.velocities).sum(axis=1), 1e-3, rtol=1e-9)
        np.testing.assert_allclose(d.velocities, problem.velocity(d.forces))

    def test_open_contacts_have_gradients(self) -> None:
        solution = sf.solve(sf.ContactProblem(np.eye(3), [0.2, 0.0, 0.5], 0.5))
        assert np.abs(solution.derivative().dforces_dg).max() == 0.0
        d = solution.derivative(smoothing=1e-3)
        assert d.dforces_dg[2, 2] < -1e-3
        assert d.vjp(forces=[[0.0, 0.0, 1.0]]).g[2] == pytest.approx(d.dforces_dg[2, 2])

    @pytest.mark.parametrize("law", ["coulomb", "convex"])
    def test_against_differences_of_the_path(self, law: str) -> None:
        bounds = {"normal_min": [0.1, 0.0, 0.2, 0.0], "normal_max": [0.6, 0.0, np.inf, 2.0]}
        problem = a_problem(5, law=law, bilateral=None, **bounds)
        solution, κ, h = sf.solve(problem), 1e-2, 1e-6
        d = solution.derivative(smoothing=κ)
        rng = np.random.default_rng(3)
        given = {"mu": rng.normal(size=4), "normal_max": np.array([1.0, 0.0, 0.0, -1.0])}
        if law == "convex":  # Coulomb's rounding ε goes by the problem's speed, and is held in the derivative
            given |= {"g": rng.normal(size=12), "normal_min": np.array([1.0, 0.0, -1.0, 0.0])}
        found = d.jvp(**given)
        ends = []
        for s in (h, -h):
            changes = {name: getattr(problem, name) + s * rate for name, rate in given.items()}
            ends.append(central_path(problem.replace(**changes), d.forces, κ))
        np.testing.assert_allclose((ends[0].forces - ends[1].forces) / (2 * h), found.forces, atol=2e-7)
        np.testing.assert_allclose(
            (ends[0].velocities - ends[1].velocities) / (2 * h), found.velocities, atol=2e-7
        )

    def test_what_it_cannot_do_is_named(self) -> None:
        with pytest.raises(sf.ProblemError, match="derivatives take exact cones"):
            sf.solve(a_problem(1, facets=4)).derivative()
        with pytest.raises(sf.ProblemError, match="normal_min < normal_max"):
            sf.solve(a_problem(1, normal_min=1.0, normal_max=1.0)).derivative(smoothing=1e-3)


def test_no_contacts() -> None:
    d = sf.solve(sf.ContactProblem(np.zeros((0, 0)), np.zeros(0), 0.5)).derivative()
    assert d.jvp(g=np.zeros(0)).forces.shape == (0, 3)
    assert d.vjp(forces=np.zeros((0, 3))).G.shape == (0, 0)


@pytest.mark.parametrize("other", [{"contacts": [sf.contact_sets.SoftFinger(0.5, 0.01)]}, {"law": "half"}])
def test_what_has_no_derivative_is_refused(other: dict[str, Any]) -> None:
    law = sf.laws.Law("half", 0.5) if "law" in other else None
    problem = (
        sf.ContactProblem(np.eye(3), [0.1, 0.0, -1.0], 0.5, law=law)
        if law is not None
        else sf.ContactProblem(np.eye(4), [0.1, 0.0, -1.0, 0.0], **other)
    )
    with pytest.raises(sf.ProblemError, match="derivatives take"):
        sf.solve(problem).derivative()
