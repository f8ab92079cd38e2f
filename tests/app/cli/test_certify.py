"""`surefoot certify`: exit codes, words, the table of several files, and what is kept."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a robot that stands still, one that hangs in the air, and no motion."""
    place, robot = tmp_path_factory.mktemp("motions"), sf.load_robot("g1")
    q = np.tile(robot.nominal, (40, 1))
    np.savetxt(place / "still.csv", q, delimiter=",")
    q[:, 2] += 0.05
    np.savetxt(place / "hangs.csv", q, delimiter=",")
    (place / "none.csv").write_text("a,b\n1,x\n")
    return place


GIVEN = ("--fps", "30", "--order", "depth", "--quaternion", "xyzw")


def test_one_motion_in_words(folder: Path, printed: Callable[..., str]) -> None:
    said = printed("certify", folder / "still.csv", *GIVEN)
    assert "still: possible" in said
    said = printed("certify", folder / "hangs.csv", *GIVEN, code=1)
    assert "hangs" in said
    assert "lower the root by 5 cm" in said


def test_several_motions_are_ranked_and_kept(
    folder: Path, tmp_path: Path, printed: Callable[..., str], answer: Callable[..., Any]
) -> None:
    files = (folder / "hangs.csv", folder / "still.csv")
    given = (*GIVEN, "--out", tmp_path / "kept", "--jobs", "1")
    said = printed("certify", *files, *given, code=1)
    assert said.index("still.csv") < said.index("hangs.csv")
    assert "1 of 2 motions are possible" in said
    assert "50.0 % of 72 frames are impossible: hangs 50.0 %" in said
    kept = sorted(path.suffix for path in (tmp_path / "kept").iterdir())
    assert kept == [".csv", ".csv", ".json", ".json"]
    assert "2 were certified before" in printed("certify", *files, *given, code=1)
    for path in (tmp_path / "kept").glob("*.json"):  # as a run leaves it that is interrupted between the two
        path.unlink()
    found = answer("certify", *files, *given, code=1)
    assert [one["verdict"] for one in found] == ["impossible", "possible"]


def test_motions_are_mended_into_a_folder(
    folder: Path, tmp_path: Path, printed: Callable[..., str], answer: Callable[..., Any]
) -> None:
    given = (folder / "hangs.csv", *GIVEN, "--repair", tmp_path / "mended")
    said = printed("certify", *given, code=1)
    assert "hangs: 100.0 % of its frames were impossible, 0.0 % are" in said
    (path,) = (tmp_path / "mended").iterdir()
    motion = sf.read_motion(path, "g1")
    assert (motion.rate, len(motion), motion.notes) == (30.0, 40, ())
    assert sf.certify_motion(motion.robot, motion).verdict == "possible"
    (facts,) = answer("certify", *given, code=1)
    assert facts["mended"]["file"] == str(path)
    assert facts["mended"]["verdict"] == "possible"
    path.write_bytes(b"what somebody made of it")
    (facts,) = answer("certify", *given, code=1)
    assert facts["mended"]["file"] == str(path.with_stem(f"{path.stem}-again-2"))
    assert path.read_bytes() == b"what somebody made of it"
    assert len(list((tmp_path / "mended").iterdir())) == 2


def test_wrong_input_exits_2(folder: Path, tmp_path: Path, printed: Callable[..., str]) -> None:
    out = ("--jobs", "1", "--out", tmp_path / "kept")
    said = printed("certify", folder / "none.csv", folder / "still.csv", *GIVEN, *out, code=2)
    assert "none.csv" in said
    assert len(list((tmp_path / "kept").glob("still*.json"))) == 1
    assert "sliding-mu" in printed("certify", folder / "still.csv", "--sliding-mu", "1", code=2)


def test_the_page_of_a_motion(folder: Path, tmp_path: Path, printed: Callable[..., str]) -> None:
    printed("certify", folder / "hangs.csv", *GIVEN, "--picture", tmp_path / "a.html", code=1)
    page = (tmp_path / "a.html").read_text()
    assert "lower the root by 5 cm" in page
    assert "data:image/png" in page


def test_reports_of_before_are_json(folder: Path, tmp_path: Path, printed: Callable[..., str]) -> None:
    printed("certify", folder / "still.csv", *GIVEN, "--out", tmp_path / "one")
    (kept,) = (tmp_path / "one").glob("*.json")
    (facts,) = json.loads(kept.read_text())
    assert facts["verdict"] == "possible"
