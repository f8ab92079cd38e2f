"""The tables of transfer, in their quick form."""

from __future__ import annotations

import pytest

from benchmarks import transfer


@pytest.mark.long
def test_the_quick_table_has_softness_lose(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("mujoco")
    transfer.main(["--quick", "--seeds", "5"])
    rows = [line.split(" | ") for line in capsys.readouterr().out.splitlines() if line.startswith("| mujoco")]
    assert len(rows) == 7
    found = {row[0].removeprefix("| "): row[1] for row in rows}
    assert {name for name, count in found.items() if count == "5 of 5"} == {
        name for name in found if name.startswith("mujoco-exact")
    }
    assert all(row[4].startswith("gained") for row in rows if row[1] == "5 of 5")
