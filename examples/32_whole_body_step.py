"""One step of whole-body control, without any simulator: torques, forces, and what gives way.

A Go2 stands and is told to accelerate sideways ever harder. The forces follow until the inner feet reach
their cones and then unload altogether; the possible acceleration falls behind the wanted one.

Run: python examples/32_whole_body_step.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pinocchio

import surefoot as sf
from surefoot.app.viz.style import FOOT_COLOURS, INK, new_figure, save


def main(folder: Path) -> dict[str, float]:
    """Return the largest sideways acceleration found, and the one that friction allows [m/s²]."""
    robot, mu = sf.load_robot("go2"), 0.6
    q, v = sf.place(robot), np.zeros(robot.model.nv)
    controller = sf.WholeBodyController(robot, mu)
    wanted = np.linspace(0.0, 10.0, 41)
    given, use = [], []
    for acceleration in wanted:
        tasks = sf.Tasks(
            stance=np.ones(4, dtype=bool),
            com_acceleration=np.array([0.0, acceleration, 0.0]),
            turn_acceleration=np.zeros(3),
            feet=np.zeros((4, 6)),
            joints=np.zeros(robot.joints),
            forces=np.tile([0.0, 0.0, robot.mass * 9.81 / 4], (4, 1)),
            frames=np.tile(np.eye(3), (4, 1, 1)),
            gaps=np.zeros(4),
        )
        command = controller.step(q, v, tasks)
        data = robot.model.createData()
        pinocchio.centerOfMass(robot.model, data, q, v, command.accelerations)
        given.append(data.acom[0][1])
        f = command.forces
        use.append((np.hypot(f[:, 0], f[:, 1]) / np.maximum(mu * f[:, 2], 1e-9)).max())
    print(f"wanted up to {wanted[-1]:.1f} m/s², got up to {max(given):.2f}; mu g = {mu * 9.81:.2f}")

    out = folder / "32_whole_body_step"
    out.mkdir(parents=True, exist_ok=True)
    if not (out / "acceleration.png").exists():
        figure, axes = new_figure(2, 1, size=(7.0, 4.6), sharex=True)
        axes[0, 0].plot(wanted, wanted, color=INK, ls="--", label="wanted")
        axes[0, 0].plot(wanted, given, color=FOOT_COLOURS[0], label="possible")
        axes[0, 0].set_ylabel("sideways [m/s²]")
        axes[0, 0].legend()
        axes[1, 0].plot(wanted, use, color=FOOT_COLOURS[1])
        axes[1, 0].set(xlabel="wanted acceleration [m/s²]", ylabel="highest use of a cone", ylim=(0.0, 1.05))
        print("picture:", save(figure, out / "acceleration.png"))
    return {"largest": float(max(given)), "friction": mu * 9.81, "use": float(max(use))}


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs"))
