"""`pd humanoid`: two legs with box feet, a waist and two arms; it stands and sways by PD on `<motor>`s.

The ankles add what the pelvis' measured lean asks for, the knees what the trunk's mass does. Swaying leads
hips and ankles along a sinusoid from side to side, or to and fro.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.foreign.ground import Ground
from benchmarks.foreign.quadruped import rotation

SIDES = ("port", "star")
"""Left and right."""
THIGH, SHANK, ANKLE, APART = 0.36, 0.36, 0.06, 0.10
"""Lengths of the links, height of the ankle over the sole, half the way between the hips [m]."""
LEG = ("hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")
BEND = 0.25
"""Angle of the knees of the stand [rad]."""
ABOVE_KNEES, LIMBS = 12.0, 24.2
"""Mass over the knees without the trunk, and of all without the trunk [kg]."""
STRONG = {"hip_roll": 1.3, "hip_pitch": 1.0, "knee": 1.0, "ankle_pitch": 0.8, "ankle_roll": 0.8, "waist": 0.8}
"""Stiffness of a joint over `kp`; the arms have less."""


@dataclass(frozen=True)
class HumanoidSettings:
    """Settings of a run: model, controller and task.

    Attributes
    ----------
    sway, forward, period
        How far it sways from side to side, or leans to and fro [rad], and the period [s].
    kp, kd, limit
        Gains [N m/rad, N m s/rad] and limit of the legs' motors [N m].
    lean_kp, lean_kd
        Gains of the balance at the ankles [N m/rad, N m s/rad].
    lean
        Lean that is commanded from one second on [rad].
    trunk_mass, believed_mass
        Of the trunk, and what the controller believes of it [kg].
    cross
        Time from which an arm is moved through the other, or a leg into the other [s], and which.
    on_chest
        More geoms of the chest, as MJCF.
    extra
        More bodies of the world, as MJCF.
    """

    duration: float = 2.6
    timestep: float = 0.002
    delay: float = 0.0
    ground: Ground = field(default_factory=Ground)
    sway: float = 0.06
    forward: float = 0.0
    period: float = 1.6
    kp: float = 450.0
    kd: float = 14.0
    limit: float = 130.0
    lean_kp: float = 120.0
    lean_kd: float = 25.0
    lean: float = 0.0
    trunk_mass: float = 12.0
    believed_mass: float = 12.0
    cross: tuple[float, str] | None = None
    on_chest: str = ""
    extra: str = ""


def mjcf(settings: HumanoidSettings) -> str:
    """Return the model."""
    s = settings
    legs = _leg("port", 1.0) + _leg("star", -1.0)
    arms = _arm("port", 1.0) + _arm("star", -1.0)
    joints = [f"{side}_{joint}" for side in SIDES for joint in LEG]
    motors = "".join(
        f"<motor name='m_{name}' joint='{name}' forcerange='-{s.limit} {s.limit}'/>"
        for name in [*joints, "waist"]
    ) + "".join(f"<motor name='m_{side}_arm' joint='{side}_arm' forcerange='-25 25'/>" for side in SIDES)
    return f"""<mujoco model='tin man'>
<compiler angle='radian'/>
<option timestep='{s.timestep}' cone='elliptic' impratio='10'/>
<default><joint armature='.03' damping='1' limited='true'/><geom friction='.8' rgba='.55 .6 .75 1'/></default>
<worldbody><light pos='0 0 5'/>{s.ground.geoms()}{s.extra}
<body name='pelvis' pos='0 0 {THIGH + SHANK + ANKLE}'><freejoint name='floating'/>
<geom name='bowl' type='box' size='.07 .13 .05' mass='6' pos='0 0 .03'/>{legs}
<body name='chest' pos='0 0 .11'><joint name='waist' axis='0 1 0' range='-.8 1.2'/>
<geom name='ribs' type='box' size='.08 .15 .16' pos='0 0 .19' mass='{s.trunk_mass}'/>
<geom name='skull' type='sphere' size='.09' pos='0 0 .46' mass='2'/>{s.on_chest}{arms}</body></body>
</worldbody><actuator>{motors}</actuator></mujoco>"""


def _leg(side: str, sign: float) -> str:
    return f"""<body name='{side}_hip' pos='0 {sign * APART} 0'>
