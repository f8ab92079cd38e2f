"""`surefoot warmup`: everything that the commands compile, compiled ahead of their first use."""

from __future__ import annotations

import contextlib
import io
import math
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.app.cli import options
from surefoot.app.cli.compiling import silent
from surefoot.app.cli.console import progress_bar, say, show, table
from surefoot.base.errors import MissingExtra

if TYPE_CHECKING:
    from rich.console import Console

    from surefoot.contact import ContactProblem

STANCES = {
    "level": "com: [0, 0, 0.3]\ncontacts: [{position: [0.2, 0.15, 0]}, {position: [0.2, -0.15, 0]}, "
    "{position: [-0.2, 0.15, 0]}, {position: [-0.2, -0.15, 0.02]}]",
    "tipping": "com: [1, 0, 0.3]\ncontacts: [{position: [0.2, 0.15, 0]}, {position: [-0.2, 0, 0]}]",
    "walls": "mu: 0.9\ncom: [0, 0, 0.5]\ncontacts: [{position: [-0.3, 0, 0.5], normal: [1, 0, 0]}, "
    "{position: [0.3, 0, 0.5], normal: [-1, 0, 0]}]",
}
"""One that stands, one that does not, one that squeezes itself between walls."""
RUN = "--no-video --no-report --out . --duration"
COMMANDS = (
    "cone --no-picture", "check level.yaml --no-picture", "check tipping.yaml --no-picture",
    "check walls.yaml --no-picture", "region level.yaml --no-picture", "solve {problems}",
    "solve {few} --solver admm", "solve {few} --solver nsgs", "solve {few} --solver newton", "solve lcp.dat",
    f"stand go2 {RUN} 0.1", f"stand go2 --world rigid {RUN} 0.1",
    f"walk go2 --terrain stairs:0.05,0.3 {RUN} 0.6", f"walk go2 --scenario true.yaml {RUN} 0.5",
    f"walk go2 --planner contact-implicit {RUN} 0.6", f"walk g1 --velocity 0.3 {RUN} 0.6",
    f"walk go2 --terrain rough:1,0.03 --terrain-knowledge map --actuators real --commands targets {RUN} 0.8",
    "plan jump 0.2 --dt 0.02 --no-video --no-report --out .", "identify", "record", "step", "episodes",
)  # fmt: skip
"""What is run, in a folder of small inputs; of identify, which would fit for a minute, a single rollout. No
commands are `sf.record`, `sf.MujocoStepper`, and audits of many episodes, in a user's own loop."""
LOOP = (
    "<mujoco><option integrator='{integrator}' cone='elliptic'/><worldbody><geom type='plane' size='9 9 1'/>"
    "<body pos='0 0 .1'><freejoint/><geom type='box' size='.1 .1 .1' mass='2'/><body pos='0 0 .2'>"
    "<joint axis='0 1 0' range='-1 1' limited='true'/><geom size='.05' mass='.2'/></body></body></worldbody>"
    "</mujoco>"
)
"""A box on the ground with an arm."""


def warmup(as_json: options.AsJson = False) -> int:
    """Compile everything that the commands need, once per machine, and say where it is kept.

    Every command is run on a small example; what has been compiled before is only loaded.
    """
    from surefoot.base.compilation import cache_folders, compiled_so_far

    terminal = sys.stderr.isatty()
    rows: list[dict[str, Any]] = []
    with silent(), _inputs() as files, progress_bar(terminal, "compiling", len(COMMANDS)) as moved:
        for words in COMMANDS:
            rows.append(_time_command(words.format(**files).split()))
            if moved is not None:
                moved(len(rows))
            elif not as_json:
                print(f"{rows[-1]['name']}: {rows[-1]['seconds']:.1f} s", file=sys.stderr, flush=True)
    kept = [file for folder in cache_folders() for file in Path(folder).glob("*.nb[ci]")]
    facts = {
        "compiled": compiled_so_far(),
        "seconds": sum(row["seconds"] for row in rows),
        "folders": cache_folders(),
        "size": sum(file.stat().st_size for file in kept),
        "tasks": rows,
    }
    show(facts, as_json, _print)
    return 0


def _time_command(words: list[str]) -> dict[str, Any]:
    """Run a command; return what it compiled, how long it took, and which package it lacks."""
    from surefoot.app.cli.commands import tree
    from surefoot.base.compilation import compiled_so_far

    before, start, missing = compiled_so_far(), time.perf_counter(), None
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            if own := OWN.get(" ".join(words)):
                own()
            else:
                tree()(args=words, prog_name="surefoot", standalone_mode=False)
    except MissingExtra as error:
        missing = str(error)
    name = " ".join(word for word in words if not word.endswith(".npz")).partition(" --no")[0]
    seconds = time.perf_counter() - start
    return {"name": name, "compiled": compiled_so_far() - before, "seconds": seconds, "skipped": missing}


