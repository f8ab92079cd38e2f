"""`servo hexapod`: six legs of three hinges around a plate, `<position>` servos; it walks on two tripods.

Feet follow a loop in the plate's frame, three at a time, by inverse kinematics. The plate is kept level by an
integral of its measured tilt, and its heading by the stride of either side.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.foreign.ground import Ground
from benchmarks.foreign.quadruped import rotation

LEGS = ("a", "b", "c", "d", "e", "f")
ANGLES = np.radians([40.0, 90.0, 140.0, 220.0, 270.0, 320.0])
"""Direction in which each leg leaves the plate [rad]."""
PLATE, COXA, FEMUR, TIBIA, BUTTON = 0.11, 0.05, 0.11, 0.16, 0.014
"""Radius of the plate, lengths of a leg's three links, radius of its foot [m]."""
RIDE, OUT = 0.11, 0.14
"""Height of the plate over the feet's centres, and how far out of its hinge a foot stands [m]."""
KINDS = ("turn", "raise", "knee")


@dataclass(frozen=True)
class HexapodSettings:
    """Settings of a run: model, controller and task.

    Attributes
    ----------
    speed, period, duty, lift
        Of the walk [m/s, s], share of a period in stance, and how high feet are lifted [m].
    kp, kv, limit
        Of the servos [N m/rad, N m s/rad, N m].
    shift, late, shift_from
        Leg to the offset of its touchdowns (x, y) [m], to the share of a period by which they are late, and
        the time from which they are so [s].
    plate_mass, extra
        Of the plate [kg]; more bodies of the world, as MJCF.
    """

    duration: float = 3.0
    timestep: float = 0.002
    delay: float = 0.0
    ground: Ground = field(default_factory=Ground)
    speed: float = 0.2
    period: float = 0.6
    duty: float = 0.55
    lift: float = 0.04
    kp: float = 40.0
    kv: float = 1.0
    limit: float = 6.0
    shift: dict[str, tuple[float, float]] = field(default_factory=dict)
    late: dict[str, float] = field(default_factory=dict)
    shift_from: float = 0.0
    plate_mass: float = 1.6
    extra: str = ""


def mjcf(settings: HexapodSettings) -> str:
    """Return the model."""
    s = settings
    legs = "".join(_leg(name, float(angle)) for name, angle in zip(LEGS, ANGLES, strict=True))
    servos = "".join(
        f"<position name='s_{kind}_{leg}' joint='{kind}_{leg}' kp='{s.kp}' kv='{s.kv}' "
        f"forcerange='-{s.limit} {s.limit}'/>"
        for leg in LEGS
        for kind in KINDS
    )
    return f"""<mujoco model='weevil'>
<compiler angle='radian'/>
<option timestep='{s.timestep}' cone='elliptic' impratio='10' integrator='implicitfast'/>
<default><joint armature='.003' damping='.03' limited='true'/>
<geom friction='.8' rgba='.4 .4 .45 1'/></default>
<worldbody><light pos='0 0 3'/>{s.ground.geoms()}{s.extra}
<body name='plate' pos='0 0 {RIDE + BUTTON}'><freejoint name='adrift'/>
<geom name='disc' type='cylinder' size='{PLATE - 0.02} .02' mass='{s.plate_mass}'/>{legs}</body>
</worldbody><actuator>{servos}</actuator></mujoco>"""


def _leg(name: str, angle: float) -> str:
    x, y = PLATE * np.cos(angle), PLATE * np.sin(angle)
    return f"""<body name='coxa_{name}' pos='{x} {y} 0' euler='0 0 {angle}'>
<joint name='turn_{name}' axis='0 0 1' range='-1.1 1.1'/>
<geom name='hub_{name}' type='sphere' size='.018' mass='.06'/>
<body name='femur_{name}' pos='{COXA} 0 0'><joint name='raise_{name}' axis='0 1 0' range='-1.6 1.2'/>
<geom name='bar_{name}' type='capsule' size='.012' fromto='.01 0 0 {FEMUR - 0.01} 0 0' mass='.08'/>
<body name='tibia_{name}' pos='{FEMUR} 0 0'><joint name='knee_{name}' axis='0 1 0' range='.1 2.6'/>
<geom name='rod_{name}' type='capsule' size='.008' fromto='.02 0 0 {TIBIA - 0.02} 0 0' mass='.05'/>
<geom name='button_{name}' type='sphere' size='{BUTTON}' pos='{TIBIA} 0 0' mass='.02'/>
</body></body></body>"""


