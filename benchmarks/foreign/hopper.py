"""`hopper`: one leg with two hip hinges and a telescope, free base, `<motor>` actuators; it hops at a speed.

The telescope is sprung by its motor (a spring in torque control), pushed a little longer while it extends. In
stance the hips level the drum; in the air they place the foot for the commanded speed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.foreign.ground import Ground
from benchmarks.foreign.quadruped import rotation

LEG, SHOE = 0.5, 0.03
"""Length of the leg from the hips to the shoe's centre, and radius of the shoe [m]."""
LEGS_MASS = 0.75
"""Of all below the drum [kg]."""
STANCE = 0.006
"""Compression of the telescope from which the foot counts as loaded [m]."""


@dataclass(frozen=True)
class HopperSettings:
    """Settings of a run: model, controller and task.

    Attributes
    ----------
    speed
        Forward [m/s].
    spring, damper, thrust
        Of the telescope [N/m, N s/m], and how much longer it pushes while it extends [m].
    kp, kd
        Gains of the hips [N m/rad, N m s/rad].
    limit, push_limit
        Of the hips [N m] and of the telescope [N].
    drum_mass, believed_mass
        Of the drum, and what the controller compensates [kg].
    place, place_from
        Offset of touchdowns (x, y) [m], from the first flight that begins after a time on [s].
    on_drum
        More geoms of the drum, as MJCF.
    extra
        More bodies of the world, as MJCF.
    """

    duration: float = 3.0
    timestep: float = 0.001
    delay: float = 0.0
    ground: Ground = field(default_factory=Ground)
    speed: float = 0.3
    spring: float = 3000.0
    damper: float = 22.0
    thrust: float = 0.028
    kp: float = 180.0
    kd: float = 14.0
    limit: float = 40.0
    push_limit: float = 500.0
    drum_mass: float = 7.0
    believed_mass: float = 7.0
    place: tuple[float, float] = (0.0, 0.0)
    place_from: float = 0.0
    on_drum: str = ""
    extra: str = ""


def mjcf(settings: HopperSettings) -> str:
    """Return the model."""
    s = settings
    return f"""<mujoco model='pogo'>
<compiler angle='radian'/>
<option timestep='{s.timestep}' cone='elliptic' impratio='10'/>
<default><joint limited='true'/><default class='hip'><joint armature='.01' damping='.05'/></default>
<geom friction='.9' rgba='.3 .6 .4 1'/></default>
<worldbody><light pos='0 0 4'/>{s.ground.geoms()}{s.extra}
<body name='drum' pos='0 0 {LEG + SHOE + 0.1}'><freejoint name='float'/>
<geom name='barrel' type='cylinder' size='.3 .04' mass='{s.drum_mass}' pos='0 0 .03'/>{s.on_drum}
<body name='gimbal' pos='0 0 0'><joint name='tip' axis='1 0 0' range='-1 1' class='hip'/>
<geom name='ring' type='sphere' size='.035' mass='.25'/>
<body name='tube'><joint name='tilt' axis='0 1 0' range='-1.2 1.2' class='hip'/>
<geom name='sleeve' type='capsule' size='.022' fromto='0 0 -.04 0 0 -.24' mass='.3'/>
<body name='rod' pos='0 0 -.24'><joint name='stroke' type='slide' axis='0 0 1' range='0 .22'
damping='1' solreflimit='.004 1'/>
<geom name='shaft' type='capsule' size='.012' fromto='0 0 0 0 0 -{LEG - 0.24}' mass='.12'/>
<geom name='shoe' type='sphere' size='{SHOE}' pos='0 0 -{LEG - 0.24}' mass='.08'/></body></body></body></body>
</worldbody>
<actuator><motor name='tip_drive' joint='tip' forcerange='-{s.limit} {s.limit}'/>
<motor name='tilt_drive' joint='tilt' forcerange='-{s.limit} {s.limit}'/>
<motor name='stroke_drive' joint='stroke' forcerange='-{s.push_limit} {s.push_limit}'/></actuator></mujoco>"""