@contextlib.contextmanager
def _inputs() -> Iterator[dict[str, str]]:
    """Work in a new folder that holds what the commands name; yield the names of the problems."""
    from surefoot.contact.files.formats import write_problem

    home = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            for name, text in STANCES.items():
                Path(f"{name}.yaml").write_text(f"mass: 16\n{text}\n", encoding="utf-8")
            Path("true.yaml").write_text("estimator: truth\n", encoding="utf-8")
            Path("lcp.dat").write_text("2\n0\n2\n2\n2 2\n2 1\n1 2\n-5 -6\n", encoding="utf-8")
            names = [str(write_problem(one, f"{k}.npz")) for k, one in enumerate(_problems())]
            yield {"problems": " ".join(names), "few": " ".join(names[:2])}
        finally:
            os.chdir(home)


def _problems() -> Iterator[ContactProblem]:
    """Return a problem of every kind that takes another way: law, bounds, pyramids, size."""
    from surefoot.contact import ContactProblem

    random = np.random.default_rng(0)
    for n, facets, high in ((4, None, math.inf), (4, None, 2.0), (3, 6, math.inf), (60, None, math.inf)):
        for law in ("coulomb", "convex"):
            J = random.normal(size=(3 * n, 3 * n + 3))
            G, g = J @ J.T, random.normal(size=3 * n)
            g[2::3] -= 1.0
            yield ContactProblem(G, g, 0.6, normal_max=high, law=law, facets=facets)


def _throw_a_cube() -> None:
    """Simulate a toss, as a fit does thousands of times."""
    from surefoot.base.spatial import GRAVITY
    from surefoot.records.identification.ground_plane import GroundPlane
    from surefoot.records.identification.thrown_body import cube_body
    from surefoot.records.identification.thrown_body_tree import sphere_places
    from surefoot.records.identification.toss_model import ThrownModel, TossScene
    from surefoot.records.identification.tosses import Cube

    start, body = np.zeros((1, 13)), cube_body(Cube())
    start[0, 2], start[0, 6] = 0.06, 1.0
    scene = TossScene(start, np.array([20]), 0.01, GroundPlane(0.0, np.zeros(2)), GRAVITY, body)
    sphere_places(body.tree, ThrownModel().rollout(np.array([0.2, 0.1, 0.0]), scene))


def _record_a_loop() -> None:
    """Record a loop, read the log and judge it."""
    from surefoot.records.audit import audit_log
    from surefoot.worlds.mujoco.mujoco_world import import_mujoco
    from surefoot.worlds.mujoco.recording import record

    mujoco = import_mujoco()
    model = mujoco.MjModel.from_xml_string(LOOP.format(integrator="RK4"))
    data = mujoco.MjData(model)
    with record(model, data) as log:
        mujoco.mj_step(model, data, 20)
    audit_log(log)


def _step_a_loop() -> None:
    """Step by exact contact, with every integrator."""
    from surefoot.worlds.mujoco.mujoco_world import import_mujoco
    from surefoot.worlds.mujoco.stepper.stepper import MujocoStepper

    mujoco = import_mujoco()
    for integrator in ("Euler", "RK4", "implicitfast"):
        model = mujoco.MjModel.from_xml_string(LOOP.format(integrator=integrator))
        data, stepper = mujoco.MjData(model), MujocoStepper(model)
        for _ in range(20):
            stepper.step(data)


def _audit_episodes() -> None:
    """Audit an episode as training does, and two as arrays."""
    from surefoot.records.audit.batch.audit_batch import audit_batch
    from surefoot.worlds.mujoco.episode.episode_audit import EpisodeAudit
    from surefoot.worlds.mujoco.mujoco_world import import_mujoco

    forces, gaps, speeds = (
        np.full((60, 2, 2, 3), [0.0, 0.0, 9.0]),
        np.zeros((60, 2, 2)),
        np.zeros((60, 2, 2, 3)),
    )
    audit_batch({"forces": forces, "gaps": gaps, "velocities": speeds}, dt=0.01, mu=0.6, mass=2.0)
    mujoco = import_mujoco()
    model = mujoco.MjModel.from_xml_string(LOOP.format(integrator="RK4"))
    data = mujoco.MjData(model)
    audit = EpisodeAudit(mujoco, model, data)
    audit.begin()
    mujoco.mj_step(model, data, 20)
    audit.finish()
    audit.close()


OWN = {
    "identify": _throw_a_cube, "record": _record_a_loop, "step": _step_a_loop, "episodes": _audit_episodes,
}  # fmt: skip
"""What is no command of `COMMANDS`."""


def _print(console: Console, facts: dict[str, Any]) -> None:
    rows = [(row["name"], str(row["compiled"]), f"{row['seconds']:.1f}") for row in facts["tasks"]]
    console.print(table(("for", "compiled", "s"), rows, "Kernels"))
    say(console, *dict.fromkeys(row["skipped"] for row in facts["tasks"] if row["skipped"]))
    where = os.path.commonpath(facts["folders"]) if facts["folders"] else "nowhere: Numba is switched off"
    say(
        console,
        f"{facts['compiled']} compiled in {facts['seconds']:.0f} s, the others were there. "
        f"{facts['size'] / 1e6:.0f} MB below: {where}",
    )
