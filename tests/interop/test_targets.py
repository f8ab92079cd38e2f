"""What is written for other tools runs there, and allows the same forces."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from surefoot.control.gait_files import read_gaits
from surefoot.errors import ProblemError
from surefoot.interop import export_sequence, target_names
from surefoot.interop.targets.table import find_target
from surefoot.simulation import drake_python

sys.path.insert(0, str(Path(__file__).parent))
from sequences import random_sequence, sampled_forces

SAMPLES = 10_000
EDGE = 1e-9
"""Forces this near to a face [N] may be called either way."""


def longest(sequence: Any) -> int:
    """Return the phase with the most contacts."""
    return int(np.argmax([len(phase.names) for phase in sequence.phases]))


def verdicts(sequence: Any, phase: int, forces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return which forces our half-spaces allow, and which are too near to a face to tell."""
    A, b = sequence.bounded_rows(phase)
    worst = (forces @ A.T - b).max(axis=1)
    return worst <= 0.0, np.abs(worst) < EDGE


def module_from(path: Path, **stand_ins: Any) -> Any:
    """Run a written file and return it as a module; stand_ins take the place of modules."""
    made = types.ModuleType(path.stem)
    before = {name: sys.modules.get(name) for name in stand_ins}
    sys.modules.update(stand_ins)
    try:
        exec(compile(path.read_text(encoding="utf-8"), str(path), "exec"), made.__dict__)
    finally:
        for name, old in before.items():
            if old is None:
                del sys.modules[name]
            else:
                sys.modules[name] = old
    return made


@pytest.mark.parametrize("name", target_names())
def test_every_target_writes_what_compiles(name: str, tmp_path: Path) -> None:
    for seed in range(10):
        for path in export_sequence(random_sequence(seed), name, tmp_path / str(seed)):
            text = path.read_text(encoding="utf-8")
            assert text.strip()
            if path.suffix == ".py":
                compile(text, str(path), "exec")
                assert "surefoot" not in text.lower().replace("written by surefoot", "")
    with pytest.raises(ProblemError, match="exists already"):
        export_sequence(random_sequence(0), name, tmp_path / "0")


def test_an_unknown_target_lists_the_known() -> None:
    with pytest.raises(ProblemError, match="valid names: acados, casadi"):
        find_target("matlab")


@pytest.mark.parametrize("seed", range(5))
def test_casadi_allows_the_same_forces(seed: int, tmp_path: Path) -> None:
    ca = pytest.importorskip("casadi")
    sequence = random_sequence(seed)
    phase = longest(sequence)
    made = module_from(export_sequence(sequence, "casadi", tmp_path)[0])
    dim = sequence.phases[phase].stance.dim
    for kind in (ca.SX, ca.MX):
        f = kind.sym("f", dim)
        h = ca.Function("h", [f], [ca.mmax(made.linear(phase, f))]).map(SAMPLES)
        forces = sampled_forces(sequence, phase, SAMPLES, seed)
        allowed = np.asarray(h(forces.T)).ravel() <= 0.0
        ours, near = verdicts(sequence, phase, forces)
        assert np.array_equal(allowed | near, ours | near)
        assert 0.02 < ours.mean() < 0.98


def test_casadi_exact_cones_are_round_and_smooth(tmp_path: Path) -> None:
    ca = pytest.importorskip("casadi")
    sequence = random_sequence(2, patches=False)
    phase = longest(sequence)
    made = module_from(export_sequence(sequence, "casadi", tmp_path)[0])
    stance = sequence.phases[phase].stance
    f = ca.SX.sym("f", stance.dim)
    h = ca.Function("h", [f], [made.exact(phase, f)])
    forces = sampled_forces(sequence, phase, 2000, 5)
    for force in forces:
        allowed = float(ca.mmax(h(force))) <= 0.0
        margin = min(
            min(
                c.mu * x[2] - np.hypot(x[0], x[1]), x[2] - c.normal_min, c.normal_max - x[2]
            )
            for c, x in zip(stance, force.reshape(-1, 3), strict=True)
        )  # fmt: skip
        if abs(margin) > 1e-6:
            assert allowed == (margin > 0.0)
    jacobian = ca.Function("J", [f], [ca.jacobian(made.exact(phase, f), f)])
    assert np.isfinite(np.asarray(jacobian(np.zeros(stance.dim)))).all()  # also at the apex


def test_acados_takes_the_same_rows(tmp_path: Path) -> None:
    ca = pytest.importorskip("casadi")
    sequence = random_sequence(4)
    phase = longest(sequence)
    made = module_from(export_sequence(sequence, "acados", tmp_path)[0])
    f = ca.SX.sym("f", sequence.phases[phase].stance.dim)
    none = types.SimpleNamespace
    ocp = none(model=none(con_h_expr=ca.SX(0, 0)), constraints=none(lh=np.zeros(0), uh=np.zeros(0)))
    made.add_contact_constraints(ocp, phase, f)
    h = ca.Function("h", [f], [ocp.model.con_h_expr])
    forces = sampled_forces(sequence, phase, 500, 4)
    allowed = np.array([bool((np.asarray(h(x)).ravel() <= ocp.constraints.uh).all()) for x in forces])
    ours, near = verdicts(sequence, phase, forces)
    assert np.array_equal(allowed | near, ours | near)
    rows = ocp.constraints.uh.size
    made.add_contact_constraints(ocp, phase, f)  # what is there is kept
    assert ocp.constraints.uh.size == ocp.constraints.lh.size == 2 * rows
    assert ocp.model.con_h_expr.numel() == 2 * rows


