"""How much angular momentum must a Go2 take off with to land a backflip, and what tucking the legs saves."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

import surefoot as sf
from surefoot.app.cli.output import new_run_folder
from surefoot.app.viz.style import draw_panels
from surefoot.mechanics.dynamics.airborne_motion import FlightRecord, Shape, fly, follow_shape
from surefoot.mechanics.robot.centroidal import centroidal_inertia

LIFT_SPEED = 3.0  # of the centre of mass at take-off [m/s]
FLIGHT_TIME = 2.0 * LIFT_SPEED / 9.81
TUCK = np.tile([0.0, 0.55, -1.2], 4)  # on top of the nominal pose: thighs forward, calves in


def smooth(s: float) -> tuple[float, float, float]:
    """Minimum-jerk step from 0 to 1 and its two derivatives."""
    s = min(max(s, 0.0), 1.0)
    return s**3 * (10 - 15 * s + 6 * s * s), 30 * s * s * (1 - s) ** 2, 60 * s * (1 - s) * (1 - 2 * s)


def tuck(robot: sf.Robot, amount: float) -> tuple[Shape, Shape]:
    """Legs in during the first quarter of the flight, out during the last: shape and accelerations."""
    quarter, size = 0.25 * FLIGHT_TIME, amount * TUCK

    def parts(t: float) -> tuple[float, float, float]:
        a, b = smooth(t / quarter), smooth((t - 3 * quarter) / quarter)
        return a[0] - b[0], (a[1] - b[1]) / quarter, (a[2] - b[2]) / quarter**2

    return (
        lambda t: (robot.nominal[7:] + parts(t)[0] * size, parts(t)[1] * size),
        lambda t, _q, _v: parts(t)[2] * size,
    )


def pitch(flight: FlightRecord) -> np.ndarray:
    """The base's pitch over the flight, unwound: (n,) [rad]."""
    return np.unwrap(2.0 * np.arctan2(flight.q[:, 4], flight.q[:, 6]))


def flip(robot: sf.Robot, amount: float, spin: float, dt: float = 4e-3) -> FlightRecord:
    carried = np.array([0.0, 0.0, robot.mass * LIFT_SPEED, 0.0, -spin, 0.0])
    return follow_shape(
        robot, robot.nominal, tuck(robot, amount)[0], FLIGHT_TIME, carried=carried, gravity=True, dt=dt
    )


def spin_needed(robot: sf.Robot, amount: float) -> float:
    """The least pitch momentum [kg m²/s] that turns the base by 360° within the flight."""
    stiff = centroidal_inertia(robot, robot.nominal)[4, 4] * 2.0 * np.pi / FLIGHT_TIME
    return brentq(
        lambda k: -pitch(flip(robot, amount, k))[-1] - 2.0 * np.pi, 0.3 * stiff, 1.5 * stiff, rtol=1e-10
    )


def main(parent: Path = Path("runs")) -> dict[str, float]:
    robot = sf.load_robot("go2")
    stretched, tucked = spin_needed(robot, 0.0), spin_needed(robot, 1.0)
    plan = flip(robot, 1.0, tucked, dt=1e-3)
    real = fly(robot, plan.q[0], plan.v[0], FLIGHT_TIME, joint_acceleration=tuck(robot, 1.0)[1])
    inertia = [centroidal_inertia(robot, q)[4, 4] for q in real.q]
    facts = {
        "flight_time": FLIGHT_TIME,
        "momentum_stiff": stretched,
        "momentum_tucked": tucked,
        "by_hand_stiff": inertia[0] * 2.0 * np.pi / FLIGHT_TIME,
        "pitch_landed_deg": float(np.degrees(pitch(real)[-1])),
        "momentum_drift": float(np.abs(real.momentum[:, 3:] - real.momentum[0, 3:]).max()),
    }
    panels = {
        "pitch [deg]": (np.degrees(pitch(real)), ("base",)),
        "momentum about y\n[kg m²/s]": (real.momentum[:, 4], ("whole robot",)),
        "inertia about y\n[kg m²]": (np.array(inertia), ("legs tucked",)),
        "height [m]": (real.com[:, 2], ("centre of mass",)),
    }
    title = f"Backflip of {FLIGHT_TIME:.2f} s: {tucked:.2f} kg m²/s with tucked legs, {stretched:.2f} without"
    path = draw_panels(new_run_folder(parent, "backflip") / "backflip.png", real.time, panels, title)
    for name, value in facts.items():
        print(f"{name:18s} {value:.6g}")
    print(f"picture: {path}")
    return facts


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs"))
