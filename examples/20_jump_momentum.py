"""A Go2 jumps and waves its legs: in the air the angular momentum stays what it was at take-off."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pinocchio

import surefoot as sf
from surefoot.app.cli.output import new_run_folder
from surefoot.app.viz.style import draw_panels
from surefoot.mechanics.dynamics.airborne_motion import FlightRecord, fly
from surefoot.mechanics.robot.centroidal import momentum

TAKE_OFF = np.array([0.4, 0.1, 2.6, 0.6, -1.5, 0.8])  # base velocity at take-off [m/s, rad/s]
STIFFNESS, DAMPING, LIMIT = 20.0, 0.5, 20.0  # [N m/rad, N m s/rad, N m]


def jump(robot: sf.Robot) -> FlightRecord:
    """Fly from take-off until the centre of mass is back at its height, legs pulled in and kicking."""
    tucked = robot.nominal[7:] + np.tile([0.0, 0.5, -0.8], 4)
    kick = 0.5 * np.tile([0.6, 1.0, 0.4], 4) * np.repeat([1.0, -1.0, -1.0, 1.0], 3)

    def torque(t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        wanted = tucked + kick * np.sin(18.0 * t)
        return LIMIT * np.tanh((STIFFNESS * (wanted - q[7:]) - DAMPING * v[6:]) / LIMIT)

    v = np.concatenate([TAKE_OFF, np.zeros(robot.joints)])
    seconds = 2.0 * momentum(robot, robot.nominal, v).com_velocity[2] / 9.81
    return fly(robot, robot.nominal, v, seconds, torque=torque, dt=1.25e-4)


def trunk_share(robot: sf.Robot, flight: FlightRecord) -> np.ndarray:
    """Angular momentum of the trunk alone about the whole robot's centre of mass: (n, 3)."""
    out, data, trunk = [], robot.model.createData(), robot.model.inertias[1]
    for q, v, com in zip(flight.q, flight.v, flight.com, strict=True):
        pinocchio.forwardKinematics(robot.model, data, q, v)
        pose, twist = data.oMi[1], data.v[1]
        h = pose.act(trunk * twist)  # [linear; angular] about the world's origin
        out.append(h.angular - np.cross(com, h.linear))
    return np.array(out)


def main(parent: Path = Path("runs")) -> dict[str, float]:
    robot = sf.load_robot("go2")
    flight = jump(robot)
    angular, linear = flight.momentum[:, 3:], flight.momentum[:, :3]
    expected = linear[0] - np.outer(flight.time, [0.0, 0.0, 9.81 * robot.mass])
    trunk = trunk_share(robot, flight)
    facts = {
        "flight_time": float(flight.time[-1]),
        "angular_drift": float(np.abs(angular - angular[0]).max()),
        "angular_size": float(np.linalg.norm(angular[0])),
        "linear_drift": float(np.abs(linear - expected).max()),
        "trunk_swing": float(np.ptp(trunk, axis=0).max()),
    }
    panels = {
        "whole robot\n[kg m²/s]": (angular, ("x", "y", "z")),
        "trunk alone\n[kg m²/s]": (trunk, ("x", "y", "z")),
        "legs\n[kg m²/s]": (angular - trunk, ("x", "y", "z")),
        "drift of the whole\n[1e-12 kg m²/s]": (1e12 * (angular - angular[0]), ("x", "y", "z")),
    }
    title = "Angular momentum in flight: legs and trunk trade it, the sum stays"
    path = draw_panels(new_run_folder(parent, "jump") / "momentum.png", flight.time, panels, title)
    for name, value in facts.items():
        print(f"{name:16s} {value:.3e}")
    print(f"picture: {path}")
    return facts


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs"))
