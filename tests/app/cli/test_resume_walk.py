"""`surefoot walk --keep-states` and `--resume`: the same log goes on, and wrong input is one line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from surefoot.app.cli import resuming
from surefoot.app.cli.main import main
from surefoot.base.errors import ProblemError, WriteError
from surefoot.records.log.log import Log
from surefoot.records.log.reading import read_log

BARE = ("--no-video", "--no-report")
CLOCKS = {"controller_time", "estimator_time"}


@pytest.fixture(scope="module")
def walked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a walk with a push, which has kept a state every 0.3 s."""
    out = tmp_path_factory.mktemp("walked")
    scenario = out / "delay.yaml"
    scenario.write_text("delay: 0.002\nice:\n  - {from: 0.5, mu: 0.5}\n")
    options = ["--duration", "0.9", "--push", "0.55:0,60,0:0.1", "--seed", "3", "--keep-states", "0.3"]
    assert main(["walk", "go2", *options, *BARE, "--scenario", str(scenario), "--out", str(out)]) in (0, 1)
    scenario.unlink()  # the log knows what stood there
    return next(out.glob("walk-go2-*"))


def resumed(walked: Path, out: Path, *options: str) -> Any:
    """Return the log of a walk that goes on."""
    assert main(["walk", "--resume", str(walked), *options, *BARE, "--out", str(out)]) in (0, 1)
    return read_log(next(out.glob("walk-go2-*")) / "log.npz")


def test_a_walk_goes_on_to_the_same_log_and_leaves_the_first_one_as_it_was(
    walked: Path, tmp_path: Path
) -> None:
    before = (walked / "log.npz").read_bytes()
    whole, log = read_log(walked / "log.npz"), resumed(walked, tmp_path, "--at", "0.5")
    assert (len(whole), len(log), log.facts["resumed_at"]) == (900, 600, 0.3)
    assert [n for n in whole if n not in CLOCKS and whole[n][300:].tobytes() != log[n].tobytes()] == []
    assert whole["push"].any()
    assert set(whole["mu"]) == {0.6, 0.5}
    assert (walked / "log.npz").read_bytes() == before
    assert sorted(path.name for path in walked.iterdir()) == ["log.npz", "summary.json"]


@pytest.mark.long
def test_pushes_velocity_and_end_may_be_others(walked: Path, tmp_path: Path) -> None:
    options = ("--at", "0.3", "--push", "0.4:0,40,0:0.1", "--velocity", "0.2,0,0.1", "--duration", "1")
    whole, log = read_log(walked / "log.npz"), resumed(walked, tmp_path, *options, "--keep-states", "0.2")
    assert len(log) == 700
    assert log["command"][-1].tolist() == [0.2, 0.0, 0.1]
    assert np.flatnonzero(log["push"].any(axis=1)).tolist() == list(range(100, 200))
    assert log["q"][0].tolist() == whole["q"][300].tolist()
    again = resumed(next(tmp_path.glob("walk-*")), tmp_path / "again", "--at", "0.9")  # and on from there
    assert again["q"].tobytes() == log["q"][500:].tobytes()


@pytest.mark.long
def test_a_walk_that_goes_on_can_be_told_to_stop(walked: Path, tmp_path: Path) -> None:
    """A controller that is made for no velocity has another gait; the one that walks is steered."""
    log = resumed(walked, tmp_path, "--at", "0.5", "--velocity", "0,0,0", "--duration", "2.5")
    assert not log["command"][-1].any()
    assert np.abs(log["v"][-100:, :2]).max() < 0.1 < read_log(walked / "log.npz")["v"][-1, 0]


