"""Forces on a foot without a sensor: a made-up leg whose truth is known, and the recorded one where it is."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.base.numerics.phases import debounced
from surefoot.records.identification.force_model import TOUCHING
from surefoot.records.identification.leg_motion import LegLog, read_leg_log
from tests.records.identification import hopper

RECORDED = Path(__file__).parents[4] / "shared" / "data" / "hopper"


@pytest.fixture(scope="module")
def made_up(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return hopper.write_hopper(tmp_path_factory.mktemp("hopper"))


@pytest.fixture(scope="module")
def fitted(made_up: Path) -> sf.ForceModel:
    return sf.ForceModel.fit(sf.load_robot(made_up / "hopper.urdf", fixed_base=True), made_up / "hopper.csv")


def _cut(log: LegLog, rows: slice) -> LegLog:
    fields = {name: getattr(log, name)[rows] for name in ("time", "q", "tau", "sensor")}
    return dataclasses.replace(log, **fields)


@pytest.mark.long
def test_forces_of_rows_kept_back(made_up: Path, fitted: sf.ForceModel) -> None:
    truth = np.loadtxt(made_up / "truth.csv", delimiter=",", skiprows=1)[:, 1:]
    found = fitted.estimate(made_up / "kept.csv")
    error = np.sqrt(((found.forces - truth) ** 2).mean(axis=0))
    assert error[2] < 0.5  # the sensor's own noise is 0.15
    assert (error[:2] < 0.5).all()
    inside = ((truth >= found.low) & (truth <= found.high)).mean(axis=0)
    assert (inside >= 0.90).all()
    assert (inside <= 0.995).all()
    assert np.mean(found.contact != (truth[:, 2] > TOUCHING)) < 0.02


def test_what_the_joints_and_the_sensor_have(fitted: sf.ForceModel) -> None:
    assert fitted.vertical_axis == (2, 1.0)
    np.testing.assert_allclose(fitted.axes, hopper.TURN, atol=0.12)
    assert abs(fitted.delay - hopper.LATE * hopper.DT) <= hopper.DT
    assert not fitted.lines[0]
    assert fitted.lines[1][0] == pytest.approx(hopper.LINE, abs=0.5)
    assert 0.5 * hopper.LENGTH <= fitted.length <= 2.5 * hopper.LENGTH
    true = {
        "gain": (hopper.GAIN,) * 2, "friction": hopper.FRICTION, "loaded": (hopper.LOADED,) * 2,
        "cubic": (hopper.CUBIC,) * 2, "inertia": (hopper.ROTOR,) * 2, "offset": (0.0, 0.0),
    }  # fmt: skip
    for j, joint in enumerate(("HFE", "KFE")):
        for term, values in true.items():
            _, low, high = fitted.joints[joint][term]
            assert low <= values[j] <= high, (joint, term)
    _, low, high = fitted.joints["KFE"]["friction"]
    assert low > 0.0
    assert high < 0.1


def test_another_recording_may_have_another_offset(made_up: Path, fitted: sf.ForceModel) -> None:
    rest = read_leg_log(made_up / "kept.csv")
    anew, other = (
        dataclasses.replace(rest, time=rest.time - rest.time[0], q=rest.q + turned) for turned in (0.0, 0.05)
    )
    widths = [(found.high - found.low)[500] for found in map(fitted.estimate, (rest, anew, other))]
    np.testing.assert_allclose(widths[0], widths[1])  # the clock began anew, where the leg stood
    assert (widths[2] > np.abs(fitted.offset)).all()
    assert (widths[2] > 1.2 * widths[0]).all()


@pytest.mark.long
def test_the_command(made_up: Path, tmp_path: Path, printed: Any, answer: Any) -> None:
    leg, kept = made_up / "hopper.urdf", made_up / "kept.csv"
    words = ("identify", made_up / "hopper.csv", "--model", leg, "--test", kept, "--out", tmp_path)
    facts = answer(*words)
    assert facts["fit"]["KFE"]["friction"]["unit"] == "N m"
    table = np.genfromtxt(facts["test"]["forces"], delimiter=",", names=True)
    assert len(table) == facts["test"]["rows"]
    for wrong in (["--law", "newton"], ["--rivals", "mujoco"], ["--seed", "3"]):
        assert f"{wrong[0]} are of tosses" in printed(*words, *wrong, code=2)
    assert "touchdowns [s]" in printed(*words)


def test_wrong_input_is_one_line(made_up: Path, fitted: sf.ForceModel, tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match="needs a force sensor"):
        sf.ForceModel.fit(fitted.robot, made_up / "kept.csv")
    with pytest.raises(ProblemError, match="a file is named by"):
        sf.ForceModel.fit(fitted.robot, 3)  # type: ignore[arg-type]
    with pytest.raises(ProblemError, match="tau_NAME"):
        fitted.estimate(made_up / "truth.csv")
    with pytest.raises(ProblemError, match="floats"):
        sf.ForceModel.fit(sf.load_robot(made_up / "hopper.urdf"), made_up / "hopper.csv")
    lines = (made_up / "hopper.csv").read_text("utf-8").splitlines()
    (tmp_path / "nan.csv").write_text(
        "\n".join([*lines[:200], lines[200].replace(",", ",nan,", 1)[:40]]), "utf-8"
    )
    with pytest.raises(ProblemError, match=r"nan\.csv"):
        read_leg_log(tmp_path / "nan.csv")


@pytest.mark.skipif(not RECORDED.exists(), reason="the recorded hopper is not beside the checkout")
@pytest.mark.parametrize("parts", [2, 3], ids=["halves", "two thirds"])
@pytest.mark.parametrize("first", [True, False], ids=["first", "last"])
@pytest.mark.sampled(1)
def test_the_recorded_hopper_across_parts(parts: int, first: bool) -> None:
    robot = sf.load_robot(RECORDED / "hopper.urdf", fixed_base=True)
    log = read_leg_log(RECORDED / "hopper.csv")
    cut = len(log.time) // parts
    seen, kept = (slice(0, -cut), slice(-cut, None)) if first else (slice(cut, None), slice(0, cut))
    seen, kept = _cut(log, seen), _cut(log, kept)
    model = sf.ForceModel.fit(robot, seen)
    found = model.estimate(kept)
    error = np.sqrt(((found.forces - kept.sensor) ** 2).mean(axis=0))
    assert {161, 107} <= {int(line) for line in model.lines[1]}  # both halves agree
    assert error[2] < 0.45  # regression on q, dq, ddq, tau: 0.63 to 0.70
    assert (error[:2] < [0.3, 0.5]).all()
    inside = ((kept.sensor >= found.low) & (kept.sensor <= found.high)).mean(axis=0)
    assert (inside[[0, 2]] > 0.9).all()
    assert inside[1] > (0.85 if parts == 3 else 0.65)  # 7 s do not show how y drifts
    assert np.mean(found.contact != (kept.sensor[:, 2] > TOUCHING)) < 0.01
    other = read_leg_log(RECORDED / "hopper_run2.csv")
    found = model.estimate(other)
    assert np.mean(found.contact != (other.sensor[:, 2] > TOUCHING)) < 0.05
    assert (((other.sensor >= found.low) & (other.sensor <= found.high)).mean(axis=0) > 0.85).all()


def _crossings(time: np.ndarray, force: np.ndarray, level: float) -> np.ndarray:
    above = debounced(time, force > level, 0.01)
    return time[1 + np.flatnonzero(~above[:-1] & above[1:])]


@pytest.mark.skipif(not RECORDED.exists(), reason="the recorded hopper is not beside the checkout")
@pytest.mark.long
def test_when_the_recorded_hopper_crosses_a_level() -> None:
    """At 49 levels, upwards and, backwards in time, downwards: a single level says little."""
    robot = sf.load_robot(RECORDED / "hopper.urdf", fixed_base=True)
    log, off = read_leg_log(RECORDED / "hopper.csv"), []
    parts = [_cut(log, slice(0, len(log.time) // 2)), _cut(log, slice(len(log.time) // 2, None))]
    for seen, kept in (parts, parts[::-1]):
        found = sf.ForceModel.fit(robot, seen).estimate(kept).forces[:, 2]
        for way in (1, -1):
            time = (way * kept.time)[::way]
            for level in np.arange(-12.0, 12.1, 0.5):
                true = _crossings(time, kept.sensor[::way, 2], level)
                off += [np.abs(true - t).min(initial=1.0) for t in _crossings(time, found[::way], level)]
    own = [[_crossings(p.time, p.sensor[:, 2], n)[-1] for n in (1.8, 1.9, 2.0, 2.1, 2.2)] for p in parts]
    print("the sensor's own touchdowns at 1.8, 1.9, ... 2.2 N:", *np.round(own, 3))
    print(f"within 5 ms: {np.mean(np.array(off) < 0.0051):.2f}, median {1e3 * np.median(off):.0f} ms")
    assert np.mean(np.array(off) < 0.0051) > 0.55  # without the motors' lines 0.53
