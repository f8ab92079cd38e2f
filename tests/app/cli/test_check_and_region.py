"""`surefoot check`, `surefoot region` and `surefoot bench statics` from the command line."""

from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[3] / "examples" / "stances"
SLIDES = """
mass: 10
com: [0.0, 0.0, 0.4]
mu: 0.3
contacts:
  - {name: a, position: [0.1, 0.1, 0.0], normal: [-0.5, 0.0, 0.8660254037844386], heading: [1, 1, 0]}
  - {name: b, position: [0.1, -0.1, 0.0], normal: [-0.5, 0.0, 0.8660254037844386], heading: [1, 1, 0]}
  - {name: c, position: [-0.2, 0.0, -0.1], normal: [-0.5, 0.0, 0.8660254037844386], heading: [1, 1, 0]}
"""


@pytest.fixture
def slides(tmp_path):
    path = tmp_path / "slides.yaml"
    path.write_text(SLIDES)
    return str(path)


def test_possible_stance_exits_zero_and_says_why(answer, tmp_path):
    found = answer("check", EXAMPLES / "go2_three_legs.yaml", "--out", tmp_path)
    assert found["possible"] is True
    assert found["verdict"].startswith("possible: margin")
    assert sum(row["force"][2] for row in found["contacts"]) == pytest.approx(16.085 * 9.81, rel=1e-6)
    assert found["largest_push"]["up (+z)"] == pytest.approx(16.085 * 9.81, rel=1e-6)
    assert found["largest_push"]["down (-z)"] is None  # any amount: no infinity in JSON
    assert found["com_region"]["distance"] < 0.0
    assert Path(found["picture"]).stat().st_size > 10_000


def test_impossible_stance_exits_one_with_a_certificate(answer, slides, tmp_path):
    found = answer("check", slides, "--out", tmp_path / "runs", code=1)
    assert found["possible"] is False
    assert found["friction_needed"] == pytest.approx(0.57735, abs=1e-4)
    assert len(found["certificate"]) == 6
    assert all(row["force"] is None for row in found["contacts"])
    assert Path(found["picture"]).exists()


def test_more_friction_on_the_command_line_helps(answer, slides):
    found = answer("check", slides, "--mu", "0.6", "--no-picture")
    assert found["picture"] is None


def test_tables_are_readable(printed, slides):
    text = printed("check", slides, "--no-picture", code=1)
    assert "impossible: needs friction 0.577" in text
    assert "Proof: along the motion" in text
    assert "how the robot will slide or fall is another question" in " ".join(text.split())
    text = printed("check", EXAMPLES / "slope.yaml", "--no-picture")
    assert "push at the centre of mass" in text
    assert "37.74" in text
    text = printed("check", "go2", "--lift", "FL,FR,RL,RR", "--no-picture", code=1)
    assert "nothing touches the ground" in text


def test_robot_on_a_slope(answer):
    pytest.importorskip("pinocchio")
    found = answer("check", "go2", "--slope", "30", "--mu", "0.5", "--no-picture", code=1)
    assert found["friction_needed"] == pytest.approx(0.57735, abs=1e-4)
    found = answer("check", "go2", "--slope", "20", "--no-picture")
    assert found["motors"]["possible"] is True
    found = answer("check", "go2", "--lift", "FL,FR", "--no-picture", code=1)
    assert [row["name"] for row in found["contacts"]] == ["RL_foot", "RR_foot"]


def test_region_draws_and_says_where_the_weight_is(answer, printed, slides, tmp_path):
    found = answer("region", EXAMPLES / "g1_hand_on_wall.yaml", "--out", tmp_path)
    assert found["com_inside"] is True
    assert found["com_region"]["area"] > 0.1
    assert found["zmp_region"]["gap"] <= 1e-3
    assert Path(found["picture"]).stat().st_size > 10_000
    found = answer("region", slides, "--out", tmp_path)
    assert found["com_inside"] is False
    assert found["com_region"]["corners"] == []
    assert "zero-moment point" in printed("region", EXAMPLES / "chimney.yaml", "--no-picture")
