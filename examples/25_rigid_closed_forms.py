"""The rigid world against closed forms: block on a slope, bouncing ball, tipping box, error over dt."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import surefoot as sf
from surefoot.app.cli.output import new_run_folder
from surefoot.app.viz.style import new_axis, save
from surefoot.base.spatial import GRAVITY, quaternion_from_rotation
from surefoot.worlds.rigid.bodies import ball, box
from surefoot.worlds.rigid.rigid_world import RigidWorld

NO_MOTORS = np.zeros(0)


def run(body: sf.Robot, q: np.ndarray, v: np.ndarray, seconds: float, **world: object) -> list[np.ndarray]:
    """Return q and v after every step: (nq + nv,) each."""
    simulated = RigidWorld(body, **world)  # type: ignore[arg-type]
    simulated.reset(q, v)
    out = []
    for _ in range(round(seconds / simulated.dt)):
        simulated.step(NO_MOTORS)
        out.append(np.concatenate(simulated.q_v()))
    return out


def on_slope(body: sf.Robot, degrees: float) -> np.ndarray:
    q, rotation = body.nominal.copy(), sf.SlopeTerrain(degrees).frame([0.0, 0.0])
    q[:3], q[3:7] = rotation @ [0.0, 0.0, q[2]], quaternion_from_rotation(rotation)
    return q


def slope_acceleration(mu: float, degrees: float) -> tuple[float, float]:
    """Downhill acceleration of a block, by formula and as simulated [m/s²]."""
    body, theta = box(2.0, (0.3, 0.3, 0.1)), np.radians(degrees)
    end = run(body, on_slope(body, degrees), np.zeros(6), 0.2, terrain=sf.SlopeTerrain(degrees), mu=mu)[-1]
    return max(0.0, np.sin(theta) - mu * np.cos(theta)) * GRAVITY, -end[7] / 0.2


def tip_speed(ratio: float, degrees: float) -> float:
    """How fast a box of width / height = ratio turns after 0.3 s on a rough slope [rad/s]."""
    body = box(1.0, (0.2 * ratio, 0.2, 0.2))
    end = run(body, on_slope(body, degrees), np.zeros(6), 0.3, terrain=sf.SlopeTerrain(degrees), mu=2.0)[-1]
    return abs(float(end[11]))


def bounces(restitution: float) -> np.ndarray:
    body, q = ball(0.5, 0.1), np.array([0, 0, 0.4, 0, 0, 0, 1.0])
    return np.array([s[2] - 0.1 for s in run(body, q, np.zeros(6), 1.2, restitution=restitution)])


def errors(dt: float) -> tuple[float, float]:
    """Error of a sliding distance and of a ball that slides into rolling, at a fixed time [m]."""
    block, sphere, push = box(2.0, (0.4, 0.4, 0.1)), ball(1.0, 0.1), np.array([3.0, 0, 0, 0, 0, 0])
    slid = run(block, block.nominal, push, 0.4, mu=0.4, dt=dt)[-1][0]
    rolled = run(sphere, sphere.nominal, push, 0.64, mu=0.4, dt=dt)[-1][0]
    t = 2 * 3.0 / (7 * 0.4 * GRAVITY)
    return (
        abs(slid - (3.0 * 0.4 - 0.2 * GRAVITY * 0.4**2)),
        abs(rolled - (3.0 * t - 0.2 * GRAVITY * t * t + 3.0 * 5 / 7 * (0.64 - t))),
    )


def main(parent: Path = Path("runs")) -> dict[str, float]:
    folder, slopes = new_run_folder(parent, "rigid"), np.arange(5.0, 46.0, 2.5)
    found = {mu: np.array([slope_acceleration(mu, s) for s in slopes]).T for mu in (0.2, 0.6)}
    limits = [(r, np.degrees(np.arctan(r))) for r in (0.3, 0.6, 0.9)]
    tips = np.array([[tip_speed(r, limit - 0.2), tip_speed(r, limit + 0.2)] for r, limit in limits])
    heights = np.column_stack([bounces(e) for e in (0.0, 0.5, 0.8)])
    steps = 5e-4 * 2.0 ** np.arange(4, -1, -1)
    wrong = np.array([errors(dt) for dt in steps])
    wrong = np.maximum(wrong, 1e-16)  # for the logarithm
    ideal = wrong[0, 1] * (steps / steps[0]) ** 2
    scales = {"xscale": "log", "yscale": "log"}
    figure, axis = new_axis((6.0, 3.6), xlabel="dt [s]", ylabel="error at a fixed time [m]", **scales)
    axis.plot(steps, ideal, label="second order")
    axis.plot(steps, wrong, "o", label=("sliding block", "ball, sliding to rolling"))
    axis.xaxis.set_minor_formatter("")
    axis.legend(fontsize=8)
    path = save(figure, folder / "order.png")
    facts = {"slope_error": max(float(np.abs(f - s).max()) for f, s in found.values())}
    facts |= {"tips_below": float(tips[:, 0].max()), "tips_above": float(tips[:, 1].min())}
    facts |= {"error_block": float(wrong[:, 0].max()), "error_ball": float(wrong[:, 1].max())}
    facts |= {"second_bounce": float(heights[350:650, 2].max() / 0.3)}
    print("\n".join(f"{name:14s} {value:.4g}" for name, value in facts.items()), f"\npicture: {path}")
    return facts


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs"))
