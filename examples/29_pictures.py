"""A sheet of the pictures of every kind of answer, below each the sentence that its `str` is."""

from __future__ import annotations

import io
import sys
import textwrap
from pathlib import Path
from tempfile import mkdtemp
from typing import Any, NamedTuple

import numpy as np

import surefoot as sf
from surefoot.app.viz.drawings import figure_of, png_of
from surefoot.app.viz.style import new_grid
from surefoot.worlds.sweep import sweep_from_dict

COLUMNS = 6
PAGES = {"light": ("#ffffff", "#22303c"), "dark": ("#12181f", "#e3e7ea")}
"""Colours of the page and of what is written on it."""


def answers() -> dict[str, Any]:
    """Return an answer of every kind that seconds make, by name."""
    robot, slope = sf.load_robot("go2"), sf.SlopeTerrain(20.0)
    q = sf.place(robot, slope)
    stance = robot.stance(q, mu=0.6, terrain=slope)
    wall = sf.read_stance(Path(__file__).parent / "stances" / "g1_hand_on_wall.yaml").stance
    rng = np.random.default_rng(0)
    A = rng.normal(size=(18, 12))
    problem = sf.ContactProblem(A @ A.T / 12.0, rng.normal(size=18) - np.tile([0.0, 0.0, 1.0], 6), 0.5)
    many = [A @ A.T / 12.0] * 200
    cone = sf.FrictionCone(0.6)
    weight = [0.0, 0.0, 9.81 * robot.mass, 0.0, 0.0, 0.0]
    grades = [robot.stance(q, mu=mu, terrain=slope) for mu in np.linspace(0.2, 1.2, 60)]
    return {
        "cone": cone, "pyramid": cone.polyhedral(6, "outer"), "sole": sf.Sole(0.22, 0.09, 0.6),
        "robot": robot, "stance": wall, "region": sf.com_region(stance, robot.mass),
        "verdict": sf.can_stand(stance, robot.com(q), robot.mass),
        "proof": sf.can_stand(robot.stance(q, mu=0.3, terrain=slope), robot.com(q), robot.mass),
        "distribution": Carried(stance, sf.distribute(stance, weight, robot.com(q))),
        "verdicts": sf.can_stand_batch(grades, robot.com(q), robot.mass),
        "wrench cone": sf.wrench_cone(stance, facets=6, about=robot.com(q)),
        "stance cone": sf.StanceCone(stance, about=robot.com(q)),
        "problem": problem, "solution": sf.solve(problem),
        "batch": sf.solve_batch(many, rng.normal(size=(200, 18)) - np.tile([0.0, 0.0, 1.0], 6), 0.5),
        "gait": sf.named_gait("trot"), **runs(robot, slope, q), **motions(robot),
    }  # fmt: skip


class Carried(NamedTuple):
    """Forces of a stance: what `surefoot.distribute` returns is an array, which its stance draws."""

    stance: sf.Stance
    forces: Any

    def __str__(self) -> str:
        return f"{self.stance} Forces: stance.plot(forces=sf.distribute(...))."


def runs(robot: sf.Robot, slope: sf.SlopeTerrain, q: Any) -> dict[str, Any]:
    """Return what a run, a plan and a sweep leave."""
    controller = sf.StandingController(robot, sf.StandingPlan(robot, slope, q), slope, q, mu=0.6)
    scenario = sf.Scenario(1.0, mu=0.6, start=q, pushes=[sf.Push(0.4, (0.0, 60.0, 0.0), 0.2)])
    log = sf.run(sf.RigidWorld(robot, slope), controller, scenario)
    row = {name: log[name][500] for name in ("q", "v", "torques")}
    a = (log["v"][501] - log["v"][499]) / (2.0 * log.fact("dt"))
    time = np.arange(0.0, 4.0, 0.0025)
    down = (time[:, None] / 0.5 + np.array([0.0, 0.5])) % 1.0 < 0.6
    sensors = sf.Log({"time": time, "foot_sensors": 80.0 * down + 20.0}, {"feet": ["left", "right"]})
    drops = sweep_from_dict({
        "experiment": "drop", "samples": 40, "seed": 3, "ranges": {"mu": [0.1, 1.0], "slope": [0, 30]},
        "settings": {"body": "box", "size": 0.1, "height": 0.1},
    })  # fmt: skip
    many = np.random.default_rng(2).normal([0.0, 0.0, 40.0], [9.0, 9.0, 6.0], (200, 16, 4, 3))
    return {
        "log": log, "report": sf.audit_log(log), "replay": sf.replay_log(log, "mujoco", robot),
        "estimate": sf.estimate_forces(robot, row["q"], row["v"], a, row["torques"], terrain=slope),
        "contact times": sf.contact_times(sensors), "sequence": sf.sequence_from_log(log),
        "plan": sf.plan(None, "ball"), "batch report": sf.audit_batch({"forces": many}, 0.01, 0.6, mass=16.0),
        "sweep": sf.run_sweep(drops, Path(mkdtemp()) / "drops", backend="serial"),
        "transfer": sf.transfer(
            robot, controller, ("mujoco", "mujoco-exact", "mujoco-exact:mu-90%"), 3, duration=0.4, start=q
        ),
    }  # fmt: skip


def motions(robot: sf.Robot) -> dict[str, Any]:
    """Return a motion that hangs in the air for a while, its certificate and its repair."""
    q = np.tile(sf.place(robot), (90, 1))
    q[30:60, 2] += 0.04 * np.sin(np.linspace(0.0, np.pi, 30))
    q[:, 9] += 0.1 * np.sin(np.linspace(0.0, 6.0, 90))
    motion = sf.Motion(robot, q, 30.0, "hop")
    report = sf.certify_motion(robot, motion)
    return {"motion": motion, "certificate": report, "repair": sf.repair_motion(report)}


def drawn(answer: Any) -> bytes:
    """Return the picture of an answer as PNG."""
    if not isinstance(answer, Carried):
        return png_of(answer)
    out = io.BytesIO()
    figure_of(answer.stance, forces=answer.forces).savefig(out, format="png", dpi=100)
    return out.getvalue()


def main(path: Path, page: str = "light") -> dict[str, Any]:
    """Draw the sheet into a new file, on a light or a dark page, and return what is on it."""
    from matplotlib.image import imread

    paper, ink = PAGES[page]
    found = answers()
    figure, axes = new_grid(len(found), COLUMNS, (3.6, 3.9), (0.2, 0.2))
    figure.set_facecolor(paper)
    for axis, (name, answer) in zip(axes, found.items(), strict=True):
        axis.imshow(imread(io.BytesIO(drawn(answer))))
        axis.set_axis_off()
        lines = textwrap.wrap(str(answer).partition("; in /")[0], 62)
        axis.set_title("\n".join([name, *lines[:3]]), fontsize=7, loc="left", color=ink)
    if path.exists():
        print(f"{path} exists already and is kept")
    else:
        figure.savefig(path, facecolor=paper)
        print(f"picture: {path}")
    return found


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "pictures.png"), *sys.argv[2:3])
