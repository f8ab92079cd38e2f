"""The benchmark of exact contacts in MuJoCo: other people's models from a folder."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

from benchmarks.mujoco_exact.accuracy import ACCURACY, rocking_lean, runs_compared
from benchmarks.mujoco_exact.dominoes import GAP, HIGH, PUSH, THICK, toppling_time
from benchmarks.mujoco_exact.models import find_models, model_rows, run_models

BOX = """<mujoco><worldbody><geom type="plane" size="9 9 1"/><body pos="0 0 0.1"><joint name="x" type="slide"
axis="1 0 0"/><joint type="slide" axis="0 0 1"/><geom type="box" size="0.1 0.1 0.1"/></body></worldbody>
<actuator><motor joint="x" gear="5" ctrlrange="-1 1"/></actuator></mujoco>"""


def test_models_of_a_folder_are_run_and_summed(tmp_path: Path) -> None:
    """Found by package and name; all steps with contacts are certified; what does not load says so."""
    assets = tmp_path / "gymnasium" / "envs" / "mujoco" / "assets"
    assets.mkdir(parents=True)
    (assets / "hopper.xml").write_text(BOX)
    (assets / "ant.xml").write_text("<mujoco><wrong/></mujoco>")
    assert list(find_models(tmp_path)) == ["gym ant", "gym hopper"]
    broken, fine = run_models(tmp_path, 0.2, 5, 0)
    assert "Schema violation" in broken.said
    assert (fine.steps, fine.held, fine.missed, fine.lost, fine.share) == (100, 100, 0, 0, 1.0)
    rows = model_rows([broken, fine])
    assert [row[0] for row in rows] == ["gym hopper", "all"]
    assert rows[-1][1:6] == ["100", "100", "100.000", "0", "0"]


def test_a_folder_without_models_is_one_line(tmp_path: Path) -> None:
    """The command says what to install, and ends with 2."""
    typer = pytest.importorskip("typer")
    from benchmarks.mujoco_exact.__main__ import main

    app = typer.Typer()
    app.command()(main)
    result = CliRunner().invoke(app, ["--models", str(tmp_path)])
    assert result.exit_code == 2
    assert "gymnasium dm_control" in " ".join(result.output.split())


@pytest.mark.long
def test_bodies_with_closed_forms() -> None:
    """The exact step has them; a rod jams at once; the lean after an impact is Housner's."""
    options, exact = runs_compared()["exact"]
    found = {name.partition(" (")[0]: measure(dict(options), exact) for name, measure in ACCURACY.items()}
    assert found["cube thrown at 6 m/s"].startswith("3.664 m, ")
    for name in ("way of a block at 0° [%]", "way of a block at 45° [%]", "rate of a disc after 0.1 s [%]"):
        assert abs(float(found[name])) < 0.01
    assert abs(float(found["tip of Painlevé's rod [m/s]"])) < 2e-3
    assert float(found["stance feet of a Go2 slip [mm/s]"]) < 1e-3
    lean = float(ACCURACY[next(name for name in ACCURACY if "rocking" in name)]({"timestep": 1e-4}, True))
    assert lean == pytest.approx(np.rad2deg(rocking_lean()), rel=5e-3)
    hit = float(ACCURACY[next(name for name in ACCURACY if "domino" in name)]({"timestep": 5e-4}, True))
    assert hit == pytest.approx(1e3 * toppling_time(), rel=3e-3)


def test_two_dominoes_are_one_that_tips_until_it_meets_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """The closed form of a row, beside the equation of motion of the first one alone."""
    monkeypatch.setattr("benchmarks.mujoco_exact.dominoes.COUNT", 2)
    arm, inertia = 0.5 * np.hypot(HIGH, THICK), (HIGH**2 + THICK**2) / 3.0
    lean = np.arctan2(THICK, HIGH)

    def falls(_: float, state: np.ndarray) -> list[float]:
        return [state[1], 9.81 * arm * np.sin(state[0] - lean) / inertia]

    def meets(_: float, state: np.ndarray) -> float:
        return float(HIGH * np.sin(state[0]) - GAP)

    meets.terminal = True  # type: ignore[attr-defined]
    found = solve_ivp(falls, (0.0, 2.0), [0.0, PUSH], events=meets, rtol=1e-10, atol=1e-12)
    assert toppling_time() == pytest.approx(found.t_events[0][0], rel=1e-8)
