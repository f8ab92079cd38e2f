"""The first call on a machine: what is loaded, what is compiled, where it is kept and when it is stale."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import surefoot

SOURCES = Path(surefoot.__file__).parent
SMALL = """
import json, numpy as np, surefoot as sf
feet = [[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.15, 0], [-0.2, -0.15, 0.05]]
stance = sf.Stance([sf.PointContact(p, mu=0.6) for p in feet])
random = np.random.default_rng(3)
J = random.normal(size=(6, 9))
solution = sf.solve(sf.ContactProblem(J @ J.T, random.normal(size=6) - [0, 0, 1, 0, 0, 1], 0.6))
distributor = sf.ForceDistributor(0.6, 5.0, 250.0)
forces = distributor.solve(stance.grasp_map([0, 0, 0.3]), [20.0, 0, 160.0, 0, 0, 0])
verdict = sf.can_stand(stance, [0.03, 0.02, 0.3], 16.0)
print(json.dumps({
    "solution": solution.forces.tolist(), "status": solution.status.value, "forces": forces.tolist(),
    "feasible": verdict.feasible, "margin": float(verdict.margin),
}))
"""
TWO_FILES = {
    "below.py": "from surefoot.base.kernels import inline_kernel\n\n"
    "SHIFT = {shift}\n\n@inline_kernel\ndef below(x: float) -> float:\n    return {factor} * x + SHIFT\n",
    "above.py": "from surefoot.base.kernels import kernel\nimport below\n{comment}\n"
    "shifted = below.below\n\n@kernel\ndef above(x: float) -> float:\n    return shifted(x)\n",
}
ASK = (
    "import above\nvalue = above.above(10.0)\n"
    "print(value, sum(above.above._cache_hits.values()), above.above._cache.cache_path)"
)


def run(code: str, *path: Path, **environment: str) -> str:
    """Run code in a new process, the folders first on its path, and return what it prints."""
    given = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"} | environment
    given["PYTHONPATH"] = os.pathsep.join([*map(str, path), str(SOURCES.parent)])
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=given)
    assert out.returncode == 0, out.stderr
    return out.stdout


def test_cones_need_neither_numba_nor_scipy() -> None:
    code = """
import sys, surefoot as sf
from surefoot.contact.cones import ProductCone
cone = sf.FrictionCone(mu=0.6)
forces = [[1.0, 2.0, 3.0], [9.0, 0.0, 1.0]]
for each in (cone, cone.dual()):
    each.contains(forces), each.margin(forces), each.project(forces)
