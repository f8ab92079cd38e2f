"""The structure of the package: wings, faces, circles of files; what import-linter cannot see is held here.

A face (`__init__.pyi`) is loaded lazily, so that import-linter sees an import of the wing and not of the
module behind the name. Here every name is followed to the module that defines it.
"""

from __future__ import annotations

import ast
import importlib
import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

import surefoot

SOURCE = Path(surefoot.__file__).parent
WINGS = ("base", "contact", "mechanics", "records", "motion", "worlds", "app")
FACES = ("contact", "mechanics", "records", "motion")
MOST_NAMES = 80

Import = tuple[str, str]
"""(module that imports, module whose name or which itself is imported)"""


@cache
def modules() -> dict[str, ast.Module]:
    """Return the trees of all modules, by dotted name."""
    found = {}
    for path in SOURCE.rglob("*.py"):
        name = ".".join(("surefoot", *path.relative_to(SOURCE).with_suffix("").parts)).removesuffix(
            ".__init__"
        )
        found[name] = ast.parse(path.read_text(encoding="utf-8"))
    return found


@cache
def shown(package: str) -> dict[str, str]:
    """Return name to module of a stub: of a wing, or of the package as a whole."""
    stub = SOURCE.joinpath(*package.split(".")[1:], "__init__.pyi")
    if not stub.is_file():
        return {}
    lines = re.findall(
        r"^from \.([\w.]+) import (\w+) as \2$", stub.read_text(encoding="utf-8"), re.MULTILINE
    )
    return {name: f"{package}.{module}" for module, name in lines}


@cache
def from_imports() -> dict[str, list[tuple[str, str, str]]]:
    """Return (module, name, name it has here) of what each module imports from modules of the package."""
    return {
        name: [
            (node.module or "", alias.name, alias.asname or alias.name)
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom) and node.module in modules()
            for alias in node.names
        ]
        for name, tree in modules().items()
    }


def target(module: str, name: str) -> str:
    """Return the module that `from module import name` needs: through faces, and packages that hand on."""
    if f"{module}.{name}" in modules():
        return f"{module}.{name}"
    if name in shown(module):
        return target(shown(module)[name], name)
    for source, taken, own in from_imports()[module] if _is_package(module) else ():
        if source != module and own == name:
            return target(source, taken)
    return module


@cache
def _is_package(module: str) -> bool:
    return SOURCE.joinpath(*module.split(".")[1:], "__init__.py").is_file()


@cache
def imports() -> frozenset[Import]:
    """Return every import within the package, each name followed to its home."""
    out = {
        (name, target(source, taken)) for name, taken_from in from_imports().items()
        for source, taken, _ in taken_from
    }  # fmt: skip
    return frozenset(one for one in out if one[0] != one[1])


def circles(arrows: Iterable[Import]) -> list[list[str]]:
    """Return the strongly connected sets of more than one: each of them reaches all others of its set."""
    table = sorted(set(arrows))
    names = sorted({name for arrow in table for name in arrow})
    index = {name: k for k, name in enumerate(names)}
    rows, columns = ([index[arrow[side]] for arrow in table] for side in (0, 1))
    graph = sp.csr_matrix((np.ones(len(table)), (rows, columns)), shape=(len(names), len(names)))
    count, label = sp.csgraph.connected_components(graph, directed=True, connection="strong")
    sets = [[name for name, own in zip(names, label, strict=True) if own == k] for k in range(count)]
    return [one for one in sets if len(one) > 1]


def wing_of(module: str) -> str:
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else ""


def test_every_module_stands_in_a_wing() -> None:
    places = {wing_of(name) for name in modules()}
    assert places == {*WINGS, "", "laws", "__main__"}
    assert {p.parent.name for p in SOURCE.glob("*/__init__.pyi")} == set(FACES)


BESIDE = re.compile(r'(?:Path\(__file__\)\.with_name|files\("surefoot[\w.]*"\)\.joinpath)\("([^"{]+)"\)')


def test_files_that_code_names_beside_itself_are_there() -> None:
    """A script for another interpreter is imported by nobody: its name is all there is."""
    named = [
        (path, name) for path in SOURCE.rglob("*.py") for name in BESIDE.findall(path.read_text("utf-8"))
    ]
    assert len(named) >= 5
    assert [str(path.parent / name) for path, name in named if not (path.parent / name).is_file()] == []


