"""`wheeled balancer`: a post on two wheels under torque control; it balances and drives at a speed.

State feedback on the measured pitch, its rate and the speed over ground; a difference of the wheels' torques
keeps the heading.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.foreign.ground import Ground
from benchmarks.foreign.quadruped import rotation

WHEEL, TRACK, POST = 0.1, 0.17, 0.45
"""Radius of the wheels, half of the way between them, height of the post [m]."""
SIDES = ("l", "r")


@dataclass(frozen=True)
class BalancerSettings:
    """Settings of a run: model, controller and task.

    Attributes
    ----------
    speed
        Forward [m/s].
    kp, kd, ks, ki
        Gains of pitch [N m/rad], its rate [N m s/rad], speed [N m s/m] and way [N m/m], of both wheels.
    limit
        Of a wheel's motor [N m].
    body_mass
        Of the post [kg].
    on_post, extra
        More geoms of the post; more bodies of the world, as MJCF.
    """

    duration: float = 3.0
    timestep: float = 0.002
    delay: float = 0.0
    ground: Ground = field(default_factory=Ground)
    speed: float = 0.4
    kp: float = 80.0
    kd: float = 12.0
    ks: float = 22.0
    ki: float = 16.0
    limit: float = 12.0
    body_mass: float = 8.0
    on_post: str = ""
    extra: str = ""


def mjcf(settings: BalancerSettings) -> str:
    """Return the model."""
    s = settings
    wheels = "".join(
        f"<body name='wheel_{side}' pos='0 {sign * TRACK} 0'><joint name='axle_{side}' axis='0 1 0'/>"
        f"<geom name='tyre_{side}' type='ellipsoid' size='{WHEEL} .025 {WHEEL}' mass='.8'/></body>"
        for side, sign in zip(SIDES, (1.0, -1.0), strict=True)
    )
    motors = "".join(
        f"<motor name='drive_{side}' joint='axle_{side}' forcerange='-{s.limit} {s.limit}'/>"
        for side in SIDES
    )
    return f"""<mujoco model='usher'>
<compiler angle='radian'/>
<option timestep='{s.timestep}' cone='elliptic' impratio='10'/>
<default><joint armature='.004' damping='.02'/><geom friction='.9' rgba='.3 .5 .75 1'/></default>
<worldbody><light pos='0 0 3'/>{s.ground.geoms()}{s.extra}
<body name='mast' pos='0 0 {WHEEL}'><freejoint name='roam'/>
<geom name='pole' type='capsule' size='.03' fromto='0 0 .08 0 0 {POST}' mass='{0.4 * s.body_mass}'/>
<geom name='head' type='box' size='.07 .1 .06' pos='0 0 {POST}' mass='{0.6 * s.body_mass}'/>{s.on_post}
{wheels}</body>
</worldbody><actuator>{motors}</actuator></mujoco>"""


class BalancerControl:
    """State feedback."""

    def __init__(self, model: Any, settings: BalancerSettings) -> None:
        self.settings = settings
        root = model.joint("roam")
        self.base, self.rate = int(root.qposadr[0]), int(root.dofadr[0])
        self.way, self.last = 0.0, 0.0
        self.begin = np.zeros(3)
        slope = settings.ground.slope
        self.normal = np.array([np.sin(slope), 0.0, np.cos(slope)])

    def start(self, data: Any) -> None:
        """Stand upright on the ground."""
        data.qpos[self.base : self.base + 3] = (WHEEL - 0.0005) * self.normal
        data.qpos[self.base + 3 : self.base + 7] = 1.0, 0.0, 0.0, 0.0
        self.begin = data.qpos[self.base : self.base + 3].copy()

    def step(self, time: float, q: Any, v: Any) -> Any:
        """Return the torques of the wheels."""
        s, R = self.settings, rotation(q[self.base + 3 : self.base + 7])
        heading = float(np.arctan2(R[1, 0], R[0, 0]))
        forward = np.array([np.cos(heading), np.sin(heading), 0.0])
        pitch = float(np.arctan2(R[:, 2] @ forward, R[2, 2]))
        spin = v[self.rate + 3 : self.rate + 6]
        speed = float(forward @ v[self.rate : self.rate + 3])
        due = s.speed * min(time / 0.8, 1.0)
        self.way = float(np.clip(self.way + s.timestep * (speed - due), -0.4, 0.4))
        both = s.kp * pitch + s.kd * spin[1] + s.ks * (speed - due) + s.ki * self.way
        yaw = -1.5 * heading - 0.4 * spin[2]
        return np.array([0.5 * both - yaw, 0.5 * both + yaw])

    def fallen(self, data: Any) -> str:
        """See `Control`."""
        R = rotation(data.qpos[self.base + 3 : self.base + 7])
        tilt = float(np.arccos(np.clip(R[2, 2], -1, 1)))
        return f"the post tilts by {tilt:.2f} rad" if tilt > 0.9 else ""

    def missed(self, data: Any) -> str:
        """See `Control`."""
        s = self.settings
        way = data.qpos[self.base : self.base + 2] - self.begin[:2]
        due = s.speed * (s.duration - 0.4)
        if abs(way[0] - due) > 0.5 * due + 0.1 or abs(way[1]) > 0.5 * due + 0.1:
            return f"it went {way[0]:.2f} m of {due:.2f}, {way[1]:.2f} m aside"
        deep = min((c.dist for c in data.contact[: data.ncon]), default=0.0)
        return f"it sank in by {-deep:.3f} m" if deep < -0.012 else ""

    def facts(self) -> dict[str, Any]:
        """See `Control`."""
        return {}

    def command(self) -> Any:
        """See `Control`."""
        return self.settings.speed, 0.0, 0.0


def vary(rng: np.random.Generator) -> BalancerSettings:
    """Draw a lawful run."""
    return BalancerSettings(
        speed=float(rng.uniform(0.3, 0.5)),
        kp=float(rng.uniform(75, 90)),
        body_mass=float(rng.uniform(7.5, 8.5)),
        ground=Ground(mu=float(rng.uniform(0.7, 0.9))),
    )
