"""Which versions the figures belong to: of the peers, of packages, of the machine."""

from __future__ import annotations

import os
import platform
import subprocess
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = ("numpy", "scipy", "numba", "pin", "example-robot-data", "mujoco")
"""Packages that the figures depend on; constraints.txt pins them."""
ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Pin:
    """A peer as it was measured.

    Attributes
    ----------
    url, commit
        Where it is, and which state of it the adapter was written for.
    variable
        Environment variable that names a checkout; with ``_PYTHON`` behind it that of its interpreter.
    needs
        What that interpreter must be able to import, as arguments of pip.
    """

    url: str
    commit: str
    variable: str
    needs: str


PINS = {
    "go2-convex-mpc": Pin(
        "https://github.com/elijah-waichong-chan/go2-convex-mpc",
        "77d4e8d23f5e6abdd7fe023dec336516d6f40638",
        "SUREFOOT_GO2_CONVEX_MPC",
        "'numpy<2' 'scipy<1.15' pin casadi",
    ),
}


def commit_of(folder: Path = ROOT) -> str:
    """Return the commit of a checkout, with + behind it for changed files; empty where there is none."""

    def git(*words: str) -> str:
        done = subprocess.run(["git", "-C", str(folder), *words], capture_output=True, text=True, check=True)
        return done.stdout.strip()

    try:
        if Path(git("rev-parse", "--show-toplevel")).resolve() != folder.resolve():
            return ""
        return git("rev-parse", "HEAD") + ("+" if git("status", "--porcelain", "-uno") else "")
    except (OSError, subprocess.CalledProcessError):
        return ""


def environment() -> dict[str, str]:
    """Return versions of packages, Python, system and processor."""
    out = {"python": platform.python_version(), "system": platform.platform(), "cpus": str(os.cpu_count())}
    for name in PACKAGES:
        try:
            out[name] = version(name)
        except PackageNotFoundError:
            out[name] = "missing"
    return out
