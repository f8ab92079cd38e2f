"""A sheet of the pictures of every kind of answer, below each the sentence that its `str` is."""

from __future__ import annotations

import io
import sys
import textwrap
from pathlib import Path
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.app.viz.drawings import png_of
from surefoot.app.viz.style import new_grid, save

COLUMNS = 4


def answers() -> dict[str, Any]:
    """Return an answer of every kind that a second makes, by name."""
    robot, slope = sf.load_robot("go2"), sf.SlopeTerrain(20.0)
    q = sf.place(robot, slope)
    stance = robot.stance(q, mu=0.6, terrain=slope)
    wall = sf.read_stance(Path(__file__).parent / "stances" / "g1_hand_on_wall.yaml").stance
    rng = np.random.default_rng(0)
    A = rng.normal(size=(18, 12))
    problem = sf.ContactProblem(A @ A.T / 12.0, rng.normal(size=18) - np.tile([0.0, 0.0, 1.0], 6), 0.5)
    controller = sf.StandingController(robot, sf.StandingPlan(robot, slope, q), slope, q, mu=0.6)
    scenario = sf.Scenario(1.0, mu=0.6, start=q, pushes=[sf.Push(0.4, (0.0, 60.0, 0.0), 0.2)])
    log = sf.run(sf.RigidWorld(robot, slope), controller, scenario)
    many = [A @ A.T / 12.0] * 200
    cone = sf.FrictionCone(0.6)
    return {
        "cone": cone, "pyramid": cone.polyhedral(6, "outer"), "sole": sf.Sole(0.22, 0.09, 0.6),
        "robot": robot, "stance": wall, "region": sf.com_region(stance, robot.mass),
        "verdict": sf.can_stand(stance, robot.com(q), robot.mass),
        "proof": sf.can_stand(robot.stance(q, mu=0.3, terrain=slope), robot.com(q), robot.mass),
        "wrench cone": sf.wrench_cone(stance, facets=6, about=robot.com(q)),
        "stance cone": sf.StanceCone(stance, about=robot.com(q)),
        "problem": problem, "solution": sf.solve(problem),
        "batch": sf.solve_batch(many, rng.normal(size=(200, 18)) - np.tile([0.0, 0.0, 1.0], 6), 0.5),
        "gait": sf.named_gait("trot"), "log": log, "report": sf.audit_log(log),
    }  # fmt: skip


def main(path: Path) -> dict[str, Any]:
    """Draw the sheet into a new file, and return what is on it."""
    from matplotlib.image import imread

    found = answers()
    figure, axes = new_grid(len(found), COLUMNS, (3.6, 3.9), (0.2, 0.2))
    for axis, (name, answer) in zip(axes, found.items(), strict=True):
        axis.imshow(imread(io.BytesIO(png_of(answer))))
        axis.set_axis_off()
        lines = textwrap.wrap(str(answer), 62)
        axis.set_title("\n".join([name, *lines[:3]]), fontsize=7, loc="left")
    if path.exists():
        print(f"{path} exists already and is kept")
    else:
        print(f"picture: {save(figure, path)}")
    return found


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "pictures.png"))
