"""Falls obey the laws: fast turns, hard landings and loads break neither motion nor depth."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from benchmarks.foreign.loops import LOOPS, OTHERS
from surefoot.mechanics.terrain import Terrain, read_terrain
from surefoot.motion.walking.walkers import walking_controller
from surefoot.records.audit.log_context import setting_of
from surefoot.records.audit.rows import Rows
from surefoot.worlds.interface.world_names import make_world
from tests.records.audit.logs import changed
from tests.robots import robot_of
from tests.worlds.mujoco.strangers import QUADRUPED, quadruped

mujoco = pytest.importorskip("mujoco")
ABLE = {loop.name: loop for loop in (*LOOPS, *OTHERS)}


def shoved(seed: int, steps: int = 900) -> Any:
    """Return the log of a quadruped that is shoved somewhere at some time, and falls."""
    rng = np.random.default_rng(seed)
    force, begin = 300.0 * rng.normal(size=3), int(rng.integers(100, 400))

    def shove(model: Any, data: Any, step: int) -> None:
        data.xfrc_applied[1, :3] = force if begin <= step < begin + 50 else 0.0

    return quadruped(steps, shove)


@pytest.mark.parametrize("seed", [3, 8, 13, 26, 34, 55])
@pytest.mark.sampled(3)
def test_a_shoved_robot_falls_by_the_laws(seed: int) -> None:
    report = sf.audit_log(shoved(seed))
    assert report.lawful, report.sentence
    assert report.first_cause is None or report.first_cause.name == "push"


@pytest.mark.parametrize(
    ("robot", "world", "force"),
    [
        ("go2", "rigid", (0.0, 450.0, 0.0)),  # calves without stops whirl at 130 rad/s
        ("go2", "rigid", (309.0, -245.0, 21.0)),
        ("go2", "mujoco", (442.0, -178.0, -31.0)),  # soft contacts hand load from one to another
        ("go2", "mujoco", (-196.0, -330.0, 77.0)),
        ("go2", "mujoco-exact", (334.0, -476.0, -49.0)),  # stops take joints back without speed
        ("go2", "mujoco-exact", (-528.0, 189.0, -54.0)),  # a foot comes down at 5 m/s
        # two kilograms and motors of 2.5 N m: with the 1000 that its file says it flew apart
        pytest.param("solo12", "rigid", (-52.0, 86.0, 3.0), marks=pytest.mark.long),
        pytest.param("solo12", "mujoco", (88.0, 15.0, -17.0), marks=pytest.mark.long),
        pytest.param("solo12", "mujoco-exact", (-70.0, 1.0, -1.0), marks=pytest.mark.long),
        pytest.param("g1", "rigid", (-304.0, 123.0, 56.0), marks=pytest.mark.long),
        pytest.param("g1", "mujoco", (-230.0, 280.0, 0.0), marks=pytest.mark.long),
        pytest.param("g1", "mujoco-exact", (-241.0, -720.0, 8.0), marks=pytest.mark.long),
    ],
)
@pytest.mark.sampled(2)
def test_a_shoved_walk_of_ours_falls_by_the_laws(
    robot: str, world: str, force: tuple[float, float, float]
) -> None:
    """Two to five times its weight for a fifth of a second, in each of our own worlds."""
    own = robot_of(robot)
    walker = walking_controller(own, sf.VelocityCommand.constant(0.4))
    scenario = sf.Scenario(3.0, 0.6, [sf.Push(1.0, force, 0.2)])
    report = sf.audit_log(sf.run(make_world(world, own), walker, scenario))
    assert report.lawful, report.sentence
    assert report.first_cause is not None
    assert report.first_cause.name == "push"


@pytest.mark.long
@pytest.mark.parametrize(
    "words",
    [
        # a stretched leg turns with 30 rad/s: small torques look like large forces at its foot
        "icub --world rigid --seed 835 --velocity 0.38,0.12,0.46 --terrain rough:8,0.01 --mu 0.2",
        # limbs turn with 40 rad/s: where forces act within a step is open
        "icub --world rigid --seed 949 --velocity 0.27,-0.05,-0.02 --slope 6 --push 1.76:78,256,-149:0.05",
        # a load of the robot's own mass is no point where it is struck by 18 m g
        "icub --world mujoco-exact --seed 341 --velocity 0.3,-0.17,-0.01 --mu 0.9 --payload 21.85",
        # a foot in a valley between facets
        "icub --world mujoco --velocity 0.78,0,0 --terrain rough:3,0.03",
        # a foot in the air, whose joints whirl
        "icub --world rigid --seed 811 --velocity 0.45,-0.12,-0.39 --mu 0.2 --payload 5.02",
        "go2 --world mujoco-exact --seed 523 --velocity 0.13,0,-0.2 --slope -6 --push 1.26:191,136,155:0.5",
    ],
)
def test_light_legs_fall_by_the_laws(words: str, tmp_path: Path, printed: Any) -> None:
    told = ("--duration", 3, "--no-video", "--no-report", "--out", tmp_path)
    printed("walk", *words.split(), *told, code=1)
    (log,) = tmp_path.glob("*/log.npz")
    report = sf.audit_log(sf.read_log(log))
    assert report.lawful, report.sentence


@pytest.mark.long
@pytest.mark.parametrize(
    "ground", [read_terrain("rough:2,0.03"), read_terrain("slope:10")], ids=["rough", "uphill"]
)
def test_a_biped_on_facets_and_at_its_stops_walks_by_the_laws(ground: Terrain) -> None:
    """Corners of its soles have their facets' normals, and its ankles end their stance at a stop."""
    own = robot_of("g1")
    walker = walking_controller(own, sf.VelocityCommand.constant(0.4), terrain=ground)
    log = sf.run(make_world("mujoco", own, terrain=ground), walker, sf.Scenario(5.0, 0.6))
    assert sf.audit_log(log).laws_broken == ()


