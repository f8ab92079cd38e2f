"""ROBOT is a name, a .urdf or an .xml in every command, and the ground is said alike."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from benchmarks.legged import write_legged

NONE = ("--no-video", "--no-report")


@pytest.fixture
def told(tmp_path: Path, printed: Any) -> Any:
    """Return a function that runs a command and gives its JSON, or what it says on standard error."""

    def run(*words: str, code: int = 0) -> Any:
        said = printed(*words, *(() if words[0] == "model" else ("--out", tmp_path)), code=code)
        return said if code else json.loads(said)

    return run


@pytest.mark.parametrize("limits", [True, False], ids=["limits", "none"])
@pytest.mark.long
def test_a_robot_is_the_same_as_urdf_and_as_mjcf(tmp_path: Path, told: Any, limits: bool) -> None:
    """Stand, walk and region within 2 %, though the files' shapes overlap and MJCF says less."""
    found: dict[str, list[float]] = {}
    peaks = []  # of torque: one touchdown's, which last bits move
    for form in ("urdf", "xml"):
        path, feet = write_legged(tmp_path, 4, form, limits)
        robot = (str(path), "--feet", ",".join(feet), "--json")
        region = told("region", *robot, "--no-picture", "--slope", "10")
        stand = told("stand", *robot, "--duration", "0.6", "--slope", "5", *NONE)
        walk = told("walk", *robot, "--duration", "3", *NONE)
        assert not walk["limits_broken"]
        found[form] = [
            region["com_region"]["area"], region["zmp_region"]["area"], stand["mass"],
            stand["statics"][0]["margin"], stand["statics"][0]["friction_needed"],
            stand["normal_force_total_mean"], walk["distance"], walk["velocity"]["forward"]["measured"],
            walk["duration"], *(foot["weight_share"] for foot in walk["feet"]),
        ]  # fmt: skip
        peaks.append(walk["torque_use_max"] + (not limits))
    print(*(f"{a:.4g}/{b:.4g}" for a, b in zip(*found.values(), strict=True)))
    assert found["xml"] == pytest.approx(found["urdf"], rel=0.02)
    assert peaks[0] == pytest.approx(peaks[1], rel=0.2)


def test_a_robot_whose_limits_are_unknown_walks_fast_without_a_warning(tmp_path: Path, told: Any) -> None:
    """Beyond its legs' reach demands are infinite; over limits that are not known that was no number."""
    path, feet = write_legged(tmp_path, 4, "xml", limits=False)
    robot = (str(path), "--feet", ",".join(feet), "--velocity", "4", "--duration", "0.5", "--json", *NONE)
    assert "its legs do not reach that far" in " ".join(told("walk", *robot, code=0)["notes"])


@pytest.mark.parametrize("command", ["check", "region", "stand", "walk"])
@pytest.mark.parametrize(
    ("ground", "said"),
    [
        (("--terrain", "moon"), "--terrain 'moon' is not one of: flat, slope:DEG, stairs:HEIGHT,DEPTH"),
        (("--terrain", "slope:5", "--slope", "5"), "--slope and --terrain both say what the ground is"),
        (("--slope", "95"), "--slope must be a number between -80 and 80, got 95"),
        (("--slope", "nan"), "--slope must be a number between -80 and 80, got nan"),
    ],
)
def test_wrong_ground_is_named_in_every_command(
    told: Any, command: str, ground: tuple[str, ...], said: str
) -> None:
    assert said in told(command, "go2", *ground, code=2)


def test_slope_is_short_for_terrain(told: Any) -> None:
    one, two = (
        told("check", "go2", *ground, "--json", "--no-picture")
        for ground in (("--slope", "10"), ("--terrain", "slope:10"))
    )
    assert one["contacts"] == two["contacts"]
    assert one["friction_needed"] == pytest.approx(0.17633, abs=1e-4)  # tan 10 deg


@pytest.mark.parametrize("command", ["check", "region", "stand", "walk", "plan"])
def test_a_file_without_feet_names_what_they_could_be(tmp_path: Path, told: Any, command: str) -> None:
    path, feet = write_legged(tmp_path, 3)
    said = told(command, str(path), *(["jump"] if command == "plan" else []), code=2)
    assert (
        f"needs --feet, the frames that touch the ground; its limbs end in {', '.join(sorted(feet))}" in said
    )


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("jmp",), "unknown task 'jmp'; valid names: backflip,"),
        (("go2", "jmp"), "unknown task 'jmp'"),
        (("jmp", "0.4"), "unknown task 'jmp'"),
        (("go2", "jump", "x"), "AMOUNT: 'x' is not a finite number"),
        (("go2", "jump", "1", "2"), "plan takes [ROBOT] TASK [AMOUNT], got go2 jump 1 2"),
        (("robodog", "jump"), "unknown robot 'robodog'"),
        (("go2", "ball"), "the task ball has a robot of its own: it takes no go2"),
    ],
)
def test_plan_takes_its_robot_first(told: Any, words: tuple[str, ...], said: str) -> None:
    assert said in told("plan", *words, code=2)
