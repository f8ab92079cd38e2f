"""Shared by all tests: fixed seeds, MuJoCo that draws without a screen, and what makes them quick.

XLA's compiled programs are kept in pytest's cache folder (`make clean` removes it), by the features of the
processor that they were compiled for, and compiled without XLA's optimiser: tests with JAX spend four fifths
of their time in the compiler (contact/batch/test_jax takes 11 s of CPU in place of 18).

Where Python is told to keep no bytecode beside the sources, it is kept in pytest's cache folder as well: else
every worker compiles four hundred files of tests anew, and every process that a test starts the package.

Several workers are given whole files, see `pytest_xdist_make_scheduler`: what the tests of a file share is
made once, and what the kernels of a package share is compiled once. (The groups of pytest-xdist 3.8, `--dist
loadgroup`, have no effect under pytest 9.2.)

One function of a package is replaced, Pinocchio's reader of meshes, by one that reads each file once: a
process of a user loads a robot or two, the tests load hundreds. Of the 0.66 s that a G1 takes, its meshes
take 0.63 (a Solo's 0.16 of 0.17, a Go2's 0.04 of 0.05).

A shell's background job ignores SIGINT, one under nohup SIGHUP, and what is ignored stays so in every process
that it starts: tests of signals would wait for ever.

Garbage is collected less often, and what was there before the first test, a million objects of imported
packages, is no longer looked through. It is collected where a worker has grown, too: few objects of a log
hold much memory, and a process of eight gigabytes takes three times as long to copy itself.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
import signal
import sys
import zlib
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")


def _processor() -> str:
    """Return a number for the instructions that this machine's processor has."""
    with contextlib.suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        told = sorted({line for line in lines if line.startswith(("flags", "Features", "model name"))})
        return f"{zlib.crc32(' '.join(told).encode()):08x}"
    return "here"


_CACHE = Path(__file__).resolve().parents[1] / ".pytest_cache" / "d"
os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(_CACHE / f"jax-{_processor()}"))
os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0")
os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES", "-1")
os.environ.setdefault("XLA_FLAGS", "--xla_backend_optimization_level=0")

if sys.dont_write_bytecode and sys.pycache_prefix is None:
    sys.pycache_prefix, sys.dont_write_bytecode = str(_CACHE / "bytecode"), False
    os.environ["PYTHONPYCACHEPREFIX"] = sys.pycache_prefix
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

for _number, _usual in ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, signal.SIG_DFL)):
    if signal.getsignal(_number) is signal.SIG_IGN:
        signal.signal(_number, _usual)

import pytest
from hypothesis import settings

from surefoot.base.errors import SurefootError
from surefoot.worlds.mujoco.mujoco_world import import_mujoco


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector: pytest.Collector) -> Generator[None, Any, Any]:
    """A file of tests that cannot be imported is an error: the reader of doctests only skips it."""
    report = yield
    skipped = report.outcome == "skipped" and "unable to import module" in str(report.longrepr)
    if skipped and collector.path.is_relative_to(Path(__file__).parent):
        report.outcome, report.longrepr = "failed", f"{collector.path} cannot be imported"
    return report


settings.register_profile("fixed", derandomize=True, deadline=None, database=None)
settings.load_profile("fixed")

with contextlib.suppress(SurefootError):  # the tests that need it say so themselves
    import_mujoco()


def _shapes_read_once(build: Callable[..., Any]) -> Callable[..., Any]:
    """Return Pinocchio's reader of a URDF's shapes, which reads each once and returns copies."""
    read: dict[Any, Any] = {}

    def shapes(model: Any, path: str, kind: Any, *, package_dirs: list[str]) -> Any:
        frames = tuple((frame.name, frame.parentJoint) for frame in model.frames)
        key = path, os.stat(path).st_mtime_ns, str(kind), tuple(package_dirs), frames
        if key not in read:
            read[key] = build(model, path, kind, package_dirs=package_dirs)
        return read[key].copy()

    return shapes


