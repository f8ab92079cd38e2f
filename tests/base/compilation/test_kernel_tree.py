"""What compiled code is kept under: the code and the constants of all that a kernel calls."""

from __future__ import annotations

from enum import IntEnum

from surefoot.base.compilation.tree import KernelTree


def test_a_changed_value_of_an_enum_is_another_constant() -> None:
    one, same, other = (IntEnum("Phase", {"STANCE": 0, "SWING": value}) for value in (1, 1, 2))
    said = [list(KernelTree(lambda _: None)._of_value(enum, ())) for enum in (one, same, other)]
    assert said[0] == said[1] != said[2]
