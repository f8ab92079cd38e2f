"""Docstrings name shapes and units: read from the source, so that no name is forgotten.

What `import surefoot` shows (and `sf.laws`, `sf.contact_sets`) has to say for every parameter, field and
result that is an array its shape ("(n, 3)"), and for every one that is a number or an array of numbers its
unit ("[N]", "[-]" for none), in the entry of that name or, where a docstring has no such sections, in its
sentences. Every other public function of the package, compiled kernels among them, names a shape where it
takes or returns an array. A reference to the name that says it ("as for `ContactProblem`") does, too.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import pytest

import surefoot

SOURCE = Path(surefoot.__file__).parent
ARRAYS = {"FloatArray", "IntArray", "BoolArray", "ArrayLike", "NDArray"}
NUMBERS = {"FloatArray", "ArrayLike", "float"}
"""Types whose values have a unit; ArrayLike may be a number, which is then its shape."""
SIZE = r"(\.\.\.|[0-9A-Za-z_][\w+*/ .-]*)"
SHAPE = re.compile(rf"\({SIZE}(, ?{SIZE})+\)|\({SIZE},\)|\(\.\.\.\)")
"""(n, 3), (..., 3), (2n + 3, 3), (nv,), and (...) for one number a batch entry."""
SYMBOL = r"(?<![A-Za-z])(N|m|mm|s|ms|kg|rad|deg|J|W|Pa|Hz|px)(?![A-Za-z])"
UNIT = re.compile(rf"\[-[\],]|\[[^\]]*{SYMBOL}[^\]]*\]|\b[Dd]imensionless\b|\bunits? of\b|\b(any|one) unit\b")
"""[m/s], [N s], [-] for what has no dimension; "in the unit of x" where it is whatever the user has."""
FREE = re.compile(
    r"\b(mask|flag|ratio|share|relative|percent|True|index|indices|unit (vector|normal)s?|rotations?)\b", re.I
)
"""Words for what has no unit."""
REFERENCE = re.compile(r"\b([Aa]s (for|in|of|on)|[Ss]ee|[Ll]ike|that of|those of|Do as) (\w+ )?`")
ENTRY = re.compile(r"^(\*{0,2}\w+(?:, \*{0,2}\w+)*)(?: ?:.*)?$")

NAMESPACES = ("contact.sets", "contact.laws", "contact.laws.soft", "contact.laws.pressure")
"""Packages whose names are shown as `sf.contact_sets` and `sf.laws`."""

Function = ast.FunctionDef | ast.AsyncFunctionDef


class Item(NamedTuple):
    """A parameter, field or result, and what is said of it."""

    name: str
    types: frozenset[str]
    text: str


def _types(annotation: ast.expr | None) -> frozenset[str]:
    if annotation is None:
        return frozenset()
    if isinstance(annotation, ast.Constant) and isinstance(annotation.value, str):
        annotation = ast.parse(annotation.value, mode="eval").body
    walked = list(ast.walk(annotation))
    if any(isinstance(node, ast.Subscript) and ast.unparse(node.value) == "Callable" for node in walked):
        return frozenset()
    found = {node.id for node in walked if isinstance(node, ast.Name)}
    return frozenset(found | {node.attr for node in walked if isinstance(node, ast.Attribute)})


def _entries(doc: str) -> dict[str, str]:
    """Return what the numpydoc sections say of each name; "" is the Returns or Yields section as a whole."""
    entries: dict[str, str] = {}
    heads = list(re.finditer(r"^(\w+(?: \w+)?)\n-{3,}$", doc, re.MULTILINE))
    for head, after in zip(heads, [*heads[1:], None], strict=False):
        text = doc[head.end() : after.start() if after else len(doc)]
        if head[1] in ("Returns", "Yields"):
            entries[""] = text
        if head[1] not in ("Parameters", "Attributes", "Other Parameters"):
            continue
        names: list[str] = []
        for line in text.splitlines():
            match = ENTRY.match(line)
            if match:
                names = [name.strip("* ") for name in match[1].split(",")]
                entries |= dict.fromkeys(names, line + "\n")
            else:
                entries |= {name: entries[name] + line + "\n" for name in names}
    return entries


def _docstring(node: Function | ast.ClassDef) -> str:
    return ast.get_docstring(node) or ""


def _given(function: Function) -> list[ast.arg]:
    given = function.args
    return [a for a in (*given.posonlyargs, *given.args, *given.kwonlyargs) if a.arg not in ("self", "cls")]


def _items(function: Function, doc: str) -> Iterator[Item]:
    """Yield a function's parameters and its result with what the docstring says of them."""
    entries = _entries(doc)
    prose = re.split(r"^\w+(?: \w+)?\n-{3,}$", doc, maxsplit=1, flags=re.MULTILINE)[0]
    for argument in _given(function):
        said = entries.get(argument.arg, "" if any(entries) else prose)
        yield Item(argument.arg, _types(argument.annotation), said)
    yield Item("result", _types(function.returns), entries.get("", "") + prose)


