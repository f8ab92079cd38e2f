"""`pd quadruped`: four legs of three hinges, `<motor>` actuators, PD to joint targets; it stands or trots.

Standing holds the feet under the hips and levels the trunk by an integral of its measured tilt. Trotting
moves the feet of each diagonal pair on sinusoids, corrected by the trunk's measured velocity. Names are by
compass: nose to the north, `nw` is front left.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from benchmarks.foreign.ground import Ground

LEGS = ("nw", "ne", "sw", "se")
LINK, HIP, WIDE = 0.18, (0.17, 0.08), 0.05
"""Length of thigh and shank, place of the hips in the trunk, way from hip to thigh [m]."""
HEIGHT, TOE = 0.29, 0.022
"""Height of the hips over the toes' centres, and radius of a toe [m]."""
FALLEN, CROOKED = 0.9, 0.22
"""Tilt of a trunk that has fallen, and of one that stands crooked [rad]."""


@dataclass(frozen=True)
class QuadrupedSettings:
    """Settings of a run: model, controller and task.

    Attributes
    ----------
    trot, speed
        Whether it trots instead of standing, and how fast [m/s].
    period, lift
        Of the trot [s], and how high feet are lifted [m].
    kp, kd, limit
        Gains [N m/rad, N m s/rad] and the motors' limit [N m].
    level
        Gain of the levelling [1/s].
    shift
        Leg to the offset of its touchdowns (x, y) [m], from the first swing after `shift_from` on [s].
    late
        Leg to the share of a period by which its touchdowns are late; a swing begins at `shift_from`.
    inward
        Offset of the roll joints towards the middle by leg [rad], from `shift_from` on.
    trunk_mass, extra
        Of the trunk [kg]; more bodies of the world, as MJCF.
    """

    duration: float = 3.0
    timestep: float = 0.002
    delay: float = 0.0
    ground: Ground = field(default_factory=Ground)
    trot: bool = False
    speed: float = 0.3
    period: float = 0.4
    lift: float = 0.07
    kp: float = 120.0
    kd: float = 2.0
    limit: float = 20.0
    level: float = 0.8
    shift: dict[str, tuple[float, float]] = field(default_factory=dict)
    late: dict[str, float] = field(default_factory=dict)
    inward: dict[str, float] = field(default_factory=dict)
    shift_from: float = 0.0
    trunk_mass: float = 6.5
    extra: str = ""


def mjcf(settings: QuadrupedSettings) -> str:
    """Return the model."""
    legs = "".join(_leg(name) for name in LEGS)
    motors = "".join(
        f"<motor name='{kind}_{leg}' joint='{leg}_{joint}' ctrllimited='false' "
        f"forcerange='-{settings.limit} {settings.limit}'/>"
        for leg in LEGS
        for kind, joint in (("spread", "roll"), ("swing", "swing"), ("bend", "bend"))
    )
    return f"""<mujoco model='moppet'>
<compiler angle='radian'/>
<option timestep='{settings.timestep}' cone='elliptic' impratio='10' integrator='Euler'/>
<default><joint armature='.006' damping='.15'/><geom friction='.8' rgba='.8 .5 .2 1'/></default>
<worldbody><light pos='0 0 4'/>{settings.ground.geoms()}{settings.extra}
<body name='crate' pos='0 0 {HEIGHT + TOE}'><freejoint name='loose'/>
<geom name='hull' type='box' size='.2 .085 .045' mass='{settings.trunk_mass}'/>
<geom name='nose' type='box' size='.03 .05 .03' pos='.2 0 .05' mass='.3'/>{legs}</body>
</worldbody><actuator>{motors}</actuator></mujoco>"""


