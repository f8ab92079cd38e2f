"""A made-up leg on a force sensor, of the recorded one's sizes, whose friction, motors and sensor are known.

Newton's law link by link with points differentiated in time: no arithmetic of the package.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

DT, LINK = 0.002, 0.16
FRICTION, LOADED, LENGTH, ROTOR = (0.04, 0.05), 0.06, 0.002, 0.0008
GAIN, CUBIC, OFFSET = -0.05, -0.02, np.array([0.8, -0.6, 1.4])
TURN = Rotation.from_euler("zx", [0.45, 0.12]).as_matrix()
LATE = 2
RIPPLE, LINE = 0.03, 108.0
NOISE = 0.15
UP = np.array([0.0, 9.81])

URDF = """<robot name="leg"><link name="root"/>
<joint name="rail" type="prismatic"><parent link="root"/><child link="base"/><axis xyz="0 0 1"/>
<limit effort="1" lower="-1" upper="1" velocity="1"/></joint>
<link name="base"><inertial><mass value="0.485"/>
<inertia ixx="8e-4" ixy="0" ixz="0" iyy="2e-3" iyz="0" izz="2e-3"/></inertial></link>
<joint name="HFE" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
<limit effort="9" lower="-9" upper="9" velocity="99"/></joint>
<link name="upper"><inertial><origin xyz="0 0 -0.08"/><mass value="0.15"/>
<inertia ixx="4e-4" ixy="0" ixz="0" iyy="4e-4" iyz="0" izz="3e-5"/></inertial></link>
<joint name="KFE" type="revolute"><parent link="upper"/><child link="shank"/><axis xyz="0 1 0"/>
<origin xyz="0 0 -0.16"/><limit effort="9" lower="-9" upper="9" velocity="99"/></joint>
<link name="shank"><inertial><origin xyz="0 0 -0.09"/><mass value="0.03"/>
<inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="2e-6"/></inertial></link>
<joint name="end" type="fixed"><parent link="shank"/><child link="foot"/><origin xyz="0 0 -0.16"/></joint>
<link name="foot"/></robot>"""


def write_hopper(folder: Path, seconds: float = 24.0, seed: int = 0) -> Path:
    """Write hopper.urdf, hopper.csv (60 % of the time), kept.csv (no sensor) and truth.csv (time, sensor)."""
    rng = np.random.default_rng(seed)
    t = DT * np.arange(round(seconds / DT))
    height = 0.2 + 0.09 * np.sin(2 * np.pi * t / 5.3) + 0.012 * np.sin(2 * np.pi * t / 1.7)
    height += 2e-4 * np.sin(2 * np.pi * 17.0 * t) * (np.sin(t) > 0.0)
    reach = np.hypot(height, 0.004)  # the foot stands 4 mm ahead of the hip
    half = np.arccos(reach / (2 * LINK))
    tilt = -np.arctan2(0.004, height)
    q = np.stack([tilt + half, -2 * half], axis=1)
    v, a = np.gradient(q, DT, axis=0), np.gradient(np.gradient(q, DT, axis=0), DT, axis=0)
    motor = np.stack([0.1 * np.sin(2 * np.pi * t / 5.3) + 0.05 * np.sin(2.0 * t), 0 * t], axis=1)
    motor[:, 1] = np.clip(7.0 * (0.22 - height) / 0.2 + 0.4, -0.5, 2.7)
    z = np.zeros_like(q)
    for k in range(1, len(t)):
        step = DT * v[k]
        z[k] = np.sign(step) + (z[k - 1] - np.sign(step)) * np.exp(-np.abs(step) / LENGTH)
    given = (1 + GAIN) * motor + CUBIC * motor**3 - (FRICTION + LOADED * np.abs(motor)) * z - ROTOR * a
    given[:, 1] += RIPPLE * np.sin(LINE * q[:, 1] + 1.0)
    force = _ground(q, given, height)
    sensor = (np.roll(force, LATE, axis=0) @ TURN.T) + OFFSET + NOISE * rng.normal(size=force.shape)
    q, motor = q + 2e-5 * rng.normal(size=q.shape), motor + 0.01 * rng.normal(size=q.shape)
    (folder / "hopper.urdf").write_text(URDF, "utf-8")
    cut = round(0.6 * len(t))
    names = "time,q_hip,q_knee,tau_hip,tau_knee"
    for name, rows, columns, head in (
        ("hopper", slice(0, cut), (t, q, motor, sensor), f"{names},ati_x,ati_y,ati_z"),
        ("kept", slice(cut, None), (t, q, motor), names),
        ("truth", slice(cut, None), (t, sensor), "time,ati_x,ati_y,ati_z"),
    ):
        table = np.column_stack([c[rows] for c in columns])
        np.savetxt(folder / f"{name}.csv", table, "%.8g", ",", header=head, comments="")
    return folder


def _ground(q: np.ndarray, torque: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Return (T, 3) the ground's force: moments of momentum about knee and hip of what lies below them."""
    upper, lower = q[:, 0], q.sum(axis=1)

    def along(angle: np.ndarray, length: float) -> np.ndarray:
        return -length * np.stack([np.sin(angle), np.cos(angle)], axis=1)

    def rate(x: np.ndarray) -> np.ndarray:
        return np.gradient(np.gradient(x, DT, axis=0), DT, axis=0)

    hip = np.stack([0 * height, height], axis=1)
    knee = hip + along(upper, LINK)
    foot = knee + along(lower, LINK)
    links = ((0.15, hip + along(upper, 0.08), upper, 4e-4), (0.03, knee + along(lower, 0.09), lower, 1e-4))

    def moment(about: np.ndarray, at: np.ndarray, f: np.ndarray) -> np.ndarray:
        arm = at - about
        return arm[:, 1] * f[:, 0] - arm[:, 0] * f[:, 1]  # about +y

    rows = []
    for joint, below in ((hip, links), (knee, links[1:])):
        asked = sum(
            moment(joint, at, m * (rate(at) + UP)) + inertia * rate(angle) for m, at, angle, inertia in below
        )
        rows.append((foot - joint, asked))
    A = np.stack([np.stack([arm[:, 1], -arm[:, 0]], axis=1) for arm, _ in rows], axis=1)
    b = np.stack([asked for _, asked in rows], axis=1) - torque
    planar = np.linalg.solve(A, b[..., None])[..., 0]
    return np.stack([planar[:, 0], 0 * height, planar[:, 1]], axis=1)