@pytest.mark.long
def test_limbs_that_whirl_hide_no_force_from_before() -> None:
    """Rows in which a joint is far beyond its motor's speed are not judged, and a note says how many."""
    own = robot_of("go2")
    walker = walking_controller(own, sf.VelocityCommand.constant(0.4))
    log = sf.run(
        make_world("rigid", own), walker, sf.Scenario(3.0, 0.6, [sf.Push(1.0, (0.0, 450.0, 0.0), 0.2)])
    )
    model = setting_of(log, None).robot
    assert model is not None
    count = int(model.whirls(np.asarray(log["v"]), 1e-3).sum())
    assert 20 < count < 200
    assert not model.whirls(np.asarray(log["v"][:1000]), 1e-3).any()
    assert any(note.startswith(f"in {count} rows a joint is faster") for note in sf.audit_log(log).notes)
    forces = np.array(log["forces"])
    forces[700:800, :, 2] *= 1.15
    assert "motion" in sf.audit_log(changed(log, forces=forces)).laws_broken
    velocities = np.array(log["contact_velocities"])
    velocities[700:800, 1, 0] += 0.5
    assert "contact velocity" in sf.audit_log(changed(log, contact_velocities=velocities)).laws_broken


@pytest.mark.parametrize(
    ("loop", "cause", "seed"),
    [
        ("pd humanoid", "delayed control", 0),  # turns fast enough for 1 kN in the wrong axes
        ("pd quadruped", "payload", 0),  # a sack slides on it
        ("hopper", "push", 1),  # its trunk is thrown onto the ground
        ("arm pushing a box", "payload", 0),  # a crate comes down on what is pushed
        ("servo hexapod", "slippery ground", 0),
        ("wheeled balancer", "push", 0),
        ("pd quadruped", "chattering gains", 1),  # contacts open within steps of full force
        ("servo hexapod", "chattering gains", 0),
    ],
)
@pytest.mark.sampled(3)
def test_failures_of_strangers_are_no_broken_laws(loop: str, cause: str, seed: int) -> None:
    report = sf.audit_log(ABLE[loop].failed(cause, seed).log)
    assert report.laws_broken == (), report.sentence


