"""The contact problem of a step, solved by others: what they find is what the stepper made of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError

from .scenes import arm, box, scene

DRIVEN = '<actuator><motor joint="first" gear="4"/></actuator>'
HELD = '<equality><joint joint1="second" joint2="first" polycoef="0 1 0 0 0"/></equality>'
SCENES: dict[str, tuple[Any, ...]] = {
    "box": (scene(box(mu=0.4), mu=0.4), (3.0, 0.5, 0.0)),
    "stack": (scene(box(), box("0.03 0 0.305", name="top")), (0.0, 1.0, 0.0)),
    "frictionless": (scene(box(dim=1), mu=0.0), (1.0, 0.0, 0.0)),
    "implicit": (scene(box(), option='cone="elliptic" integrator="implicitfast"'), (2.0, 0.0, 0.0)),
    "limits": (scene(box(), arm("0 0.01", damping=0.3)), (2.0, 0.0, 0.0)),
    "dry": (scene(box(), arm(dry=0.4, damping=0.1)), (2.0, 0.0, 0.0)),
    "equality": (scene(box(), arm("-90 90"), extra=HELD), (2.0, 0.0, 0.0)),
    "torsional": (scene(box(dim=4)), (0.5, 0.0, 0.0)),
}  # fmt: skip


def begin(name: str) -> tuple[Any, Any, sf.MujocoStepper]:
    """Return model, data and stepper of a scene that has gone on for a while."""
    model, speed = SCENES[name]
    data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
    data.qvel[:3] = speed
    for _ in range(30):
        stepper.step(data)
    return model, data, stepper


@pytest.mark.parametrize("name", list(SCENES))
def test_other_solvers_find_what_the_stepper_found(name: str) -> None:
    """The stepper's impulses by another judge, and velocities of another solver.

    A stack's are not unique under Coulomb's law: which of its corners carries decides what they rub.
    """
    _, data, stepper = begin(name)
    found = stepper.problem(data)
    assert found.status.value == "solved"
    assert len(found.names) == found.problem.contacts
    solution = sf.solve(found.problem, tol=1e-9)
    assert solution.solved, solution
    speed = float(np.abs(found.problem.g).max())
    own = found.problem.G @ found.impulses.ravel() + found.problem.g
    if name != "stack":
        np.testing.assert_allclose(solution.velocities.ravel(), own, atol=2e-6 * speed)
    told = sf.residuals(found.problem, found.impulses)
    assert told.velocity_error < 1e-6 * speed, told


@pytest.mark.parametrize("name", ["box", "limits", "dry", "equality"])
def test_the_step_goes_where_its_problem_says(name: str) -> None:
    """The sum of a step's forces is that of the problem's impulses, and asking changed nothing."""
    model, data, stepper = begin(name)
    before = data.qpos.copy(), data.qvel.copy(), *stepper.last_impulses()
    found, again = stepper.problem(data), stepper.problem(data)
    for one, two in zip(before, (data.qpos, data.qvel, *stepper.last_impulses()), strict=True):
        np.testing.assert_array_equal(one, two)
    np.testing.assert_array_equal(found.impulses, again.impulses)
    stepper.step(data)
    h = model.opt.timestep
    pressed = found.impulses[[k for k, n in enumerate(found.names) if n.startswith("floor")], 2]
    force = np.zeros(6)
    normal = 0.0
    for c in range(data.ncon):
        mujoco.mj_contactForce(stepper.model, data, c, force)
        normal += force[0]
    assert pressed.sum() == pytest.approx(h * normal, rel=1e-9)


def test_clarabel_agrees_where_nothing_slides() -> None:
    """A crate at rest: the convex problem has the same solution there, found by an interior point code."""
    clarabel = pytest.importorskip("clarabel")
    from scipy import sparse

    model = SCENES["box"][0]
    data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
    for _ in range(60):
        stepper.step(data)
    problem = stepper.problem(data).problem
    n = problem.contacts
    rows = np.zeros((3 * n, 3 * n))
    for k in range(n):
        rows[3 * k, 3 * k + 2] = problem.mu[k]
        rows[3 * k + 1, 3 * k] = rows[3 * k + 2, 3 * k + 1] = 1.0
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-12
    solver = clarabel.DefaultSolver(
        sparse.csc_matrix(np.triu(problem.G)), problem.g, sparse.csc_matrix(-rows), np.zeros(3 * n),
        [clarabel.SecondOrderConeT(3)] * n, settings,
    )  # fmt: skip
    forces = np.array(solver.solve().x)
    np.testing.assert_allclose(problem.G @ forces + problem.g, 0.0, atol=1e-7)
    own = stepper.problem(data).impulses
    np.testing.assert_allclose(forces.reshape(-1, 3).sum(axis=0)[2], own[:, 2].sum(), rtol=1e-6)


def test_a_problem_goes_into_a_file_and_comes_back(tmp_path: Path) -> None:
    _, data, stepper = begin("dry")
    found = stepper.problem(data)
    path = sf.write_problem(found.problem, tmp_path / "step.npz", found.impulses)
    read = sf.read_problem(path)
    np.testing.assert_array_equal(read.G, found.problem.G)
    np.testing.assert_array_equal(read.reference, found.impulses)
    assert sf.solve(read, tol=1e-8).solved
    assert "dry of first" in found.names


def test_what_no_problem_holds_is_refused() -> None:
    air = scene(box("0 0 3"))
    with pytest.raises(ProblemError, match="no constraint is active"):
        sf.MujocoStepper(air).problem(mujoco.MjData(air))
    rolling = scene(box(dim=6))
    with pytest.raises(ProblemError, match="rolling friction"):
        sf.MujocoStepper(rolling).problem(mujoco.MjData(rolling))
    soft = scene(box(name="rubber_1"))
    with pytest.raises(ProblemError, match="is soft"):
        sf.MujocoStepper(soft, soft="rubber_*").problem(mujoco.MjData(soft))
