"""A cube is thrown flat at 6 m/s: on MuJoCo's soft contacts it tumbles, under Coulomb's law it slides.

Run: python examples/27_two_ground_laws.py [ANIMATION.webp]
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.app.viz.film import write_animation
from surefoot.app.viz.palette import GROUND, GROUND_LINE, INK, LINES, PAPER, rgba
from surefoot.worlds.mujoco.mujoco_world import import_mujoco

mujoco = import_mujoco()  # it draws without a screen, too

SIDE, SPEED, MU = 0.05, 6.0, 0.5
"""Half the cube's side [m], its speed [m/s] and friction."""
SIZE, RATE, SECONDS = (720, 300), 20, 1.6
LAWS = {"mj_step": (0.12, LINES[1]), "sf.MujocoStepper": (-0.12, LINES[0])}
"""What steps a cube, how far aside it is drawn [m], and its colour."""
CUBE = f"""<body pos="0 0 {SIDE}"><freejoint/>
<geom type="box" size="{SIDE} {SIDE} {SIDE}" mass="1" friction="{MU}"/></body>"""
MODEL = f"""<mujoco><option cone="elliptic"/><worldbody><geom type="plane" size="9 9 1" friction="{MU}"/>
{CUBE}</worldbody></mujoco>"""
LID = f"{1.004 * SIDE} {1.004 * SIDE} {0.2 * SIDE}"
DRAWN = """<body name="{name}" mocap="true"><geom type="box" size="{side} {side} {side}" rgba="{colour}"/>
<geom type="box" size="{lid}" pos="0 0 {up}" rgba="{paper}"/></body>"""
SCENE = """<mujoco><visual>
<headlight ambient="0.4 0.4 0.4" diffuse="0.4 0.4 0.4"/>
<global offwidth="{width}" offheight="{height}"/>
<quality shadowsize="4096"/></visual>
<asset><texture name="ground" type="2d" builtin="checker" rgb1="{ground}" rgb2="{line}"
width="256" height="256"/><material name="ground" texture="ground" texrepeat="40 40"/>
<texture type="skybox" builtin="flat" rgb1="{paper}" rgb2="{paper}" width="8" height="8"/></asset>
<worldbody><light pos="1.5 -2 4" dir="0 0.4 -1" directional="true" diffuse="0.5 0.5 0.5"/>
<geom type="plane" size="10 10 1" material="ground"/>{cubes}</worldbody></mujoco>"""


def thrown(exact: bool, seconds: float = SECONDS) -> np.ndarray:
    """Return (T, 7) places and rotations of the cube after each step."""
    model = mujoco.MjModel.from_xml_string(MODEL)
    data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
    data.qvel[0] = SPEED
    out = []
    for _ in range(round(seconds / model.opt.timestep)):
        if exact:
            stepper.step(data)
        else:
            mujoco.mj_step(model, data)
        out.append(data.qpos.copy())
    return np.array(out)


def scene() -> Any:
    """Return both cubes, each with a lid of another colour, to be placed by hand."""
    words = {key: " ".join(map(str, rgba(colour))) for key, colour in (("paper", PAPER), ("ground", GROUND))}
    words |= {"line": " ".join(map(str, rgba(GROUND_LINE)[:3])), "ground": words["ground"][: -len(" 1.0")]}
    cubes = "".join(
        DRAWN.format(
            name=name, side=SIDE, lid=LID, up=0.81 * SIDE, colour=" ".join(map(str, rgba(colour))),
            paper=words["paper"],
        )
        for name, (_, colour) in LAWS.items()
    )  # fmt: skip
    words["paper"] = words["paper"][: -len(" 1.0")]
    return mujoco.MjModel.from_xml_string(SCENE.format(width=SIZE[0], height=SIZE[1], cubes=cubes, **words))


def frames_of(runs: dict[str, np.ndarray], step: float = 0.002) -> list[Any]:
    """Return the pictures: both cubes side by side, each with its law above it."""
    from PIL import Image, ImageDraw, ImageFont

    width, height = SIZE
    model, camera, out = scene(), mujoco.MjvCamera(), []
    data = mujoco.MjData(model)
    camera.azimuth, camera.elevation, camera.distance = 20.0, -20.0, 0.75
    large, small = (ImageFont.load_default(size) for size in (22, 16))
    with mujoco.Renderer(model, height, width) as renderer:
        for k in range(0, min(map(len, runs.values())), round(1.0 / RATE / step)):
            for body, (name, (aside, _)) in enumerate(LAWS.items()):
                data.mocap_pos[body] = runs[name][k, :3] + [0.0, aside, 0.0]
                data.mocap_quat[body] = runs[name][k, 3:]
            camera.lookat[:] = np.mean([run[k, 0] for run in runs.values()]), 0.0, 0.1
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, camera)
            picture = Image.fromarray(renderer.render())
            pen = ImageDraw.Draw(picture)
            for at, (name, (_, colour)) in zip((24, width - 220), LAWS.items(), strict=True):
                pen.text((at, 14), name, fill=colour, font=large)
                lift = max(0.0, 1e3 * (runs[name][k, 2] - SIDE))
                pen.text((at, 42), f"{runs[name][k, 0]:.2f} m, {lift:.0f} mm up", fill=INK, font=small)
            out.append(picture)
    return out


def main(animation: Path) -> dict[str, np.ndarray]:
    """Return the ways of both cubes, and draw them."""
    runs = {name: thrown(exact) for name, exact in zip(LAWS, (False, True), strict=True)}
    for name, run in runs.items():
        print(f"{name}: {run[-1, 0]:.2f} m, lifts by {max(0.0, 1e3 * (run[:, 2].max() - SIDE)):.0f} mm")
    closed = SPEED**2 / (2.0 * MU * 9.81)
    print(f"closed form: {closed:.2f} m")
    if animation.exists():
        print(f"{animation} exists already, not drawn again")
        return runs
    try:
        frames = frames_of(runs)
    except Exception as error:  # no OpenGL or Pillow: each backend fails with a class of its own
        print(f"no animation: {error}")
        return runs
    write_animation(frames, animation, RATE)
    print(f"animation: {animation}")
    return runs


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs/27_two_ground_laws.webp"))