class HopperControl:
    """Hopping in three parts: height by thrust, attitude by the hips in stance, speed by the foot's place."""

    def __init__(self, model: Any, settings: HopperSettings) -> None:
        self.settings = settings
        root = model.joint("float")
        self.base, self.rate = int(root.qposadr[0]), int(root.dofadr[0])
        names = ("tip", "tilt", "stroke")
        self.q = np.array([model.joint(n).qposadr[0] for n in names])
        self.v = np.array([model.joint(n).dofadr[0] for n in names])
        self.flying, self.misplaces = True, False

    def start(self, data: Any) -> None:
        """Begin in the air."""
        data.qpos[self.base + 2] = LEG + SHOE + 0.06

    def step(self, time: float, q: Any, v: Any) -> Any:
        """Return the controls: two torques and a force."""
        s = self.settings
        R = rotation(q[self.base + 3 : self.base + 7])
        heading = np.arctan2(R[1, 0], R[0, 0])
        turn = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
        velocity = turn @ v[self.rate : self.rate + 2]
        roll, pitch = np.arctan2(R[2, 1], R[2, 2]), -np.arcsin(np.clip(R[2, 0], -1.0, 1.0))
        spin = v[self.rate + 3 : self.rate + 6]
        joints, rates = q[self.q], v[self.v]
        stroke, extend = joints[2], rates[2]
        loaded = stroke > STANCE
        want = np.array([min(time / 0.6, 1.0) * s.speed, 0.0])
        weight = s.believed_mass * 9.81
        force = -s.spring * stroke - s.damper * extend - 20.0
        if loaded:
            self.flying = False
            force -= s.spring * s.thrust * (1.0 if extend < 0.0 else 0.0) + (weight - 68.67)
            return np.array([s.kp * roll + s.kd * spin[0], s.kp * pitch + s.kd * spin[1], force])
        neutral = 0.5 * 0.17 * velocity + 0.05 * (velocity - want)
        self.misplaces |= time >= s.place_from and not self.flying
        self.flying = True
        if self.misplaces:
            neutral = neutral + np.array(s.place)
        tilt = -np.arcsin(np.clip(neutral[0] / LEG, -0.6, 0.6)) - pitch
        tip = np.arcsin(np.clip(neutral[1] / LEG, -0.6, 0.6)) - roll
        gains = 0.35 * s.kp, 0.18 * s.kd
        return np.array([
            gains[0] * (tip - joints[0]) - gains[1] * rates[0],
            gains[0] * (tilt - joints[1]) - gains[1] * rates[1],
            force,
        ])  # fmt: skip

    def fallen(self, data: Any) -> str:
        """See `Control`."""
        R = rotation(data.qpos[self.base + 3 : self.base + 7])
        tilt = float(np.arccos(np.clip(R[2, 2], -1, 1)))
        height = float(data.qpos[self.base + 2])
        edge = self.settings.ground.edge
        floor = min(edge[1], 0.0) if edge is not None else 0.0
        if tilt > 0.9:
            return f"the drum tilts by {tilt:.2f} rad"
        return f"the drum is at {height:.3f} m" if height - floor < 0.3 else ""

    def missed(self, data: Any) -> str:
        """See `Control`."""
        s, way = self.settings, data.qpos[self.base : self.base + 2]
        due = s.speed * (s.duration - 0.4)
        if np.linalg.norm(way) < 0.5 * due:
            return f"it went {np.linalg.norm(way):.2f} m of {due:.2f}"
        return f"it ran away by {np.linalg.norm(way):.2f} m" if np.linalg.norm(way) > 2.0 * due + 0.3 else ""

    def facts(self) -> dict[str, Any]:
        """See `Control`."""
        return {"mass_controller": self.settings.believed_mass + LEGS_MASS}

    def command(self) -> Any:
        """See `Control`."""
        return self.settings.speed, 0.0, 0.0


def vary(rng: np.random.Generator) -> HopperSettings:
    """Draw a lawful run."""
    mass = float(rng.uniform(6.7, 7.3))
    return HopperSettings(
        speed=float(rng.uniform(0.2, 0.4)),
        drum_mass=mass,
        believed_mass=mass,
        kp=float(rng.uniform(170, 190)),
        ground=Ground(mu=float(rng.uniform(0.75, 0.95))),
    )
