"""The benchmark of the direct method prints its tables."""

from __future__ import annotations

import pytest

pytest.importorskip("casadi")


def test_quick_run(capsys) -> None:
    from benchmarks.direct_planning import main

    main(["--quick"])
    said = capsys.readouterr().out
    assert said.count("almost") == 4  # joint feedback cannot balance it in the replay
    assert "lawful" in said
