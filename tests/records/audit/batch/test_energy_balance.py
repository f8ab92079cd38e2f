"""The energy balance of joints, row by row: what is judged is summed anew in plain loops."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.records.audit.batch.environments import Environments
from surefoot.records.audit.batch.joint_work import JointArrays, judge_joints, read_joints
from surefoot.records.audit.limits import LIMITS, AuditLimits

T, N, J, DT = 9, 2, 3, 0.01
RNG = np.random.default_rng(6)
SPEEDS, TORQUES = RNG.normal(size=(T, N, J)), 4.0 * RNG.normal(size=(T, N, J))
ENERGY = RNG.normal(size=(T, N))
EPISODES = np.array([[0, 0, 9], [1, 0, 4], [1, 4, 9]])
WHOLE = np.array([[0, 0, 9], [1, 0, 9]])


def rules(way: float = 0.0, share: float = 0.0, window: float = 0.03) -> AuditLimits:
    rebound = replace(LIMITS.rebound, way=way, share=share)
    return replace(LIMITS, rebound=rebound, checks=replace(LIMITS.checks, slide_window=window))


def given(episodes: Any = EPISODES, **arrays: Any) -> Environments:
    forces = {"forces": np.zeros((T, N, 1, 3)), **arrays}
    return Environments(forces, DT, np.array([50.0, 20.0]), True, episodes, {}, ())


def summed(excess: Any, episodes: Any, rows: int) -> Any:
    """Return sums over so many rows up to each, none from before its episode, its last row left out."""
    out = np.zeros((T, N))
    for one, first, end in episodes:
        for t in range(first, end):
            out[t, one] = sum(excess[s, one] for s in range(max(first, t - rows + 1), t + 1) if s < end - 1)
    return out


def beyond(most: float, speeds: Any = SPEEDS, torques: Any = TORQUES) -> tuple[Any, Any]:
    """Return the work that joints do beyond a limit of their torques, and the size of all (T, N) [J]."""
    excess, size = np.zeros((T, N)), np.zeros((T, N))
    for t in range(T - 1):
        for one in range(N):
            for j in range(J):
                way = (speeds[t, one, j] + speeds[t + 1, one, j]) / 2.0 * DT
                tau = torques[t, one, j]
                limited = max(-most, min(most, tau))
                excess[t, one] += max(tau * way - limited * way, 0.0)
                size[t, one] += abs(tau * way)
    return excess, size


def test_work_beyond_the_limits_is_summed_within_episodes() -> None:
    joints = JointArrays(SPEEDS, TORQUES, None, np.array(2.0), 0.0)
    found, bad = judge_joints(joints, given(), rules(way=1e-4, share=0.1))
    excess, size = beyond(2.0)
    value, power = summed(excess, EPISODES, 3), summed(size, EPISODES, 3)
    limit = np.maximum(1e-4 * np.array([50.0, 20.0]), 0.1 * power)
    np.testing.assert_array_equal(bad, value > limit)
    assert bad.any(axis=0).all()
    assert not bad.all(axis=0).any()
    row = (value - limit).argmax(axis=0)
    every = np.arange(N)
    np.testing.assert_allclose(found.worst, value[row, every])
    np.testing.assert_allclose(found.limit, limit[row, every])
    np.testing.assert_allclose(found.instant, row * DT)
    np.testing.assert_allclose(found.share, bad.mean(axis=0))
    assert (found.name, found.unit, found.law) == ("joint work", "J", False)


def test_the_joint_that_works_hardest_is_named() -> None:
    torques = np.zeros((T, N, J))
    torques[3, 0, 2], torques[3, 0, 1] = -90.0, 50.0
    torques[6, 1, 1], torques[6, 1, 0] = 90.0, np.nan
    speeds = np.ones((T, N, J)) * [1.0, 1.0, -1.0]
    joints = JointArrays(speeds, torques, None, np.array(1.0), 0.0)
    found, _ = judge_joints(joints, given(WHOLE), rules(way=1e-4))
    assert found.contact[0] == 2
    torques[6, 1, 0] = 0.0
    found, _ = judge_joints(joints, given(WHOLE), rules(way=1e-4))
    assert found.contact.tolist() == [2, 1]


def test_energy_beyond_torques_and_what_is_open_is_told() -> None:
    for most in (np.inf, 2.0):
        joints = JointArrays(SPEEDS, TORQUES, ENERGY, np.array(most), 0.125)
        found, bad = judge_joints(joints, given(WHOLE), rules())
        excess = np.zeros((T, N))
        for t in range(T - 1):
            held = np.clip(TORQUES[t], -most, most)
            way = 0.5 * DT * (SPEEDS[t] + SPEEDS[t + 1])
            unsure = 0.5 * DT * np.abs(held * (SPEEDS[t + 1] - SPEEDS[t]))
            excess[t] = ENERGY[t + 1] - ENERGY[t] - (held * way + unsure).sum(axis=1)
        value = summed(excess, WHOLE, 3)
        np.testing.assert_array_equal(bad, value > 0.125)
        np.testing.assert_allclose(found.worst, value.max(axis=0))
        np.testing.assert_allclose(found.limit, 0.125)


def test_actuators_without_known_torques_may_push_as_hard_as_they_can() -> None:
    most = np.array([1.0, 2.0, 3.0])
    joints = JointArrays(SPEEDS, None, ENERGY, most, 0.0)
    found, _ = judge_joints(joints, given(WHOLE), rules(share=0.2))
    able = np.zeros((T, N))
    for t in range(T - 1):
        able[t] = (most * np.maximum(np.abs(SPEEDS[t]), np.abs(SPEEDS[t + 1])) * DT).sum(axis=1)
    gain = np.vstack([np.diff(ENERGY, axis=0), np.zeros((1, N))])
    value, power = summed(gain - able, WHOLE, 3), summed(able, WHOLE, 3)
    np.testing.assert_allclose(found.worst - found.limit, (value - 0.2 * power).max(axis=0))


def test_contacts_give_the_most_that_their_velocities_about_a_row_allow() -> None:
    forces, velocities = RNG.normal(size=(T, N, 2, 3)), RNG.normal(size=(T, N, 2, 3))
    joints = JointArrays(np.zeros((T, N, J)), np.zeros((T, N, J)), 0.1 * ENERGY, np.array(np.inf), 0.0)
    both = given(WHOLE, forces=forces, contact_velocities=velocities)
    found, _ = judge_joints(joints, both, rules(window=DT))
    excess = np.zeros((T, N))
    for t in range(T - 1):
        for one in range(N):
            excess[t, one] = 0.1 * (ENERGY[t + 1, one] - ENERGY[t, one])
            for p in range(2):
                near = [velocities[s, one, p] for s in (max(t - 1, 0), t, t + 1)]
                excess[t, one] -= DT * max(float(forces[t, one, p] @ v) for v in near)
    np.testing.assert_allclose(found.worst, excess.max(axis=0))


def test_rows_that_are_no_numbers_are_left_out() -> None:
    energy = ENERGY.copy()
    energy[4, 0] = np.nan
    joints = JointArrays(SPEEDS, TORQUES, energy, np.array(np.inf), 0.0)
    found, bad = judge_joints(joints, given(WHOLE), rules(window=DT))
    assert np.isfinite(found.worst).all()
    assert not bad[3:5, 0].any()


def read(**arrays: Any) -> JointArrays | None:
    limits = arrays.pop("limits", None)
    return read_joints(arrays, limits, (T, N))


def test_arrays_of_joints_are_read_as_they_are() -> None:
    assert read(forces=SPEEDS) is None
    one = read(joint_velocities=SPEEDS, torques=TORQUES, energy=ENERGY, limits=[1.0, 2.0, 0.0])
    assert one is not None
    for got, expected in ((one.velocities, SPEEDS), (one.torques, TORQUES), (one.energy, ENERGY)):
        assert got is not None
        np.testing.assert_array_equal(got, expected)
    np.testing.assert_array_equal(one.most, [1.0, 2.0, 0.0])
    free = read(joint_velocities=SPEEDS, torques=TORQUES, energy=ENERGY)
    assert free is not None
    assert np.isinf(np.broadcast_to(free.most, TORQUES.shape)).all()


@pytest.mark.parametrize(
    ("kind", "eps"), [(np.float64, 2.0**-52), (np.float32, 2.0**-23), (np.int64, 2.0**-52)]
)
def test_energies_are_rounded_in_their_own_precision(kind: Any, eps: float) -> None:
    energy = np.zeros((T, N), dtype=kind)
    energy[2, 1] = -8
    one = read(joint_velocities=SPEEDS, torques=TORQUES, energy=energy)
    assert one is not None
    assert one.rounding == pytest.approx(4.0 * eps * 8.0)
    bare = read(joint_velocities=SPEEDS, torques=TORQUES, limits=1.0)
    assert bare is not None
    assert bare.rounding == 0.0


SHAPE = "got the shape"


@pytest.mark.parametrize(("arrays", "words"), [
    ({"torques": TORQUES},
     "joint work needs the array joint_velocities (T, N, joints) beside torques and energy"),
    ({"joint_velocities": SPEEDS[:, 0]},
     "array joint_velocities must have shape (*(9, 2), joints), got (9, 3)"),
    ({"joint_velocities": SPEEDS[1:]},
     "array joint_velocities must have shape (*(9, 2), joints), got (8, 2, 3)"),
    ({"joint_velocities": SPEEDS, "torques": TORQUES[..., 1:]},
     "array torques must have shape (9, 2, 3), got (9, 2, 2)"),
    ({"joint_velocities": SPEEDS, "energy": ENERGY.T}, "array energy must have shape (9, 2), got (2, 9)"),
    ({"joint_velocities": SPEEDS, "torques": TORQUES},
     "joint work needs energy (T, N), or torques and the fact effort_limits, beside joint_velocities"),
    ({"joint_velocities": SPEEDS, "limits": 1.0},
     "joint work needs energy (T, N), or torques and the fact effort_limits, beside joint_velocities"),
    ({"joint_velocities": SPEEDS, "energy": ENERGY},
     "joint work needs torques (T, N, joints), or the fact effort_limits, beside energy"),
    ({"joint_velocities": SPEEDS, "energy": ENERGY, "limits": [1.0, 2.0]},
     f"the fact effort_limits must be >= 0, a number or (3,), {SHAPE} (2,)"),
    ({"joint_velocities": SPEEDS, "energy": ENERGY, "limits": [1.0, -2.0, 1.0]},
     f"the fact effort_limits must be >= 0, a number or (3,), {SHAPE} (3,)"),
])  # fmt: skip
def test_arrays_that_judge_nothing_are_refused(arrays: dict[str, Any], words: str) -> None:
    with pytest.raises(sf.ProblemError) as caught:
        read(**arrays)
    assert str(caught.value) == words
