"""What a recording knows of the model: momentum and what moves it, friction's cone, rotors, a lazy solver."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.records.audit.log_context import setting_of
from surefoot.records.audit.report import AuditReport
from surefoot.records.audit.rows import Rows
from tests.worlds.mujoco.recordings import recorded

mujoco = pytest.importorskip("mujoco")

CRATE = """<mujoco model='parcel'><option {option}/><worldbody>
<geom name='floor' type='plane' size='5 5 1' friction='0.6' {geom}/>
<body name='crate' pos='0 0 .1' gravcomp='{gravcomp}'><freejoint/>
<geom name='shell' type='box' size='.2 .2 .1' mass='5' {geom}/></body></worldbody></mujoco>"""
LEGGED = """<mujoco model='table scene'><option cone='elliptic' impratio='30' timestep='.001' {option}/>
<default><joint axis='0 1 0' damping='.4' armature='.02' frictionloss='.3' {joint}/>
<geom contype='0' conaffinity='0' condim='6' friction='.8 .02 .01' density='800'/></default><worldbody>
<geom type='plane' size='5 5 1' contype='1' conaffinity='1'/>
<body name='trunk' pos='0 0 .36'><freejoint/><geom type='box' size='.2 .12 .04'/>
{legs}</body></worldbody><actuator>{motors}</actuator></mujoco>"""
SOLVED = 1e-3
"""Share of m g to which Newton's method ends."""
NAMES = ("RR", "FL", "RL", "FR")


def legged(option: str = "", joint: str = "") -> Any:
    """A trunk on four legs with joints as real robots' models have them, in no usual order."""
    legs = motors = ""
    for name in NAMES:
        x, y = (0.18 if name[0] == "F" else -0.18), (0.1 if name[1] == "L" else -0.1)
        legs += (
            f"<body name='{name}_thigh' pos='{x} {y} 0'><joint name='{name}_hip'/>"
            "<geom type='capsule' fromto='0 0 0 0 0 -.18' size='.02'/>"
            f"<body name='{name}_calf' pos='0 0 -.18'><joint name='{name}_knee'/>"
            "<geom type='capsule' fromto='0 0 0 0 0 -.16' size='.015'/>"
            f"<geom name='{name}' size='.02' pos='0 0 -.16' contype='1' conaffinity='1'/>"
            f"<body name='{name}_foot' pos='0 0 -.16'/></body></body>"
        )
        motors += f"<motor joint='{name}_hip'/><motor joint='{name}_knee'/>"
    return mujoco.MjModel.from_xml_string(LEGGED.format(legs=legs, motors=motors, option=option, joint=joint))


def marked(model: Any, seconds: float = 0.6, push: Callable[[Any], None] | None = None) -> sf.Log:
    """Record a legged model that marches on the spot."""

    def march(data: Any) -> None:
        wave = 0.2 * np.sin(12.0 * data.time) * np.repeat([1.0, -1.0, -1.0, 1.0], 2)
        data.ctrl[:] = 40.0 * (wave * np.tile([1.0, -2.0], 4) - data.qpos[7:]) - 1.0 * data.qvel[6:]
        if push is not None:
            push(data)

    return recorded(model, round(1e3 * seconds), before=march)


def settled(model: Any) -> Any:
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 400)
    return data


def slid(
    option: str = "", geom: str = "", gravcomp: float = 0.0, speed: tuple[float, float] = (0.7, 0.0),
    push: Callable[[Any], None] | None = None,
) -> sf.Log:  # fmt: skip
    """Record a crate that slides on the floor."""
    model = mujoco.MjModel.from_xml_string(CRATE.format(option=option, geom=geom, gravcomp=gravcomp))
    data = settled(model)
    data.qvel[:2] = speed
    return recorded(model, 500, data, push)


def names(report: AuditReport) -> list[str]:
    return [s.name for s in report.symptoms]


def rest(log: sf.Log) -> np.ndarray:
    """Return what the momentum leaves over, in m g and m g m."""
    setting = setting_of(log, None)
    return Rows(log, setting, 0, len(log)).left_over / setting.weight


@pytest.mark.parametrize("option", ["", pytest.param("integrator='RK4'", marks=pytest.mark.long)])
def test_contacts_and_known_pushes_are_all_that_changes_the_momentum(option: str) -> None:
    def push(data: Any) -> None:
        data.xfrc_applied[1] = [3.0, 0.0, -5.0, 0.0, 0.2, 0.1]

    for log in (slid(option, push=push), marked(legged(option), 0.2, push=push)):
        # RK4: a mean force at a mean place has its moment up to a body's turn within a step
        assert np.abs(rest(log)[:, :3]).max() < SOLVED
        assert np.abs(rest(log)[:, 3:]).max() < (2e-3 if "RK4" in option else SOLVED)
        assert log["wrench_applied"][0, :3] == pytest.approx([3.0, 0.0, -5.0])
        report = sf.audit_log(log)
        assert not report.coverage["balance"]
        assert report.lawful, report.sentence


