"""The benchmark of other people's models, on our own."""

from __future__ import annotations

from pathlib import Path

import pytest

import surefoot as sf
from benchmarks.audit_models import main, measure, models_under, own_models

pytest.importorskip("mujoco")

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.long
def test_our_own_models_are_told_as_a_table(capsys: pytest.CaptureFixture[str]) -> None:
    main(["--quick"])
    out = capsys.readouterr().out
    assert "| crate | pyramid | 3 | lawful |" in out
    assert "| hopper | pyramid | 3 |" in out
    assert "0 cannot tell of 2" in out
    rows = list(measure((m for m in own_models() if m[0] == "crate"), 0.1, cones=True))
    assert len(rows) == 9
    assert {row.verdict for row in rows} == {"lawful"}


def test_models_are_found_without_their_meshes(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text(
        "<mujoco><asset><mesh name='m' file='none.stl'/></asset><worldbody><body><freejoint/>"
        "<geom type='mesh' mesh='m'/><geom size='.1'/></body></worldbody></mujoco>"
    )
    (tmp_path / "part.xml").write_text("<mujocoinclude/>")
    assert [name for name, _ in models_under([tmp_path])] == ["a"]


@pytest.mark.shared
def test_a_learned_policy_is_broken_by_its_solver_and_lawful_with_a_better_one() -> None:
    folder, spec = ROOT.parent / "shared" / "policies", ROOT / "examples" / "policies" / "playground_go1.yaml"
    if not folder.exists():
        pytest.skip("needs the networks beside the checkout")
    pytest.importorskip("onnxruntime")
    policy, file = sf.Policy(folder / "playground_go1.onnx", spec), folder / "playground_go1.xml"
    shipped, better = (
        next(measure(models_under([file]), 2.0, False, iterations, policy=policy))
        for iterations in (None, 100)
    )
    assert (shipped.verdict, better.verdict) == ("broken", "lawful")
    assert "unconverged solver" in shipped.reason
