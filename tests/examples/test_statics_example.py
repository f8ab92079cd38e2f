"""The numbered example on statics runs, and its claims hold."""

import runpy
from pathlib import Path


def test_can_it_stand(capsys):
    runpy.run_path(str(Path(__file__).parents[2] / "examples" / "10_can_it_stand.py"))
    text = capsys.readouterr().out
    assert "20 deg, mu 0.6: Verdict(possible" in text
    assert "friction needed 0.700" in text
    assert "no force works against the motion" in text
