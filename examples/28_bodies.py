"""What of a robot may touch: its shins on the edge of a stair."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
from scipy.spatial import ConvexHull

import surefoot as sf
from surefoot.mechanics.collision import Shape, robot_geometry


def on_a_stair() -> sf.RigidWorld:
    """Go2 pushed forwards until its shins hold it."""
    robot = sf.load_robot("go2")
    world = sf.RigidWorld(robot, sf.StairsTerrain(0.12, 0.3, 1), collision="full")
    q = robot.nominal.copy()
    q[0] = -0.03 - robot.foot_positions()[0, 0]
    world.reset(q)
    for k in range(1500):
        now, v = world.q_v()
        torques = np.clip(80.0 * (robot.nominal[7:] - now[7:]) - 2.0 * v[6:], -23.0, 23.0)
        world.step(torques, np.array([60.0, 0.0, 0.0]) if k > 200 else None)
    return world


def outline(shape: Shape, rotation: np.ndarray, position: np.ndarray) -> np.ndarray:
    """The outline (n, 2) of a shape seen along y [m]."""
    around = np.linspace(0.0, 2.0 * np.pi, 40)
    circle = shape.radius * np.column_stack([np.cos(around), 0.0 * around, np.sin(around)])
    points = ((shape.knots() @ rotation.T + position)[:, None] + circle)[..., [0, 2]].reshape(-1, 2)
    return points[ConvexHull(points).vertices]


def draw_robot(axes: Any, world: sf.RigidWorld) -> None:
    """Draw what may touch, the ground and the forces."""
    data = world.robot.model.createData()
    pinocchio.forwardKinematics(world.robot.model, data, world.q_v()[0])
    for solid in robot_geometry(world.robot).solids:
        pose = data.oMi[solid.joint] * pinocchio.SE3(solid.rotation, solid.position)
        line = outline(solid.shape, pose.rotation, pose.translation)
        axes.fill(*line.T, facecolor="#9db4cc", edgecolor="#43566b", alpha=0.55, linewidth=0.8)
    axes.fill([-0.7, 0.0, 0.0, 0.4, 0.4, -0.7], [0, 0, 0.12, 0.12, -0.05, -0.05], color="#c9c2b4")
    for touch in world.touches():
        start, along = touch.position[[0, 2]], 2e-3 * touch.force[[0, 2]]
        axes.annotate(
            "", start + along, start, arrowprops={"color": "#b5332b", "arrowstyle": "->", "lw": 1.6}
        )
    axes.set(xlim=(-0.6, 0.4), ylim=(-0.05, 0.55), aspect="equal", title="Go2's shins on the edge of a stair")


def main(parent: Path = Path("runs")) -> dict[str, float]:
    """Print what the shins carry and draw it."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    (parent / "bodies").mkdir(parents=True, exist_ok=True)
    path = parent / "bodies" / "bodies.png"
    figure, axes = pyplot.subplots(figsize=(6, 4), layout="constrained")
    world = on_a_stair()
    draw_robot(axes, world)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)
    shins = sum(float(np.linalg.norm(t.force)) for t in world.touches() if "calf" in t.body)
    print(f"shins carry {shins:.0f} N; picture: {path}")
    return {"shins": shins}


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs"))
