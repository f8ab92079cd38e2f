"""`surefoot walk --planner contact-implicit` and `surefoot bench plan`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.planning import iteration
from benchmarks.planning.mujoco_ilqr import MujocoEngine
from surefoot.cli.main import main
from surefoot.planning.shooting.engine import Engine
from surefoot.robot import load_robot


def test_a_walk_without_a_gait_says_how_it_plans(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    words = ["walk", "--planner", "contact-implicit", "--velocity", "0.5,0,0", "--duration", "0.6"]
    code = main([*words, "--no-video", "--no-report", "--json", "--out", str(tmp_path)])
    found = json.loads(capsys.readouterr().out)
    assert code in (0, 1)  # half a second says nothing of the velocity
    assert found["gait"] == "contact-implicit"
    assert found["outcome"] in ("walked", "did not follow")
    assert found["feasible_share"] == 1.0
    assert "25 knots of 20 ms" in found["notes"][0]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--planner", "magic"], "contact-implicit"),
        (["--planner", "contact-implicit", "--gait", "pace"], "--gait"),
        (["g1", "--planner", "contact-implicit"], "g1"),
    ],
)
def test_wrong_words_are_one_line(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["walk", *words]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert len(err.strip().splitlines()) == 1


def test_mujocos_differences_are_turned_into_pinocchios_tangents() -> None:
    """A and B against central differences of the rival's own steps, by Pinocchio's integrate."""
    import pinocchio

    robot = load_robot("go2")
    engine = MujocoEngine(iteration.problem(robot, False, iteration.RIVAL_DT))
    iteration.start(engine)
    rng = np.random.default_rng(0)
    start = pinocchio.integrate(robot.model, robot.nominal, 0.1 * rng.normal(size=18))
    start[2] += 0.5  # in the air: smooth
    assert engine.restart(start, rng.normal(size=18))
    assert engine.differentiate(0.0)
    now = engine.now
    A, B = now.A[0].copy(), now.B[0].copy()
    states, torques = (now.q.copy(), now.v.copy()), now.torques.copy()
    ends = []
    for d in np.vstack([np.eye(48), -np.eye(48)]) * 1e-5:
        q, v, u = states[0].copy(), states[1].copy(), torques.copy()
        q[0] = pinocchio.integrate(robot.model, q[0], d[:18])
        v[0] += d[18:36]
        u[0] += d[36:]
        now.q[:], now.v[:], now.torques[:] = q, v, u
        ends.append(now._step(0))
    middle = ends[0][0]
    flat = np.array([np.r_[pinocchio.difference(robot.model, middle, q), v] for q, v in ends])
    J = (flat[:48] - flat[48:]).T / 2e-5
    np.testing.assert_allclose(A, J[:, :36], atol=2e-4)
    np.testing.assert_allclose(B, J[:, 36:], atol=2e-3)


def test_the_benchmark_prints_json_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "plan", "--quick", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    solver, mpc = found["solver"], found["mpc"]
    assert solver["derivative_ratio"] > 3.0
    assert 0.0 < solver["knot"]["derivative"] < solver["ours"]["derivative"] < solver["ours"]["iteration"]
    assert solver["descent"]["ours"]["costs"][-1] < solver["descent"]["ours"]["costs"][0]
    assert mpc["walk"]["done"]
    assert mpc["pushes"][0]["done"]
    assert mpc["tick"]["processor"]["p99"] > 0.0


def test_both_solvers_start_from_the_same_motion() -> None:
    robot = load_robot("go2")
    problem = iteration.problem(robot, False, iteration.RIVAL_DT)
    costs = [iteration.start(kind(problem)) for kind in (Engine, MujocoEngine)]
    assert costs[0] == pytest.approx(costs[1], rel=0.5)