@pytest.mark.parametrize("force", [-20.0, 100.0])
def test_a_hidden_force_is_named(force: float) -> None:
    def push(data: Any) -> None:
        data.qfrc_applied[2] = force

    report = sf.audit_log(marked(legged(), push=push))
    assert report.verdict == "broken"
    assert {"motion", "balance", "acceleration"} == set(report.laws_broken)
    assert names(report)[0] == "outside force"
    assert f"(0, 0, {force:g}) N" in report.sentence
    assert "qfrc_applied" in report.sentence


def test_compensated_gravity_a_spring_and_a_weld_are_named() -> None:
    report = sf.audit_log(slid(gravcomp=0.9))
    assert report.verdict == "broken"
    assert names(report)[0] == "outside force"
    assert "gravity is compensated" in report.sentence
    held = mujoco.MjModel.from_xml_string(
        CRATE.format(option="", geom="", gravcomp=0).replace(
            "</worldbody>", "</worldbody><equality><connect body1='crate' anchor='0 0 .1'/></equality>"
        )
    )
    held.body("crate").pos[2] = 0.1
    data = mujoco.MjData(held)
    data.qpos[2] = 0.12
    report = sf.audit_log(recorded(held, 300, data))
    assert report.verdict == "broken"
    assert "constraints to the world" in report.sentence


def test_a_model_that_is_not_free_is_judged_where_it_is() -> None:
    hopper = """<mujoco><option timestep='.001'/><worldbody><geom type='plane' size='5 5 1'/>
    <body pos='0 0 {z}'><joint type='slide' axis='1 0 0'/><joint type='slide' axis='0 0 1'/>
    <joint axis='0 1 0'/><geom type='capsule' fromto='0 0 -.2 0 0 .2' size='.05'/>
    <body pos='0 0 -.2'><joint name='hip' axis='0 1 0' damping='1'/>
    <geom type='capsule' fromto='0 0 0 .1 0 -.3' size='.04'/></body></body></worldbody>
    <actuator><motor joint='hip'/></actuator></mujoco>"""

    def swing(data: Any) -> None:
        data.ctrl[:] = 2.0 * np.sin(50.0 * data.time)

    def push(data: Any) -> None:
        data.qfrc_applied[0] = 8.0

    for height in (0.6, 50.0):  # lands, or never touches anything
        model = mujoco.MjModel.from_xml_string(hopper.format(z=height))
        log = recorded(model, 300, before=swing)
        assert np.abs(rest(log)[:, :3]).max() < 1e-6
        assert log.doubts == () or height > 1.0  # seven joints are no quaternion
        report = sf.audit_log(log)
        assert report.lawful, report.sentence
        assert sf.audit_log(recorded(model, 300, before=push)).verdict == "broken"


def test_rotors_dampers_and_dry_friction_are_no_broken_law(tmp_path: Any) -> None:
    """The legs' forces explain the joint torques of a model as real robots have it, feet matched by name."""
    path = tmp_path / "table.xml"
    model = legged()
    mujoco.mj_saveLastXML(str(path), model)
    robot = sf.load_robot(path, feet=["FL_foot", "FR_foot", "RL_foot", "RR_foot"])
    log = marked(model)
    assert log.facts["robot"] == "table"
    assert log.facts["feet"] == list(NAMES)
    assert log.facts["armature"].tolist() == [0.02] * 8
    report = sf.audit_log(log, robot)
    assert not report.coverage["motion"], report.coverage["motion"]
    assert report.lawful, report.sentence
    assert len(report.friction) == 4, report.friction  # the ground is one
    wrong = sf.Log({**log.arrays, "forces": log["forces"] * [1.0, 1.0, 1.3]}, log.facts)
    assert sf.audit_log(wrong, robot).verdict == "broken"


def test_a_pyramid_is_judged_as_one_and_its_bias_is_named() -> None:
    for impratio in (1, 100):
        report = sf.audit_log(slid(f"impratio='{impratio}'", speed=(0.7, 0.7)))
        assert report.lawful, report.sentence
        assert "pyramid bias" in names(report)
        straight = sf.audit_log(slid(f"cone='elliptic' impratio='{impratio}'", speed=(0.7, 0.7)))
        assert straight.lawful
        assert "pyramid bias" not in names(straight)