<joint name='{side}_hip_roll' axis='1 0 0' range='-.7 .7'/>
<geom name='{side}_knob' type='sphere' size='.045' mass='.8'/>
<body name='{side}_thigh'><joint name='{side}_hip_pitch' axis='0 1 0' range='-1.8 1'/>
<geom name='{side}_femur' type='capsule' size='.05' fromto='0 0 -.08 0 0 -{THIGH - 0.05}' mass='2.8'/>
<body name='{side}_shank' pos='0 0 -{THIGH}'><joint name='{side}_knee' axis='0 1 0' range='-.05 2.3'/>
<geom name='{side}_tibia' type='capsule' size='.04' fromto='0 0 -.04 0 0 -{SHANK - 0.06}' mass='1.9'/>
<body name='{side}_joint' pos='0 0 -{SHANK}'><joint name='{side}_ankle_pitch' axis='0 1 0' range='-1 1'/>
<geom name='{side}_malleolus' type='sphere' size='.02' mass='.2'/>
<body name='{side}_foot'><joint name='{side}_ankle_roll' axis='1 0 0' range='-.5 .5'/>
<geom name='{side}_sole' type='box' size='.11 .05 .015' pos='.03 0 -{ANKLE - 0.015}' mass='.8'/>
</body></body></body></body></body>"""


def _arm(side: str, sign: float) -> str:
    return f"""<body name='{side}_upper_arm' pos='0 {sign * 0.21} .29'>
