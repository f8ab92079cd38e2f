"""`arm pushing a box`: a bolted arm of four `<position>` actuators pushes a free box along a table to a goal.

The hand is led by inverse kinematics along a line, corrected sideways by the measured place of the box. What
gravity takes of the joint targets is added to them, from the masses that the controller believes. `record` is
given the arm or the box as its robot.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.foreign.ground import Ground
from benchmarks.foreign.quadruped import rotation

POST, UPPER, FORE = 0.32, 0.32, 0.30
"""Height of the shoulder, lengths of the arm's links to elbow and wrist [m]."""
HAND, HALF = 0.10, 0.055
"""Length of the hand, which hangs down, and half a side of the box [m]."""
START, REACH = 0.36, 0.72
"""Where the box is at first, and how far the wrist comes [m]."""
LINKS_MASS, STRAIGHT = 3.6, 0.06
"""Of the arm without what the hand holds [kg], and the elbow's angle at its stop [rad]."""
TABLE = "0.025 1"
"""The table's solref: with a harder one the box rattles against the hand."""
NEAR = 0.035
"""The box is at its goal within this [m]."""
JOINTS = ("pan", "lift", "fold", "drop")


@dataclass(frozen=True)
class PusherSettings:
    """Settings of a run: model, controller and task.

    Attributes
    ----------
    goal, side
        Where the box is to go in x, and where it is in y at first [m].
    arrive
        When the hand is to arrive [s].
    kp, kv, limit
        Of the actuators [N m/rad, N m s/rad, N m].
    box_mass, tool, believed_tool
        Of the box, of what the hand holds, and what the controller believes of that [kg].
    watched
        Body that is recorded as the robot.
    fold_in
        Time from which the hand is drawn into the post [s].
    extra
        More bodies of the world, as MJCF.
    """

    duration: float = 3.0
    timestep: float = 0.002
    delay: float = 0.0
    ground: Ground = field(default_factory=lambda: Ground(mu=0.4, solref=TABLE))
    goal: float = 0.56
    side: float = 0.0
    arrive: float = 2.2
    kp: float = 420.0
    kv: float = 22.0
    limit: float = 60.0
    box_mass: float = 1.2
    tool: float = 0.3
    believed_tool: float = 0.3
    watched: str = "post"
    fold_in: float = np.inf
    extra: str = ""


def mjcf(settings: PusherSettings) -> str:
    """Return the model."""
    s = settings
    servos = "".join(
        f"<position name='servo_{name}' joint='{name}' kp='{s.kp}' kv='{s.kv}' "
        f"forcerange='-{s.limit} {s.limit}'/>"
        for name in JOINTS
    )
    c, n = np.cos(s.ground.slope), np.sin(s.ground.slope)
    box = (START * c + HALF * n, s.side, HALF * c - START * n)
    return f"""<mujoco model='shove'>
<compiler angle='radian'/>
<option timestep='{s.timestep}' cone='elliptic' impratio='10' integrator='implicitfast'/>
<default><joint armature='.02' damping='.4'/><geom friction='.5' rgba='.6 .35 .55 1'/></default>
<worldbody><light pos='0 0 4'/>{s.ground.geoms()}{s.extra}
<geom name='pillar' type='cylinder' size='.05 {POST / 2 - 0.03}' pos='0 0 {POST / 2 - 0.03}'/>
<body name='post' pos='0 0 {POST}'><joint name='pan' axis='0 0 1'/>
<geom name='turret' type='cylinder' size='.045 .03' mass='1.5'/>
<body name='boom'><joint name='lift' axis='0 1 0'/>
<geom name='beam' type='capsule' size='.025' fromto='.06 0 0 {UPPER - 0.03} 0 0' mass='1.2'/>
<body name='forearm' pos='{UPPER} 0 0'><joint name='fold' axis='0 1 0' range='{STRAIGHT} 2.9' limited='true'/>
<geom name='rod' type='capsule' size='.02' fromto='.02 0 0 {FORE - 0.02} 0 0' mass='.8'/>
<body name='hand' pos='{FORE} 0 0'><joint name='drop' axis='0 1 0'/>
<geom name='stem' type='capsule' size='.01' fromto='0 0 0 0 0 -{HAND - 0.03}' mass='{s.tool}'/>
<geom name='pad' type='box' size='.02 .05 .03' pos='0 0 -{HAND}' mass='.1' friction='.05' priority='2'/>
</body></body></body></body>
<body name='parcel' pos='{box[0]} {box[1]} {box[2]}' euler='0 {s.ground.slope} 0'>
<freejoint name='parcel_free'/>
<geom name='carton' type='box' size='{HALF} {HALF} {HALF}' mass='{s.box_mass}' rgba='.7 .6 .3 1'/></body>
</worldbody><actuator>{servos}</actuator></mujoco>"""


