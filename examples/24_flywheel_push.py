"""How much harder a push a robot survives when it may swing its upper body: LIPM against LIPM + flywheel.

Point mass at constant height z over a foot of half length p, a flywheel of inertia J on top:

    x'' = w² (x - cop) - tau / (m z),    J theta'' = tau,    w² = g / z,    |cop| <= p

The capture point c = x + x'/w grows like exp(w t) beyond p. Full torque one way for
T = sqrt(J theta_max / tau), then the other way for as long, brings the flywheel to rest at theta_max and
moves c back by tau / (m g) (1 - exp(-w T))² (Pratt, Carff, Drakunov, Goswami, "Capture point", 2006).
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pinocchio

import surefoot as sf
from surefoot.app.cli.output import new_run_folder
from surefoot.app.viz.style import draw_panels, new_axis, save
from surefoot.base.spatial import GRAVITY

LEAN, STEP = 0.8, 2.5e-4  # farthest lean of the upper body [rad], time step [s]


class Pendulum:  # G1 as a point mass with its upper body as the flywheel, driven by both hips
    def __init__(self, robot: sf.Robot, inertia: float | None = None) -> None:
        model, data = robot.model, robot.model.createData()
        pinocchio.ccrba(model, data, robot.nominal, np.zeros(model.nv))
        waist = data.oYcrb[model.getJointId("waist_yaw_joint")]  # the subtree above the waist
        hips = [k for k, name in enumerate(robot.joint_names) if "hip_pitch" in name]
        self.torque = float(robot.effort_limits[hips].sum())
        self.mass, self.height, self.foot = robot.mass, float(data.com[0][2]), 0.5 * robot.feet[0].size[0]
        self.inertia = float(waist.inertia[1, 1]) if inertia is None else inertia
        self.w, self.half = np.sqrt(GRAVITY / self.height), np.sqrt(self.inertia * LEAN / self.torque)

    def limits(self) -> tuple[float, float]:
        """The largest pushes [N s] by the formula, without and with the flywheel."""
        back = self.torque / (self.mass * GRAVITY) * (1.0 - np.exp(-self.w * self.half)) ** 2
        return self.mass * self.w * self.foot, self.mass * self.w * (self.foot + back)

    def run(self, pushes: np.ndarray, flywheel: bool, seconds: float) -> np.ndarray:
        """Simulate all pushes [N s] at once; return (n, steps, 2): capture point and lean."""
        x, v = np.zeros_like(pushes), pushes / self.mass
        lean, rate, out = np.zeros_like(pushes), np.zeros_like(pushes), []
        back = self.limits()[1] / (self.mass * self.w) - self.foot  # what full torque brings back
        effort = flywheel * self.torque * np.clip((v / self.w - self.foot) / back + 0.02, 0.0, 1.0)
        for k in range(round(seconds / STEP)):
            capture, middle = x + v / self.w, (k + 0.5) * STEP / self.half
            way = 1.0 if middle < 1.0 else -1.0 if middle < 2.0 else 0.0
            cop = np.where(way * effort != 0.0, self.foot, np.clip(1.5 * capture, -self.foot, self.foot))
            a = self.w**2 * (x - cop) - way * effort / (self.mass * self.height)
            alpha = way * effort / self.inertia
            x, v = x + STEP * v + 0.5 * STEP**2 * a, v + STEP * a
            lean, rate = lean + STEP * rate + 0.5 * STEP**2 * alpha, rate + STEP * alpha
            out.append(np.column_stack([capture, lean]))
        return np.array(out).transpose(1, 0, 2)

    def survives(self, flywheel: bool) -> float:
        """The largest push [N s] that ends within the foot, by simulation."""
        pushes = self.limits()[flywheel] * np.linspace(0.95, 1.05, 201)
        return float(pushes[np.abs(self.run(pushes, flywheel, 2.0)[:, -1, 0]) <= self.foot].max())


def main(parent: Path = Path("runs")) -> dict[str, float]:
    robot, folder = sf.load_robot("g1"), new_run_folder(parent, "flywheel")
    body = Pendulum(robot)
    plain, wheel = body.limits()
    facts = {"inertia": body.inertia, "torque": body.torque, "half_time": body.half}
    facts |= {"lipm_formula": plain, "lipm_simulated": body.survives(False), "flywheel_formula": wheel}
    facts |= {"flywheel_simulated": body.survives(True), "gain_percent": 100 * (wheel / plain - 1.0)}
    push = np.array([0.5 * (plain + wheel)])
    runs = [body.run(push, swings, 0.8)[0] for swings in (False, True)]
    edge = np.full(len(runs[0]), body.foot)
    captures = np.clip(np.column_stack([runs[0][:, 0], runs[1][:, 0], edge]), -1.0, 0.3)
    panels = {
        "capture point [m]": (captures, ("without", "with flywheel", "edge of the foot")),
        "lean [deg]": (np.degrees(runs[1][:, 1]), ("upper body",)),
    }
    title = f"G1, a push of {push[0]:.1f} N s: the swing of the upper body brings the capture point back"
    path = draw_panels(folder / "push.png", STEP * np.arange(len(edge)), panels, title)
    sizes = np.geomspace(0.1, 5.0, 6)
    gains = np.array([[p.limits()[1], p.survives(True)] for p in (Pendulum(robot, s) for s in sizes)])
    facts["gain_percent_at_5_kgm2"] = float(100 * (gains[-1, 1] / plain - 1.0))
    labels = {"xlabel": "inertia of the flywheel [kg m²]", "ylabel": "harder push survived [%]"}
    figure, axis = new_axis((6.0, 3.6), xscale="log", **labels)
    axis.plot(sizes, 100 * (gains[:, 0] / plain - 1), label="formula")
    axis.plot(sizes, 100 * (gains[:, 1] / plain - 1), "o", label="simulated")
    axis.xaxis.set_minor_formatter("")
    axis.legend(fontsize=8)
    save(figure, folder / "gain.png")
    print("\n".join(f"{name:24s} {value:.4g}" for name, value in facts.items()), f"\npicture: {path}")
    return facts


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs"))
