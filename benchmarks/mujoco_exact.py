"""MuJoCo's step beside the exact one: what each costs, and what each does to bodies with a closed form.

    python -m benchmarks.mujoco_exact [--quick]

Price is CPU time of the thread, both steps in turn in one run; MuJoCo has elliptic cones and its own settings
otherwise. Accuracy is also asked of MuJoCo's best: impratio 100 and ten iterations without slip.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import typer

import surefoot as sf
from benchmarks.printing import show, table

BOX = (
    '<body pos="{at}"><freejoint/>'
    '<geom type="box" size="{size}" mass="{mass}" friction="{mu}" condim="{dim}"/></body>'
)
SETTINGS = {"MuJoCo": {}, "MuJoCo, impratio 100, noslip 10": {"impratio": 100.0, "noslip_iterations": 10}}
"""What is compared beside the exact step."""
QUICK, WHOLE = 400, 3000
"""Steps of a price."""
HOLD, SLOW = 2.0, 0.02
"""Stiffness of a joint over the weight [m/rad], and its damping over the stiffness [s]."""
GRASP = 0.03
"""Half the width of what is pinched [m]."""


def bodies(*parts: str, option: str = "", extra: str = "", mu: float = 0.5) -> Any:
    """Return a model of bodies over a plane, elliptic cones."""
    floor = f'<geom type="plane" size="99 99 1" friction="{mu}"/>'
    world = f"<worldbody>{floor}{''.join(parts)}</worldbody>"
    text = f'<mujoco><option cone="elliptic" {option}/>{world}{extra}</mujoco>'
    return mujoco.MjModel.from_xml_string(text)


def box(
    at: str = "0 0 0.1", size: str = "0.1 0.1 0.1", mass: float = 1.0, mu: float = 0.5, dim: int = 3
) -> str:
    """Return a free box."""
    return BOX.format(at=at, size=size, mass=mass, mu=mu, dim=dim)


def stack(count: int) -> Any:
    """Return boxes on each other."""
    return bodies(*(box(f"0 0 {0.1 + 0.2 * k}") for k in range(count)))


def pinch() -> Any:
    """Return a part between two fingers on slides, pressed by motors, off the ground."""
    finger = (
        '<body pos="{x} 0 1"><joint name="{n}" type="slide" axis="1 0 0" damping="5"/>'
        '<geom type="sphere" size="0.02" mass="0.1" friction="1" condim="4"/></body>'
    )
    left = finger.format(x=-GRASP - 0.02, n="left")
    right = finger.format(x=GRASP + 0.02, n="right")
    part = box("0 0 1", f"{GRASP} {GRASP} {GRASP}", mass=0.1, mu=1.0, dim=4)
    return bodies(
        left, right, part,
        extra='<actuator><motor joint="left"/><motor joint="right"/></actuator>',
    )  # fmt: skip


def hand() -> Any:
    """Return a ball in a cup of 32 small spheres on dry slides."""
    parts = []
    for k in range(32):
        angle, height = 2.0 * np.pi * (k % 16) / 16, 0.05 + 0.05 * (k // 16)
        x, y = 0.12 * np.cos(angle), 0.12 * np.sin(angle)
        parts.append(
            f'<body pos="{x:.6f} {y:.6f} {height}"><joint type="slide" axis="{-x:.6f} {-y:.6f} 0" '
            'stiffness="50" springref="0.03" damping="2"/>'
            '<geom size="0.02" mass="0.02" contype="2" conaffinity="1"/></body>'
        )
    ball = (
        '<body pos="0 0 0.1"><freejoint/>'
        '<geom type="sphere" size="0.1" mass="1" contype="1" conaffinity="3"/></body>'
    )
    return bodies(*parts, ball)


def robot(name: str) -> tuple[Any, Any]:
    """Return the model of a robot that its joints' springs hold, and its start."""
    world = sf.MujocoWorld(sf.load_robot(name), mu=0.7)
    model, start = world.model, world.data
    joints, weight = world.robot.joints, world.robot.mass * 9.81
    # springs at the joints and damping that Euler's method takes implicitly: explicit
    # control of wrists is not stable
    model.jnt_stiffness[-joints:], model.qpos_spring[-joints:] = HOLD * weight, start.qpos[-joints:]
    model.dof_damping[-joints:] = SLOW * HOLD * weight
    return model, start


