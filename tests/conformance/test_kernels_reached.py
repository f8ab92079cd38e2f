"""Every public kernel is reached by a test, by its name or through what calls it in the package.

How well a test judges what it reaches is what `python -m tests.mutations` measures.
"""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import surefoot

TESTS = Path(__file__).parents[1]
SOURCES = Path(surefoot.__file__).parent
DECORATORS = {"kernel", "inline_kernel", "releasing_kernel"}


def names_in(node: ast.AST) -> set[str]:
    """Return the names and attributes that some code uses."""
    inside = list(ast.walk(node))
    return {n.id for n in inside if isinstance(n, ast.Name)} | {
        n.attr for n in inside if isinstance(n, ast.Attribute)
    }


def definitions() -> dict[str, list[ast.AST]]:
    """Return the functions and classes of the package, methods included, by their names."""
    found: dict[str, list[ast.AST]] = {}
    for path in SOURCES.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                found.setdefault(node.name, []).append(node)
    return found


def is_public_kernel(node: ast.AST) -> bool:
    """Tell whether a definition is a decorated function without a leading underscore."""
    if not isinstance(node, ast.FunctionDef) or node.name.startswith("_"):
        return False
    return bool({d.id for d in node.decorator_list if isinstance(d, ast.Name)} & DECORATORS)


@pytest.mark.long
def test_every_public_kernel_is_reached() -> None:
    found = definitions()
    named = (names_in(ast.parse(path.read_text(encoding="utf-8"))) for path in TESTS.rglob("test_*.py"))
    reached, new = set[str](), set[str]().union(*named) & set(found)
    while new:
        reached |= new
        new = set[str]().union(*(names_in(n) for name in new for n in found[name])) & set(found) - reached
    kernels = {name for name, nodes in found.items() if any(is_public_kernel(n) for n in nodes)}
    assert len(kernels) > 100
    assert not kernels - reached, "no test reaches them: write one, or make them private"
