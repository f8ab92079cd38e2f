"""The package as a whole: light to import, honest about what is missing, names where they belong."""

from __future__ import annotations

import ast
import importlib
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import surefoot as sf


def test_import_is_light() -> None:
    heavy = ("numba", "scipy", "pinocchio", "mujoco", "matplotlib", "typer", "numpy")
    code = f"import surefoot, sys; print([m for m in {heavy!r} if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


def test_every_public_name_loads() -> None:
    for name in sf.__all__:
        assert getattr(sf, name) is not None
    assert set(sf.__all__) <= set(dir(sf))


def test_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'frictioncone'"):
        sf.frictioncone  # noqa: B018


@pytest.mark.parametrize(
    ("module", "package", "call"),
    [
        (
            "mujoco",
            "mujoco",
            "from surefoot.worlds.mujoco.mujoco_world import import_mujoco; import_mujoco()",
        ),
        ("pinocchio", "pin", "import surefoot; surefoot.load_robot('go2')"),
        ("matplotlib", "matplotlib", "from surefoot.app.viz.style import new_figure; new_figure()"),
    ],
)
def test_absent_package_is_one_clear_error(module: str, package: str, call: str) -> None:
    code = (
        f"import sys; sys.modules[{module!r}] = None; from surefoot.base.errors import SurefootError\n"
        f"try:\n    {call}\nexcept ImportError as x:\n    assert isinstance(x, SurefootError)\n    print(x)"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.startswith(f"{package} is not installed; run: pip install -e '.[")


def test_the_stub_is_the_one_list_of_names() -> None:
    """Every name has one home in `__init__.pyi`, and is what its home calls by that name."""
    source = (Path(sf.__file__).parent / "__init__.pyi").read_text(encoding="utf-8")
    homes = re.findall(r"^from \.([\w.]+) import (\w+) as (\w+)$", source, re.MULTILINE)
    modules = re.findall(r"^from \. import (\w+) as (\w+)$", source, re.MULTILINE)
    listed = [name for _, name, _ in homes] + [name for name, _ in modules] + ["__version__"]
    assert sorted(listed) == sorted(sf.__all__)
    assert all(getattr(sf, name) is importlib.import_module(f"surefoot.{name}") for name, _ in modules)
    for home, name, shown in homes:
        assert name == shown
        assert getattr(sf, name) is getattr(importlib.import_module(f"surefoot.{home}"), name)


def test_there_are_114_names_at_most_and_each_is_shown() -> None:
    """In a page or an example, as a user would write it; `pytest -s` prints how many there are."""
    root = Path(__file__).resolve().parents[1]
    found = [
        root / "README.md",
        *root.glob("docs/**/*.md"),
        *root.glob("course/en/*.md"),
        *root.glob("examples/*.py"),
    ]
    text = "\n".join(page.read_text(encoding="utf-8") for page in found if "build" not in page.parts)
    shown = {*re.findall(r"\bsf\.(\w+)", text)}
    for listed in re.findall(r"^from surefoot import ([\w, ]+)$", text, re.MULTILINE):
        shown |= {name.strip() for name in listed.split(",")}
    names = {*sf.__all__} - {"__version__"}
    print(f"\n{len(names)} public names")
    assert len(names) <= 114  # estimate_state is the latest: a stranger's log in one call
    assert names <= shown, f"nobody sees {sorted(names - shown)}"


def test_the_packages_docstring_lists_every_name_once_under_five_verbs() -> None:
    text = (sf.__doc__ or "").partition("By what one does with them:")[2]
    sections = re.findall(r"^(\w+)\n((?:    .*\n?)+)", text, re.MULTILINE)
    assert [name for name, _ in sections] == ["Constrain", "Solve", "Check", "Walk", "Look"]
    names = [name for _, body in sections for name in re.findall(r"\w+", body)]
    assert sorted(names) == sorted({*sf.__all__} - {"__version__"})


POSIX = ("fcntl", "grp", "pwd", "resource", "termios")
"""Modules of Python that Windows does not have."""


def test_no_module_needs_what_windows_lacks() -> None:
    """Such an import is one that may fail: behind `try`, or in a function that says what else is done."""
    for path in Path(sf.__file__).parent.rglob("*.py"):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, (ast.Import, ast.ImportFrom)):
                named = (
                    [node.module or ""] if isinstance(node, ast.ImportFrom) else [a.name for a in node.names]
                )
                assert not set(POSIX) & set(named), path


@pytest.mark.long
def test_every_module_is_imported_without_what_windows_lacks() -> None:
    code = f"""
import asyncio, importlib, os, pkgutil, shutil, signal, subprocess, sys, tarfile
import numba, numpy, scipy, surefoot
from surefoot.base.errors import MissingExtra
sys.modules.update(dict.fromkeys({POSIX!r}))
for name in ("sched_getaffinity", "fork", "getuid", "nice", "sysconf", "uname"):
    delattr(os, name)
for name in ("SIGHUP", "SIGKILL", "SIGALRM", "SIGUSR1"):
    delattr(signal, name)
for module in pkgutil.walk_packages(surefoot.__path__, "surefoot."):
    if not module.name.endswith("__main__"):
        try:
            importlib.import_module(module.name)
        except MissingExtra:
            pass
from surefoot.base.compilation import PLAIN_BECAUSE
print(repr(PLAIN_BECAUSE))
"""
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "''"


def test_the_install_page_has_every_extra() -> None:
    root = Path(__file__).parent.parent
    extras = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"][
        "optional-dependencies"
    ]
    page = (root / "docs" / "install.md").read_text(encoding="utf-8")
    table = "\n".join(line for line in page.splitlines() if line.startswith("| ") and "[" in line)
    named = {name for found in re.findall(r"\[([\w,]+)\]`", table) for name in found.split(",")}
    assert named == set(extras)
