"""Joint work that actuators cannot give: MuJoCo's own energies, honest loops and those that get more."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.arrays import FloatArray

mujoco: Any = pytest.importorskip("mujoco")

ARM = """<mujoco><option timestep="0.002"><flag energy="enable" contact="disable"/></option><worldbody><body>
<joint name="a" axis="0 1 0" damping="{damping}"/>
<geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass="1"/><body pos=".3 0 0">
<joint name="b" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass=".5"/></body></body>
</worldbody><actuator><motor joint="a"/><motor joint="b"/></actuator></mujoco>"""
LIMITS = np.array([8.0, 3.0])
EXPLOIT = "joint work beyond the actuators"


def arm(seed: int, push: float = 0.0, strong: float = 1.0, damping: float = 0.3) -> dict[str, FloatArray]:
    """Return (T, 1, ...) arrays of an arm under random torques, within limits times `strong`, and a push."""
    model = mujoco.MjModel.from_xml_string(ARM.format(damping=damping))
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    rows: dict[str, list[Any]] = {"torques": [], "joint_velocities": [], "energy": []}
    for k in range(600):
        if k % 25 == 0:
            data.ctrl[:] = strong * LIMITS * rng.uniform(-1.0, 1.0, 2)
        data.xfrc_applied[2, :3] = push * data.cvel[2, 3:] if 200 <= k < 300 else 0.0
        rows["joint_velocities"].append(data.qvel.copy())
        mujoco.mj_step(model, data)
        rows["torques"].append(data.qfrc_actuator.copy())
        rows["energy"].append(float(data.energy.sum()))
    arrays = {name: np.array(values)[:, None] for name, values in rows.items()}
    arrays["forces"] = np.zeros((600, 1, 1, 3))
    return arrays


def told(arrays: dict[str, FloatArray], **options: Any) -> set[str]:
    report = sf.audit_batch(arrays, 0.002, mu=0.6, mass=1.5, **options)
    return {one.name for one in report.exploits}


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("damping", [0.15, 0.5])
def test_an_honest_arm_is_within_its_actuators(seed: int, damping: float) -> None:
    """By its torques, by its limits alone, and by both; in single precision too."""
    arrays = arm(seed, damping=damping)
    assert EXPLOIT not in told(arrays, facts={"effort_limits": LIMITS})
    assert EXPLOIT not in told(arrays)
    assert EXPLOIT not in told({name: array.astype(np.float32) for name, array in arrays.items()})
    without = {name: array for name, array in arrays.items() if name != "torques"}
    assert EXPLOIT not in told(without, facts={"effort_limits": LIMITS})


@pytest.mark.parametrize("seed", range(3))
def test_torques_beyond_the_limits_are_found_with_their_joint(seed: int) -> None:
    """Three times the torque: with the energies, and without them."""
    arrays = arm(seed, strong=3.0)
    assert EXPLOIT not in told(arrays)  # whoever tells no limits is believed
    assert EXPLOIT in told(arrays, facts={"effort_limits": LIMITS})
    del arrays["energy"]
    report = sf.audit_batch(arrays, 0.002, mu=0.6, mass=1.5, facts={"effort_limits": LIMITS})
    law = report["joint work"]
    row = round(float(law.instant[0]) / 0.002)
    assert (
        np.abs(arrays["torques"][max(row - 25, 0) : row + 1, 0, law.contact[0]]) > LIMITS[law.contact[0]]
    ).any()


def test_energy_from_nowhere_is_found_with_its_time_and_reward() -> None:
    """A hand that pushes along the motion from 0.4 to 0.6 s."""
    arrays, reward = arm(1, push=4.0), np.zeros((600, 1))
    reward[200:300] = 1.0
    report = sf.audit_batch(arrays, 0.002, mu=0.6, mass=1.5, reward=reward)
    found = {one.name: one for one in report.exploits}[EXPLOIT]
    assert 0.4 <= found.instant <= 0.66
    assert found.reward > 0.2
    assert "broken" not in report.verdicts  # a sign, no law of contact


def test_no_window_reaches_across_episodes() -> None:
    """A reset to more energy is no work."""
    one, two = arm(2), arm(3)
    arrays = {name: np.concatenate([one[name], two[name]]) for name in one}
    arrays["energy"][600:] += 1000.0
    done = np.zeros((1200, 1), dtype=bool)
    done[599] = True
    assert EXPLOIT in told(arrays)
    assert EXPLOIT not in told(arrays, done=done)


@pytest.mark.parametrize(
    ("lacks", "limits", "line"),
    [
        (("joint_velocities",), None, "joint work needs the array joint_velocities"),
        (("energy",), None, "joint work needs energy"),
        (("torques",), None, "joint work needs torques"),
        ((), -1.0, "the fact effort_limits must be >= 0"),
        ((), np.ones(3), "must be >= 0, a number or \\(2,\\), got"),
    ],
)
def test_what_judges_nothing_is_one_line(lacks: tuple[str, ...], limits: Any, line: str) -> None:
    arrays = {name: array for name, array in arm(0).items() if name not in lacks}
    with pytest.raises(sf.SurefootError, match=line):
        told(arrays, facts=None if limits is None else {"effort_limits": limits})
