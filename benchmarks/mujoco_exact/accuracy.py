"""What a step does to bodies with a closed form: exact, as MuJoCo is, and as MuJoCo is at its best."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np

import surefoot as sf
from benchmarks.mujoco_exact.dominoes import HIT, dominoes, push, toppling_time
from benchmarks.mujoco_exact.scenes import bodies, box, painleve_rod, pinch, stack, still

STIFF = {"impratio": 100.0, "noslip_iterations": 10}
SETTINGS: dict[str, dict[str, float]] = {
    "MuJoCo": {}, "impratio 10": {"impratio": 10.0}, "impratio 100, noslip 10": STIFF,
    "the same at 0.5 ms": {**STIFF, "timestep": 0.0005},
}  # fmt: skip
"""What is compared beside the exact step: MuJoCo with these options, elliptic cones."""


def runs_compared() -> dict[str, tuple[dict[str, float], bool]]:
    """Return what is compared: options of MuJoCo, and whether the step is exact."""
    return {"exact": ({}, True)} | {name: (dict(options), False) for name, options in SETTINGS.items()}


def follow(
    model: Any, options: dict[str, float], exact: bool, seconds: float, prepare: Callable[[Any], None],
    look: Callable[[Any], object] = still, restitution: float = 0.0,
) -> Any:  # fmt: skip
    """Return the data of a model after some seconds, looked at after each step."""
    for name, value in options.items():
        setattr(model.opt, name, value)
    data = mujoco.MjData(model)
    prepare(data)
    stepper = sf.MujocoStepper(model, restitution=restitution)
    step = stepper.step if exact else (lambda d: mujoco.mj_step(model, d))
    for _ in range(round(seconds / model.opt.timestep)):
        step(data)
        look(data)
    return data


def _slope(options: dict[str, float], exact: bool) -> str:
    """Return the creep on a slope of 0.4 under mu 0.5 [µm/s]."""
    a = np.arctan(0.4)
    model = bodies(box(), option=f'gravity="{9.81 * np.sin(a)} 0 {-9.81 * np.cos(a)}"')
    data = follow(model, options, exact, 2.0, still)
    return f"{1e6 * abs(data.qpos[0]) / 2.0:.2g}"


def _pinched(options: dict[str, float], exact: bool) -> str:
    """Return the creep of a part between two fingers [µm/s]."""
    data = follow(pinch(), options, exact, 2.0, lambda d: d.ctrl.__setitem__(slice(None), (4.0, -4.0)))
    return f"{1e6 * abs(data.qpos[4] - 1.0) / 2.0:.2g}"


def _thrown(options: dict[str, float], exact: bool) -> str:
    """Return the way [m], lift [mm] and largest tilt [°] of a cube that is thrown flat at 6 m/s on mu 0.5."""
    side, lift, tilt = 0.05, [0.0], [0.0]

    def look(data: Any) -> None:
        lift.append(data.qpos[2] - side)
        tilt.append(tilt_of(data.qpos[3:7]))

    model = bodies(box(f"0 0 {side}", f"{side} {side} {side}"))
    data = follow(model, options, exact, 2.0, lambda d: d.qvel.__setitem__(0, 6.0), look)
    return f"{data.qpos[0]:.3f} m, {1e3 * max(lift):.2g} mm, {max(tilt):.2g}°"


def tilt_of(quaternion: Any) -> float:
    """Return the angle between the axis of a (4,) rotation, wxyz, and the vertical [°]."""
    axes = np.zeros(9)
    mujoco.mju_quat2Mat(axes, quaternion)
    return float(np.rad2deg(np.arctan2(np.hypot(axes[2], axes[5]), axes[8])))


def _straight(options: dict[str, float], exact: bool) -> str:
    """Return by how much a flat block misses its closed way along its side [%]."""
    return _way(options, exact, 0.0)


def _diagonal(options: dict[str, float], exact: bool) -> str:
    """Return the same at 45°."""
    return _way(options, exact, 0.25 * np.pi)


def _way(options: dict[str, float], exact: bool, angle: float) -> str:
    """Return by how much a flat block misses its closed way under an angle [%]."""
    speed = 3.0
    model = bodies(box("0 0 0.02", "0.1 0.1 0.02"))
    way = speed * np.cos(angle), speed * np.sin(angle)
    data = follow(model, options, exact, 2.0, lambda d: d.qvel.__setitem__(slice(0, 2), way))
    closed = speed**2 / (2.0 * 0.5 * 9.81) - model.opt.timestep * speed / 2.0
    return f"{100.0 * (np.hypot(*data.qpos[:2]) / closed - 1.0):+.3f}"


def _sunk(options: dict[str, float], exact: bool) -> str:
    """Return how far a stack of six sinks [µm]."""
    data = follow(stack(6), options, exact, 2.0, still)
    return f"{1e6 * max(0.1 + 0.2 * k - data.qpos[7 * k + 2] for k in range(6)):.2g}"


def _spun(options: dict[str, float], exact: bool) -> str:
    """Return by how much a spinning ball misses its closed rate after 0.5 s [%]."""
    ball = (
        '<body pos="0 0 0.1"><freejoint/><geom size="0.1" mass="1" condim="4" friction="0.5 0.01 0"/></body>'
    )
    data = follow(bodies(ball), options, exact, 0.5, lambda d: d.qvel.__setitem__(5, 20.0))
    closed = 20.0 - 0.01 * 9.81 / (0.4 * 0.01) * 0.5
    return f"{100.0 * (data.qvel[5] / closed - 1.0):+.3f}"


def _disc(options: dict[str, float], exact: bool) -> str:
    """Return by how much a disc that turns on its rim's contacts misses its closed rate after 0.1 s [%]."""
    shape = '<geom type="cylinder" size="0.1 0.02" mass="1" friction="0.5"/>'
    model = bodies(f'<body pos="0 0 0.02"><freejoint/>{shape}</body>')
    data = follow(model, options, exact, 0.1, lambda d: d.qvel.__setitem__(5, 20.0))
    closed = 20.0 - 2.0 * 0.5 * 9.81 / 0.1 * 0.1
    return f"{100.0 * (data.qvel[5] / closed - 1.0):+.3f}"


