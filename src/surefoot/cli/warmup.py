"""`surefoot warmup`: everything that the commands compile, compiled ahead of their first use."""

from __future__ import annotations

import math
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from surefoot.cli import options
from surefoot.cli.compiling import silent
from surefoot.cli.console import say, show, table
from surefoot.cli.progress import progress_bar
from surefoot.errors import MissingExtra

if TYPE_CHECKING:
    from rich.console import Console

    from surefoot.contact import ContactProblem
    from surefoot.stance import Stance

FEET = ((0.2, 0.15, 0.0), (0.2, -0.15, 0.0), (-0.2, 0.15, 0.0), (-0.2, -0.15, 0.02))
COM, MASS, MU = (0.0, 0.0, 0.3), 16.0, 0.6


def warmup(
    as_json: options.AsJson = False,
) -> int:
    """Compile everything that the commands need, once per machine, and say where it is kept.

    Every command's kernels are called on a small example; what has been compiled before is only loaded.
    """
    from surefoot.compilation import cache_folders, compiled_so_far, tidy

    terminal = sys.stderr.isatty()
    rows: list[dict[str, Any]] = []
    with silent(), progress_bar(terminal and not as_json, "compiling", len(TASKS)) as moved:
        for name, task in TASKS.items():
            rows.append(_timed(name, task))
            if moved is not None:
                moved(len(rows))
            elif not as_json:
                print(f"{name}: {rows[-1]['seconds']:.1f} s", file=sys.stderr, flush=True)
    facts = {
        "compiled": compiled_so_far(),
        "seconds": sum(row["seconds"] for row in rows),
        "deleted": tidy(),
        "folders": cache_folders(),
        "size": sum(f.stat().st_size for f in _files(cache_folders())),
        "tasks": rows,
    }
    show(facts, as_json, _print)
    return 0


def _timed(name: str, task: Callable[[], None]) -> dict[str, Any]:
    """Run a task; return what it compiled, how long it took, and which package it lacks."""
    from surefoot.compilation import compiled_so_far

    before, start, missing = compiled_so_far(), time.perf_counter(), None
    try:
        task()
    except MissingExtra as error:
        missing = str(error)
    seconds = time.perf_counter() - start
    return {"name": name, "compiled": compiled_so_far() - before, "seconds": seconds, "skipped": missing}


def _files(folders: list[str]) -> Iterator[Path]:
    """Return the files of compiled code in folders."""
    for folder in folders:
        yield from Path(folder).glob("*.nb[ci]")


def _print(console: Console, facts: dict[str, Any]) -> None:
    import os

    rows = [(row["name"], str(row["compiled"]), f"{row['seconds']:.1f}") for row in facts["tasks"]]
    console.print(table(("for", "compiled", "s"), rows, "Kernels"))
    say(console, *(f"{row['name']}: {row['skipped']}" for row in facts["tasks"] if row["skipped"]))
    where = os.path.commonpath(facts["folders"]) if facts["folders"] else "nowhere: Numba is switched off"
    say(
        console,
        f"{facts['compiled']} compiled in {facts['seconds']:.0f} s, the others were there. "
        f"{facts['size'] / 1e6:.0f} MB below: {where}",
    )


def _stance() -> Stance:
    from surefoot.stance import PointContact, Stance

    return Stance([PointContact(p, mu=MU) for p in FEET])


def _problems() -> Iterator[ContactProblem]:
    """Return a problem of every kind that takes another way: law, contacts, pyramids, ties, size."""
    import numpy as np

    from surefoot.contact import ContactProblem

    random = np.random.default_rng(0)
    for law in ("coulomb", "convex"):
        for n, facets, high in ((4, None, math.inf), (4, None, 2.0), (3, 6, math.inf), (60, None, math.inf)):
            J = random.normal(size=(3 * n, 3 * n + 3))
            G, g = J @ J.T, random.normal(size=3 * n)
            g[2::3] -= 1.0
            yield ContactProblem(G, g, MU, normal_max=high, law=law, facets=facets)


