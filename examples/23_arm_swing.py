"""G1 swings its legs as in walking; its arms, swung against them, take the yaw momentum away."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import surefoot as sf
from surefoot.app.cli.output import new_run_folder
from surefoot.app.viz.style import draw_panels
from surefoot.mechanics.dynamics.airborne_motion import follow_shape
from surefoot.mechanics.robot.centroidal import momentum, momentum_matrix

PERIOD = 1.0  # one stride [s]
HIP, KNEE, SHOULDER_LIMIT = 0.35, 0.45, 0.8  # amplitudes [rad]


def joint(robot: sf.Robot, name: str) -> int:
    return robot.joint_names.index(f"{name}_joint")


def swing(robot: sf.Robot, shoulder: float, t: float) -> tuple[np.ndarray, np.ndarray]:
    """Joint positions and velocities: legs against each other, each arm against the leg of its side."""
    q, v = robot.nominal[7:].copy(), np.zeros(robot.joints)
    w = 2.0 * np.pi / PERIOD
    for side, sign in (("left", 1.0), ("right", -1.0)):
        hip, knee = joint(robot, f"{side}_hip_pitch"), joint(robot, f"{side}_knee")
        arm, phase = joint(robot, f"{side}_shoulder_pitch"), w * t + (0.0 if sign > 0 else np.pi)
        q[hip] -= HIP * np.sin(phase)
        v[hip] = -HIP * w * np.cos(phase)
        q[knee] += 0.5 * KNEE * (1.0 + np.sin(phase + 0.8))
        v[knee] = 0.5 * KNEE * w * np.cos(phase + 0.8)
        q[arm] += shoulder * np.sin(phase)
        v[arm] = shoulder * w * np.cos(phase)
    return q, v


def angular(robot: sf.Robot, shoulder: float, times: np.ndarray) -> np.ndarray:
    """Angular momentum about the centre of mass while the pelvis keeps its heading: (n, 3)."""
    out = []
    for t in times:
        q, v = robot.nominal.copy(), np.zeros(robot.model.nv)
        q[7:], v[6:] = swing(robot, shoulder, t)
        out.append(momentum(robot, q, v).angular)
    return np.array(out)


def best_swing(robot: sf.Robot, times: np.ndarray) -> float:
    """The shoulder amplitude [rad] of least yaw momentum over a stride."""
    amplitudes = np.linspace(0.0, SHOULDER_LIMIT, 33)
    power = [np.mean(angular(robot, a, times)[:, 2] ** 2) for a in amplitudes]
    fit = np.polynomial.Polynomial.fit(amplitudes, power, 4)
    fine = np.linspace(0.0, SHOULDER_LIMIT, 2001)
    return float(fine[np.argmin(fit(fine))])


def pelvis_yaw(robot: sf.Robot, shoulder: float) -> np.ndarray:
    """How far the pelvis would turn over a stride on frictionless ground [rad]: no yaw momentum at all."""
    start = robot.nominal.copy()
    flight = follow_shape(robot, start, lambda t: swing(robot, shoulder, t), PERIOD, dt=5e-3)
    x, y, z, w = flight.q[:, 3:7].T
    return np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def main(parent: Path = Path("runs")) -> dict[str, float]:
    robot = sf.load_robot("g1")
    times = np.linspace(0.0, PERIOD, 81)
    amplitude = best_swing(robot, times[:-1])
    still, swung = angular(robot, 0.0, times), angular(robot, amplitude, times)
    step = times[1] - times[0]
    torque = [np.abs(np.gradient(h[:, 2], step)[2:-2]).max() for h in (still, swung)]
    turn = [float(np.degrees(np.ptp(pelvis_yaw(robot, a)))) for a in (0.0, amplitude)]
    arms = momentum_matrix(robot, robot.nominal)[5, 6 + joint(robot, "left_shoulder_pitch")]
    facts = {
        "shoulder_amplitude": amplitude,
        "yaw_momentum_still": float(np.abs(still[:, 2]).max()),
        "yaw_momentum_swung": float(np.abs(swung[:, 2]).max()),
        "cancelled": 1.0 - float(np.std(swung[:, 2]) / np.std(still[:, 2])),
        "yaw_torque_still": float(torque[0]),
        "yaw_torque_swung": float(torque[1]),
        "pelvis_turn_still_deg": turn[0],
        "pelvis_turn_swung_deg": turn[1],
        "momentum_per_shoulder_speed": float(arms),
    }
    yaw = np.column_stack([still[:, 2], swung[:, 2], swung[:, 2] - still[:, 2]])
    panels = {"yaw momentum\n[kg m²/s]": (yaw, ("arms still", "arms swung", "what arms add"))}
    share, degrees = 100 * facts["cancelled"], np.degrees(amplitude)
    title = f"G1: arms swung by {degrees:.0f}° cancel {share:.0f} % of the legs' yaw momentum"
    path = draw_panels(new_run_folder(parent, "arm-swing") / "yaw.png", times, panels, title)
    print("\n".join(f"{name:28s} {value:.4g}" for name, value in facts.items()), f"\npicture: {path}")
    return facts


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs"))