def _still(data: Any) -> None:
    """Ask nothing of the motors."""


def _press(data: Any) -> None:
    """Press both fingers with 4 N."""
    data.ctrl[:] = 4.0, -4.0


@dataclass(frozen=True)
class Price:
    """CPU time of a step [µs]: median and 99th percentile, exact and MuJoCo's, and what was not solved."""

    name: str
    exact: tuple[float, float]
    soft: tuple[float, float]
    unsolved: int
    steps: int

    @property
    def allowed(self) -> float:
        """The larger of three times MuJoCo's median and 30 µs more."""
        return max(3.0 * self.soft[0], self.soft[0] + 30.0)


def price(name: str, model: Any, control: Callable[[Any], None], steps: int, start: Any = None) -> Price:
    """Return what both steps cost in the same loop."""
    stepper = sf.MujocoStepper(model)
    both = [mujoco.MjData(model) for _ in range(2)]
    for data in both:
        if start is not None:
            data.qpos[:], data.qvel[:] = start.qpos, start.qvel
    ways: tuple[Callable[[Any], None], ...] = (stepper.step, lambda data: mujoco.mj_step(model, data))
    taken = np.zeros((2, steps))
    for k in range(steps):
        for way in range(2):
            control(both[way])
            begin = time.thread_time_ns()
            ways[way](both[way])
            taken[way, k] = time.thread_time_ns() - begin
    late = taken[:, steps // 10 :] / 1e3
    numbers = [(float(np.median(row)), float(np.percentile(row, 99))) for row in late]
    return Price(name, numbers[0], numbers[1], stepper.unsolved, steps)


def prices(quick: bool) -> Iterator[Price]:
    """Yield the prices of all scenes."""
    steps = QUICK if quick else WHOLE
    for name in ("go2", "g1"):
        model, start = robot(name)
        yield price(f"{name} standing", model, _still, steps, start)
    yield price("pinch", pinch(), _press, steps)
    for count in (1, 3, 6, 10):
        yield price(f"stack of {count}", stack(count), _still, steps if count < 10 else steps // 4)
    yield price("hand of 32 contacts", hand(), _still, steps)


def _runs() -> dict[str, tuple[dict[str, float], bool]]:
    """Return what is compared: options of MuJoCo, and whether the step is exact."""
    return {"exact": ({}, True)} | {name: (dict(options), False) for name, options in SETTINGS.items()}


def follow(
    model: Any, options: dict[str, float], exact: bool, seconds: float, prepare: Callable[[Any], None]
) -> Any:
    """Return the data of a model after some seconds."""
    for name, value in options.items():
        setattr(model.opt, name, value)
    data = mujoco.MjData(model)
    prepare(data)
    step = sf.MujocoStepper(model).step if exact else (lambda d: mujoco.mj_step(model, d))
    for _ in range(round(seconds / model.opt.timestep)):
        step(data)
    return data


def _slope(options: dict[str, float], exact: bool) -> str:
    """Return the creep on a slope of 0.4 under mu 0.5 [µm/s]."""
    a = np.arctan(0.4)
    model = bodies(box(), option=f'gravity="{9.81 * np.sin(a)} 0 {-9.81 * np.cos(a)}"')
    data = follow(model, options, exact, 2.0, _still)
    return f"{1e6 * abs(data.qpos[0]) / 2.0:.2g}"


def _pinched(options: dict[str, float], exact: bool) -> str:
    """Return the creep of a part between two fingers [µm/s]."""
    data = follow(pinch(), options, exact, 2.0, lambda d: d.ctrl.__setitem__(slice(None), (4.0, -4.0)))
    return f"{1e6 * abs(data.qpos[4] - 1.0) / 2.0:.2g}"


def _thrown(options: dict[str, float], exact: bool) -> str:
    """Return the way [m] and the tilt [°] of a cube that is thrown flat at 6 m/s on mu 0.5."""
    data = follow(bodies(box()), options, exact, 2.0, lambda d: d.qvel.__setitem__(0, 6.0))
    upright = np.zeros(9)
    mujoco.mju_quat2Mat(upright, data.qpos[3:7])
    return f"{data.qpos[0]:.3f} m, {np.rad2deg(np.arccos(min(1.0, upright[8]))):.2g}°"


def _diagonal(options: dict[str, float], exact: bool) -> str:
    """Return by how much a flat block misses its closed way at 45° [%]."""
    speed = 3.0
    model = bodies(box("0 0 0.02", "0.1 0.1 0.02"))
    turn = speed / np.sqrt(2.0)
    data = follow(model, options, exact, 2.0, lambda d: d.qvel.__setitem__(slice(0, 2), (turn, turn)))
    closed = speed**2 / (2.0 * 0.5 * 9.81) - model.opt.timestep * speed / 2.0
    return f"{100.0 * (np.hypot(*data.qpos[:2]) / closed - 1.0):+.3f}"


def _sunk(options: dict[str, float], exact: bool) -> str:
    """Return how far a stack of six sinks [µm]."""
    data = follow(stack(6), options, exact, 2.0, _still)
    return f"{1e6 * max(0.1 + 0.2 * k - data.qpos[7 * k + 2] for k in range(6)):.2g}"


def _spun(options: dict[str, float], exact: bool) -> str:
    """Return by how much a spinning ball misses its closed rate after 0.5 s [%]."""
    ball = (
        '<body pos="0 0 0.1"><freejoint/><geom size="0.1" mass="1" condim="4" friction="0.5 0.01 0"/></body>'
    )
    data = follow(bodies(ball), options, exact, 0.5, lambda d: d.qvel.__setitem__(5, 20.0))
    closed = 20.0 - 0.01 * 9.81 / (0.4 * 0.01) * 0.5
    return f"{100.0 * (data.qvel[5] / closed - 1.0):+.3f}"


ACCURACY: dict[str, Callable[[dict[str, float], bool], str]] = {
    "creep on a slope [µm/s]": _slope, "creep of a pinched part [µm/s]": _pinched,
    "cube thrown at 6 m/s (3.664 m, 0°)": _thrown, "way of a block at 45° [%]": _diagonal,
    "a stack of six sinks [µm]": _sunk, "spin after 0.5 s [%]": _spun,
}  # fmt: skip
"""Title to what is measured."""


def main(quick: bool = False, as_json: bool = typer.Option(False, "--json")) -> None:
    """Print the tables of price and accuracy."""
    found = list(prices(quick))
    rows = [
        [
            p.name, f"{p.exact[0]:.1f}", f"{p.exact[1]:.0f}", f"{p.soft[0]:.1f}", f"{p.soft[1]:.0f}",
            f"{p.exact[0] / p.soft[0]:.1f}", f"{p.allowed:.0f}", f"{p.unsolved} of {p.steps}",
        ]
        for p in found
    ]  # fmt: skip
    head = ["scene", "exact [µs]", "p99", "mj_step [µs]", "p99", "ratio", "allowed", "unsolved"]
    kinds = _runs()
    accurate = [[name, *(measure(*kind) for kind in kinds.values())] for name, measure in ACCURACY.items()]
    show(
        [
            table(head, rows, "CPU time of a step, median and 99th percentile"),
            table(["what", *kinds], accurate, "accuracy at 2 ms, MuJoCo with elliptic cones"),
        ],
        as_json,
    )


if __name__ == "__main__":
    typer.run(main)