def _solve() -> None:
    from surefoot.contact import ContactProblem, contact_sets
    from surefoot.contact.diagnosis import redundancy
    from surefoot.solvers.solver import solve

    for problem in _problems():
        found = solve(problem)
        _ = found.residuals, found.velocities
        for solver in ("admm", "nsgs", "newton"):
            if problem.facets is None or solver == "admm":
                solve(problem, solver, max_iterations=20)
        redundancy(problem)
    kinds = contact_sets.SoftFinger(MU, 0.02), contact_sets.Pyramid(MU)
    general = ContactProblem(
        [[1.0 + (i == j) for j in range(7)] for i in range(7)], [-1.0] * 7, contacts=kinds
    )
    for solver in ("auto", "set_admm"):
        solve(general, solver)


def _lcp() -> None:
    import numpy as np

    from surefoot.contact.lcp import LCP
    from surefoot.solvers.lcp import lcp_solver_names, solve_lcp

    for solver in lcp_solver_names():
        try:
            solve_lcp(LCP(np.eye(3) + 0.1, np.array([-1.0, 0.5, -0.2])), solver)
        except MissingExtra:
            continue


def _forces() -> None:
    import numpy as np

    from surefoot.control.force_distribution import ForceDistributor

    stance, wrench = _stance(), [20.0, 0.0, 160.0, 0.0, 1.0, 0.0]
    A = stance.grasp_map(COM)
    ForceDistributor(MU, 5.0, 250.0).solve(A, wrench)
    limited = ForceDistributor(MU, 5.0, 250.0, torque_limit=np.full(6, 20.0))
    limited.solve(A, wrench, jacobian=np.full((12, 6), 0.1), torque_offset=np.zeros(6))


def _statics() -> None:
    from surefoot.equilibrium import regions, statics
    from surefoot.stance import PointContact, Stance

    stance = _stance()
    walls = Stance([PointContact([x, 0.0, 0.5], normal=[-x / abs(x), 0.0, 0.0], mu=0.9) for x in (-0.3, 0.3)])
    for each, com in ((stance, COM), (stance, (1.0, 0.0, 0.3)), (walls, (0.0, 0.0, 0.5))):
        statics.can_stand(each, com, MASS)
        statics.friction_needed(each, com, MASS)
    regions.com_region(stance, MASS)
    regions.support_polygon(stance)
    regions.zmp_region(stance, COM, MASS)


def _cones() -> None:
    from surefoot.cones import FrictionCone, PolyhedralCone

    pyramid = FrictionCone(MU).polyhedral()
    pyramid.project([10.0, 0.0, 1.0])
    PolyhedralCone.from_rays(pyramid.rays, "dd")


def _identify() -> None:
    import numpy as np

    from surefoot.estimation.cube_model import CubeModel
    from surefoot.estimation.ground_plane import GroundPlane
    from surefoot.estimation.toss_model import TossScene
    from surefoot.estimation.tosses import Cube
    from surefoot.spatial import GRAVITY

    start = np.zeros((1, 13))
    start[0, 2], start[0, 6] = 0.06, 1.0
    scene = TossScene(start, np.array([20]), 0.01, GroundPlane(0.0, np.zeros(2)), GRAVITY, Cube())
    CubeModel().rollout(np.array([0.2, 0.1, 0.0]), scene)


def _command(*arguments: str) -> Callable[[], None]:
    """Return the task that runs a command, its words kept back and its files thrown away."""

    def task() -> None:
        import contextlib
        import io

        from surefoot.cli.main import app

        with (
            tempfile.TemporaryDirectory() as folder,
            contextlib.redirect_stdout(io.StringIO()),
        ):
            app(args=[*arguments, "--out", folder], prog_name="surefoot", standalone_mode=False)

    return task


RUN = ("--no-video", "--no-report", "--json", "--duration")
TASKS: dict[str, Callable[[], None]] = {
    "cones": _cones,
    "solve": _solve,
    "solve, complementarity": _lcp,
    "check, region": _statics,
    "contact forces": _forces,
    "identify": _identify,
    "stand": _command("stand", "go2", *RUN, "0.1"),
    "stand, rigid": _command("stand", "go2", "--world", "rigid", *RUN, "0.1"),
    "walk": _command("walk", "go2", "--terrain", "stairs:0.05,0.3", *RUN, "0.6"),
    "walk, true state": _command("walk", "go2", "--estimator", "truth", *RUN, "0.5"),
    "walk, contact-implicit": _command("walk", "go2", "--planner", "contact-implicit", *RUN, "0.6"),
}
"""What is compiled, by the commands that need it."""
