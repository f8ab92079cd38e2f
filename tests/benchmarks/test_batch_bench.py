"""`surefoot bench batch`: JSON alone on stdout; ours is solved to the tolerance, its gradients are right."""

import json

import pytest

from surefoot.cli.main import main


@pytest.mark.long
def test_json_is_the_only_output(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "batch", "--quick", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["problems"] == 100
    assert found["velocity_error"]["ours"] <= 1e-8
    assert found["gradient_error"]["ours"] < 1e-6
    assert found["times"]["compiled loop, solve"] > 0.0
