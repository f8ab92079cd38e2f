"""Two worlds, one robot: where the rigid world and MuJoCo agree, and what MuJoCo's soft contacts change."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.app.cli.output import new_run_folder
from surefoot.app.viz.style import draw_panels
from surefoot.base.spatial import GRAVITY, quaternion_from_rotation
from surefoot.motion.control.controller import RobotState
from surefoot.motion.standing.standing_controller import StandingController
from surefoot.motion.standing.standing_plan import StandingPlan
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.rigid.bodies import box
from surefoot.worlds.rigid.rigid_world import RigidWorld

BLOCK = box(2.0, (0.3, 0.3, 0.1), rounding=0.01)
WORLDS: dict[str, Any] = {"rigid": RigidWorld, "mujoco": MujocoWorld}


def standing_forces(world_type: Any, degrees: float) -> np.ndarray:
    """A Go2's contact forces, averaged over the last 0.3 s of 2 s of standing on a slope: (4, 3) [N]."""
    ground, robot = sf.SlopeTerrain(degrees), sf.load_robot("go2")
    q = sf.place(robot, ground)
    controller = StandingController(robot, StandingPlan(robot, ground, q), ground, q)
    world, forces = world_type(robot, ground), []
    world.reset(q)
    for k in range(2000):
        world.step(controller.step(RobotState(*world.q_v(), k * world.dt)).torques)
        forces.append(world.contacts().forces)
    return np.mean(forces[-300:], axis=0)


def slide(world: Any, mu: float, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """A block pushed onto level ground: its path (x, height) and the normal force on it, step by step."""
    world.reset(BLOCK.nominal, np.array([speed, 0, 0, 0, 0, 0]))
    path, normal = [], []
    for _ in range(round((speed / (mu * GRAVITY) + 0.1) / world.dt)):
        world.step(np.zeros(0))
        path.append(world.q_v()[0][[0, 2]] - [0.0, BLOCK.nominal[2]])
        normal.append(world.contacts().forces[:, 2].sum())
    return np.array(path), np.array(normal)


def creep(world_type: Any, degrees: float = 20.0) -> float:
    """Speed of a block that should stick on a slope [m/s]."""
    ground = sf.SlopeTerrain(degrees)
    world, q, rotation = world_type(BLOCK, ground, mu=0.5), BLOCK.nominal.copy(), ground.frame([0.0, 0.0])
    q[:3], q[3:7] = rotation @ [0.0, 0.0, q[2]], quaternion_from_rotation(rotation)
    world.reset(q)
    places = []
    for _ in range(1000):
        world.step(np.zeros(0))
        places.append(world.q_v()[0][:3])
    return float(np.linalg.norm(places[-1] - places[499]) / 0.5)


def main(parent: Path = Path("runs")) -> dict[str, float]:
    facts, heights, forces = {}, [], []
    for degrees in (0.0, 10.0):
        hard, soft = (standing_forces(w, degrees) for w in WORLDS.values())
        apart = np.linalg.norm(hard - soft, axis=1) / np.linalg.norm(hard, axis=1)
        facts[f"standing_{degrees:g}deg_percent"] = 100 * float(apart.max())
    facts["closed_form_distance"] = 2.0**2 / (2 * 0.5 * GRAVITY)
    blocks = {name: make(BLOCK, mu=0.5) for name, make in WORLDS.items()}
    blocks["convex"] = RigidWorld(BLOCK, mu=0.5, law="convex")
    for name, world in blocks.items():
        path, normal = slide(world, 0.5, 2.0)
        heights.append(1e3 * path[:, 1])
        forces.append(normal)
        facts |= {
            f"{name}_distance": float(path[-1, 0]),
            f"{name}_highest_mm": float(heights[-1].max()),
            f"{name}_largest_force": float(normal.max()),
            f"{name}_mean_force": float(normal[1:].mean()),
        }
    facts |= {f"{name}_creep": creep(make) for name, make in WORLDS.items()}
    names = ("rigid, Coulomb", "MuJoCo", "rigid, convex law")
    panels = {
        "height of the block\n[mm]": (np.column_stack(heights), names),
        "normal force [N]\n(clipped at 100)": (np.minimum(np.column_stack(forces), 100.0), names),
    }
    title = "A block slides at 2 m/s: convex friction laws throw it up, Coulomb's does not"
    time = 1e-3 * np.arange(1, len(heights[0]) + 1)
    path_of_picture = draw_panels(new_run_folder(parent, "worlds") / "slide.png", time, panels, title)
    print(
        "\n".join(f"{name:24s} {value:.6g}" for name, value in facts.items()), f"\npicture: {path_of_picture}"
    )
    return facts


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs"))
