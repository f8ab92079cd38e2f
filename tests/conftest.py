"""Shared by all tests: fixed seeds, MuJoCo that draws without a screen, and what makes them quick.

XLA's compiled programs are kept in pytest's cache folder (`make clean` removes it), by the features of the
processor that they were compiled for: tests with JAX spend four fifths of their time in the compiler. Tests
that use JAX belong to one group of workers, "jax", so that no two processes write there at once.

Garbage is collected less often, and what was there before the first test, a million objects of imported
packages, is no longer looked through.
"""

from __future__ import annotations

import contextlib
import gc
import os
import zlib
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")


def _processor() -> str:
    """Return a number for the instructions that this machine's processor has."""
    with contextlib.suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        told = sorted({line for line in lines if line.startswith(("flags", "Features", "model name"))})
        return f"{zlib.crc32(' '.join(told).encode()):08x}"
    return "here"


_CACHE = Path(__file__).resolve().parents[1] / ".pytest_cache" / "d" / f"jax-{_processor()}"
os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(_CACHE))
os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0")
os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES", "-1")

import pytest
from hypothesis import settings

from surefoot.errors import SurefootError
from surefoot.simulation.mujoco import import_mujoco

settings.register_profile("fixed", derandomize=True, deadline=None, database=None)
settings.load_profile("fixed")

with contextlib.suppress(SurefootError):  # the tests that need it say so themselves
    import_mujoco()


def pytest_configure(config: pytest.Config) -> None:
    """Let a file that a killed run left half written be compiled anew."""
    for doing in ("reading", "writing"):
        config.addinivalue_line("filterwarnings", f"ignore:Error {doing} persistent compilation cache")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Run tests that share a fixture of their module in one worker, which then makes it once."""
    for item in items:
        file, told = item.nodeid.split("::")[0], getattr(item, "_fixtureinfo", None)
        known = [one for defs in told.name2fixturedefs.values() for one in defs] if told else []
        shares = any(one.scope == "module" and one.baseid == file for one in known)
        if shares and item.get_closest_marker("xdist_group") is None:
            item.add_marker(pytest.mark.xdist_group(file))


def pytest_collection_finish() -> None:
    """Spare the collector what is there for good."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)