def _rocked(options: dict[str, float], exact: bool) -> str:
    """Return how far a block that leans by 8° leans to the other side after its first impact [°].

    The closed form is Housner's: the moment of momentum about the new edge stays.
    """
    half, high, lean = 0.1, 0.4, np.deg2rad(8.0)
    slender, reach, angles = np.arctan(half / high), np.hypot(half, high), []

    def prepare(data: Any) -> None:
        data.qpos[0] = half - reach * np.sin(slender - lean)
        data.qpos[2] = reach * np.cos(slender - lean)
        data.qpos[3:7] = np.cos(0.5 * lean), 0.0, np.sin(0.5 * lean), 0.0

    def look(data: Any) -> None:
        angles.append(2.0 * np.arctan2(data.qpos[5], data.qpos[3]))

    follow(bodies(box("0 0 0", f"{half} 0.2 {high}", mu=2.0)), options, exact, 1.2, prepare, look)
    return f"{np.rad2deg(-min(angles)):.3f}"


def rocking_lean(half: float = 0.1, high: float = 0.4, lean: float = np.deg2rad(8.0)) -> float:
    """Return the lean after the first impact of a block that rocks from edge to edge [rad].

    G. W. Housner, "The behavior of inverted pendulum structures during earthquakes", Bulletin of the
    Seismological Society of America 53(2), 1963: an impact leaves 1 - 3/2 sin² of the rate.
    """
    slender = np.arctan(half / high)
    rate = 1.0 - 1.5 * np.sin(slender) ** 2
    risen = rate**2 * (np.cos(slender - lean) - np.cos(slender))
    return float(slender - np.arccos(np.cos(slender) + risen))


