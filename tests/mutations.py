"""How strong the tests are: single lines of the package are changed, and a package's own tests judge each.

    python -m tests.mutations --seed 0 --count 100 [--package contact/cones] [--tests "tests/axioms"]

A change is an operator (+ and -, * and /, < and <=, and, or, ...), a constant, or a dropped statement, drawn
with the seed from the lines of code of a package (all packages, by their lines, if none is named), but not in
annotations, which mypy judges. It is made in a copy of the checkout that is removed afterwards.
A change is caught when the package's tests fail, or run for much longer than without it; with `--all` what
these miss is judged by the tests marked long as well. The last line tells how many of how many were caught;
the exit code is 0 unless a package's tests fail without any change.
"""

from __future__ import annotations

import argparse
import ast
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = Path("src/surefoot")
PATIENCE, LONGEST = 4.0, 300.0
"""Tests that run this many times as long as without a change, and at least so long [s], have found it."""
SETTINGS_PAGE = "tests/docs/test_settings_page.py"
"""Judges what settings are, of all packages: their defaults, ranges, units and sources."""
NO_TESTS = 5
"""Pytest's exit code where no test has the mark."""
SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.MatMult: ast.Mult,
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.And: ast.Or,
    ast.Or: ast.And, ast.USub: ast.UAdd, ast.FloorDiv: ast.Div, ast.Pow: ast.Mult, ast.Mod: ast.FloorDiv,
    ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd,
}  # fmt: skip
"""Operator to what takes its place."""


class Mutation(NamedTuple):
    """One changed line: its file below the package, its number, what it was, and what it is now."""

    file: Path
    line: int
    before: str
    after: str


def package_of(file: Path) -> str:
    """Return wing and package of a file below the package; a module at the top of a wing is a package."""
    return "/".join(file.with_suffix("").parts[:2])


def tests_of(package: str) -> list[str]:
    """Return where the tests of a package are."""
    wing, _, own = package.rpartition("/")
    beside = ROOT.glob(f"tests/{wing}/test_{own}*.py")
    places = [f"tests/{package}", *(str(p.relative_to(ROOT)) for p in beside)]
    return [place for place in places if (ROOT / place).exists()]


def mutations(file: Path, source: str) -> Iterator[Mutation]:
    """Yield every change of a single line that a file of the package may have, some of them no Python."""
    lines, tree = source.splitlines(), ast.parse(source)
    unread = set(_annotations(tree))
    for node in ast.walk(tree):
        if node in unread:
            continue
        number, end = getattr(node, "lineno", 0), getattr(node, "end_lineno", 0)
        if not number or number != end:
            continue
        line = lines[number - 1]
        start, stop = (_column(line, getattr(node, name)) for name in ("col_offset", "end_col_offset"))
        for text in _changed(node):
            after = line[:start] + text + line[stop:]
            if after != line:
                yield Mutation(file, number, line, after)


