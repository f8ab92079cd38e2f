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

import surefoot as sf
from surefoot.app.export import TARGETS, ContactSequence, SequencePhase, export_sequence
from surefoot.app.export.targets.target_names import find_target
from surefoot.base.errors import ProblemError
from surefoot.mechanics.stance import PointContact
from surefoot.worlds.drake import drake_python
from tests.app.export.sequences import random_sequence, sampled_forces

SAMPLES = 10_000
EDGE = 1e-9
"""Forces this near to a face [N] may be called either way."""


def longest(sequence: Any) -> int:
    """Return the phase with the most contacts."""
    return int(np.argmax([len(phase.names) for phase in sequence.phases]))


def verdicts(sequence: Any, phase: int, forces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return which forces our half-spaces allow, and which are too near to a face to tell."""
    rows = sequence.halfspaces(phase)
    A, b = rows.A, rows.b
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


@pytest.mark.parametrize("name", TARGETS)
def test_every_target_writes_what_compiles(name: str, tmp_path: Path) -> None:
    for seed in range(10):
        sequence = random_sequence(seed, patches=name != "ocs2", lean=0.05)
        for path in export_sequence(sequence, name, tmp_path / str(seed)):
            text = path.read_text(encoding="utf-8")
            assert text.strip()
            if path.suffix == ".py":
                compile(text, str(path), "exec")
                assert "surefoot" not in text.lower().replace("written by surefoot", "")
    with pytest.raises(ProblemError, match="exists already"):
        export_sequence(sequence, name, tmp_path / "0")


def test_an_unknown_target_lists_the_known() -> None:
    with pytest.raises(ProblemError, match="valid names: casadi, crocoddyl"):
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


def info(text: str) -> dict[str, Any]:
    """Return INFO notation as Boost's `read_info` reads it: words by line, `;` begins a comment."""
    tree: dict[str, Any] = {}
    stack, last = [tree], ""
    for line in text.splitlines():
        for word in [line.split(";")[0].split()]:
            if word == ["{"]:
                stack[-1][last] = inner = {}
                stack.append(inner)
            elif word == ["}"]:
                stack.pop()
            elif word:
                last, stack[-1][word[0]] = word[0], " ".join(word[1:])
    assert len(stack) == 1
    return tree


def values(block: dict[str, Any]) -> list[str]:
    """Return [0], [1], ... as OCS2's `loadStdVector` does: up to the first that is missing."""
    out: list[str] = []
    while f"[{len(out)}]" in block:
        out.append(block[f"[{len(out)}]"])
    return out


@pytest.mark.parametrize("seed", range(20))
def test_ocs2_reads_gait_and_schedule(seed: int, tmp_path: Path) -> None:
    """What its `loadModeSequenceTemplate`, `loadModeSchedule` and `loadFrictionConeSettings` ask for."""
    sequence = random_sequence(seed, patches=False, lean=0.05)
    gaits, friction = export_sequence(sequence, "ocs2", tmp_path)
    found = info(gaits.read_text())
    for name in values(found["list"]):
        assert len(values(found[name]["modeSequence"])) == len(sequence.phases)
    assert np.allclose(np.array(values(found["sequence"]["switchingTimes"]), float), sequence.switching)
    events = values(found["initialModeSchedule"].get("eventTimes", {}))
    assert np.allclose(np.array(events, float), sequence.switching[1:-1], atol=1e-9)
    for phase, mode in zip(sequence.phases, values(found["sequence"]["modeSequence"]), strict=True):
        feet = zip(("LF", "RF", "LH", "RH"), sequence.frames, strict=True)
        on = "_".join(label for label, frame in feet if frame in phase.names)
        assert mode == {"": "FLY", "LF_RF_LH_RH": "STANCE"}.get(on, on)
    keys = info(friction.read_text())["frictionConeSoftConstraint"]
    assert {k: float(v) for k, v in keys.items() if k != "frictionCoefficient"} == {"mu": 0.1, "delta": 5.0}


@pytest.mark.parametrize("seed", range(5))
def test_ocs2s_upright_cone_is_inside_every_contacts_own(seed: int, tmp_path: Path) -> None:
    sequence = random_sequence(seed, patches=False, lean=0.03)
    friction = export_sequence(sequence, "ocs2", tmp_path)[1]
    mu = float(info(friction.read_text())["frictionConeSoftConstraint"]["frictionCoefficient"])
    angle = np.linspace(0.0, 2.0 * np.pi, 720)
    edge = np.column_stack([mu * np.cos(angle), mu * np.sin(angle), np.ones(720)])
    used = []
    for contact in (c for phase in sequence.phases for c in phase.stance):
        own = edge @ contact.rotation_world_contact
        used.append((np.hypot(own[:, 0], own[:, 1]) / (contact.mu * own[:, 2])).max())
    assert max(used) == pytest.approx(1.0, abs=1e-4)  # and no smaller than it has to be


def test_what_ocs2_cannot_say_is_refused() -> None:
    normal = sf.SlopeTerrain(25.0).normal([0.0, 0.0])
    feet = [PointContact((x, 0.0, 0.0), normal, 0.4, f"{x}") for x in range(4)]
    for frames, contacts, told in (
        (5, [], "name 4 feet, the sequence has 5"),
        (2, [], "name 4 feet, the sequence has 2"),
        (4, [sf.SoleContact((0.0, 0.0, 0.0), sf.Sole(0.1, 0.1), name="0")], "0 is a sole"),
        (4, feet, "none is inside that of 0, which leans by 25 deg at mu 0.4"),
    ):
        names = [f"{k}" for k in range(frames)]
        sequence = ContactSequence([SequencePhase(0.1, sf.Stance(contacts))], names)
        with pytest.raises(ProblemError, match=told):
            find_target("ocs2")(sequence)


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


class TsidContact(types.SimpleNamespace):
    """Stands for TSID's contacts: keeps what it is given, and has their rows."""

    def __init__(self, name: str, robot: object, frame: str, *rest: Any) -> None:
        *corners, normal, mu, low, high = rest
        super().__init__(name=name, frame=frame, corners=corners, normal=normal, mu=mu, low=low, high=high)
        self.local = True  # TaskSE3Equality's own choice

    def useLocalFrame(self, local: bool) -> None:
        self.local = local

    @property
    def rows(self) -> np.ndarray:
        """B of B @ force <= 0 (4, 3), as updateForceInequalityConstraints() of its source forms it."""
        first = np.cross(self.normal, [1.0, 0.0, 0.0])
        second = np.cross(self.normal, first)
        sides = [v / np.linalg.norm(v) for v in (first, second)]
        return np.array([sign * v - self.mu * self.normal for v in sides for sign in (-1.0, 1.0)])


@pytest.mark.parametrize("seed", range(5))
def test_tsids_pyramids_are_inside_the_cones_of_their_contacts(seed: int, tmp_path: Path) -> None:
    sequence = random_sequence(seed, fit="inner")
    tsid = types.SimpleNamespace(ContactPoint=TsidContact, Contact6d=TsidContact)
    made = module_from(export_sequence(sequence, "tsid", tmp_path)[0], tsid=tsid)
    forces = np.random.default_rng(seed).normal(size=(2000, 3)) * [20.0, 20.0, 20.0] + [0.0, 0.0, 30.0]
    for k, phase in enumerate(sequence.phases):
        found = made.contacts(None, k)
        assert set(found) == set(phase.names)
        for contact in phase.stance:
            one, point = found[contact.name], isinstance(contact, PointContact)
            assert one.frame == contact.name
            allowed = forces[(forces @ one.rows.T <= 0.0).all(axis=1)]
            local = allowed if one.local else allowed @ contact.rotation_world_contact
            assert one.local != point  # in the foot's own axes the normal would turn with a tilted foot
            assert len(allowed) > 20
            assert sf.FrictionCone(contact.mu).contains(local).all()
            for corners in one.corners:
                assert np.ptp(corners, axis=1).tolist() == [contact.sole.length, contact.sole.width, 0.0]


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
@pytest.mark.parametrize(("name", "code"), [("drake", DRAKE), ("crocoddyl", CROCODDYL)])
def test_another_tool_allows_the_same_forces(name: str, code: str, seed: int, tmp_path: Path) -> None:
    if name == "drake" and not drake_python.present():
        pytest.skip("Drake is not installed, and SUREFOOT_DRAKE_PYTHON names no interpreter that has it")
    python = drake_python.interpreter() if name == "drake" else other_python(name)
    sequence = random_sequence(seed)
    phase = longest(sequence)
    export_sequence(sequence, name, tmp_path)
    forces = sampled_forces(sequence, phase, SAMPLES, seed)
    allowed = ask(python, code.format(phase=phase), tmp_path, forces)
    ours, near = verdicts(sequence, phase, forces)
    assert np.array_equal(allowed | near, ours | near)