def _leg(name: str) -> str:
    x = HIP[0] if name[0] == "n" else -HIP[0]
    side = 1.0 if name[1] == "w" else -1.0
    return f"""<body name='{name}_yoke' pos='{x} {side * HIP[1]} 0'>
<joint name='{name}_roll' axis='1 0 0' range='-.9 .9' limited='true'/>
<geom name='{name}_can' type='cylinder' size='.032 .02' euler='1.5708 0 0' mass='.35'/>
<body name='{name}_upper' pos='0 {side * WIDE} 0'>
<joint name='{name}_swing' axis='0 1 0' range='-2 2.6' limited='true'/>
<geom name='{name}_bone' type='capsule' size='.018' fromto='0 0 0 0 0 -{LINK}' mass='.45'/>
<body name='{name}_lower' pos='0 0 -{LINK}'>
<joint name='{name}_bend' axis='0 1 0' range='-2.6 -.1' limited='true'/>
<geom name='{name}_shin' type='capsule' size='.011' fromto='0 0 -.02 0 0 -{LINK - 0.02}' mass='.14'/>
<geom name='toe_{name}' type='sphere' size='{TOE}' pos='0 0 -{LINK}' mass='.05'/></body></body></body>"""


class QuadrupedControl:
    """PD to joint targets of a stand or a trot."""

    def __init__(self, model: Any, settings: QuadrupedSettings) -> None:
        self.settings = settings
        self.q = np.array(
            [model.joint(f"{leg}_{j}").qposadr[0] for leg in LEGS for j in ("roll", "swing", "bend")]
        )
        self.v = np.array(
            [model.joint(f"{leg}_{j}").dofadr[0] for leg in LEGS for j in ("roll", "swing", "bend")]
        )
        root = model.joint("loose")
        self.base, self.rate = int(root.qposadr[0]), int(root.dofadr[0])
        self.hips = np.array(
            [[HIP[0] if n[0] == "n" else -HIP[0], (1.0 if n[1] == "w" else -1.0) * HIP[1], 0.0] for n in LEGS]
        )
        self.level = np.zeros(2)
        self.begin = np.zeros(3)
        self.shifted, self.swinging = set[str](), dict.fromkeys(LEGS, True)
        slope = settings.ground.slope
        self.normal = np.array([np.sin(slope), 0.0, np.cos(slope)])

    def start(self, data: Any) -> None:
        """Stand on the ground, along its slope."""
        slope = self.settings.ground.slope
        data.qpos[self.base : self.base + 3] = (HEIGHT + TOE - 0.001) * self.normal
        data.qpos[self.base + 3 : self.base + 7] = np.cos(slope / 2), 0.0, np.sin(slope / 2), 0.0
        data.qpos[self.q] = np.concatenate([joint_angles(0.0, 0.0, HEIGHT)] * 4)
        self.begin = data.qpos[self.base : self.base + 3].copy()

    def step(self, time: float, q: Any, v: Any) -> Any:
        """Return the torques."""
        s = self.settings
        target = self.targets(time, q, v)
        return s.kp * (target - q[self.q]) - s.kd * v[self.v]

    def targets(self, time: float, q: Any, v: Any) -> Any:
        """Return the joint targets (12,)."""
        s, R = self.settings, rotation(q[self.base + 3 : self.base + 7])
        up = R.T @ self.normal  # measured against the ground: its slope is known to the loop
        velocity = R.T @ v[self.rate : self.rate + 3]
        if not s.trot:
            self.level += s.timestep * s.level * np.clip(up[:2], -0.3, 0.3)
            self.level = np.clip(self.level, -0.35, 0.35)
        ramp = min(time / 0.5, 1.0)
        out = []
        for k, leg in enumerate(LEGS):
            x, y, height = 0.0, 0.0, HEIGHT
            if s.trot:
                dx, dy, lift = self._trot(time, leg, velocity, ramp)
                x, y, height = x + dx, y + dy, height - lift
                height += 0.5 * float(self.hips[k, :2] @ up[:2])
            else:
                height += float(self.hips[k, :2] @ self.level)
            roll, swing, bend = joint_angles(x, y, height)
            if time >= s.shift_from and leg in s.inward:
                roll += (-1.0 if leg[1] == "w" else 1.0) * s.inward[leg]
            out += [roll, swing, bend]
        return np.array(out)

    def _trot(self, time: float, leg: str, velocity: Any, ramp: float) -> tuple[float, float, float]:
        """Return x, y of a foot under its hip, and how high it is lifted [m]."""
        s = self.settings
        phase = time / s.period + (0.0 if leg in ("nw", "se") else 0.5)
        if time >= s.shift_from:  # the swing that begins then takes longer
            phase -= s.late.get(leg, 0.0) * min((time - s.shift_from) / (0.5 * s.period), 1.0)
        speed = s.speed * ramp
        turn = 2.0 * np.pi * phase
        x = 0.25 * speed * s.period * np.cos(turn)
        swing = max(0.0, -np.sin(turn))
        x += 0.08 * (velocity[0] - speed) * (1.0 if swing > 0.0 else 0.0)
        y = 0.12 * velocity[1]
        if time >= s.shift_from and leg in s.shift and swing > 0.0 and not self.swinging[leg]:
            self.shifted.add(leg)
        self.swinging[leg] = swing > 0.0
        if leg in self.shifted:
            x, y = x + s.shift[leg][0], y + s.shift[leg][1]
        return float(x), float(y), float(s.lift * swing * ramp)

    def fallen(self, data: Any) -> str:
        """See `Control`."""
        at = data.qpos[self.base : self.base + 3]
        tilt = np.arccos(
            np.clip(rotation(data.qpos[self.base + 3 : self.base + 7])[:, 2] @ self.normal, -1, 1)
        )
        height = float(at @ self.normal)
        drop = self.settings.ground.edge
        floor = min(drop[1], 0.0) if drop is not None else 0.0
        if tilt > FALLEN:
            return f"the trunk tilts by {tilt:.2f} rad"
        if height - floor < 0.5 * HEIGHT:
            return f"the trunk is at {height:.3f} m"
        return ""

    def missed(self, data: Any) -> str:
        """See `Control`."""
        s, q = self.settings, data.qpos
        way = q[self.base : self.base + 3] - self.begin
        tilt = float(
            np.arccos(np.clip(rotation(q[self.base + 3 : self.base + 7])[:, 2] @ self.normal, -1, 1))
        )
        if s.trot:
            due = s.speed * (s.duration - 0.25)
            if way[0] < 0.5 * due:
                return f"it went {way[0]:.2f} m of {due:.2f}"
            return f"it drifted by {way[1]:.2f} m" if abs(way[1]) > 0.5 * due + 0.2 else ""
        if np.linalg.norm(way) > 0.12:
            return f"it slid by {np.linalg.norm(way):.2f} m"
        if tilt > CROOKED:
            return f"it stands crooked by {tilt:.2f} rad"
        deep = min((c.dist for c in data.contact[: data.ncon]), default=0.0)
        return f"it sank in by {-deep:.3f} m" if deep < -0.012 else ""

    def facts(self) -> dict[str, Any]:
        """See `Control`."""
        return {}

    def command(self) -> Any:
        """See `Control`."""
        return (self.settings.speed if self.settings.trot else 0.0, 0.0, 0.0)


def joint_angles(x: float, y: float, height: float) -> Any:
    """Return roll, swing and bend of a leg whose toe is at (x, y) under its hip [rad]."""
    reach = float(np.clip(np.hypot(x, height), 0.06, 2 * LINK - 0.004))
    knee = float(np.arccos(reach / (2 * LINK)))
    return np.array([np.arctan2(y, height), np.arctan2(-x, height) + knee, -2.0 * knee])


def rotation(quaternion: Any) -> Any:
    """Return the matrix of a quaternion w, x, y, z."""
    out = np.zeros(9)
    mujoco.mju_quat2Mat(out, np.asarray(quaternion, dtype=float))
    return out.reshape(3, 3)


def vary(rng: np.random.Generator) -> QuadrupedSettings:
    """Draw a lawful run."""
    return QuadrupedSettings(
        trot=bool(rng.random() < 0.5),
        speed=float(rng.uniform(0.2, 0.4)),
        period=float(rng.uniform(0.36, 0.44)),
        kp=float(rng.uniform(110, 130)),
        trunk_mass=float(rng.uniform(6.0, 7.0)),
        ground=Ground(mu=float(rng.uniform(0.7, 0.9))),
    )
