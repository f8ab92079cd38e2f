"""Numbers that are kept of a page are compared to their digits, but for what processors make differ."""

from __future__ import annotations

import pytest


@pytest.mark.parametrize(
    ("kept", "fresh", "same"),
    [
        ("[[-0.  0.  39.4485]", "[[ 0. -0.  39.4485]", True),
        ("[[-0.5  0.  39.4485]", "[[ 0.5  0.  39.4485]", False),
        ("39.4485", "39.4486", False),
        ("| scs | 8.2e-05 | 0.0 % |", "| scs | 2.6e-05 | 0.0 % |", True),
        ("| scs | 8.2e-05 | 0.0 % |", "| scs | 8.2e-05 | 0.1 % |", False),
        ("| scs | 8.2e-05 |", "| scs | 2.6e-07 |", False),
        ("residual 3e-16", "residual 4e-12", True),
        ("residual 3e-16", "residual 4", False),
    ],
)
def test_only_what_processors_make_differ_is_let_pass(kept: str, fresh: str, same: bool) -> None:
    pytest.importorskip("nbclient")
    from docs.course.run import is_same

    assert is_same(kept, fresh) is same
