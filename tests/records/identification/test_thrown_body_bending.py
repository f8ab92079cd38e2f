"""Hinges that give: the tree and its springs against Pinocchio, and against a rigid one as they stiffen."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from benchmarks.problems.tosses import ELBOW, random_tosses
from surefoot.records.identification.ground_plane import GroundPlane
from surefoot.records.identification.identify import identify
from surefoot.records.identification.thrown_body import ThrownBody, thrown_body
from surefoot.records.identification.thrown_body_bending import RELAXES
from surefoot.records.identification.thrown_body_tree import FallingBody, dynamics, place, work_arrays
from surefoot.records.identification.toss_model import ThrownModel, TossScene

CHAIN = """
<robot name="chain">
  <link name="a"><inertial><mass value="0.4"/><origin xyz="0.01 0 0"/>
    <inertia ixx="5e-4" iyy="6e-4" izz="7e-4" ixy="0" ixz="1e-4" iyz="0"/></inertial>
    <collision><geometry><box size="0.1 0.05 0.05"/></geometry></collision></link>
  <link name="b"><inertial><mass value="0.3"/><origin xyz="0.03 0.01 0"/>
    <inertia ixx="4e-4" iyy="5e-4" izz="4e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="c"><inertial><mass value="0.2"/><origin xyz="0 0.02 0.01"/>
    <inertia ixx="2e-4" iyy="3e-4" izz="2e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="d"><inertial><mass value="0.1"/><origin xyz="0.02 0 0.01"/>
    <inertia ixx="2e-4" iyy="2e-4" izz="2e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="first" type="continuous"><parent link="a"/><child link="b"/>
    <origin xyz="0.05 0.01 0" rpy="0.3 0 0.2"/><axis xyz="0 1 0"/></joint>
  <joint name="second" type="prismatic"><parent link="b"/><child link="c"/>
    <origin xyz="0.04 0 0.02"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="third" type="continuous"><parent link="c"/><child link="d"/>
    <origin xyz="0 0.03 0" rpy="0 0.4 0"/><axis xyz="1 0 0"/></joint>
