"""Limits of size, held by counting: files, functions, signatures, and no ladders over families.

Docstrings do not count as lines of a function, `self` and `cls` not as parameters. What a limit is not meant
for stands in a table with its reason.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

import surefoot

TESTS = Path(__file__).parent
SOURCE = Path(surefoot.__file__).parent
FILE_LINES, FUNCTION_LINES, PARAMETERS, KERNEL_PARAMETERS = 400, 60, 10, 14

EXCEPTED = {
    # the short form of a contact problem is a contract: every argument has its name there
    ("parameters", "surefoot/contact/problem/problem.py", "__init__"),
    ("parameters", "surefoot/motion/planning/planner.py", "plan"),  # and what can be asked of a plan
    # where a user's words, or a file's, become a law
    ("isinstance", "surefoot/contact/laws/__init__.py", "Law"),
    # where what a user gives as ground is refused if it is none
    ("isinstance", "surefoot/worlds/interface/world.py", "Terrain"),
    # a solver's law is a word or, for the stepper, a soft law: the one place that tells them apart
    ("isinstance", "surefoot/mechanics/dynamics/options.py", "SoftLaw"),
}
"""(limit, file, name of the function, file or class) that a limit is not meant for."""

FAMILIES = ("Terrain", "World", "Law", "Controller")
"""Bases of the families that one asks by their methods, not for their class."""

Offence = tuple[str, str, str]


def _files(folder: Path, prefix: str) -> Iterator[tuple[str, Path]]:
    for path in sorted(folder.rglob("*.py")):
        yield f"{prefix}/{path.relative_to(folder).as_posix()}", path


@cache
def _facts() -> tuple[frozenset[Offence], dict[str, set[str]], frozenset[tuple[str, str, str]]]:
    """Return what breaks the limits on sizes, the bases of classes, and (file, name, class) of questions.

    Classes are named by their modules: two of one name are two. The trees themselves, a million objects, are
    not kept: they would slow every later collection of garbage.
    """
    sizes, bases, asked = set[Offence](), dict[str, set[str]](), set[tuple[str, str, str]]()
    for file, path in (*_files(SOURCE, "surefoot"), *_files(TESTS, "tests")):
        text = path.read_text(encoding="utf-8")
        nodes = list(ast.walk(ast.parse(text)))
        sizes |= set(_sizes(file, text, nodes))
        names = _origins(file, nodes)
        bases |= _bases(file, nodes, names)
        if file.startswith("surefoot/"):
            asked |= {(file, name, names.get(name, name)) for name in _questions(nodes)}
    return frozenset(sizes), bases, frozenset(asked)


def _module(file: str) -> str:
    """Return the name of a file's module."""
    return file.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def _origins(file: str, nodes: Sequence[ast.AST]) -> dict[str, str]:
    """Return where the names of a file come from: module and class, by name."""
    out = dict[str, str]()
    for node in nodes:
        if isinstance(node, ast.ImportFrom) and node.module:
            out |= {alias.asname or alias.name: f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.ClassDef):
            out[node.name] = f"{_module(file)}.{node.name}"
    return out


def _length(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Return the lines of a function without its decorators and its docstring."""
    assert function.end_lineno is not None
    lines, first = function.end_lineno - function.lineno + 1, function.body[0]
    if ast.get_docstring(function, clean=False) is not None:
        assert first.end_lineno is not None
        lines -= first.end_lineno - first.lineno + 1
    return lines


def _parameters(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    given = function.args
    named = [*given.posonlyargs, *given.args, *given.kwonlyargs]
    counted = sum(argument.arg not in ("self", "cls") for argument in named)
    return counted + (given.vararg is not None) + (given.kwarg is not None)


def _allowed(file: str, function: ast.FunctionDef | ast.AsyncFunctionDef) -> float:
    """Return how many parameters a function may have: kernels have more, commands any number."""
    marks = [ast.unparse(mark) for mark in function.decorator_list]
    if any("kernel" in mark for mark in marks):
        return KERNEL_PARAMETERS
    command = file.startswith("surefoot/app/cli/") and function.name == Path(file).stem
    return float("inf") if command else PARAMETERS


def _sizes(file: str, text: str, nodes: Sequence[ast.AST]) -> Iterator[Offence]:
    """Yield what breaks the limits on sizes in a file."""
    if text.count("\n") > FILE_LINES:
        yield "file", file, Path(file).name
    for node in nodes:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            if _length(node) > FUNCTION_LINES:
                yield "lines", file, node.name
            if _parameters(node) > _allowed(file, node):
                yield "parameters", file, node.name


def _bases(file: str, nodes: Sequence[ast.AST], names: dict[str, str]) -> dict[str, set[str]]:
    """Return the bases of every class in a file, by module and name."""
    plain = (
        (node.name, [ast.unparse(base).split("[")[0].split(".")[-1] for base in node.bases])
        for node in nodes
        if isinstance(node, ast.ClassDef)
    )
    return {f"{_module(file)}.{name}": {names.get(base, base) for base in own} for name, own in plain}


@cache
def _members() -> frozenset[str]:
    """Return all classes of the families, by module and name: their bases, and what inherits from them."""
    bases = {name: {_home(base) for base in own} for name, own in _facts()[1].items()}
    found = {name for name in bases if name.endswith(FAMILIES)}
    while True:
        heirs = {name for name, parents in bases.items() if parents & found} - found
        if not heirs:
            return frozenset(found)
        found |= heirs


@cache
def _home(name: str) -> str:
    """Return the class that a name stands for; one that a package hands on is that of its modules."""
    package, _, own = name.rpartition(".")
    if name in _facts()[1]:
        return name
    begin = f"{package}." if package else ""
    inside = [one for one in _facts()[1] if one.startswith(begin) and one.endswith(f".{own}")]
    return inside[0] if inside else name


def _questions(nodes: Sequence[ast.AST]) -> Iterator[str]:
    """Yield the names that a file's isinstance asks for."""
    for node in nodes:
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "isinstance":
            for part in ast.walk(node.args[-1]):
                yield part.id if isinstance(part, ast.Name) else getattr(part, "attr", "")


@cache
def _offences() -> frozenset[Offence]:
    sizes, _, asked = _facts()
    return sizes | {("isinstance", file, name) for file, name, origin in asked if _home(origin) in _members()}


def test_the_limits_hold_everywhere() -> None:
    broken = _offences() - EXCEPTED
    assert not broken, "\n".join(" ".join(one) for one in sorted(broken))


def test_what_has_been_mended_is_off_the_list() -> None:
    mended = EXCEPTED - _offences()
    assert not mended, "\n".join(" ".join(one) for one in sorted(mended))


def test_classes_of_one_name_are_told_apart_by_their_modules() -> None:
    """A belief about which feet touch is no terrain, a belief about the ground is one."""
    nodes = list(ast.walk(ast.parse("from surefoot.mechanics.terrain import Terrain\nclass Odds: ...")))
    names = _origins("surefoot/motion/estimation/odds.py", nodes)
    assert names == {
        "Terrain": "surefoot.mechanics.terrain.Terrain",
        "Odds": "surefoot.motion.estimation.odds.Odds",
    }
    assert _home(names["Terrain"]) == "surefoot.mechanics.terrain.terrain.Terrain" in _members()
    assert "surefoot.motion.ground.ground_belief.BeliefTerrain" in _members()
    assert "surefoot.motion.estimation.contact_fusion.GroundBelief" not in _members()