@pytest.mark.parametrize("seed", range(20))
def test_ocs2_reads_back_the_same_modes(seed: int, tmp_path: Path) -> None:
    sequence = random_sequence(seed)
    path = export_sequence(sequence, "ocs2", tmp_path)[0]
    schedule = read_gaits(path, 4, max_flight=np.inf)["sequence"]
    assert np.allclose(schedule.event_times, sequence.switching[1:-1], atol=1e-9)
    for k, phase in enumerate(sequence.phases):
        middle = sequence.switching[k] + 0.5 * phase.duration
        assert schedule.contacts([middle])[0].tolist() == [name in phase.names for name in sequence.frames]


def test_ocs2_refuses_three_feet() -> None:
    sequence = random_sequence(0)
    from dataclasses import replace

    with pytest.raises(ProblemError, match="2 or 4 feet"):
        find_target("ocs2").files(replace(sequence, frames=(*sequence.frames, "ARM")))


def test_isaac_lab_gives_every_foot_its_ground(tmp_path: Path) -> None:
    sequence = random_sequence(6)
    utils = types.ModuleType("isaaclab.sim")
    utils.RigidBodyMaterialCfg = types.SimpleNamespace  # type: ignore[attr-defined]
    package = types.ModuleType("isaaclab")
    package.sim = utils  # type: ignore[attr-defined]
    path = export_sequence(sequence, "isaaclab", tmp_path)[0]
    made = module_from(path, isaaclab=package, **{"isaaclab.sim": utils})
    for k, phase in enumerate(sequence.phases):
        middle = sequence.switching[k] + 0.5 * phase.duration
        for contact in phase.stance:
            material = made.ground_material(contact.name, middle)
            assert material.static_friction == material.dynamic_friction == contact.mu
        for name in set(sequence.frames) - set(phase.names):
            with pytest.raises(KeyError):
                made.ground_material(name, middle)


def ask(python: str, code: str, folder: Path, forces: np.ndarray) -> np.ndarray:
    """Return what another Python says of forces: it may crash, and that is an error of this test."""
    np.save(folder / "forces.npy", forces)
    env = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    done = subprocess.run(
        [python, "-c", code], cwd=folder, env=env, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return np.array(json.loads(done.stdout.strip().splitlines()[-1]), dtype=bool)


DRAKE = """
import json, numpy as np
from pydrake.solvers import MathematicalProgram
import contacts_drake as c
prog = MathematicalProgram(); f = c.new_forces(prog, {phase}); bound = c.add_linear(prog, f, {phase})
A, up = bound.evaluator().GetDenseA(), bound.evaluator().upper_bound()
x = np.load("forces.npy"); print(json.dumps((x @ A.T <= up).all(axis=1).tolist()))
"""
CROCODDYL = """
import json, numpy as np
import contacts_crocoddyl as c
x, at, ok = np.load("forces.npy"), 0, True
cones = c.cones({phase})
for contact in c.PHASES[{phase}]["contacts"]:
    own, dim = cones[contact["frame"]], contact["dim"]
    y = x[:, at:at + dim] @ own.A.T
    ok = ok & (y <= own.ub).all(axis=1) & (y >= own.lb).all(axis=1)
    at += dim
print(json.dumps(ok.tolist()))
"""


def other_python(name: str) -> str:
    """Return the interpreter that has a package, from the environment, or skip."""
    found = os.environ.get(f"SUREFOOT_{name.upper()}_PYTHON", "")
    if not found:
        pytest.skip(f"SUREFOOT_{name.upper()}_PYTHON names no interpreter with {name}")
    return found


@pytest.mark.parametrize("seed", range(3))
def test_drake_allows_the_same_forces(seed: int, tmp_path: Path) -> None:
    if not drake_python.present():
        pytest.skip("Drake is not installed, and SUREFOOT_DRAKE_PYTHON names no interpreter that has it")
    sequence = random_sequence(seed)
    phase = longest(sequence)
    export_sequence(sequence, "drake", tmp_path)
    forces = sampled_forces(sequence, phase, SAMPLES, seed)
    allowed = ask(drake_python.interpreter(), DRAKE.format(phase=phase), tmp_path, forces)
    ours, near = verdicts(sequence, phase, forces)
    assert np.array_equal(allowed | near, ours | near)


@pytest.mark.parametrize("seed", range(3))
def test_crocoddyl_allows_the_same_forces(seed: int, tmp_path: Path) -> None:
    python = other_python("crocoddyl")
    sequence = random_sequence(seed)
    phase = longest(sequence)
    export_sequence(sequence, "crocoddyl", tmp_path)
    forces = sampled_forces(sequence, phase, SAMPLES, seed)
    allowed = ask(python, CROCODDYL.format(phase=phase), tmp_path, forces)
    ours, near = verdicts(sequence, phase, forces)
    assert np.array_equal(allowed | near, ours | near)