def _toppled(options: dict[str, float], exact: bool) -> str:
    """Return when the last of eight dominoes is hit [ms]."""
    hit: list[float] = []

    def look(data: Any) -> None:
        if abs(data.qvel[-1]) > HIT:
            hit.append(data.time)

    follow(dominoes(), options, exact, 1.0, push, look)
    return f"{1e3 * hit[0]:.1f}" if hit else "-"


def _jammed(options: dict[str, float], exact: bool) -> str:
    """Return the speed of the tip of Painlevé's rod 10 ms after it met the ground [m/s]."""
    data = follow(painleve_rod(), options, exact, 0.01, lambda d: d.qvel.__setitem__(0, 1.0))
    mujoco.mj_kinematics(data.model, data)
    return f"{data.qvel[0] + data.qvel[2] * (data.site_xpos[0, 2] - data.xpos[1, 2]):.3f}"


def _cradle(options: dict[str, float], exact: bool) -> str:
    """Return the speed of the last of five balls, 5 mm apart, where the first comes at 1 m/s [m/s]."""
    ball = (
        '<body pos="{x} 0 1"><joint type="slide" axis="1 0 0"/>'
        '<geom size="0.05" mass="1" condim="1" solref="-100000 0"/></body>'
    )
    model = bodies(*(ball.format(x=0.105 * k) for k in range(5)))
    data = follow(model, options, exact, 0.1, lambda d: d.qvel.__setitem__(0, 1.0), restitution=1.0)
    return f"{data.qvel[4]:.4f}"


def _energy(options: dict[str, float], exact: bool) -> str:
    """Return the most by which the energy of a box that slides to rest on a slope rises in a step [µJ]."""
    a = np.arctan(0.4)
    model = bodies(box(), option=f'gravity="{9.81 * np.sin(a)} 0 {-9.81 * np.cos(a)}"')
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    found: list[float] = []

    def look(data: Any) -> None:
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        found.append(float(data.energy.sum()))

    follow(model, options, exact, 2.0, lambda d: d.qvel.__setitem__(0, 1.0), look)
    return f"{1e6 * max(0.0, float(np.diff(found).max())):.2g}"


def _walked(options: dict[str, float], exact: bool) -> str:
    """Return the mean speed along the ground of a trotting Go2's feet that carry and do not slide [mm/s]."""
    if "timestep" in options:
        return "-"  # the robot's controller ticks as the world does
    world = sf.MujocoWorld(sf.load_robot("go2"), mu=0.6, exact=exact)
    for name, value in options.items():
        setattr(world.model.opt, name, value)
    walk = sf.WalkingController(world.robot, sf.VelocityCommand.constant(0.5), "trot")
    log = sf.run(world, walk, sf.Scenario(2.0, 0.6))
    forces, speeds = log["forces"], np.linalg.norm(log["contact_velocities"][..., :2], axis=-1)
    carries = forces[..., 2] > 0.1 * 9.81 * world.robot.mass
    sticks = carries & (np.linalg.norm(forces[..., :2], axis=-1) < 0.5 * forces[..., 2])
    return f"{1e3 * speeds[sticks].mean():.2g}"


ACCURACY: dict[str, Callable[[dict[str, float], bool], str]] = {
    "creep on a slope [µm/s]": _slope, "creep of a pinched part [µm/s]": _pinched,
    "cube thrown at 6 m/s (3.664 m, 0 mm, 0°)": _thrown,
    "way of a block at 0° [%]": _straight, "way of a block at 45° [%]": _diagonal,
    "rate of a disc after 0.1 s [%]": _disc, "spin of a ball after 0.5 s [%]": _spun,
    f"lean of a rocking block [°] ({np.rad2deg(rocking_lean()):.3f})": _rocked,
    f"the eighth domino is hit after [ms] ({1e3 * toppling_time():.1f})": _toppled,
    "tip of Painlevé's rod [m/s] (0)": _jammed,
    "the cradle's last ball [m/s] (1)": _cradle,
    "energy rises to rest on a slope by [µJ]": _energy,
    "a stack of six sinks [µm]": _sunk, "stance feet of a Go2 slip [mm/s]": _walked,
}  # fmt: skip
"""Title to what is measured."""