def _annotations(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield every node within an annotation: no test reads one, mypy judges them all."""
    for node in ast.walk(tree):
        for name in ("annotation", "returns"):
            if isinstance(own := getattr(node, name, None), ast.AST):
                yield from ast.walk(own)


def _column(line: str, offset: int) -> int:
    """Return the place in a line of an offset in its bytes."""
    return len(line.encode()[:offset].decode())


def _changed_file(one: Mutation, folder: Path) -> str:
    """Return the text of a file of a checkout with one line changed."""
    lines = (folder / PACKAGE / one.file).read_text(encoding="utf-8").splitlines(keepends=True)
    lines[one.line - 1] = one.after + "\n"
    return "".join(lines)


def _compiles(one: Mutation) -> bool:
    try:
        ast.parse(_changed_file(one, ROOT))
    except SyntaxError:
        return False
    return True


def _changed(node: ast.AST) -> Iterator[str]:
    """Yield texts to stand where a node stands."""
    if isinstance(node, ast.Constant) and not isinstance(node.value, str | bytes):
        value = node.value
        if isinstance(value, bool):
            yield repr(not value)
        elif isinstance(value, int | float):
            yield repr(value + 1)
            yield repr(-value) if value else "2"
    elif isinstance(node, ast.BinOp | ast.UnaryOp | ast.BoolOp) and type(node.op) in SWAPS:
        yield ast.unparse(_with(node, "op", SWAPS[type(node.op)]()))
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        yield ast.unparse(node.operand)
    elif isinstance(node, ast.Compare) and type(node.ops[0]) in SWAPS:
        yield ast.unparse(_with(node, "ops", [SWAPS[type(node.ops[0])](), *node.ops[1:]]))
    elif isinstance(node, ast.Assign | ast.AugAssign | ast.Raise) or (
        isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
    ):
        yield "pass"


def _with(node: ast.AST, name: str, value: object) -> ast.AST:
    """Return a copy of a node with another field."""
    fields = {field: getattr(node, field) for field in node._fields}
    return type(node)(**{**fields, name: value})


def drawn(packages: list[str], count: int, seed: int) -> list[Mutation]:
    """Return changes of as many different lines, drawn from the packages' files (all, if none is named)."""
    per_line: dict[tuple[Path, int], list[Mutation]] = {}
    for path in sorted((ROOT / PACKAGE).rglob("*.py")):
        file = path.relative_to(ROOT / PACKAGE)
        if (not packages or package_of(file) in packages) and tests_of(package_of(file)):
            for one in mutations(file, path.read_text(encoding="utf-8")):
                per_line.setdefault((file, one.line), []).append(one)
    chance = random.Random(seed)
    places, found = sorted(per_line), list[Mutation]()
    for place in chance.sample(places, len(places)):
        if len(found) < count and (compiling := [one for one in per_line[place] if _compiles(one)]):
            found.append(chance.choice(compiling))
    return found


class Judge:
    """Runs packages' tests in a copy of the checkout, with a change and, where that matters, without.

    What passes with a change has missed it, whatever it does without; what fails has found it if the same
    file of tests passes without it.

    Parameters
    ----------
    copy
        The copy's folder.
    places
        Tests to judge by; empty for those of the package.
    everything
        Whether long ones judge what the others miss.
    """

    def __init__(self, copy: Path, places: list[str], everything: bool) -> None:
        self._copy, self._places = copy, places
        self._marks = ("not long", "long") if everything else ("not long",)
        self._seconds: dict[tuple[str, ...], float] = {}
        self._sound: dict[tuple[str, ...], bool] = {}

    def _run(self, places: list[str], mark: str, limit: float | None) -> str | None:
        """Return what tests print where one fails, "" where all pass; None beyond a time limit [s]."""
        words = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", mark]
        command = ["env", f"PYTHONPATH={self._copy / 'src'}:{self._copy}", *words, *places]
        try:
            done = subprocess.run(command, cwd=self._copy, capture_output=True, timeout=limit, text=True)
        except subprocess.TimeoutExpired:
            return None
        return f"{done.returncode}\n{done.stdout}" if done.returncode not in (0, NO_TESTS) else ""

    def _ordered(self, one: Mutation) -> list[str]:
        """Return the files of tests that judge a change, those that name its module first.

        A file that declares settings is judged by the test of their page as well.
        """
        files: dict[Path, None] = {}
        declares = "= setting(" in (self._copy / PACKAGE / one.file).read_text(encoding="utf-8")
        page = [SETTINGS_PAGE] if declares else []
        for place in self._places or [*tests_of(package_of(one.file)), *page]:
            path = self._copy / place
            files |= dict.fromkeys(sorted(path.rglob("test_*.py")) if path.is_dir() else [path])
        module = one.file.stem if one.file.stem != "__init__" else one.file.parent.name

        def far(file: Path) -> bool:
            return module not in file.name and module not in file.read_text(encoding="utf-8")

        return [str(file.relative_to(self._copy)) for file in sorted(files, key=far)]

    def _passes_clean(self, places: list[str], mark: str) -> bool:
        """Return whether tests pass without a change, asked once."""
        key = (mark, *places)
        if key not in self._sound:
            begin = time.perf_counter()
            self._sound[key] = self._run(places, mark, None) == ""
            self._seconds[key] = time.perf_counter() - begin
        return self._sound[key]

    def caught(self, one: Mutation) -> bool | None:
        """Return whether the tests of its package find a change; None where they fail without it."""
        for mark in self._marks:
            found = self._caught_by(one, mark)
            if found is not False:
                return found
        return False

    def _caught_by(self, one: Mutation, mark: str) -> bool | None:
        path = self._copy / PACKAGE / one.file
        source, places, limit = path.read_text(encoding="utf-8"), self._ordered(one), LONGEST
        while True:
            path.write_text(_changed_file(one, self._copy), encoding="utf-8")
            try:
                told = self._run(places, mark, limit)
            finally:
                path.write_text(source, encoding="utf-8")
            if told == "":
                return False
            failed = re.findall(r"^(?:FAILED|ERROR) (\S+?\.py)", told or "", re.MULTILINE)[:1]
            if not self._passes_clean(failed or sorted(places), mark):
                return None
            if told is not None or limit >= (needed := PATIENCE * self._seconds[mark, *sorted(places)]):
                return True
            limit = needed


def main() -> int:
    """Change, judge, tell."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--package", action="append", default=[], help="repeatable; all packages if none")
    parser.add_argument("--tests", default="", help="what judges, in place of the packages' own tests")
    parser.add_argument("--all", action="store_true", help="long tests judge as well")
    asked = parser.parse_args()
    chosen = drawn(asked.package, asked.count, asked.seed)
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "copy"
        shutil.copytree(
            ROOT, copy, ignore=shutil.ignore_patterns(".git", ".venv", "runs", ".pytest_cache", "build")
        )
        judge, found, judged = Judge(copy, asked.tests.split(), asked.all), 0, 0
        for one in sorted(chosen):
            caught = judge.caught(one)
            if caught is None:
                print(f"{package_of(one.file)}: its tests fail without any change")
                return 1
            found, judged = found + caught, judged + 1
            word = "caught" if caught else "MISSED"
            print(f"{word} {one.file}:{one.line}: {one.before.strip()}  ->  {one.after.strip()}", flush=True)
    print(f"{found} of {judged} caught")
    return 0


if __name__ == "__main__":
    sys.exit(main())
