"""Rules on actuators, on damping against inertia and on trees, each at the border of its fault."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio
import pytest

from surefoot.mechanics.robot.lint.facts import ActuatorFacts, Fault
from surefoot.mechanics.robot.lint.softness import Sinking
from tests.mechanics.robot.lint.facts_by_hand import joint, link, offences, places, subject


def motor(name: str, of: str, **other: Any) -> ActuatorFacts:
    return ActuatorFacts(name, of, **other)


def test_an_actuator_names_a_joint_of_the_file() -> None:
    motors = [
        motor("a", "knee"), motor("b", "tail"), motor("c", ""), motor("d", "tendon", on_joint=False)
    ]  # fmt: skip
    for kind, severity in (("mjcf", "error"), ("urdf", "warning")):
        about = subject([joint("knee")], format=kind, actuators=motors)
        why = "the file has no such joint"
        assert offences("actuator-without-joint", about) == [
            ("actuator b", "joint tail", why, severity),
            ("actuator c", "joint (none)", why, severity),
        ]


def test_a_joint_of_an_mjcf_with_actuators_has_one() -> None:
    joints = [joint("hip"), joint("knee"), joint("tail"), joint("weld", "fixed")]
    about = subject(joints, format="mjcf", actuators=[motor("a", "hip")], legs=["knee"])
    why = "controllers take it as a motor without limit"
    assert offences("joint-without-actuator", about) == [
        ("joint knee", "no actuator", why, "error"),
        ("joint tail", "no actuator", why, ""),
    ]
    assert not offences("joint-without-actuator", subject(joints, format="mjcf"))
    assert not offences("joint-without-actuator", subject(joints, actuators=[motor("a", "hip")]))


@pytest.mark.parametrize("count", [2, 3])
def test_three_joints_of_the_world_without_motors_stand_for_a_free_base(count: int) -> None:
    base = [joint(f"slide{k}", "prismatic", parent="world", child=f"base{k}") for k in range(count)]
    joints, motors = [*base, joint("hip"), joint("tail")], [motor("a", "hip")]
    for legs, severity in (([], ""), (["slide1"], "error")):
        about = subject(joints, format="mjcf", actuators=motors, legs=legs)
        found = offences("joint-without-actuator", about)
        named = (
            "slide0, slide1, slide2 stand for a free base, and are none here: the base counts as bolted down"
        )
        if count == 3:
            assert found[0] == ("link base0", "3 joints without actuators", named, severity)
        assert [place for place, *_ in found[count == 3 :]] == [
            *(["joint slide0", "joint slide1"] if count == 2 else []), "joint tail",
        ]  # fmt: skip


def test_two_motors_on_one_joint_of_an_mjcf_are_told() -> None:
    motors = [motor("a", "hip"), motor("b", "hip"), motor("c", "knee"), motor("d", "knee", on_joint=False)]
    told = [("joint hip", "2 actuators", "their torques add up", "")]
    assert offences("actuators-share-joint", subject(format="mjcf", actuators=motors)) == told
    assert not offences("actuators-share-joint", subject(actuators=motors))


def test_gears_and_ranges_of_nothing_are_useless() -> None:
    motors = [
        motor("a", "hip", gear=0.0), motor("b", "hip", gear=0.0, on_joint=False),
        motor("c", "hip", force=(2.0, 2.0), command=(3.0, 1.0)), motor("d", "hip", force=(-1.0, 1.0)),
    ]  # fmt: skip
    assert offences("actuator-useless", subject(format="mjcf", actuators=motors)) == [
        ("actuator a", "gear 0", "it moves nothing", ""),
        ("actuator c", "forcerange 2 to 2", "no value is within it", ""),
        ("actuator c", "ctrlrange 3 to 1", "no value is within it", ""),
    ]
    assert not offences("actuator-useless", subject(actuators=motors))


def arm(inertia: float) -> Any:
    """Return a robot of one hinge about an axis through the centre of mass: it feels the inertia [kg m²]."""
    model = pinocchio.Model()
    hinge = model.addJoint(0, pinocchio.JointModelRY(), pinocchio.SE3.Identity(), "hip")
    body = pinocchio.Inertia(1.0, np.zeros(3), np.diag([1.0, inertia, 1.0]))
    model.appendBodyToJoint(hinge, body, pinocchio.SE3.Identity())
    return SimpleNamespace(model=model, data=model.createData(), nominal=np.zeros(1), joints=1)


@pytest.mark.parametrize(("damping", "found"), [(21.0, True), (19.0, False), (0.0, False)])
def test_damping_grows_from_twice_the_inertia_over_the_step(damping: float, found: bool) -> None:
    """h d / I = 0.001 d / 0.01, of a hinge of which a rotor is 0.004 kg m²."""
    hip = joint("hip", damping=damping, armature=0.004)
    why = "h d / (I + armature) = 2.1 > 2 with h 0.001 s and 0.01 kg m² (armature 0.004)"
    told = [("joint hip", "damping 21 N m s", why, "")] * found
    assert offences("step-unstable", subject([hip, joint("tail", damping=9.0)], robot=arm(0.006))) == told


def test_damping_below_zero_drives_the_joint() -> None:
    told = [("joint hip", "damping -1", "it drives the joint", "error")]
    assert offences("step-unstable", subject([joint("hip", damping=-1.0)], robot=arm(0.01))) == told
    assert offences("step-unstable", subject([joint("hip", damping=-1.0)])) == told


@pytest.mark.parametrize(
    ("gains", "value", "why"),
    [
        ((0.0, 21.0), "kv 21 N m s", "h kv / (I + armature) = 2.1 > 2 with h 0.001 s and 0.01 kg m²"),
        ((0.0, 19.0), "", ""),
        ((41000.0, 0.0), "kp 41000 N m", "h² kp / I = 4.1 > 4 with h 0.001 s and I 0.01 kg m²"),
        ((39000.0, 0.0), "", ""),
    ],
)
def test_gains_of_servos_grow_like_damping_and_springs(
    gains: tuple[float, float], value: str, why: str
) -> None:
    servos = [motor("a", name, stiffness=gains[0], damping=gains[1]) for name in ("hip", "tail")]
    about = subject([joint("hip")], actuators=servos, robot=arm(0.01))
    assert offences("step-unstable", about) == [("actuator a", value, why, "")] * bool(value)


@pytest.mark.parametrize(
    ("integrator", "undamped", "joint_severity", "servo_severity"),
    [
        ("EULER", False, "", "error"), ("EULER", True, "error", "error"), ("RK4", False, "error", "error"),
        ("RK4", True, "error", "error"), ("IMPLICIT", True, "", ""), ("IMPLICITFAST", False, "", ""),
    ],
)  # fmt: skip
def test_explicit_steps_of_the_file_s_own_integrator_are_errors(
    integrator: str, undamped: bool, joint_severity: str, servo_severity: str
) -> None:
    mujoco = pytest.importorskip("mujoco")
    option = mujoco.MjModel.from_xml_string('<mujoco><option timestep="0.002"/></mujoco>').opt
    option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}")
    if undamped:
        option.disableflags |= mujoco.mjtDisableBit.mjDSBL_EULERDAMP
    about = subject(
        [joint("hip", damping=11.0)], actuators=[motor("a", "hip", damping=11.0)], robot=arm(0.01),
        compiled=SimpleNamespace(opt=option), mujoco=mujoco,
    )  # fmt: skip
    found = offences("step-unstable", about)
    assert [(place, severity) for place, _, _, severity in found] == [
        ("joint hip", joint_severity), ("actuator a", servo_severity),
    ]  # fmt: skip
    assert all("= 2.2 > 2 with h 0.002 s" in detail for _, _, detail, _ in found)


def test_a_rotor_is_smaller_than_the_robot_s_inertia_about_its_reach() -> None:
    """4 kg at 0.5 m: 1 kg m²."""
    joints = [
        joint("back", armature=-0.1), joint("large", length=0.5, armature=1.1),
        joint("fair", length=0.5, armature=0.9), joint("slide", "prismatic", armature=1.1),
    ]  # fmt: skip
    links = [link("trunk", 4.0), link("large_link", 0.0)]
    assert offences("armature-absurd", subject(joints, links)) == [
        ("joint back", "armature -0.1", "no rotor has it", "error"),
        ("joint large", "armature 1.1 kg m²", "more than the whole robot about it, 1 kg m²", ""),
    ]
    assert places("armature-absurd", subject(joints)) == ["joint back"]


@pytest.mark.parametrize(
    ("inertia", "rotor", "found"),
    [(9e-11, 0.0, True), (1.1e-10, 0.0, False), (9e-11, 2e-11, False), (9e-11, -1.0, True)],
)
def test_a_joint_feels_at_least_a_ten_billionth(inertia: float, rotor: float, found: bool) -> None:
    hip = joint("hip", armature=rotor)
    why = "below 1e-10 kg m² a simulated world refuses the robot"
    for legs, severity in (([], ""), (["hip"], "error")):
        told = [("joint hip", "inertia 9e-11 kg m²", why, severity)] * found
        assert offences("joint-moves-nothing", subject([hip], robot=arm(inertia), legs=legs)) == told


@pytest.mark.parametrize(
    ("step", "gravity", "found"),
    [
        (0.0101, (0.0, 0.0, -9.81), ["0.0101 s"]), (0.0099, (0.0, 0.0, -9.81), []),
        (0.001, (0.0, 0.0, -0.9), ["(0, 0, -0.9) m/s²"]), (0.001, (0.0, 0.0, -1.1), []),
        (0.001, (0.0, 0.0, -19.9), []), (0.001, (0.0, 0.0, -20.1), ["(0, 0, -20.1) m/s²"]),
        (0.001, (6e-4, -6e-4, -9.81), ["(0.0006, -0.0006, -9.81) m/s²"]), (0.001, (4e-4, 4e-4, -9.81), []),
        (0.001, (0.0, 0.0, 9.81), ["(0, 0, 9.81) m/s²"]),
    ],
)  # fmt: skip
def test_worlds_have_short_steps_and_a_gravity_downwards(
    step: float, gravity: tuple[float, float, float], found: list[str]
) -> None:
    compiled = SimpleNamespace(opt=SimpleNamespace(timestep=step, gravity=gravity))
    assert [value for _, value, _, _ in offences("world-unusual", subject(compiled=compiled))] == found
    assert not offences("world-unusual", subject())


def sinking(depth: float, own_floor: bool, **other: Any) -> Sinking:
    given = {"solref": (0.02, 1.0), "solimp": (0.9, 0.95, 0.001, 0.5, 2.0)} | other
    return Sinking(depth, 2e-4, 4, 30.0, body="calf", own_floor=own_floor, **given)


@pytest.mark.parametrize(
    ("depth", "own_floor", "other", "severity"),
    [
        (0.9e-3, True, {}, None), (1.1e-3, True, {}, ""), (4.9e-3, True, {}, ""), (5.1e-3, True, {}, "error"),
        (1.1e-3, False, {}, "note"), (5.1e-3, False, {}, "note"),
        (4.9e-3, False, {"solref": (0.03, 1.0)}, "warning"),
        (5.1e-3, False, {"solref": (0.03, 1.0)}, "error"),
        (4.9e-3, False, {"solimp": (0.9, 0.95, 0.002, 0.5, 2.0)}, "warning"),
        (4.9e-3, False, {"solimp": (0.9, 0.95, 0.001, 0.6, 2.0)}, "note"),
    ],
)  # fmt: skip
def test_depths_are_errors_from_five_millimetres_on_contacts_of_the_file(
    depth: float, own_floor: bool, other: dict[str, Any], severity: str | None
) -> None:
    found = offences("contact-sinks", subject(sinking=sinking(depth, own_floor, **other)))
    assert [(place, told) for place, _, _, told in found] == [("foot body calf", severity)] * (
        severity is not None
    )
    for _, value, detail, _ in found:
        assert value == f"sinks {1e3 * depth:.3g} mm"
        assert "4 contacts of 30 N" in detail
        assert "it sinks 0.2 mm" in detail
        assert ("the audit counts what exceeds 1 mm as penetration" in detail) is own_floor
        assert ("on a floor of MuJoCo's defaults" in detail) is not own_floor


def test_faults_of_a_reader_are_told_by_their_rule() -> None:
    about = subject(links=[link("trunk")])
    about.facts.faults += [
        Fault("not-a-number", "link a", "nan"),
        Fault("tree-broken", "joint b", "x", "no kind"),
    ]
    assert offences("not-a-number", about) == [("link a", "nan", "a finite number is needed", "")]
    assert offences("tree-broken", about) == [("joint b", "x", "no kind", "")]


def test_a_tree_has_one_root_and_one_joint_above_each_link() -> None:
    links = [link(name) for name in ("trunk", "a", "b", "c")]
    joints = [
        joint("ja", child="a"), joint("jb", child="b"), joint("jb2", parent="a", child="b"),
        joint("jx", child="x"), joint("jy", parent="", child="a"),
    ]  # fmt: skip
    about = subject(joints, links)
    why = "the file has no such link"
    assert offences("tree-broken", about) == [
        ("joint jx", "child link x", why, ""), ("joint jy", "parent link missing", why, ""),
        ("link a", "child of 2 joints", "joints ja, jy; a tree has one above each link", ""),
        ("link b", "child of 2 joints", "joints jb, jb2; a tree has one above each link", ""),
        ("link c", "2 roots", "no joint ties it to trunk", ""),
    ]  # fmt: skip
    assert not offences("tree-broken", subject(joints, links, format="mjcf"))
    assert not offences("tree-broken", subject(joints[:2], links[:3]))
    assert not offences("tree-broken", subject())
    loop = [joint("ab", parent="a", child="b"), joint("ba", parent="b", child="a")]
    told = [("link a", "no root", "the joints close a loop", "")]
    assert offences("tree-broken", subject(loop, links[1:3])) == told


def test_names_stand_once_in_a_urdf() -> None:
    links, joints = (
        [link("a"), link("a"), link("b"), link("")],
        [joint("a"), joint("k"), joint("k"), joint("k")],
    )
    why = "each needs a name of its own"
    assert offences("name-twice", subject(joints, links)) == [
        ("link a", "2 times", why, ""), ("link (no name)", "1 times", why, ""),
        ("joint k", "3 times", why, ""),
    ]  # fmt: skip
    assert not offences("name-twice", subject(joints, links, format="mjcf"))


def test_a_mimic_follows_a_joint_of_the_file() -> None:
    joints = [joint("a", mimics="b"), joint("b"), joint("c", mimics="x")]
    assert offences("mimic-unknown", subject(joints)) == [
        ("joint c", "mimics x", "the file has no such joint", "")
    ]


def test_a_refusal_is_told_unless_the_file_could_not_be_read() -> None:
    about = subject(refusal="no mass")
    assert offences("load-refused", about) == [("file dog.urdf", "does not load", "no mass", "")]
    about.facts.faults.append(Fault("not-a-number", "link a", "nan"))
    assert offences("load-refused", about)
    about.facts.faults.append(Fault("file-unreadable", "file", "cannot be read"))
    assert not offences("load-refused", about)
    assert not offences("load-refused", subject())


def test_a_second_free_base_is_told_where_the_loader_adds_one() -> None:
    floating, fixed = SimpleNamespace(floating=True), SimpleNamespace(floating=False)
    joints = [joint("free", "floating"), joint("hip")]
    (found,) = offences("base-twice", subject(joints, robot=floating))
    assert found[:2] == ("joint free", "type floating")
    for quiet in (
        subject(joints, robot=fixed),
        subject(joints),
        subject(joints, format="mjcf", robot=floating),
    ):
        assert not offences("base-twice", quiet)