def test_wings_import_downwards_only() -> None:
    """With faces followed to what is behind them."""
    up = {
        one
        for one in imports()
        if {wing_of(one[0]), wing_of(one[1])} <= set(WINGS)
        and WINGS.index(wing_of(one[0])) < WINGS.index(wing_of(one[1]))
    }
    assert not up, sorted(up)


def test_names_cross_wings_through_faces_only() -> None:
    """`from surefoot.contact import ...` outside contact, never `from surefoot.contact.cones import ...`."""
    private = [
        f"{name}: {source}.{taken}"
        for name, taken_from in from_imports().items()
        for source, taken, _ in taken_from
        if wing_of(name) not in ("app", "laws", "__main__", "")
        and wing_of(source) in WINGS[1:]
        and wing_of(source) != wing_of(name)
        and taken not in shown(source)
    ]
    assert not private, private


@pytest.mark.parametrize("wing", FACES)
def test_a_face_is_short_needed_and_true(wing: str) -> None:
    """At most 80 names, each used by another wing, each what its home calls by that name."""
    names = shown(f"surefoot.{wing}")
    used = {
        taken
        for name, taken_from in from_imports().items()
        for source, taken, _ in taken_from
        if source == f"surefoot.{wing}" and wing_of(name) not in (wing, "app")
    }
    assert len(names) <= MOST_NAMES
    assert set(names) == used, sorted(set(names) ^ used)
    package = importlib.import_module(f"surefoot.{wing}")
    assert sorted(package.__all__) == sorted(names)
    for name, home in names.items():
        value = getattr(package, name)
        if f"{home}.{name}" not in modules():
            assert value is getattr(importlib.import_module(home), name)
    with pytest.raises(AttributeError, match="no attribute 'frictioncone'"):
        _ = package.frictioncone


def test_a_circle_is_found() -> None:
    assert circles([("a", "b"), ("b", "c"), ("c", "a"), ("c", "d"), ("e", "a")]) == [["a", "b", "c"]]
    assert circles([("a", "b"), ("b", "c"), ("a", "c")]) == []


def test_no_circle_of_files() -> None:
    """Imports in functions and for type checkers count, and names are followed through faces."""
    assert circles(imports()) == []


def test_no_circle_through_a_package() -> None:
    """Whoever imports a module runs the `__init__` of each package around it first."""
    packages = {name for name in modules() if any(other.startswith(f"{name}.") for other in modules())}
    around = {
        (one, package)
        for one, other in imports()
        for package in packages
        if other.startswith(f"{package}.") and not f"{one}.".startswith(f"{package}.")
    }
    assert circles({*imports(), *around}) == []


def test_no_circle_of_packages_within_a_wing() -> None:
    """A package is a folder of a wing, or a file that stands beside them."""
    packages = {
        (".".join(one.split(".")[1:3]), ".".join(other.split(".")[1:3]))
        for one, other in imports()
        if wing_of(one) == wing_of(other) and one.count(".") > 1 and other.count(".") > 1
    }
    assert circles((a, b) for a, b in packages if a != b) == []


def reached(start: str) -> dict[str, str]:
    """Return what a package's modules import directly or not, each with the module that imports it."""
    out: dict[str, str] = {}
    ahead = [name for name in modules() if name == start or name.startswith(f"{start}.")]
    while ahead:
        one = ahead.pop()
        for importer, imported in imports():
            if importer == one and imported not in out:
                out[imported] = one
                ahead.append(imported)
    return out


@pytest.mark.parametrize("judge", ["surefoot.records.audit", "surefoot.records.log"])
def test_what_judges_imports_nothing_that_it_judges(judge: str) -> None:
    """No solver, estimate, controller or world, directly or not: no arithmetic is shared with them."""
    players = ("contact.solvers", "contact.batch", "records.identification", "motion", "worlds")
    wrong = {
        name: by
        for name, by in reached(judge).items()
        if name.startswith(tuple(f"surefoot.{p}" for p in players))
    }
    assert not wrong


@pytest.mark.parametrize(
    "player", ["contact", "mechanics", "motion", "records.identification", "records.log"]
)
def test_what_is_judged_does_not_import_the_audit(player: str) -> None:
    ruler = {
        name: by
        for name, by in reached(f"surefoot.{player}").items()
        if name.startswith("surefoot.records.audit")
    }
    assert not ruler