@pytest.mark.parametrize(("integrator", "most"), [("EULER", 1e-9), ("IMPLICITFAST", 1e-9), ("RK4", 2e-2)])
@pytest.mark.sampled(1)
def test_a_robot_that_turns_fast_in_the_air_needs_no_force(integrator: str, most: float) -> None:
    """MuJoCo changes a base's velocity in the world's axes; its own turn by 2 deg in a step.

    A row of Runge and Kutta is a mean of stages, of which its ends do not tell all.
    """
    model = mujoco.MjModel.from_xml_string(QUADRUPED)
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}")
    data = mujoco.MjData(model)
    turn = np.array([12.0, -9.0, 14.0]) * (0.3 if integrator == "RK4" else 1.0)
    data.qpos[2], data.qvel[:3], data.qvel[3:6] = 1.5, (2.0, -1.0, 1.0), turn
    with sf.record(model, data) as log:
        mujoco.mj_step(model, data, 600)
    flight = int((log["forces"][..., 2] > 0.0).any(axis=1).argmax()) - 1  # it lands in the end
    rows = Rows(log, setting_of(log, None), 0, len(log))
    assert rows.unexplained is not None
    left = np.linalg.norm(rows.unexplained.force[:flight], axis=1).max() / (9.81 * log.facts["mass"])
    assert left < most
    assert sf.audit_log(log).laws_broken == ()


def test_a_force_from_nowhere_is_still_found_in_a_fall() -> None:
    log = shoved(26)
    v = np.array(log["v"])
    v[500:, 0] += 0.5  # a kick in one row
    assert not sf.audit_log(changed(log, v=v)).lawful
    forces = np.array(log["forces"])
    forces[500:600, :, 2] *= 1.1
    assert "motion" in sf.audit_log(changed(log, forces=forces)).laws_broken


def test_what_a_hand_moves_can_move() -> None:
    """A plate that is moved by hand (mocap) under a ball: the ball's own velocity is not the contact's."""
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body name='plate' mocap='true'><geom type='box' size='2 2 .05' friction='1'/>"
        "</body><body pos='0 0 .1501'><freejoint/><geom size='.1' friction='1'/></body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    with sf.record(model, data) as log:
        for k in range(300):
            data.mocap_pos[0, 0] = 1e-3 * k
            mujoco.mj_step(model, data)
    assert log.facts["contact_other_moves"].tolist() == [1.0]
    assert "contact velocity" not in sf.audit_log(log).laws_broken


@pytest.mark.parametrize(
    "held", ["limited='true' range='-.2 .2'", "damping='3'", "stiffness='50'", "frictionloss='1'"]
)
def test_a_rail_that_holds_its_cart_is_no_force_from_nowhere(held: str) -> None:
    """A cart at the end of its rail: 4 kN on a pendulum were broken balance once."""
    text = (
        "<mujoco><worldbody><geom type='plane' size='9 9 1' pos='0 0 -1'/><body name='cart'>"
        "<joint type='slide' axis='1 0 0' {held}/><geom size='.1' mass='1'/>"
        "<body><joint name='swing' axis='0 1 0'/>"
        "<geom type='capsule' fromto='0 0 0 .3 0 .3' size='.02' mass='1'/></body></body></worldbody>"
        "<actuator><motor joint='swing'/></actuator></mujoco>"
    )
    free, on_rails = (mujoco.MjModel.from_xml_string(text.format(held=one)) for one in ("", held))
    for model in (free, on_rails):
        data = mujoco.MjData(model)
        data.qvel[0] = 2.0
        with sf.record(model, data) as log:
            mujoco.mj_step(model, data, 400)
        assert sf.audit_log(log).laws_broken == ()
        assert ("free_wrenches" in log.facts) == (model is free)


def test_what_lands_in_long_steps_of_runge_and_kutta_moves_by_its_momentum() -> None:
    """An ant without torques: of velocities between those at the ends of a row a log tells nothing."""
    gymnasium = pytest.importorskip("gymnasium")
    path = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets" / "ant.xml"
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    with sf.record(model, data) as log:
        mujoco.mj_step(model, data, 400)
    assert sf.audit_log(log).laws_broken == ()


@pytest.mark.parametrize("seed", [1, 2])
def test_the_centre_of_mass_of_limbs_that_whirl_in_long_steps_moves_by_the_momentum(seed: int) -> None:
    """Steps of 10 ms move a cheetah's joints by 0.3 rad: two of a limb together make its arc."""
    gymnasium = pytest.importorskip("gymnasium")
    path = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets" / "half_cheetah.xml"
    model, rng = mujoco.MjModel.from_xml_path(str(path)), np.random.default_rng(seed)
    data = mujoco.MjData(model)
    with sf.record(model, data) as log:
        for step in range(400):
            if step % 20 == 0:
                data.ctrl[:] = rng.uniform(-1.0, 1.0, model.nu)
            mujoco.mj_step(model, data)
    assert sf.audit_log(log).laws_broken == ()