class PusherControl:
    """Joint targets by inverse kinematics of a line through the box to its goal."""

    def __init__(self, model: Any, settings: PusherSettings) -> None:
        self.settings = settings
        self.q = np.array([model.joint(name).qposadr[0] for name in JOINTS])
        self.box = int(model.joint("parcel_free").qposadr[0])
        self.level = HALF

    def start(self, data: Any) -> None:
        """Begin behind the box."""
        data.qpos[self.q] = self.angles(*self.hand_at(0.0, data.qpos))
        data.ctrl[:] = data.qpos[self.q]

    def hand_at(self, time: float, q: Any) -> tuple[float, float, float]:
        """Return where the pad's middle is to be (x, y, z) [m]."""
        s = self.settings
        share = min(time / s.arrive, 1.0)
        smooth = share * share * share * (10.0 - 15.0 * share + 6.0 * share * share)
        begin = START - HALF - 0.03
        x = begin + smooth * (s.goal - HALF - 0.02 - begin)
        y = s.side + 0.6 * (q[self.box + 1] - s.side)
        if time > s.fold_in:
            gone = min((time - s.fold_in) / 0.4, 1.0)
            return x - gone * (x - 0.02), y, self.level + 0.12 * gone
        return x, y, self.level

    def angles(self, x: float, y: float, z: float) -> Any:
        """Return the joints' angles (4,) at which the pad is there and the hand hangs down [rad]."""
        out, up = float(np.hypot(x, y)), z + HAND - POST
        reach = float(np.clip(np.hypot(out, up), 0.08, UPPER + FORE - 1e-3))
        beyond = float(np.hypot(out, up)) - reach  # out of reach the angles go on as they came
        inner = np.arccos(np.clip((reach**2 + UPPER**2 - FORE**2) / (2 * reach * UPPER), -1, 1))
        outer = np.arccos(np.clip((UPPER**2 + FORE**2 - reach**2) / (2 * UPPER * FORE), -1, 1))
        lift = -np.arctan2(up, out) - inner
        fold = np.pi - outer - 3.0 * max(beyond, 0.0)
        return np.array([np.arctan2(y, x), lift, fold, -lift - fold])

    def step(self, time: float, q: Any, v: Any) -> Any:
        """Return the targets, raised by what gravity would take of them."""
        s = self.settings
        target = self.angles(*self.hand_at(time, q))
        _, lift, fold, _ = q[self.q]
        upper, fore = UPPER * np.cos(lift), FORE * np.cos(lift + fold)
        hand = s.believed_tool + 0.1
        wrist = 9.81 * (hand * (upper + fore) + 0.8 * (upper + 0.5 * fore) + 1.2 * 0.5 * upper)
        elbow = 9.81 * (hand * fore + 0.8 * 0.5 * fore)
        target[1] -= wrist / s.kp
        target[2] -= elbow / s.kp
        return target

    def fallen(self, data: Any) -> str:
        """See `Control`."""
        R = rotation(data.qpos[self.box + 3 : self.box + 7])
        if R[2, 2] < 0.7:
            return "the box has tipped over"
        x = float(data.qpos[self.box])
        if x > self.settings.goal + 0.12 or abs(data.qpos[self.box + 1] - self.settings.side) > 0.12:
            return f"the box slid off to x = {x:.2f} m, y = {data.qpos[self.box + 1]:.2f} m"
        return ""

    def missed(self, data: Any) -> str:
        """See `Control`."""
        s = self.settings
        x, y, z = data.qpos[self.box : self.box + 3]
        if abs(x - s.goal) > NEAR or abs(y - s.side) > NEAR:
            return f"the box is at x = {x:.3f} m of {s.goal:.3f}, y = {y:.3f} m"
        return f"the box has sunk in by {HALF - z:.3f} m" if z < HALF - 0.008 and not s.ground.slope else ""

    def facts(self) -> dict[str, Any]:
        """See `Control`."""
        arm = self.settings.watched == "post"
        return {"mass_controller": self.settings.believed_tool + LINKS_MASS} if arm else {}

    def command(self) -> Any:
        """See `Control`."""
        return None


def vary(rng: np.random.Generator) -> PusherSettings:
    """Draw a lawful run."""
    return PusherSettings(
        goal=float(rng.uniform(0.5, 0.58)),
        side=float(rng.uniform(-0.03, 0.03)),
        arrive=float(rng.uniform(1.9, 2.4)),
        box_mass=float(rng.uniform(1.0, 1.5)),
        watched="post" if rng.random() < 0.5 else "parcel",
        ground=Ground(mu=float(rng.uniform(0.35, 0.5)), solref=TABLE),
    )
