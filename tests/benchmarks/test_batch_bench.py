"""`surefoot bench batch`: JSON alone on stdout; ours is solved to the tolerance, its gradients are right."""

from typing import Any

import pytest


@pytest.mark.long
def test_json_is_the_only_output(answer: Any) -> None:
    found = answer("bench", "batch", "--quick")
    assert found["problems"] == 100
    assert found["velocity_error"]["ours"] <= 1e-8
    assert found["gradient_error"]["ours"] < 1e-6
    assert found["times"]["compiled loop, solve"] > 0.0