<joint name='{side}_arm' axis='0 1 0' range='-2.5 2.5'/>
<geom name='{side}_limb' type='capsule' size='.035' fromto='0 0 0 0 0 -.42' mass='1.6'/></body>"""


class HumanoidControl:
    """PD to the joint targets of a stand, and a balance at the ankles."""

    def __init__(self, model: Any, settings: HumanoidSettings) -> None:
        s = self.settings = settings
        names = [str(model.joint(int(j)).name) for j in model.actuator_trnid[:, 0]]
        self.q = np.array([model.joint(n).qposadr[0] for n in names])
        self.v = np.array([model.joint(n).dofadr[0] for n in names])
        strong = np.array([STRONG.get(n.split("_", 1)[-1], 0.15) for n in names])
        self.kp, self.kd = s.kp * strong, s.kd * strong
        root = model.joint("floating")
        self.base, self.rate = int(root.qposadr[0]), int(root.dofadr[0])
        short = [n.split("_", 1)[-1] for n in names]
        stand = {"hip_pitch": -BEND / 2, "knee": BEND, "ankle_pitch": -BEND / 2}
        self.rest = np.array([stand.get(n, 0.0) for n in short])
        self.pitching = np.array([-1.0 if n == "ankle_pitch" else 0.0 for n in short])
        self.knees = np.array([1.0 if n == "knee" else 0.0 for n in short])
        self.ankle_rolls = np.array([1.0 if n == "ankle_roll" else 0.0 for n in short])
        self.rolling = self.ankle_rolls - np.array([1.0 if n == "hip_roll" else 0.0 for n in short])
        side = s.cross[1] if s.cross is not None else ""
        into = {f"{side}_hip_roll": -0.55 if side == "port" else 0.55, f"{side}_knee": 0.5}
        self.crossing = np.array([into.get(n, 0.0) for n in names])
        slope = s.ground.slope
        self.normal = np.array([np.sin(slope), 0.0, np.cos(slope)])
        self.begin = np.zeros(3)
        self.feet = [model.geom(f"{side}_sole").id for side in SIDES]

    def start(self, data: Any) -> None:
        """Stand."""
        slope = self.settings.ground.slope
        height = (THIGH + SHANK) * np.cos(BEND / 2) + ANKLE
        data.qpos[self.base : self.base + 3] = (height - 0.0005) * self.normal
        data.qpos[self.base + 3 : self.base + 7] = np.cos(slope / 2), 0.0, np.sin(slope / 2), 0.0
        data.qpos[self.q] = self.rest
        self.begin = data.qpos[self.base : self.base + 3].copy()

    def step(self, time: float, q: Any, v: Any) -> Any:
        """Return the torques."""
        s = self.settings
        R = rotation(q[self.base + 3 : self.base + 7])
        pitch, roll = -np.arcsin(np.clip(R[2, 0], -1.0, 1.0)), np.arctan2(R[2, 1], R[2, 2])
        pitch -= s.ground.slope
        spin = v[self.rate + 3 : self.rate + 6]
        ramp = min(time / 0.6, 1.0)
        wave = np.sin(2.0 * np.pi * time / s.period) * ramp
        lean = s.forward * wave + s.lean * np.clip((time - 1.0) / 0.5, 0.0, 1.0)
        goal = self.rest + lean * self.pitching + s.sway * wave * self.rolling
        if s.cross is not None and time > s.cross[0]:
            goal = goal + min((time - s.cross[0]) / 0.25, 1.0) * self.crossing
        torque = self.kp * (goal - q[self.q]) - self.kd * v[self.v]
        torque -= self.pitching * (s.lean_kp * (pitch - lean) + s.lean_kd * spin[1])
        torque += self.knees * 0.5 * 9.81 * (s.believed_mass + ABOVE_KNEES) * THIGH * np.sin(BEND / 2)
        torque += self.ankle_rolls * 0.6 * (s.lean_kp * roll + s.lean_kd * spin[0])
        return torque

    def fallen(self, data: Any) -> str:
        """See `Control`."""
        R = rotation(data.qpos[self.base + 3 : self.base + 7])
        tilt = float(np.arccos(np.clip(R[:, 2] @ self.normal, -1, 1)))
        height = float(data.qpos[self.base : self.base + 3] @ self.normal)
        if tilt > 0.8:
            return f"the pelvis tilts by {tilt:.2f} rad"
        return f"the pelvis is at {height:.2f} m" if height < 0.5 else ""

    def missed(self, data: Any) -> str:
        """See `Control`."""
        way = data.qpos[self.base : self.base + 3] - self.begin
        R = rotation(data.qpos[self.base + 3 : self.base + 7])
        tilt = float(np.arccos(np.clip(R[:, 2] @ self.normal, -1, 1)))
        if np.linalg.norm(way) > 0.15:
            return f"it moved by {np.linalg.norm(way):.2f} m"
        if tilt > 0.3:
            return f"it stands crooked by {tilt:.2f} rad"
        deep = min((c.dist for c in data.contact[: data.ncon]), default=0.0)
        return f"it sank in by {-deep:.3f} m" if deep < -0.012 else ""

    def facts(self) -> dict[str, Any]:
        """See `Control`."""
        return {"mass_controller": self.settings.believed_mass + LIMBS}

    def command(self) -> Any:
        """See `Control`."""
        return 0.0, 0.0, 0.0


def vary(rng: np.random.Generator) -> HumanoidSettings:
    """Draw a lawful run."""
    to_and_fro = rng.random() < 0.3
    size = float(rng.uniform(0.02, 0.05))
    mass = float(rng.uniform(11, 13))
    return HumanoidSettings(
        sway=0.0 if to_and_fro else size,
        forward=0.6 * size if to_and_fro else 0.0,
        period=float(rng.uniform(1.4, 2.0)),
        kp=float(rng.uniform(430, 480)),
        trunk_mass=mass,
        believed_mass=mass,
        ground=Ground(mu=float(rng.uniform(0.7, 0.9))),
    )