@pytest.mark.parametrize("cone", ["elliptic", "pyramidal"])
@pytest.mark.parametrize("condim", [4, 6])
def test_moments_share_the_cone_of_a_slide(cone: str, condim: int) -> None:
    """A ball that slides and spins is braked by what its spinning leaves of the cone."""
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><option cone='{cone}' impratio='10'/><worldbody>"
        f"<geom type='plane' size='5 5 1' condim='{condim}' friction='.5 .03 .02'/>"
        "<body pos='0 0 .1'><freejoint/><geom size='.1' mass='2' friction='.5 .03 .02'/></body>"
        "</worldbody></mujoco>"
    )
    data = settled(model)
    data.qvel[:] = [0.8, 0.3, 0.0, 0.0, 0.0, 20.0]
    log = recorded(model, 300, data)
    moved = np.abs(log["contact_moments"]).max()
    assert moved > 0.1
    report = sf.audit_log(log)
    assert report.lawful, report.sentence
    assert "frictionless slide" not in names(report)
    assert len(report.friction) == 1, report.friction
    assert report.friction[0].low == pytest.approx(0.5, rel=0.02)
    without = {name: a for name, a in log.arrays.items() if name != "contact_moments"}
    assert sf.audit_log(sf.Log(without, log.facts)).verdict == "broken"


def test_a_solver_that_stops_early_is_named() -> None:
    report = sf.audit_log(slid("solver='PGS' iterations='1'"))
    assert names(report)[0] == "unconverged solver"
    assert not any(
        "unconverged" in name for name in names(sf.audit_log(slid("solver='PGS' iterations='200'")))
    )


@pytest.mark.parametrize("sweeps", [1, 2])
def test_forces_that_noslip_changes_afterwards_are_not_called_unconverged(sweeps: int) -> None:
    """Noslip sweeps change the solver's forces on purpose: another solver's are no measure of them."""
    option = f"solver='PGS' iterations='1' noslip_iterations='{sweeps}'"
    assert "solver_error" not in slid(option).arrays
    assert "solver_error" in slid("solver='PGS' iterations='1'").arrays


def test_what_hides_anything_names_the_remedy() -> None:
    log = slid(geom="solref='.2 1'")
    report = sf.audit_log(log)
    assert report.verdict == "cannot tell"
    assert "solref" in report.reason


def test_momentum_and_energy_are_those_of_the_model() -> None:
    """By MuJoCo's own energy, and the rate of momentum that the same log has from the accelerations."""
    model = legged()
    model.dof_armature[:] = 0.0
    log = marked(model, 0.3)
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    data = mujoco.MjData(model)
    for row in (0, 150, 299):
        data.qpos[:], data.qvel[:] = log["q"][row], log["v"][row]
        data.qpos[3:7] = log["q"][row][[6, 3, 4, 5]]
        turn = rotation_from_quaternion(log["q"][row][3:7])
        data.qvel[:3] = turn @ log["v"][row][:3]
        mujoco.mj_forward(model, data)
        assert log["energy"][row] == pytest.approx(data.energy.sum(), rel=1e-9)
        mujoco.mj_subtreeVel(model, data)
        momentum = [*(log.facts["mass"] * data.subtree_linvel[0]), *data.subtree_angmom[0]]
        np.testing.assert_allclose(log["momentum"][row], momentum, atol=1e-9)


def crate(text: str = CRATE, lift: float = 0.0) -> tuple[Any, Any]:
    """Return the crate's model, and its data with it lifted."""
    model = mujoco.MjModel.from_xml_string(text.format(option="", geom="", gravcomp=0.0))
    data = mujoco.MjData(model)
    data.qpos[2] += lift
    return model, data


def test_a_start_below_the_ground_is_named() -> None:
    for lift, symptom in ((-0.02, "starts in the ground"), (0.0, None)):
        model, data = crate(lift=lift)
        report = sf.audit_log(recorded(model, 300, data))
        assert report.verdict == ("lawful" if symptom is None else "broken")
        assert [s.name for s in report.symptoms[:1]] == ([] if symptom is None else [symptom])


def test_a_body_that_never_touches_is_audited() -> None:
    model, data = crate(lift=5.0)
    log = recorded(model, 150, data)
    assert log["contact_positions"].shape[1] == 0
    assert sf.audit_log(log).verdict == "lawful"


def test_a_free_joint_with_a_rotors_inertia_is_named() -> None:
    """`<joint type="free">` takes the joints' defaults, as in Unitree's B2, H1-2 and R1."""
    model, data = crate(CRATE.replace("<freejoint/>", "<joint type='free' armature='2'/>"), lift=5.0)
    report = sf.audit_log(recorded(model, 150, data))
    assert report.verdict == "broken"  # it falls as if it weighed 7 kg: g 5 / 7
    assert "armature on the root: up to 14 N" in report.symptoms[0].evidence