</robot>
"""


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> dict[str, ThrownBody]:
    folder = tmp_path_factory.mktemp("models")
    found = {}
    for name, text in (("elbow", ELBOW), ("chain", CHAIN)):
        path = folder / f"{name}.urdf"
        path.write_text(text)
        found[name] = thrown_body(path)
    return found


def test_what_gives_has_two_springs_behind_its_joint(models: dict[str, ThrownBody]) -> None:
    chain = models["chain"]
    assert chain.bend_hinges().tree.masses.size == 4, "a rigid one is as it was"
    own = {"compliance_first": 0.02, "compliance_third": 0.05}
    names = [p.name for p in chain.parameters]
    assert [name for name in names if name.startswith("compliance")] == list(own), "a slide does not give"
    bent = chain.at(own).bend_hinges()
    tree = bent.tree
    np.testing.assert_array_equal(tree.parents, [-1, 0, 1, 2, 3, 4, 5, 6])
    np.testing.assert_array_equal(bent.columns, [0, 1, 2, 3, 4, 5, 6, 7, 10, 11])
    assert [list(bent.joints(i)) for i in (1, 2, 3)] == [[1, 2, 3], [4], [5, 6, 7]]
    np.testing.assert_array_equal(tree.masses, [0.4, 0.0, 0.0, 0.3, 0.2, 0.0, 0.0, 0.1])
    np.testing.assert_allclose(tree.stiffness, [0.0, 0.0, 50.0, 50.0, 0.0, 0.0, 20.0, 20.0])
    np.testing.assert_allclose(tree.damping, RELAXES * tree.stiffness)
    for joints in ((1, 2, 3), (5, 6, 7)):
        axes = tree.axes[list(joints)]
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    wide = bent.widen(np.arange(1.0, 20.0)[None])
    np.testing.assert_array_equal(wide[0, bent.columns], np.arange(1.0, 11.0))
    np.testing.assert_array_equal(wide[0, 14:], [*range(11, 18), 0, 0, 18, 19, 0, 0])


def test_motion_with_springs_is_pinocchios(models: dict[str, ThrownBody]) -> None:
    bent = models["chain"].at({"compliance_first": 0.02, "compliance_third": 0.05}).bend_hinges()
    tree, random = bent.tree, np.random.default_rng(0)
    model = _pinocchio(tree)
    data, n = model.createData(), tree.masses.size - 1
    for _ in range(5):
        q = np.concatenate([random.normal(size=3), [0.0, 0.0, 0.0, 1.0], 0.3 * random.normal(size=n)])
        v = random.normal(size=6 + n)
        at = work_arrays(tree)
        place(tree, q, at)
        dynamics(tree, at, q, v, np.array([0.0, 0.0, -9.81]), 0.0)
        ours = np.linalg.solve(np.tril(at.M) @ np.tril(at.M).T, at.f)
        torques = (
            -tree.stiffness[1:] * q[7:] - np.where(tree.stiffness[1:] > 0.0, tree.damping[1:], 0.0) * v[6:]
        )
        theirs = pin.aba(model, data, q, v, np.append(np.zeros(6), torques))
        theirs[:3] += np.cross(v[3:6], v[:3])  # of the origin, in axes that do not turn
        np.testing.assert_allclose(ours, theirs, rtol=1e-8, atol=1e-7)
        # over a step, backward Euler's own equation: M a = f(q + h (v + h a), v + h a), springs alone
        h = 1e-3
        dynamics(tree, at, q, v, np.array([0.0, 0.0, -9.81]), h)
        implicit = np.linalg.solve(np.tril(at.M) @ np.tril(at.M).T, at.f)
        after = v + h * implicit
        held = tree.stiffness[1:] * (q[7:] + h * after[6:])
        held += np.where(tree.stiffness[1:] > 0.0, tree.damping[1:], 0.0) * after[6:]
        theirs = pin.aba(model, data, q, v, np.append(np.zeros(6), -held))
        theirs[:3] += np.cross(v[3:6], v[:3])
        np.testing.assert_allclose(implicit, theirs, rtol=1e-8, atol=1e-6)


def _pinocchio(tree: FallingBody) -> pin.Model:
    """Return a tree of ours as Pinocchio's model."""
    model = pin.Model()
    made = [model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "free")]
    for i in range(1, tree.masses.size):
        kind = pin.JointModelPrismaticUnaligned if tree.sliding[i] else pin.JointModelRevoluteUnaligned
        at = pin.SE3(tree.turns[i], tree.places[i])
        made.append(model.addJoint(made[tree.parents[i]], kind(tree.axes[i]), at, f"joint{i}"))
    for joint, mass, centre, inertia in zip(made, tree.masses, tree.centres, tree.inertias, strict=True):
        model.appendBodyToJoint(joint, pin.Inertia(float(mass), centre, inertia), pin.SE3.Identity())
    return model


def test_a_stiff_hinge_is_a_rigid_one_and_a_soft_one_meets_the_ground_alone(
    models: dict[str, ThrownBody],
) -> None:
    """A bar falls on one end, the other hangs on a hinge: what the ground gives it stops what it meets."""
    elbow, level = models["elbow"], GroundPlane(0.0, np.zeros(2))
    start = [0.0, 0.0, 0.06, *np.array([0.2, 0.1, 0.0, 1.0]) / np.sqrt(1.05), 0.4]
    start += [0.3, 0.0, -1.0, 1.0, 2.0, 0.0, 3.0]

    def end(compliance: float) -> np.ndarray:
        body = elbow.at({"compliance_hinge": compliance})
        scene = TossScene(np.array([start]), np.array([12]), 0.005, level, 9.81, body)
        return ThrownModel(steps=20).rollout(np.array([0.2, 0.3, 0.0]), scene)

    rigid = end(0.0)
    assert rigid.shape == (12, 8)
    stiff = [np.abs(end(c) - rigid).max() for c in (1e-7, 1e-5, 1e-2)]
    assert stiff[0] < 1e-4
    assert stiff[0] < stiff[1] < stiff[2]
    assert stiff[2] > 1e-3


@pytest.mark.long
def test_how_far_a_hinge_gives_is_found(tmp_path: Path) -> None:
    path = tmp_path / "elbow.urdf"
    path.write_text(ELBOW)
    for compliance in (0.0, 5e-3):
        true = thrown_body(path).at({"compliance_hinge": compliance})
        recorded = random_tosses(24, (0.2, 0.3, 0.0), seed=4, frames=60, steps=2, body=true)
        found = identify(recorded, ThrownModel(steps=2), model=path, resamples=100)["compliance_hinge"]
        assert found.value == pytest.approx(compliance, abs=1e-3)
        assert found.low <= compliance <= found.high
