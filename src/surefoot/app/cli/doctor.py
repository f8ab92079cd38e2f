"""`surefoot doctor`: what is installed, what can draw, what is compiled, and what is missing for what."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, metadata, requires, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot import __version__
from surefoot.app.cli import options
from surefoot.app.cli.console import say, show, table

if TYPE_CHECKING:
    from packaging.requirements import Requirement
    from rich.console import Console

TRY = (
    "from surefoot.worlds.mujoco.mujoco_world import import_mujoco; import_mujoco(); import os; "
    "print(os.environ.get('MUJOCO_GL', '')); "
    "import mujoco; m = mujoco.MjModel.from_xml_string('<mujoco/>'); r = mujoco.Renderer(m, 16, 16); "
    "r.update_scene(mujoco.MjData(m)); r.render(); r.close()"
)
"""What a process that can draw survives; in one of its own, since a bad OpenGL may end it."""
PATIENCE = 60.0
"""Longest wait for that process [s]."""


def doctor(as_json: options.AsJson = False) -> int:
    """Say what of Surefoot works on this machine, and what would make the rest work.

    Exit code 0 if the base install is sound, 1 if something that it needs is missing or broken. Extras that
    are not installed are no fault.
    """
    facts = examine()
    show(facts, as_json, _print)
    return 0 if facts["sound"] else 1


def examine() -> dict[str, Any]:
    """Return all that `surefoot doctor` says."""
    extras, kernels = _extras(), _kernels()
    base = extras.pop("")
    built: Any = np.show_config(mode="dicts")
    blas = built.get("Build Dependencies", {}).get("blas", {})
    return {
        "surefoot": __version__,
        "python": platform.python_version(),
        "executable": sys.executable,
        "platform": platform.platform(),
        "cores": os.cpu_count(),
        "base": base,
        "extras": extras,
        "blas": {key: blas.get(key, "unknown") for key in ("name", "version")},
        "numba": kernels,
        "drawing": _drawing(),
        "sound": all(p["fits"] for p in base) and kernels["works"],
    }


def _extras() -> dict[str, list[dict[str, Any]]]:
    """Return the packages of every extra, "" for those of the base, with their versions."""
    from packaging.requirements import Requirement

    found: dict[str, list[dict[str, Any]]] = {"": []}
    for line in requires("surefoot") or []:
        needed = Requirement(line)
        for extra in ("", *(metadata("surefoot").get_all("Provides-Extra") or ())):
            if _is_required(needed, extra):
                found.setdefault(extra, []).append(_package(needed))
    return {name: packages for name, packages in found.items() if name not in ("all", "dev")}


def _is_required(needed: Requirement, extra: str) -> bool:
    """Return whether an extra ("" for the base) requires a package on this Python beyond the base."""
    asked = [needed.marker is None or needed.marker.evaluate({"extra": e}) for e in ("", extra)]
    return asked[1] and (not extra or not asked[0])


def _package(needed: Requirement) -> dict[str, Any]:
    """Return what is known of a package: its version (None if absent), what is asked, whether it fits."""
    have, fits = None, False
    with suppress(PackageNotFoundError):
        have = version(needed.name)
        fits = needed.specifier.contains(have, prereleases=True)
    return {"name": needed.name, "version": have, "needs": str(needed.specifier), "fits": fits}


def _kernels() -> dict[str, Any]:
    """Return whether kernels compile, in which way, for which processor, and how many are on the disk."""
    import llvmlite.binding
    import numba

    import surefoot
    from surefoot.base.compilation import PLAIN_BECAUSE, kept_files
    from surefoot.base.numerics import vectors  # noqa: F401 - any kernel, so that the folders are known

    kept = kept_files(Path(surefoot.__file__).parent)
    try:
        works = bool(numba.njit(lambda x: x + 1)(1) == 2)
    except Exception:  # whatever a broken installation raises
        works = False
    return {
        "version": numba.__version__,
        "processor": os.environ.get("NUMBA_CPU_NAME") or llvmlite.binding.get_host_cpu_name(),
        "threads": numba.config.NUMBA_NUM_THREADS,
        "switched_off": bool(numba.config.DISABLE_JIT),
        "works": works,
        "way": "plain" if PLAIN_BECAUSE else "whole trees",
        "plain_because": PLAIN_BECAUSE,
        "compiled": len(kept),
        "size": sum(f.stat().st_size for f in kept),
    }


def _drawing() -> dict[str, Any]:
    """Return through which OpenGL MuJoCo draws, and whether it does."""
    from importlib.util import find_spec

    if find_spec("mujoco") is None:
        return {"works": None, "through": None, "note": "mujoco is not installed (extra sim)"}
    try:
        done = subprocess.run([sys.executable, "-c", TRY], capture_output=True, text=True, timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        return {"works": False, "through": None, "note": f"no answer within {PATIENCE:g} s"}
    lines = [line for line in done.stderr.strip().splitlines() if line.strip()]
    note = "" if done.returncode == 0 else (lines[-1] if lines else f"exit code {done.returncode}")
    return {"works": done.returncode == 0, "through": done.stdout.strip() or None, "note": note}


def _print(console: Console, facts: dict[str, Any]) -> None:
    """Print in words."""
    say(
        console,
        f"surefoot {facts['surefoot']} on Python {facts['python']}, {facts['platform']}, "
        f"{facts['cores']} cores",
        f"BLAS: {facts['blas']['name']} {facts['blas']['version']}",
    )
    numba = facts["numba"]
    state = "compiles" if numba["works"] else "DOES NOT COMPILE"
    off = ", switched off by NUMBA_DISABLE_JIT" if numba["switched_off"] else ""
    warm = f"{numba['compiled']} kernels on the disk, {numba['size'] / 1e6:.0f} MB"
    cold = "none compiled yet: surefoot warmup does it once"
    say(console, f"Numba {numba['version']} {state} for {numba['processor']}{off}; "
        + (warm if numba["compiled"] else cold))  # fmt: skip
    if not numba["switched_off"]:
        plain = f"plain numba.njit, slower the first time: {numba['plain_because']}"
        say(console, f"kernels are compiled by {plain if numba['plain_because'] else 'whole trees of calls'}")
    drawing = facts["drawing"]
    works = {True: "works", False: "does not work", None: "unknown"}[drawing["works"]]
    through = f" through {drawing['through']}" if drawing["through"] else ""
    say(console, f"drawing: {works}{through}" + (f" ({drawing['note']})" if drawing["note"] else ""))
    rows = [_row(name, packages) for name, packages in {"base": facts["base"], **facts["extras"]}.items()]
    console.print(table(("extra", "state", "packages"), rows, left=3))
    if not facts["sound"]:
        say(console, "the base install is broken: see above", style="bold red")


def _row(name: str, packages: list[dict[str, Any]]) -> list[str]:
    """Return an extra's row of the table."""
    absent = [p for p in packages if p["version"] is None]
    old = [p for p in packages if p["version"] is not None and not p["fits"]]
    if old:
        state = "too old: " + ", ".join(f"{p['name']} {p['version']}, needs {p['needs']}" for p in old)
    elif not absent:
        state = "complete"
    elif len(absent) == len(packages):
        state = f"pip install -e '.[{name}]'"
    else:
        state = "missing: " + ", ".join(p["name"] for p in absent)
    return [name, state, ", ".join(f"{p['name']} {p['version']}" for p in packages if p["version"])]
