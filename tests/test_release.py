"""What is released works where nothing of the checkout is: the wheel, the source archive, every extra.

The extras are installed from the network into environments of their own, minutes and gigabytes: `make
test-release` does that, the suite leaves it out.
"""

from __future__ import annotations

import os
import re
import runpy
import subprocess
import sys
import tarfile
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

import surefoot
from tests.same_logs.revisions import DATA_ONLY

ROOT = Path(__file__).parent.parent
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = SETTINGS["project"]
PROJECT_HOME = SETTINGS["tool"]["hatch"]["metadata"]["hooks"]["custom"]["home"]
EXTRAS = PROJECT["optional-dependencies"]
TRY = """
import surefoot as sf
stance = sf.Stance([sf.PointContact(position=(x, y, 0.0), mu=0.6) for x in (-0.2, 0.2) for y in (-0.1, 0.1)])
assert sf.can_stand(stance, (0.0, 0.0, 0.3), 16.0).feasible
print(sf.__file__)
"""
IMPORTED = {
    "robot": "pinocchio", "sim": "mujoco", "qp": "qpsolvers", "viz": "matplotlib", "files": "mcap",
    "sweep": "pyarrow", "scale": "ray", "jax": "jax", "mjx": "mujoco.mjx", "torch": "torch",
    "gym": "gymnasium",
    "plan": "casadi", "lab": "viser", "rerun": "rerun", "drake": "pydrake", "bullet": "pybullet",
    "policy": "onnxruntime",
    "wire": "cyclonedds",
    "cdd": "cdd",
    "all": "pinocchio", "dev": "pytest", "docs": "sphinx",
}  # fmt: skip
"""A module that each extra brings."""


def build(kind: str, out: Path) -> Path:
    """Return a new wheel or source archive of the checkout."""
    pytest.importorskip("hatchling", reason="hatchling builds the release")
    code = f"import hatchling.build as b; print(b.build_{kind}({str(out)!r}))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    return out / done.stdout.strip().splitlines()[-1]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build("wheel", tmp_path_factory.mktemp("wheel"))


def files_of(wheel: Path) -> set[str]:
    return set(zipfile.ZipFile(wheel).namelist())


def test_the_wheel_holds_the_package_and_nothing_else(wheel: Path) -> None:
    names = files_of(wheel)
    package = Path(surefoot.__file__).parent
    kept = {
        f"surefoot/{p.relative_to(package).as_posix()}"
        for p in package.rglob("*")
        if p.is_file() and "__pycache__" not in p.parts
    }
    assert kept <= names
    assert "surefoot/examples/stances/chimney.yaml" in names
    assert all(n.startswith(("surefoot/", "surefoot-")) for n in names)
    assert "surefoot/py.typed" in names
    assert any(n.endswith("licenses/LICENSE") for n in names)


def test_the_wheel_works_away_from_the_checkout(wheel: Path, tmp_path: Path) -> None:
    zipfile.ZipFile(wheel).extractall(tmp_path / "site")
    env = {**os.environ, "PYTHONPATH": str(tmp_path / "site"), "NUMBA_DISABLE_JIT": "1"}  # nothing to compile

    def python(*arguments: str) -> str:
        done = subprocess.run(
            [sys.executable, *arguments], cwd=tmp_path, env=env, capture_output=True, text=True, check=True
        )
        return done.stdout

    assert str(tmp_path) in python("-c", "import surefoot; print(surefoot.__file__)")
    assert python("-m", "surefoot", "--version").strip() == f"surefoot {surefoot.__version__}"
    assert str(tmp_path) in python("-c", TRY)


@pytest.mark.long
def test_the_examples_of_a_wheel_are_copied_and_run(wheel: Path, tmp_path: Path) -> None:
    zipfile.ZipFile(wheel).extractall(tmp_path / "site")
    env = {**os.environ, "PYTHONPATH": str(tmp_path / "site")}

    def surefoot_command(*words: str) -> str:
        command = [sys.executable, "-m", "surefoot", *words]
        return subprocess.run(
            command, cwd=tmp_path, env=env, capture_output=True, text=True, check=True
        ).stdout

    assert "chimney.yaml" in surefoot_command("examples")
    assert "possible" in surefoot_command("check", "examples/stances/chimney.yaml", "--no-picture")


RELATIVE = re.compile(r"""(?:\]\(|(?:src|href)=")(?!https?:|#|mailto:)([^)"\s]+)""")
"""Links and pictures that lead nowhere unless the repository is around the page."""


def test_what_the_index_is_told(wheel: Path) -> None:
    """The README, whose links lead into the repository once it has an address, and nowhere before."""
    told = zipfile.ZipFile(wheel).read(next(n for n in files_of(wheel) if n.endswith("METADATA"))).decode()
    assert "Description-Content-Type: text/markdown" in told
    assert "print(verdict)" in told
    if not PROJECT_HOME:
        assert RELATIVE.findall(told) == []
    hook = runpy.run_path(str(ROOT / "hatch_build.py"))
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    assert RELATIVE.findall(hook["without_relative_links"](page)) == []
    home = "https://h.org/s"
    absolute = hook["with_absolute_links"](page, home)
    assert RELATIVE.findall(absolute) == []
    paths = re.findall(rf"{home}/(?:blob|raw)/main/([^)\"\s#]+)", absolute)
    assert len(paths) == len(RELATIVE.findall(page)) > 20
    assert [path for path in paths if not (ROOT / path).is_file()] == []


