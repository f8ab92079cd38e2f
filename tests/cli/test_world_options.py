from __future__ import annotations

import json

import pytest

from surefoot.cli.main import main
from surefoot.cli.world_options import contact_law
from surefoot.laws import Hertz, HuntCrossley, MujocoLaw, SpringDamper


def summary(capsys, tmp_path, *arguments):
    options = ["--no-video", "--no-report", "--json", "--out", str(tmp_path)]
    code = main([arguments[0], "go2", *arguments[1:], *options])
    return code, json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(
    ("text", "law"),
    [
        ("spring-damper:k=2e4,d=100", SpringDamper(2e4, 100.0)),
        ("hunt-crossley:k=2e5,a=0.5,p=1.5", HuntCrossley(2e5, 0.5, 1.5)),
        ("hertz:radius=0.02,modulus=1e7,a=0.3", Hertz.sphere(0.02, 1e7, dissipation=0.3)),
        ("hertz:k=1e6", Hertz(1e6)),
        ("mujoco:mass=4", MujocoLaw((0.02, 1.0), (0.9, 0.95, 0.001), mass=4.0)),
    ],
)
def test_law_of_a_text(text, law):
    assert contact_law(text, 0.6) == law


def test_stands_on_soft_ground(capsys, tmp_path):
    code, found = summary(
        capsys, tmp_path, "stand", "--world", "rigid", "--law", "hunt-crossley:k=2e5,a=0.5", "--duration", "1"
    )
    assert (code, found["stood"], found["laws_broken"]) == (0, True, [])


def test_a_whole_robot_stands_as_its_feet_do(capsys, tmp_path):
    common = ("stand", "--world", "rigid", "--duration", "0.5")
    code, found = summary(capsys, tmp_path / "full", *common, "--collision", "full")
    _, feet = summary(capsys, tmp_path / "feet", *common)
    assert (code, found["stood"], found["laws_broken"]) == (0, True, [])
    for whole, alone in zip(found["feet"], feet["feet"], strict=True):
        assert whole["normal_force_mean"] == pytest.approx(alone["normal_force_mean"], rel=1e-6)


def test_chatter_is_told_before_it_happens_and_breaks_laws(capsys, tmp_path):
    law = ("--law", "spring-damper:k=2e6,d=100")
    common = ["stand", "go2", "--world", "rigid", *law, "--duration", "0.5", "--no-video", "--no-report"]
    assert main([*common, "--explicit", "--out", str(tmp_path)]) == 1
    assert "above the stability limit" in " ".join(capsys.readouterr().out.split())
    assert main([*common, "--out", str(tmp_path)]) == 0


def test_walks_in_the_rigid_world_and_on_soft_mujoco_ground(capsys, tmp_path):
    code, found = summary(capsys, tmp_path, "walk", "--world", "rigid", "--duration", "1")
    assert (code, found["walked"]) == (0, True)
    code, found = summary(capsys, tmp_path, "stand", "--solref", "0.02,1", "--solimp", "0.9,0.95")
    assert code == 1
    assert found["stood"]
    assert any("penetration" in line for line in found["laws_broken"])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--law", "spring-damper:k=2e4"], "--law is of --world rigid"),
        (["--world", "rigid", "--solref", "0.02,1"], "--solref is of --world mujoco"),
        (["--world", "rigid", "--law", "rubber"], "unknown law 'rubber'"),
        (["--world", "rigid", "--law", "spring-damper:x=1"], "valid names: d, k"),
        (["--world", "rigid", "--law", "spring-damper:k=1,k=2"], "k is given twice"),
        (["--world", "rigid", "--law", "spring-damper:k=nan"], "not a finite number"),
        (["--world", "rigid", "--law", "spring-damper"], "takes k, d"),
        (["--world", "rigid", "--law", "hertz:radius=0.02"], "takes k, a, radius"),
        (["--world", "rigid", "--explicit"], "--explicit goes with --law"),
        (["--solref", "0.02,-1"], "solref"),
        (["--solref", "a,b"], "not a finite number"),
        (["--world", "moon"], "unknown world 'moon'"),
        (["--world", "drake", "--collision", "full"], "--collision full is of --world mujoco or rigid"),
        (["--world", "drake", "--actuators", "real"], "--actuators real is of --world mujoco or rigid"),
        (["--actuators", "magic"], "valid names: ideal, real"),
        (["--world", "rigid", "--collision", "legs"], "valid names: feet, full"),
    ],
)
@pytest.mark.parametrize("command", ["stand", "walk"])
def test_wrong_options_are_one_line(capsys, command, options, words):
    assert main([command, "go2", *options]) == 2
    assert words in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--commands", "thoughts"], "valid names: targets, torques"),
        (["--control-rate", "333"], "--control-rate must be 1000 over a whole number"),
        (["--control-rate", "0"], "--control-rate must be"),
        (["--latency", "fast"], "--latency: 'fast' is not a finite number"),
        (["--latency", "1"], "--latency must be auto, none or from 0 to 0.03 s"),
        (["--dropout", "1"], "--dropout is T:DURATION"),
        (["--dropout", "99:0.1"], "when the run is over"),
        (["--dropout", "1:-0.1"], "duration of a dropout must be"),
        (["--planner", "contact-implicit", "--commands", "targets"], "takes no --commands"),
    ],
)
def test_wrong_commands_are_one_line(capsys, options, words):
    assert main(["walk", "go2", "--no-video", "--no-report", *options]) == 2
    assert words in " ".join(capsys.readouterr().err.split())
