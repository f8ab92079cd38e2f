"""No part of a controller writes into another: state changes hands by what functions return."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import surefoot

MOTION = Path(surefoot.__file__).parent / "motion"
FILES = sorted(path for room in ("control", "standing", "walking") for path in (MOTION / room).rglob("*.py"))


def foreign_writes(tree: ast.AST) -> list[str]:
    """Return the lines that write an attribute of any object but self, or of one of self's attributes."""
    found = []
    for node in ast.walk(tree):
        targets: list[ast.expr] = []
        if isinstance(node, ast.Assign):
            targets = list(node.targets)
        elif isinstance(node, (ast.AugAssign, ast.AnnAssign)):
            targets = [node.target]
        elif isinstance(node, ast.Delete):
            targets = list(node.targets)
        while targets:
            target = targets.pop()
            if isinstance(target, (ast.Tuple, ast.List)):
                targets += target.elts
                continue
            if isinstance(target, ast.Starred):
                target = target.value
            while isinstance(target, ast.Subscript):  # self.part.array[:] = ... writes into the part, too
                target = target.value
            if isinstance(target, ast.Attribute) and not (
                isinstance(target.value, ast.Name) and target.value.id == "self"
            ):
                found.append(f"{node.lineno}: {ast.unparse(node)}")
    return found


@pytest.mark.parametrize(
    ("code", "count"),
    [
        ("self.a = 1", 0), ("a[0] = 1", 0), ("self.a[0], b = 1, 2", 0), ("self.a.b = 1", 1),
        ("other.x += 1", 1), ("self.a.b[:] = 0.0", 1), ("(x, body.height) = 1, 2", 1), ("del a.b", 1),
    ],
)  # fmt: skip
def test_the_rule(code: str, count: int) -> None:
    assert len(foreign_writes(ast.parse(code))) == count


KERNELS = {"foot_phases.py"}
"""Compiled tables whose records are local variables: `foot = feet[k]; foot.phase = ...` writes an array."""


def test_no_part_writes_into_another() -> None:
    found = {}
    for path in FILES:
        if path.name not in KERNELS:
            found[str(path.relative_to(MOTION))] = foreign_writes(ast.parse(path.read_text()))
    assert {name: lines for name, lines in found.items() if lines} == {}


def test_the_phase_of_a_foot_has_one_writer() -> None:
    marks = ".phase = ", '["phase"] = ', '["phase"], '
    writers = [p.name for p in FILES if any(mark in p.read_text() for mark in marks)]
    assert writers == ["foot_phases.py"]