def line_of(capfd: pytest.CaptureFixture[str], *words: str) -> str:
    """Return the one line that a command says which ends with code 2."""
    assert main([*words, *BARE]) == 2
    said = capfd.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    return said.err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("--at 0.5", "--at is of --resume LOG"),
        ("--resume RUN", "--resume takes --at TIME"),
        ("--resume RUN --at -1", "--at must be a number >= 0, got -1"),
        ("--resume RUN --at nan", "--at must be a number >= 0, got nan"),
        ("--resume RUN --at 1.2", "--at 1.2: RUN/log.npz tells of 0.000 to 0.900 s"),
        ("--resume RUN --at 0.5 --gait walk", "takes --duration, --push, --velocity, not --gait"),
        ("a1 --resume RUN --at 0.5", "takes --duration, --push, --velocity, not ROBOT"),
        ("--resume RUN --at 0.5 --scenario s.yaml --seed 3 --mu 0.6", "not --scenario, --seed, --mu"),
        ("--resume RUN --at 0.5 --duration 0.2", "--duration 0.2 "),
        ("--resume RUN --at 0.7 --duration 0.5", "--duration 0.5 ends before the kept state of 0.6 s"),
        ("--resume nothing.npz --at 1", "nothing.npz is not a Surefoot log (npz): there is no such file"),
        ("--resume FOLDER --at 1", "FOLDER is not a Surefoot log"),
        ("go2 --keep-states 0", "--keep-states must be a number >= 0.001, got 0"),
        ("go2 --keep-states nan", "--keep-states must be a number"),
        (
            "go2 --keep-states 1 --planner contact-implicit",
            "--planner contact-implicit does not tell its state",
        ),
        ("go2 --keep-states 1 --policy x.onnx", "--keep-states goes with --planner convex: --policy"),
    ],
)
def test_wrong_input_is_one_line(
    words: str, told: str, walked: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    def filled(text: str) -> str:
        return text.replace("RUN", str(walked)).replace("FOLDER", str(tmp_path))

    said = line_of(capfd, "walk", *map(filled, words.split()), "--out", str(tmp_path / "out"))
    assert filled(told) in said
    assert not (tmp_path / "out").exists()


def test_a_log_without_states_a_broken_one_and_one_of_another_version_are_refused(
    walked: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    log = tmp_path / "log.npz"
    read_log(walked / "log.npz").save(log)  # channels and facts alone
    ask = ("walk", "--resume", str(log), "--at", "0.5", "--out", str(tmp_path / "out"))
    assert "has kept no states: walk with --keep-states SECONDS" in line_of(capfd, *ask)
    whole = (walked / "log.npz").read_bytes()
    log.write_bytes(whole[:-2000])
    assert "is not a Surefoot log" in line_of(capfd, *ask)
    at = whole.index(b"states/000000300.npz") + 4000
    log.write_bytes(whole[:at] + bytes(64) + whole[at + 64 :])
    assert "the state of 0.300 s in" in line_of(capfd, *ask)
    log.write_bytes(whole)
    monkeypatch.setattr(resuming, "_versions", lambda: {"surefoot": "0.0.1", "mujoco": "1"})
    assert "was made by other versions: surefoot " in line_of(capfd, *ask)
    assert not (tmp_path / "out").exists()


@pytest.mark.long
def test_what_a_run_leaves_whose_log_was_not_saved_goes_on_as_well(
    walked: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(log: Log, path: Path) -> Path:
        raise WriteError(path, OSError(28, "No space left on device"))

    options = ["--duration", "0.9", "--keep-states", "0.3", "--seed", "3", "--out", str(tmp_path)]
    with monkeypatch.context() as patch:
        patch.setattr(Log, "save", full)
        assert main(["walk", "go2", *options, *BARE]) == 1
    (run,) = tmp_path.glob("walk-go2-*")
    parts = run / "log.parts"
    names = [f"{step:09d}.npz" for step in (0, 300, 600)]
    assert sorted(path.name for path in (parts / "states").iterdir()) == names
    log, whole = resumed(run, tmp_path / "more", "--at", "0.6"), read_log(parts)
    assert log["q"].tobytes() == whole["q"][600:].tobytes()
    with pytest.raises(ProblemError, match=r"a log that has kept states is saved as \.npz"):
        whole_log(parts).save(tmp_path / "log.mcap")
    assert whole_log(parts).save(tmp_path / "log.npz").exists()
    assert not parts.exists()
    assert resumed(tmp_path / "log.npz", tmp_path / "last", "--at", "0.6")["time"][0] == 0.6


def whole_log(parts: Path) -> Log:
    """Return the log in a folder of parts as its run would have it."""
    log = read_log(parts)
    log.parts = parts
    return log