def _fields(node: ast.ClassDef) -> Iterator[Item]:
    """Yield the public fields of a class, said in its docstring or in a string below the field."""
    doc = _docstring(node)
    entries = _entries(doc)
    for field, below in zip(node.body, [*node.body[1:], None], strict=False):
        if not isinstance(field, ast.AnnAssign) or not isinstance(field.target, ast.Name):
            continue
        name = field.target.id
        if name.startswith("_") or "ClassVar" in _types(field.annotation):
            continue
        own = below.value if isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant) else None
        said = entries.get(name, "" if entries else doc) + (str(own.value) if own else "")
        yield Item(name, _types(field.annotation), said)


@pytest.fixture(scope="module", autouse=True)
def _forgotten_afterwards() -> Iterator[None]:
    """Let go of the trees, a million objects that would slow every later collection of garbage."""
    yield
    _modules.cache_clear()
    _exported.cache_clear()


@cache
def _modules() -> dict[str, ast.Module]:
    paths = sorted(SOURCE.rglob("*.py"))
    return {p.relative_to(SOURCE).as_posix(): ast.parse(p.read_text(encoding="utf-8")) for p in paths}


def _definition(home: str, name: str) -> tuple[str, Function | ast.ClassDef] | None:
    """Return the file and node that define a name of a module, through re-exports; None for a value."""
    file = f"{home.replace('.', '/')}.py"
    file = file if file in _modules() else f"{home.replace('.', '/')}/__init__.py"
    for node in _modules()[file].body:
        if isinstance(node, Function | ast.ClassDef) and node.name == name:
            return file, node
        inside = isinstance(node, ast.ImportFrom) and (node.module or "").startswith("surefoot.")
        if inside and any(alias.name == name for alias in node.names):
            return _definition(node.module.removeprefix("surefoot."), name)
    return None


@cache
def _exported() -> dict[str, tuple[str, Function | ast.ClassDef]]:
    stub = (SOURCE / "__init__.pyi").read_text(encoding="utf-8")
    homes = re.findall(r"^from \.([\w.]+) import (\w+) as \w+$", stub, re.MULTILINE)
    homes += [(home, name) for home in NAMESPACES for name in import_module(f"surefoot.{home}").__all__]
    found = {name: _definition(home, name) for home, name in homes}
    return {name: definition for name, definition in found.items() if definition}


def _public(node: ast.ClassDef) -> Iterator[Function]:
    for method in node.body:
        if isinstance(method, Function) and not method.name.startswith("_"):
            yield method


def _own_items(name: str, node: Function | ast.ClassDef) -> Iterator[tuple[str, Item]]:
    """Yield all that an exported name has to say, with where it is said."""
    if isinstance(node, Function):
        yield from ((name, item) for item in _items(node, _docstring(node)))
        return
    yield from ((name, item) for item in _fields(node))
    for method in node.body:
        if isinstance(method, Function) and method.name == "__init__":
            doc = _docstring(node)
            yield from ((name, item) for item in _items(method, doc) if item.name != "result")
    for method in _public(node):
        yield from ((f"{name}.{method.name}", item) for item in _items(method, _docstring(method)))


def _faults(item: Item) -> Iterator[str]:
    """Yield what is not said of an item: its shape, its unit."""
    if REFERENCE.search(item.text):
        return
    array = item.types & ARRAYS
    number = "ArrayLike" in item.types and re.search(r"\b[Nn]umber\b", item.text)
    if array and not number and not SHAPE.search(item.text):
        yield "shape"
    if item.types & NUMBERS and not UNIT.search(item.text) and not FREE.search(item.text):
        yield "unit"


def _functions() -> Iterator[tuple[str, Function]]:
    """Yield every public function and method of public classes with the module that has it."""
    for file, tree in _modules().items():
        package = file.removesuffix(".py").replace("/", ".")
        for node in tree.body:
            if isinstance(node, Function) and not node.name.startswith("_"):
                yield f"{package}.{node.name}", node
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                yield from ((f"{package}.{node.name}.{method.name}", method) for method in _public(node))


def test_exported_names_say_shapes_and_units() -> None:
    wanting = [
        f"{where} ({definition[0]}:{definition[1].lineno}): {fault} of {item.name}"
        for name, definition in _exported().items()
        for where, item in _own_items(name, definition[1])
        for fault in _faults(item)
    ]
    assert not wanting, f"{len(wanting)}\n" + "\n".join(wanting)


def _says(doc: str, what: re.Pattern[str]) -> bool:
    return bool(what.search(doc) or REFERENCE.search(doc))


def _has(function: Function, types: set[str]) -> bool:
    found = [_types(argument.annotation) for argument in _given(function)] + [_types(function.returns)]
    return any(own & types for own in found)


def test_public_functions_and_kernels_say_shapes() -> None:
    wanting = [
        f"{where}:{function.lineno}"
        for where, function in _functions()
        if _has(function, ARRAYS) and not _says(_docstring(function), SHAPE)
    ]
    assert not wanting, f"{len(wanting)}\n" + "\n".join(wanting)


def test_the_exported_names_are_found() -> None:
    found = set(_exported())
    assert {"FrictionCone", "solve_batch", "RigidWorld", "HuntCrossley", "SoftFinger", "Log"} <= found
    values = {"laws", "contact_sets", "rl", "__version__"}
    assert set(surefoot.__all__) - found - values <= {"Controller", "Terrain"} | found