def test_links_become_absolute() -> None:
    hook = runpy.run_path(str(ROOT / "hatch_build.py"))
    text = '[a](docs/a.md#b) [c](https://x.org) <img src="docs/i.png" alt=""> ![d](docs/d.svg) [e](#e)'
    assert hook["with_absolute_links"](text, "https://h.org/s/") == (
        "[a](https://h.org/s/blob/main/docs/a.md#b) [c](https://x.org) "
        '<img src="https://h.org/s/raw/main/docs/i.png" alt=""> '
        "![d](https://h.org/s/raw/main/docs/d.svg) [e](#e)"
    )
    assert hook["without_relative_links"](text) == "a [c](https://x.org)   [e](#e)"
    metadata: dict[str, object] = {}
    hook["AddressHook"](str(ROOT), {"home": "https://h.org/s"}).update(metadata)
    assert metadata["urls"]["Issues"] == "https://h.org/s/issues"  # type: ignore[index]


@pytest.mark.long
def test_the_source_archive_builds_the_same_wheel(wheel: Path, tmp_path: Path) -> None:
    archive = build("sdist", tmp_path)
    with tarfile.open(archive) as packed:
        packed.extractall(tmp_path, **DATA_ONLY)
    source = archive.with_name(archive.name.removesuffix(".tar.gz"))
    assert {"Makefile", "constraints.txt", "LICENSE", "tests", "docs", "benchmarks"} <= {
        p.name for p in source.iterdir()
    }
    kept = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    missing = [name for name in kept.stdout.splitlines() if not (source / name).exists()]
    assert missing == [], "the tests of what is unpacked need all that the repository has"
    code = f"import hatchling.build as b; print(b.build_wheel({str(tmp_path)!r}))"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=source, capture_output=True, text=True, check=True
    )
    assert files_of(tmp_path / done.stdout.strip().splitlines()[-1]) == files_of(wheel)


@pytest.mark.skipif(
    "SUREFOOT_RELEASE" not in os.environ, reason="installs from the network: make test-release"
)
@pytest.mark.parametrize("extra", ["", *EXTRAS])
def test_it_installs_in_a_clean_environment(extra: str, wheel: Path, tmp_path: Path) -> None:
    venv.create(tmp_path / "env", with_pip=True)
    python = tmp_path / "env" / "bin" / "python"
    what = f"{wheel}[{extra}]" if extra else str(wheel)
    pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "-c", ROOT / "constraints.txt", what], check=True)
    done = subprocess.run([python, "-c", TRY], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert str(tmp_path) in done.stdout
    if extra in IMPORTED:
        subprocess.run([python, "-c", f"import {IMPORTED[extra]}"], cwd=tmp_path, check=True)
    subprocess.run([python, "-m", "surefoot", "doctor"], cwd=tmp_path, check=True)


def test_this_version_has_an_entry_in_the_changelog() -> None:
    lines = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").splitlines()
    versions = [line.removeprefix("## ").split(",")[0] for line in lines if line.startswith("## ")]
    assert versions[0] == surefoot.__version__, "the newest entry is this version's"
    assert len(set(versions)) == len(versions)
    assert f"version: {surefoot.__version__}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")


def test_the_conda_recipe_asks_for_what_the_wheel_asks_for() -> None:
    """Bounds are the same, of the base and of the extras that have an output, under conda's own names."""
    yaml = pytest.importorskip("yaml")
    names = {"pin": "pinocchio", "mujoco": "mujoco-python", "matplotlib": "matplotlib-base"}
    lines = (ROOT / "conda" / "meta.yaml").read_text(encoding="utf-8").splitlines()
    plain = "\n".join(line for line in lines if "{%" not in line and "{{" not in line)
    outputs = {one["name"]: one["requirements"]["run"] for one in yaml.safe_load(plain)["outputs"]}

    def listed(requirements: list[str]) -> set[str]:
        found = [Requirement(text) for text in requirements]
        return {f"{names.get(r.name, r.name)} {r.specifier}" for r in found if r.marker is None}

    def asked(output: list[str]) -> set[str]:
        return {f"{name} {SpecifierSet(bounds)}" for name, bounds in (text.split(" ", 1) for text in output)}

    python = f"python {PROJECT['requires-python']}"
    assert asked(outputs.pop("surefoot")) == {python, *listed(PROJECT["dependencies"])}
    for name, wanted in outputs.items():
        assert asked(wanted) == listed(EXTRAS[name.removeprefix("surefoot-")]), name
    assert {"surefoot-robot", "surefoot-sim", "surefoot-viz", "surefoot-qp"} <= outputs.keys()
