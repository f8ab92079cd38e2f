"""The private parts of Numba that kernels are compiled with: a new Numba fails here, and is told what to do.

How fast and how often kernels are compiled with them, `tests/test_startup.py` tests.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

import surefoot
from surefoot.base.compilation import choice, numba_internals

ROOT = Path(__file__).parents[3]
TO_DO = f"""
Numba {numba.__version__} differs from those that surefoot.base.compilation.numba_internals was made for.
Until that is repaired users lose time at first calls and nothing else: leave `choice.KNOWN` and the bounds in
pyproject.toml and conda/meta.yaml below this version, and kernels take the plain path by themselves.
To repair it, change numba_internals.py alone until this file and tests/test_startup.py, long tests included,
pass with the old version and the new one; then raise the three bounds."""
PROGRAM = """
from surefoot.base.compilation.numba_internals import compiled
from surefoot.base.compilation.uncounted import borrowed, keep, window

@compiled
def twice(x):
    return 2.0 * x

@compiled
def plus(x):
    return x + 1.0

def small(x):
    return plus(x)

small = compiled(small, folded=True)

@compiled
def applied(f, x):
    return f(x)

@compiled
def top(a):
    part = window(a, 2, 2, 2)
    total = applied(twice, part[1, 1]) + small(borrowed(a)[0])
    keep(a)
    return total
"""


@pytest.fixture
def top(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return a module's kernels, of which `top` uses all of it; compiled code is kept in a new folder."""
    file = tmp_path / "all_of_it.py"
    file.write_text(PROGRAM)
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "kept"))
    names: dict[str, Any] = {"__name__": "all_of_it"}
    exec(compile(PROGRAM, str(file), "exec"), names)
    return names


def test_this_numba_is_one_that_is_known() -> None:
    assert choice.unknown_version(numba.__version__) == "", TO_DO


def test_the_bounds_are_the_same_in_three_places() -> None:
    low, high = (".".join(map(str, bound)) for bound in choice.KNOWN)
    asked = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]
    assert f"numba>={low},<{high}" in asked
    assert f"- numba >={low},<{high}\n" in (ROOT / "conda" / "meta.yaml").read_text(encoding="utf-8")
    pinned = re.search(r"^numba==(\S+)", (ROOT / "constraints.txt").read_text(encoding="utf-8"), re.MULTILINE)
    assert pinned is not None
    assert choice.unknown_version(pinned[1]) == ""


@pytest.mark.parametrize(
    ("version", "known"),
    [
        ("0.61.0", True),
        ("0.68.1", True),
        ("0.60.9", False),
        ("0.69.0dev0+3.g1", False),
        ("1.0", False),
        ("", False),
    ],
)
def test_versions(version: str, known: bool) -> None:
    assert (choice.unknown_version(version) == "") is known


def _named(part: tuple[Any, str, str]) -> str:
    """Return a name that is the same in every process: no address stands in it."""
    return f"{getattr(part[0], '__name__', type(part[0]).__name__)}-{part[1]}"


@pytest.mark.parametrize("part", numba_internals.RELIES_ON, ids=_named)
def test_a_part_is_there_and_takes_what_it_took(part: tuple[Any, str, str], monkeypatch: Any) -> None:
    monkeypatch.setattr(numba_internals, "RELIES_ON", (part,))
    try:
        numba_internals.check()
    except TypeError as error:
        pytest.fail(f"{error}. {TO_DO}")


def test_what_has_gone_or_changed_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    owner = numba_internals.JITCodeLibrary
    monkeypatch.delenv(choice.ASKED, raising=False)
    assert choice.plain_because() == ("" if choice.unknown_version(numba.__version__) == "" else TO_DO)
    monkeypatch.setattr(numba_internals, "RELIES_ON", ((owner, "_gone", ""),))
    assert choice.plain_because().endswith("JITCodeLibrary _gone has gone")
    monkeypatch.setattr(numba_internals, "RELIES_ON", ((owner, "get_pointer_to_function", "self title"),))
    assert choice.plain_because().endswith("get_pointer_to_function takes (self name), not (self title)")


