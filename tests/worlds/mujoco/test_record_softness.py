"""What MuJoCo's models declare of their softness, against MuJoCo itself."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.contact import MujocoLaw
from surefoot.mechanics.robot import load_robot, place
from surefoot.mechanics.terrain import FlatTerrain
from surefoot.motion.standing.standing_controller import StandingController
from surefoot.motion.standing.standing_plan import StandingPlan
from surefoot.records.audit.limits import LIMITS
from surefoot.records.audit.log_context import setting_of
from surefoot.worlds.interface.world_names import make_world
from surefoot.worlds.mujoco.landing import impedance_at
from surefoot.worlds.mujoco.record_softness import SoftContact, soft_contact
from surefoot.worlds.running.run import Scenario, run
from surefoot.worlds.running.scenario import STANDING_FALL, START_DEPTH
from tests.worlds.mujoco.recordings import recorded

mujoco = pytest.importorskip("mujoco")

SCENE = """<mujoco><option cone='{cone}' impratio='{ratio}'/><worldbody>
<geom type='plane' size='5 5 1' friction='{mu}' {soft}/>
<body pos='0 0 {height}'><freejoint/>
 <geom type='{kind}' size='{size}' mass='5' friction='{mu}' {soft}/></body>
</worldbody></mujoco>"""
SPHERE, BOX = ("sphere", ".1"), ("box", ".2 .2 .1")


def scene(kind: tuple[str, str], height: float, soft: str = "", cone: str = "elliptic", ratio: int = 1,
          mu: float = 0.6) -> object:  # fmt: skip
    shape, size = kind
    text = SCENE.format(cone=cone, ratio=ratio, mu=mu, soft=soft, height=height, kind=shape, size=size)
    return mujoco.MjModel.from_xml_string(text)


SOFTNESS = ["", "solref='0.005 1'", "solref='-5000 -100'", "solimp='0.8 0.95 0.005'"]


@pytest.mark.parametrize("cone", ["elliptic", "pyramidal"])
@pytest.mark.parametrize(
    ("ratio", "mu", "soft"), [(1, 0.3, ""), (10, 1.0, ""), *((1, 0.6, s) for s in SOFTNESS[1:])]
)
def test_rest_depth_and_creep_are_the_engines(cone: str, ratio: int, mu: float, soft: str) -> None:
    model = scene(BOX, 0.1, soft, cone, ratio, mu)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 3000)
    found = soft_contact(mujoco, model, (0, 1), data.contact[0])
    assert found is not None
    share = 5.0 * 9.81 / 4.0
    assert found.sinking(share) == pytest.approx(-np.mean(data.contact.dist), rel=1e-3)
    data.xfrc_applied[1, :2] = 0.1 * mu * 5.0 * 9.81, 0.0
    mujoco.mj_step(model, data, 2000)
    creep = float(data.qvel[0])
    assert creep == pytest.approx(0.1 * found.creep(share), rel=0.1)


@pytest.mark.parametrize("soft", SOFTNESS)
@pytest.mark.parametrize("drop", [0.005, 0.2])
def test_a_ball_lands_as_deep_as_declared(soft: str, drop: float) -> None:
    log = recorded(scene(SPHERE, 0.1 + drop, soft), 1000)
    deepest = -float(log["gaps"].min())
    declared = log.fact("sinking")
    assert deepest <= declared
    assert declared == pytest.approx(deepest, rel=1e-6)
    assert not any(v.law == "penetration" for v in sf.audit_log(log).violations)


def test_a_box_that_sinks_by_the_defaults_is_lawful_and_it_is_said() -> None:
    log = recorded(scene(BOX, 0.12), 1000)
    report = sf.audit_log(log)
    assert log["gaps"].min() < -4e-3
    assert report.lawful, report.sentence
    assert any("declares itself soft: sinking to 4.2 mm" in note for note in report.notes)


def test_what_is_deeper_than_declared_is_still_found() -> None:
    log = recorded(scene(BOX, 0.12), 500)
    log.arrays["gaps"] = log["gaps"] - 1e-3
    assert "penetration" in sf.audit_log(log).laws_broken


def test_depth_that_is_only_there_declares_nothing() -> None:
    """A box that starts 8 mm in the ground has not landed: only its rest depth is declared."""
    log = recorded(scene(BOX, 0.092), 500)
    assert log.fact("sinking") < 1e-3
    assert "penetration" in sf.audit_log(log).laws_broken


@pytest.mark.parametrize("solref", [None, (0.01, 1.0)])
def test_a_world_declares_its_ground(solref: tuple[float, float] | None) -> None:
    robot, ground = load_robot("go2"), FlatTerrain()
    q = place(robot, ground)
    softness = {} if solref is None else {"solref": solref, "solimp": (0.9, 0.95)}
    world = make_world("mujoco", robot, ground, 0.6, payload=3.0, **softness)
    controller = StandingController(robot, StandingPlan(robot, ground, q, ()), ground, q, 0.6)
    log = run(world, controller, Scenario(0.4, 0.6, seed=1, start=q, depth=START_DEPTH, fall=STANDING_FALL))
    assert -log["gaps"].min() <= log.fact("sinking") < (1e-3 if solref is None else 3e-3)
    report = sf.audit_log(log)
    assert report.lawful, report.sentence
    # and the load is told
    assert log.fact("mass") == pytest.approx(robot.mass + 3.0)
    assert (log.fact("payload"), log.fact("mass_controller")) == (3.0, pytest.approx(robot.mass))
    wrong = sf.Log(log.arrays, {**log.facts, "mass": robot.mass, "payload": 0.0}, channels=log.channels)
    assert "wrong mass" in [s.name for s in sf.audit_log(wrong).symptoms]


@pytest.mark.parametrize("fact", ["sinking", "creep", "stopping"])
def test_a_world_cannot_declare_everything_away(fact: str) -> None:
    log = recorded(scene(BOX, 0.12), 300)
    arrays, facts = dict(log.arrays), {**log.facts, fact: 1e9}
    if fact == "creep":  # it is told row by row
        arrays["contact_creep"] = np.full_like(log["contact_creep"], 1e9)
    elif fact == "sinking":  # and goes deep
        arrays["gaps"] = log["gaps"] - 0.06
    else:  # no more is believed than a soft world needs
        assert setting_of(sf.Log(arrays, facts), None).stopping == LIMITS.softness.stopping
        return
    report = sf.audit_log(sf.Log(arrays, facts))
    assert report.verdict == "cannot tell"
    assert f"declares a {fact} of 1e+09" in report.reason
    assert "what helps is" in report.reason


DROP = """<mujoco><option timestep='0.002' cone='{cone}'/><worldbody>
<geom type='plane' size='9 9 1' friction='0.7'/>
<body pos='0 0 {height}' quat='{turn}'><freejoint/>
 <geom type='box' size='.1 .15 .08' mass='3' friction='.7'/></body>