pyramid = cone.polyhedral(facets=8, fit="outer")
pyramid.contains(forces), pyramid.halfspaces, pyramid.rays, pyramid.fit_error, pyramid.margin([0.0, 0.0, 1.0])
sf.Sole(0.2, 0.1, 0.6).closed_form().contains([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
ProductCone([cone, cone]).project([0.0] * 6)
print([name for name in ("numba", "scipy") if name in sys.modules])
"""
    assert run(code).strip() == "[]"


def test_help_and_cone_commands_need_no_numba() -> None:
    code = """
import sys
from surefoot.app.cli.main import main
main(["--help"]), main(["cone", "--no-picture"])
print([name for name in ("numba", "scipy", "matplotlib") if name in sys.modules])
"""
    assert run(code).strip().endswith("[]")


def test_a_command_loads_what_it_needs() -> None:
    """`python -m benchmarks.start_up` prints what is saved by it."""
    code = """
import sys
from surefoot.app.cli.main import main, run
try: run(["--version"])
except SystemExit: print("typer" in sys.modules)
main(["--help"])
print([m for m in ("numpy", "surefoot.app.cli.check") if m in sys.modules])
main(["check", "STANCE", "--no-picture"])
ours = sum(m.startswith("surefoot.") for m in sys.modules)
others = "scipy.sparse numba.np.linalg numba.cpython.unicode surefoot.app.cli.walk"
others += " surefoot.mechanics.statics.com_region"
print(ours, [m for m in others.split() if m in sys.modules])
"""
    stance = Path(__file__).parents[1] / "examples" / "stances" / "go2_three_legs.yaml"
    run(code.replace("STANCE", str(stance)))  # compiles, which loads more
    said = run(code.replace("STANCE", str(stance)))
    lines = [line for line in said.splitlines() if line.startswith(("False", "True", "[", *"0123456789"))]
    assert lines[:2] == ["False", "[]"]
    count, others = lines[2].split(" ", 1)
    assert others == "[]"
    assert (
        int(count) <= 64
    )  # of them seven wings and packages whose `__init__` is a line, and the model of the file


@pytest.mark.parametrize(
    ("name", "most"),
    [("solve", 61), ("can_stand", 46), ("StandingController", 134), ("WalkingController", 200)],
)
def test_a_name_loads_what_it_needs(name: str, most: int) -> None:
    """Modules are counted, not seconds; `docs/install.md` has those. Of a walk's, ten hold settings."""
    code = f"""
import sys, surefoot as sf
sf.{name}
ours = [m for m in sys.modules if m.startswith("surefoot.")]
heavy = {"scipy.stats", "scipy.optimize", "scipy.spatial", "surefoot.records.audit"}
others = sorted(heavy & sys.modules.keys())
print(len(ours), others)
"""
    count, others = run(code).split(" ", 1)
    assert others.strip() == "[]"
    assert int(count) <= most


def test_a_first_tick_of_standing_loads_no_linear_algebra() -> None:
    """On all feet and on three: SciPy's takes a tenth of a second, and comes with `@` in a kernel."""
    code = """
import sys, numpy as np, surefoot as sf
from surefoot.motion.standing.standing_plan import Lift
robot, flat = sf.load_robot("go2"), sf.FlatTerrain()
q, v = sf.place(robot, flat), np.zeros(18)
controller = sf.StandingController(robot, sf.StandingPlan(robot, flat, q, [Lift("FL", 1.0, 2.0)]), flat, q)
before = set(sys.modules)
for time in (0.0, 1.5):
    controller.step(sf.RobotState(q, v, time))
print([name for name in ("scipy.linalg", "numba.np.linalg") if name in sys.modules.keys() - before])
"""
    run(code)  # compiles, which loads more
    assert run(code).strip() == "[]"


@pytest.fixture
def two_files(tmp_path: Path):
    """Return the function that writes a kernel and another one in its own file, and asks for f(10)."""

    def ask(factor: float = 2.0, shift: float = 1.0, comment: str = "", **environment: str) -> list[str]:
        for name, text in TWO_FILES.items():
            text = text.replace("{factor}", str(factor)).replace("{shift}", str(shift))
            (tmp_path / name).write_text(text.replace("{comment}", comment))
        # files that change within a second and keep their size look unchanged to Python's own cache
        return run(ASK, tmp_path, **{"PYTHONDONTWRITEBYTECODE": "1"} | environment).split()

    return ask


@pytest.mark.long
def test_compiled_code_is_kept_until_code_or_constants_change(two_files) -> None:
    value, hits, folder = two_files()
    assert (float(value), hits) == (21.0, "0")
    files = len(list(Path(folder).glob("*.nb?")))
    assert two_files()[:2] == [value, "1"]
    assert two_files(comment="# moves every line\n\n\n")[:2] == [value, "1"]
    # in another file than the kernel that is asked, which Numba alone does not see
    assert [float(x) for x in two_files(factor=3.0)[:2]] == [31.0, 0.0]
    assert [float(x) for x in two_files(factor=3.0, shift=5.0)[:2]] == [35.0, 0.0]
    assert [float(x) for x in two_files(factor=3.0, shift=5.0)[:2]] == [35.0, 1.0]
    assert len(list(Path(folder).glob("*.nb?"))) == files, "old code was left behind"


@pytest.mark.long
def test_read_only_sources_use_the_users_folder(two_files, tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.mkdir()
    blocked = tmp_path / "__pycache__"  # a file: nobody can write beside the sources, not even root
    blocked.write_text("")
    environment = {"HOME": str(home), "XDG_CACHE_HOME": str(home / "cache"), "PYTHONDONTWRITEBYTECODE": "1"}
    value, hits, folder = two_files(**environment)
    assert (float(value), hits) == (21.0, "0")
    assert Path(folder).is_relative_to(home)
    assert two_files(**environment)[1] == "1"


@pytest.mark.long
def test_nowhere_to_write_is_no_error(tmp_path: Path) -> None:
    for name, text in TWO_FILES.items():
        text = text.replace("{factor}", "2.0").replace("{shift}", "1.0").replace("{comment}", "")
        (tmp_path / name).write_text(text)
    for name in ("__pycache__", "home"):  # files: nobody can make a folder of them, not even root
        (tmp_path / name).write_text("")
    home = str(tmp_path / "home")
    code = "import above\nprint(above.above(10.0))"
    out = run(code, tmp_path, HOME=home, XDG_CACHE_HOME=home, PYTHONDONTWRITEBYTECODE="1")
    assert float(out) == 21.0


def test_code_that_was_compiled_beside_read_only_sources_is_used(two_files, tmp_path: Path) -> None:
    two_files()
    keep = tmp_path / "kept"
    beside = tmp_path / "__pycache__"
    code = (
        "import numba.core.caching as c\n"
        "c.InTreeCacheLocator.ensure_cache_path = lambda self: (_ for _ in ()).throw(OSError())\n" + ASK
    )
    environment = {"HOME": str(keep), "XDG_CACHE_HOME": str(keep)}
    value, hits, folder = run(code, tmp_path, **environment).split()
    assert (float(value), hits) == (21.0, "1")
    assert Path(folder) != beside


@pytest.mark.long
def test_of_two_processes_that_miss_a_kernel_one_compiles_it(tmp_path: Path) -> None:
    code = f"""
import time, numpy as np
from pathlib import Path
from surefoot.base import compilation
from surefoot.contact.problem.blocks import checked_mirror
Path("{tmp_path}", str(time.time_ns())).touch()
while len(list(Path("{tmp_path}").glob("1*"))) < 2: time.sleep(0.001)
checked_mirror(np.eye(3), 1e-9)
print(compilation.compiled_so_far())
"""
    with ThreadPoolExecutor() as two:
        compiled = list(two.map(lambda _: int(run(code, NUMBA_CACHE_DIR=str(tmp_path / "kept"))), range(2)))
    assert sorted(compiled) == [0, 1]


@pytest.mark.long
def test_without_compilation_the_results_are_the_same() -> None:
    compiled, plain = (json.loads(run(SMALL, NUMBA_DISABLE_JIT=flag)) for flag in ("0", "1"))
    assert compiled["status"] == plain["status"] == "solved"
    assert compiled["feasible"] is plain["feasible"] is True
    for name in ("solution", "forces", "margin"):
        np.testing.assert_allclose(compiled[name], plain[name], rtol=1e-9, atol=1e-9)


@pytest.mark.long
def test_a_long_compilation_says_so_once(tmp_path: Path) -> None:
    code = """
import logging
records = []
class Keep(logging.Handler):
    def emit(self, record): records.append(record)
log = logging.getLogger("surefoot.compilation")
log.addHandler(Keep()); log.setLevel(logging.DEBUG); log.propagate = False
from surefoot.base import compilation
from surefoot.base.compilation import progress
progress.LONG = 0.0
import numpy as np
from surefoot.contact.cones.nearest import nearest_in_cone
nearest_in_cone(np.eye(3), np.ones((1, 3)))
nearest_in_cone(np.eye(3), np.ones((1, 3)))
shares = [r.share for r in records]
print([r.levelname for r in records if r.levelno > logging.DEBUG], compilation.compiled_so_far())
print(shares == sorted(shares), shares[0], shares[-1], records[0].kernel)
print(records[0].getMessage())
"""
    lines = run(code, NUMBA_CACHE_DIR=str(tmp_path)).splitlines()
    assert lines[0] == "['WARNING'] 1"
    assert lines[1] == "True 0.0 1.0 nearest_points"
    assert "surefoot warmup" in lines[2]