def test_a_tree_is_compiled_once_and_its_parts_are_only_translated(top: Any) -> None:
    given = np.arange(6.0)
    assert top["top"](given) == 11.0, TO_DO
    (linked,) = top["twice"]._part.overloads.values()
    assert isinstance(linked.library, numba_internals.Part), TO_DO
    assert linked.library.get_pointer_to_function("any") == 0
    assert not top["twice"].overloads, TO_DO


def test_what_a_folded_kernel_calls_is_not_folded_with_it(top: Any) -> None:
    """Numba hands the option on: a tree below a folded kernel became one function that took LLVM a minute."""
    top["top"](np.arange(9.0))
    (folded,), (called,) = (top[name]._part.overloads.values() for name in ("small", "plus"))
    assert "alwaysinline" in folded.library.get_llvm_str()
    assert "alwaysinline" not in called.library.get_llvm_str()


def test_arrays_are_lent_uncounted(top: Any) -> None:
    """The counting that Numba would write for `window` and `borrowed` is not in the code."""
    given = np.arange(6.0)
    before = sys.getrefcount(given)
    top["top"](given)
    assert sys.getrefcount(given) == before, TO_DO
    (code,) = top["top"].inspect_llvm().values()
    body = re.search(r"^define [^@]*@_ZN9all_of_it3top.*?^}", code, re.MULTILINE | re.DOTALL)
    assert body is not None
    assert "NRT_incref" not in body[0], TO_DO


def test_compiled_code_is_kept_as_machine_code_of_the_tree(top: Any) -> None:
    """A kernel that is given another one is kept as well, without an address of this process."""
    top["top"](np.arange(6.0))
    cache = top["top"]._cache
    (kept,) = Path(cache.cache_path).glob("*.nbc")
    with kept.open("rb") as file:
        (_, kind, (machine, llvm)), *_ = numba_internals._Unpickler(file).load()
    assert kind == "object", TO_DO
    assert isinstance(machine, bytes), TO_DO
    assert isinstance(llvm, bytes), TO_DO
    key = cache._index_key(top["top"].signatures[0], top["top"].targetctx.codegen())
    assert cache._cache_file.load(key) is not None, TO_DO


def test_an_entry_point_is_a_compiled_function(top: Any) -> None:
    call = numba_internals.entry_point(top["top"], (numba.float64[::1],))
    given = np.arange(6.0)
    given.setflags(write=False)
    assert call(given) == 11.0, TO_DO
    assert len(top["top"].signatures) == 1, TO_DO


def test_no_other_file_imports_private_parts() -> None:
    """The clock's events are no exception to the rule: Numba's manual has them for programs to use."""
    package = Path(surefoot.__file__).parent
    found = set[tuple[str, str]]()
    texts = {path: path.read_text(encoding="utf-8") for path in package.rglob("*.py")}
    for path in (path for path, text in texts.items() if "numba." in text):
        for node in ast.walk(ast.parse(texts[path])):
            if isinstance(node, ast.ImportFrom):
                names = [f"{node.module}.{alias.name}" for alias in node.names]
            elif isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif (
                isinstance(node, ast.Attribute)
                and isinstance(node.value, ast.Name)
                and node.value.id == "numba"
            ):
                names = [f"numba.{node.attr}.x"] if node.attr in ("core", "np", "misc", "cpython") else []
            else:
                continue
            found |= {(path.name, name) for name in names if name.startswith("numba.")}
    others = {(file, name) for file, name in found if file not in ("numba_internals.py", "uncounted.py")}
    assert others == {("clock.py", "numba.core.event")}


def test_where_a_part_cannot_be_imported_kernels_are_plain_with_one_line_in_the_log() -> None:
    code = (
        "import numba.core.datamodel as d, sys\nkept = d.register_default\ndel d.register_default\n"
        "import surefoot.base.kernels as k\nfrom surefoot.base import compilation as c\n"
        "d.register_default = kept\n"  # Numba needs it itself
        "f = k.kernel(lambda x: 2.0 * x)\nprint(f(3.0), bool(c.PLAIN_BECAUSE))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout.split() == ["6.0", "True"], done.stderr
    (line,) = done.stderr.splitlines()
    assert "plain numba.njit" in line
    assert "register_default" in line