class HexapodControl:
    """Servo targets of a walk on two tripods."""

    def __init__(self, model: Any, settings: HexapodSettings) -> None:
        self.settings = settings
        self.q = np.array([model.joint(f"{k}_{leg}").qposadr[0] for leg in LEGS for k in KINDS])
        root = model.joint("adrift")
        self.base, self.rate = int(root.qposadr[0]), int(root.dofadr[0])
        self.mounts = np.stack([PLATE * np.cos(ANGLES), PLATE * np.sin(ANGLES)], axis=1)
        out = PLATE + COXA + OUT
        self.home = np.stack([out * np.cos(ANGLES), out * np.sin(ANGLES)], axis=1)
        self.level = np.zeros(2)
        self.begin = np.zeros(3)
        slope = settings.ground.slope
        self.normal = np.array([np.sin(slope), 0.0, np.cos(slope)])

    def start(self, data: Any) -> None:
        """Stand on the ground."""
        slope = self.settings.ground.slope
        data.qpos[self.base : self.base + 3] = (RIDE + BUTTON - 0.0005) * self.normal
        data.qpos[self.base + 3 : self.base + 7] = np.cos(slope / 2), 0.0, np.sin(slope / 2), 0.0
        for k in range(len(LEGS)):
            x, y = self.home[k].tolist()
            data.qpos[self.q[3 * k : 3 * k + 3]] = self.angles(k, x, y, -RIDE)
        data.ctrl[:] = data.qpos[self.q]
        self.begin = data.qpos[self.base : self.base + 3].copy()

    def angles(self, k: int, x: float, y: float, z: float) -> Any:
        """Return the three angles of a leg whose foot is there in the plate's frame [rad]."""
        way = np.array([x, y]) - self.mounts[k]
        turn = np.arctan2(way[1], way[0]) - ANGLES[k]
        turn = np.arctan2(np.sin(turn), np.cos(turn))
        out = float(np.hypot(*way)) - COXA
        reach = float(np.clip(np.hypot(out, z), 0.06, FEMUR + TIBIA - 2e-3))
        knee = np.pi - np.arccos(np.clip((FEMUR**2 + TIBIA**2 - reach**2) / (2 * FEMUR * TIBIA), -1, 1))
        inner = np.arccos(np.clip((FEMUR**2 + reach**2 - TIBIA**2) / (2 * FEMUR * reach), -1, 1))
        return np.array([turn, np.arctan2(-z, out) - inner, knee])

    def step(self, time: float, q: Any, v: Any) -> Any:
        """Return the servos' targets."""
        s, R = self.settings, rotation(q[self.base + 3 : self.base + 7])
        up = R.T @ self.normal
        self.level = np.clip(self.level + s.timestep * 1.2 * np.clip(up[:2], -0.3, 0.3), -0.25, 0.25)
        speed = s.speed * min(time / 0.4, 1.0)
        heading = float(np.arctan2(R[1, 0], R[0, 0]))
        sideways = float(R[:, 1] @ (q[self.base : self.base + 3] - self.begin))
        out = []
        for k, leg in enumerate(LEGS):
            dx, dy, lift = self._loop(time, k, leg, speed, heading, sideways)
            x, y = self.home[k] + (dx, dy)
            z = -RIDE + lift - float(self.home[k] @ self.level)
            out.append(self.angles(k, x, y, z))
        return np.concatenate(out)

    def _loop(
        self, time: float, k: int, leg: str, speed: float, heading: float, sideways: float
    ) -> tuple[float, float, float]:
        """Return how far a foot is from its home, and how high it is lifted [m]."""
        s = self.settings
        phase = time / s.period + 0.5 * (k % 2)
        if time >= s.shift_from:
            phase -= s.late.get(leg, 0.0) * min((time - s.shift_from) / (0.4 * s.period), 1.0)
        phase %= 1.0
        stride = speed * s.duty * s.period
        turn = float(np.clip(0.4 * heading, -0.1, 0.1))
        stride_x = stride + turn * self.home[k, 1]
        aside = float(np.clip(-0.3 * sideways, -0.02, 0.02)) - turn * self.home[k, 0]
        if phase < s.duty:
            share, lift = 0.5 - phase / s.duty, 0.0
        else:
            swing = (phase - s.duty) / (1.0 - s.duty)
            share, lift = -0.5 * np.cos(np.pi * swing), s.lift * np.sin(np.pi * swing)
        x, y = stride_x * share, aside * share
        if time >= s.shift_from and leg in s.shift:
            x, y = x + s.shift[leg][0], y + s.shift[leg][1]
        return float(x), float(y), float(lift * min(time / 0.3, 1.0))

    def fallen(self, data: Any) -> str:
        """See `Control`."""
        R = rotation(data.qpos[self.base + 3 : self.base + 7])
        tilt = float(np.arccos(np.clip(R[:, 2] @ self.normal, -1, 1)))
        edge = self.settings.ground.edge
        floor = min(edge[1], 0.0) if edge is not None else 0.0
        height = float(data.qpos[self.base : self.base + 3] @ self.normal) - floor
        if tilt > 0.6:
            return f"the plate tilts by {tilt:.2f} rad"
        return f"the plate is at {height:.3f} m" if height < 0.5 * RIDE else ""

    def missed(self, data: Any) -> str:
        """See `Control`."""
        s = self.settings
        way = data.qpos[self.base : self.base + 3] - self.begin
        due = s.speed * (s.duration - 0.2)
        if way[0] < 0.5 * due:
            return f"it went {way[0]:.2f} m of {due:.2f}"
        R = rotation(data.qpos[self.base + 3 : self.base + 7])
        tilt = float(np.arccos(np.clip(R[:, 2] @ self.normal, -1, 1)))
        if tilt > 0.18:
            return f"it walks crooked by {tilt:.2f} rad"
        return f"it drifted by {way[1]:.2f} m" if abs(way[1]) > 0.4 * due + 0.1 else ""

    def facts(self) -> dict[str, Any]:
        """See `Control`."""
        return {}

    def command(self) -> Any:
        """See `Control`."""
        return self.settings.speed, 0.0, 0.0


def vary(rng: np.random.Generator) -> HexapodSettings:
    """Draw a lawful run."""
    return HexapodSettings(
        speed=float(rng.uniform(0.15, 0.25)),
        period=float(rng.uniform(0.5, 0.7)),
        kp=float(rng.uniform(36, 46)),
        plate_mass=float(rng.uniform(1.4, 1.8)),
        ground=Ground(mu=float(rng.uniform(0.7, 0.9))),
    )
