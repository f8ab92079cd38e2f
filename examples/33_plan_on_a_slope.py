"""A trotting body on a slope is kicked sideways: the plan of the next 0.3 s, and its forces in their cones.

Run: python examples/33_plan_on_a_slope.py [FOLDER]
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

from surefoot.app.viz.style import FOOT_COLOURS, MUTED, new_figure, save
from surefoot.base.spatial import rotation_from_normal
from surefoot.motion.control.mpc import BodyReference, BodyState, ConvexMpc

MU, SLOPE, NAMES = 0.5, math.radians(15.0), ("FL", "FR", "RL", "RR")


def main(folder: Path, kick: float = 0.4) -> dict[str, float]:
    """Return the speed left after the plan, the largest use of a cone, and the bound on the forces' error."""
    normal = np.array([-math.sin(SLOPE), 0.0, math.cos(SLOPE)])
    ground = rotation_from_normal(normal)
    mpc = ConvexMpc(15.0, np.diag([0.1, 0.25, 0.3]), mu=MU, normal_min=2.0, normal_max=300.0)
    reference = BodyReference.cruise(0.3 * normal, yaw=0.0, normal=normal)
    state = BodyState(reference.rotation[0], reference.position[0], kick * ground[:, 1], np.zeros(3))
    feet = (
        np.array([[0.19, 0.14, 0.0], [0.19, -0.14, 0.0], [-0.19, 0.14, 0.0], [-0.19, -0.14, 0.0]]) @ ground.T
    )
    contacts = np.array([[1, 0, 0, 1]] * 5 + [[0, 1, 1, 0]] * 5, dtype=bool)
    plan = mpc.solve(state, reference, feet, contacts, np.array([ground] * 4))

    print(
        f"{plan.status.value} after {plan.iterations} steps, forces within {plan.error:.0e} N of the optimum"
    )
    sideways = np.linalg.norm(plan.forces[..., :2], axis=-1)
    use = np.where(contacts, sideways / (MU * np.maximum(plan.forces[..., 2], 1e-9)), 0.0)
    for k, (forces, share) in enumerate(zip(plan.forces, use, strict=True)):
        words = (
            f"{NAMES[i]} {forces[i, 2]:5.1f} N at {100 * share[i]:3.0f} %"
            for i in np.flatnonzero(contacts[k])
        )
        print(f"{1000 * k * mpc.dt:4.0f} ms: " + ", ".join(words))

    figure, axes = new_figure(1, 2, size=(9.0, 4.0))
    turn = np.linspace(0.0, 2.0 * math.pi, 100)
    axes[0, 0].plot(np.cos(turn), np.sin(turn), color=MUTED)
    for i, name in enumerate(NAMES):
        on = contacts[:, i]
        push = plan.forces[on, i, :2] / (MU * plan.forces[on, i, 2:])
        axes[0, 0].plot(*push.T, "o-", color=FOOT_COLOURS[i], label=name, markersize=3.5)
    axes[0, 0].set(
        aspect="equal", xlabel="uphill / (mu f_n)", ylabel="left / (mu f_n)", title="Forces in their cones"
    )
    axes[0, 0].legend(loc="upper center", bbox_to_anchor=(0.5, 0.95))
    speed = plan.linear_velocity @ ground
    for j, label in enumerate(("uphill", "left", "off the ground")):
        axes[0, 1].plot(1000 * mpc.dt * np.arange(11), speed[:, j], color=FOOT_COLOURS[j], label=label)
    axes[0, 1].set(xlabel="time [ms]", ylabel="velocity [m/s]", title="The second pair of feet can stop it")
    axes[0, 1].legend()
    out = folder / "33_plan_on_a_slope"
    out.mkdir(parents=True, exist_ok=True)
    if not (out / "plan.png").exists():
        print("picture:", save(figure, out / "plan.png"))
    return {"left": float(np.linalg.norm(speed[-1])), "use": float(use.max()), "error": plan.error}


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs"))