</worldbody></mujoco>"""


@pytest.mark.parametrize("cone", ["pyramidal", "elliptic"])
@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.long) for k in (1, 2))])
def test_a_box_that_tumbles_down_is_lawful_and_one_that_sticks_beyond_its_cone_is_not(
    cone: str, seed: int
) -> None:
    random = np.random.default_rng(seed)
    turn = " ".join(f"{x:.6f}" for x in random.normal(size=4))
    model = mujoco.MjModel.from_xml_string(DROP.format(cone=cone, height=0.3 + 0.1 * seed, turn=turn))
    data = mujoco.MjData(model)
    data.qvel[:] = [0.5, -0.3, 0.0, 1.0, 2.0, -1.0]
    log = recorded(model, 600, data)
    report = sf.audit_log(log)
    assert report.verdict == "lawful"
    assert any("after a hard touchdown" in note for note in report.notes)
    forces = log["forces"].copy()
    forces[500:550, :, 0] = 2.0 * forces[500:550, :, 2]
    spoilt = sf.Log(dict(log.arrays) | {"forces": forces}, log.facts, channels=log.channels)
    assert sf.audit_log(spoilt).verdict == "broken"


def test_compiled_impedance_is_the_laws() -> None:
    """At depths below, within and beyond the width, of powers and midpoints at their bounds."""
    rng = np.random.default_rng(5)
    for _ in range(50):
        solimp = (
            *rng.uniform(0.0, 1.0, 2),
            float(rng.uniform(0.0, 0.02)),
            float(rng.uniform()),
            rng.uniform(0.5, 4),
        )
        law = MujocoLaw((0.02, 1.0), tuple(map(float, solimp)))
        soft = SoftContact(law, 1.0, 1.0, 1.0, 1.0, 0.5, 0.002)
        for depth in rng.uniform(0.0, 0.03, 8):
            expected = float(law.impedance(np.array(depth))[0])
            assert impedance_at(soft._numbers, float(depth)) == pytest.approx(expected, rel=1e-12)