with contextlib.suppress(ImportError):  # the tests that need it say so themselves
    import pinocchio

    pinocchio.buildGeomFromUrdf = _shapes_read_once(pinocchio.buildGeomFromUrdf)

PACKAGES = (
    "contact/batch", "mechanics/dynamics", "parity", "contact/derivative", "contact/problem", "conformance",
    "contact/solvers", "adversary", "benchmarks", "app/cli", "", "worlds/experiments", "examples",
    "mechanics/statics", "motion/planning", "records/identification", "motion/estimation", "worlds/rigid",
    "worlds/running", "motion/control", "motion/walking",
)  # fmt: skip
"""Packages that compile the same kernels stand together, all others at the empty name in the middle.

One worker begins at the left, the next at the right: what two compile both is 34 s of CPU in place of 39.
"""
WITH_JAX = ("contact/batch/test_dialects", "docs/test_cookbook", "worlds/rigid/test_trajectory_gradient")
"""Files for the worker that has test_jax: no two should write to one folder of compiled programs."""


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Return what gives every worker whole files, those that take long first."""
    from xdist.scheduler import LoadScopeScheduling

    class WholeFiles(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.split("::")[0].removeprefix("tests/").removesuffix(".py")
            return "contact/batch/test_jax" if file in WITH_JAX else file

        def _assign_work_unit(self, node: Any) -> None:
            packages = PACKAGES[::-1] if self.nodes.index(node) % 2 else PACKAGES

            def place(file: str) -> int:
                names = (
                    "/".join(file.split("/")[:k]) for k in (2, 1)
                )  # wing and package, or one of tests' own folders
                return packages.index(next((name for name in names if name in packages), ""))

            # of a package the file with the most tests, which is first in the queue
            self.workqueue.move_to_end(min(self.workqueue, key=place), last=False)
            super()._assign_work_unit(node)

    return WholeFiles(config, log) if config.getvalue("dist") == "loadgroup" else None


def pytest_configure(config: pytest.Config) -> None:
    """Let a file that a killed run left half written be compiled anew."""
    for doing in ("reading", "writing"):
        config.addinivalue_line("filterwarnings", f"ignore:Error {doing} persistent compilation cache")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave as many cases of a test as its mark `sampled` says, evenly spread, to `make test`."""
    cases: dict[tuple[str, int], list[pytest.Item]] = {}
    for item in items:
        mark = item.get_closest_marker("sampled")
        if mark is not None and item.get_closest_marker("long") is None:
            cases.setdefault((item.nodeid.partition("[")[0], mark.args[0]), []).append(item)
    for (_, count), found in cases.items():
        kept = {k * (len(found) - 1) // max(count - 1, 1) for k in range(count)}
        for k, item in enumerate(found):
            if k not in kept:
                item.add_marker(pytest.mark.long)


def pytest_collection_finish() -> None:
    """Spare the collector what is there for good."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)


GROWN = 256
"""Growth of a process after which its garbage is collected [MiB]."""
_largest = 0


def pytest_runtest_teardown() -> None:
    """Collect what holds memory in cycles before the process grows further."""
    global _largest
    if sys.platform == "win32":
        return
    import resource

    kibibytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    if kibibytes > _largest + GROWN * 1024:
        gc.collect()
        _largest = kibibytes


@pytest.fixture(scope="session")
def go2() -> Any:
    """Return the robot of most tests, which none may change."""
    from tests.robots import go2

    return go2()


@pytest.fixture(scope="session")
def robot(go2: Any) -> Any:
    """Return the same, where the name does not matter."""
    return go2


@pytest.fixture
def printed(capfd: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Return what runs a command line: it gives what is said, on standard error where the exit code is 2."""
    from surefoot.app.cli.main import main

    def run(*words: object, code: int = 0) -> str:
        assert main([*map(str, words)]) == code
        return capfd.readouterr()[code == 2]

    return run


@pytest.fixture
def answer(printed: Callable[..., str]) -> Callable[..., Any]:
    """Return what runs a command line: it gives the JSON that is printed, once the exit code is as told."""
    return lambda *words, code=0: json.loads(printed(*words, "--json", code=code))
