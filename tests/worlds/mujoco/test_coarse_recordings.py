"""Robots on coarse rows of Runge and Kutta's scheme, under random and no control: nobody pushes them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import surefoot as sf

mujoco = pytest.importorskip("mujoco")

LEG = """<body pos='{x} {y} 0'><geom name='thigh{n}' type='capsule' fromto='0 0 0 {x} {y} 0' size='.07'/>
<joint name='hip{n}' axis='0 0 1' range='-40 40'/><body pos='{x} {y} 0'>
<joint name='knee{n}' axis='{a} {b} 0' range='-10 70'/>
<geom name='shank{n}' type='capsule' fromto='0 0 0 {x2} {y2} 0' size='.07'/></body></body>"""
SIDES = [(0.2, 0.2), (-0.2, 0.2), (-0.2, -0.2), (0.2, -0.2)]
SPIDER = """<mujoco model='spider'><option integrator='RK4' timestep='{step}'/><compiler angle='degree'/>
<default><joint armature='1' damping='1'/><geom density='5' friction='1 .5 .5' margin='.01'/></default>
<worldbody><geom name='floor' type='plane' size='40 40 1'/><body name='trunk' pos='0 0 .7'><freejoint/>
<geom name='ball' type='sphere' size='.22'/>{legs}</body></worldbody><actuator>{motors}</actuator></mujoco>"""


def spider(step: float = 0.01) -> Any:
    """Return a light spider on four legs of two joints, whose contacts push from 20 mm above the ground."""
    legs = "".join(LEG.format(n=n, x=x, y=y, a=-y, b=x, x2=2 * x, y2=2 * y) for n, (x, y) in enumerate(SIDES))
    motors = "".join(
        f"<motor joint='{joint}{n}' gear='150' ctrlrange='-1 1' ctrllimited='true'/>"
        for n in range(4)
        for joint in ("hip", "knee")
    )
    return mujoco.MjModel.from_xml_string(SPIDER.format(step=step, legs=legs, motors=motors))


def recorded(model: Any, seed: int, size: float, seconds: float = 4.0, change: Any = None) -> sf.Log:
    """Return the log of random controls of a size, held for five steps, from a pose that is drawn."""
    rng, data = np.random.default_rng(seed), mujoco.MjData(model)
    data.qpos[:] += rng.uniform(-0.1, 0.1, model.nq)
    data.qvel[:] = 0.1 * rng.standard_normal(model.nv)
    with sf.record(model, data) as log:
        for k in range(round(seconds / model.opt.timestep / 5)):
            data.ctrl[:] = size * rng.uniform(-1.0, 1.0, model.nu)
            if change is not None and k == 40:
                change(data)
            mujoco.mj_step(model, data, nstep=5)
    return log


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("size", [0.0, 0.5, 1.0])
@pytest.mark.sampled(2)
def test_what_a_row_leaves_open_is_no_law_broken(seed: int, size: float) -> None:
    """Touches begin and stops are met within rows in which legs turn by a tenth of a radian."""
    report = sf.audit_log(recorded(spider(), seed, size))
    assert report.verdict != "broken", report.sentence
    assert not {"swapped feet", "outside force"} & {s.name for s in report.symptoms}


@pytest.mark.parametrize("seed", range(3))
def test_a_kick_is_found_all_the_same(seed: int) -> None:
    """A metre per second more in one row, on a robot that a row's openness must not hide."""

    def kick(data: Any) -> None:
        data.qvel[1] += 1.0

    report = sf.audit_log(recorded(spider(), seed, 0.2, change=kick))
    assert report.verdict == "broken"
    assert any(1.9 < v.start < 2.1 for v in report.violations), report.violations


def test_all_legs_are_feet_in_a_tilted_pose() -> None:
    """Legs of one kind are feet together, whichever is the lowest at the start."""
    log = recorded(spider(), 0, 0.0, seconds=1.0)
    owner = np.asarray(log.facts["contact_foot"], dtype=int)
    standing = np.asarray(log.facts["contact_is_foot"])
    told = {str(log.facts["feet"][k]): bool(s) for k, s in zip(owner, standing, strict=True)}
    legs = [name for name in told if name.startswith("shank")]
    assert len(legs) >= 2
    assert all(told[name] for name in legs)
    assert not told.get("ball", False)


def test_points_within_a_margin_are_in_the_middle_of_the_gap() -> None:
    """The ground that contact points show lies where it is."""
    from surefoot.records.audit.log_context import setting_of

    ground = setting_of(recorded(spider(), 1, 0.0), None).ground
    assert ground is not None
    assert abs(float(ground[3])) < 1e-3
