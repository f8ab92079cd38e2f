"""Pictures of a logged run: the robot drawn by MuJoCo, with its contact forces as arrows; `film` joins them.

The physics is long over when this runs: configurations and forces are read from the log. Rendering
needs an OpenGL that works without a screen (EGL or OSMesa); `Renderer` says in one line why not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from surefoot.app.viz import palette
from surefoot.app.viz.meshes import add_meshes
from surefoot.app.viz.palette import rgba
from surefoot.app.viz.shapes import bones, cone_rim
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import SurefootError, one_line
from surefoot.base.spatial import quaternion_wxyz
from surefoot.mechanics import GroundBox, Robot, Terrain
from surefoot.records import Log
from surefoot.worlds.mujoco.mujoco_world import add_ground, import_mujoco, robot_spec

WIDTH, HEIGHT = 1280, 720
ARROW_LENGTH = 1.2
"""Length of the arrow of a force of m g, in base heights."""
FORCE_COLOUR, PUSH_COLOUR = rgba(palette.FORCE), rgba(palette.PUSH)

BONE_COLOUR = (0.25, 0.28, 0.32, 1.0)
LIGHTEST = 1e-6
"""Mass [kg] and inertia [kg m2] of a link that has none, in a model that is only drawn."""
POINT_SIZE = 0.012
"""Radius of the ball that stands for a foot without one [m]."""
ARROW_WIDTH, BONE_WIDTH = 0.03, 0.0225
"""Of the shafts of arrows and of bones, in base heights."""
LINE_WIDTH = 0.0025
"""Of other lines, as a share of the picture's height: lines have no shadow."""
CONE_COLOUR = rgba(palette.CONE, 0.55)
EDGE_COLOUR = (0.35, 0.33, 0.3, 1.0)
SUN, SUN_RADIUS, SUNLIGHT = np.array([1.0, -1.5, 4.0]), 0.2, 0.45
"""Place of the light from what the camera looks at, its radius [m], and its strength."""
LAG = 0.3
"""Time in which camera and light make up for 63 % of their distance to the robot [s]."""

Arrow: TypeAlias = tuple[FloatArray, FloatArray, tuple[float, ...]]
"""Start and vector in world axes [m], colour (red, green, blue, opacity)."""


class RenderError(SurefootError, RuntimeError):
    """No picture could be drawn; the message says why."""


class Renderer:
    """Draws a robot on its terrain, off screen.

    Parameters
    ----------
    robot, terrain
        Who and on what.
    width, height
        Size of a frame [pixels].
    fine
        Whether to draw smooth edges and softer shadows, at five times the cost.

    Attributes
    ----------
    size
        Height of the base, which arrows and the camera go by [m].
    focus
        (3,) what camera and light are at [m]; None before the first picture.

    Raises
    ------
    RenderError
        If there is no OpenGL to draw with.
    """

    def __init__(
        self, robot: Robot, terrain: Terrain, width: int = WIDTH, height: int = HEIGHT, fine: bool = False
    ) -> None:
        mujoco = self._mujoco = import_mujoco()
        spec = drawn_spec(robot, terrain, width, height, FINE if fine else QUICK)
        self.robot = robot
        try:
            self.model = spec.compile()
        except ValueError as error:
            said = one_line(error)
            raise RenderError(f"no pictures: MuJoCo cannot draw {robot.name} ({said:.120})") from error
        self.data = mujoco.MjData(self.model)
        try:
            self._renderer = mujoco.Renderer(self.model, height, width)
        except Exception as error:  # each GL backend fails with a class of its own
            reason = one_line(error) or type(error).__name__
            raise RenderError(f"no pictures: MuJoCo found no OpenGL to draw with ({reason:.120})") from error
        scene = self._renderer.scene
        scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
        scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 1
        self._camera = mujoco.MjvCamera()
        self._height = height
        self._lights = np.array(self.model.light_pos)
        self.focus: FloatArray | None = None
        self.size = float(robot.nominal[2]) if robot.floating else 0.5
        self._camera.distance = 4.2 * self.size
        self._camera.azimuth, self._camera.elevation = 140.0, -14.0

    def frame(
        self, q: FloatArray, arrows: list[Arrow], lines: Sequence[Arrow] = (), elapsed: float = math.inf
    ) -> Any:
        """Return the picture (height, width, 3) of a configuration, arrows and lines.

        Parameters
        ----------
        q
            (nq,) [m, -, rad].
        arrows, lines
            Drawn beside the robot.
        elapsed
            Since the last picture [s], which camera and light follow with a lag; without it they are there.
        """
        self.data.qpos[:] = q
        if self.robot.floating:
            self.data.qpos[3:7] = quaternion_wxyz(q[3:7])
        self._mujoco.mj_kinematics(self.model, self.data)
        middle = np.array(q[:3]) if self.robot.floating else self.data.xpos[1:].mean(axis=0)
        self.focus = middle if self.focus is None else follow(self.focus, middle, elapsed)
        self.model.light_pos[:] = self._lights + self.focus
        self._mujoco.mj_forward(self.model, self.data)
        self._camera.lookat[:] = self.focus - [0.0, 0.0, 0.45 * self.size]
        self._renderer.update_scene(self.data, self._camera)
        ends = np.zeros((0, 2, 3)) if self.robot.visual.ngeoms else bones(self.robot, q)
        sticks = [(a, b - a, BONE_COLOUR) for a, b in ends]
        for line, drawn in ((False, arrows), (True, [*lines, *sticks])):
            for start, vector, colour in drawn:
                self._arrow(start, vector, colour, line)
        return self._renderer.render()

    def _arrow(self, start: FloatArray, vector: FloatArray, colour: tuple[float, ...], line: bool) -> None:
        scene, mujoco = self._renderer.scene, self._mujoco
        if scene.ngeom >= scene.maxgeom or float(np.linalg.norm(vector)) < 1e-3 * self.size:
            return
        geom = scene.geoms[scene.ngeom]
        kinds = mujoco.mjtGeom
        if not line:
            kind, width = kinds.mjGEOM_ARROW, ARROW_WIDTH * self.size
        elif colour == BONE_COLOUR:
            kind, width = kinds.mjGEOM_CAPSULE, BONE_WIDTH * self.size
        else:
            kind, width = kinds.mjGEOM_LINE, max(1.0, LINE_WIDTH * self._height)  # pixels
        shade = np.array(colour, np.float32)
        mujoco.mjv_initGeom(geom, kind, np.zeros(3), np.zeros(3), np.eye(3).ravel(), shade)
        length = 1.0 if line else 2.0  # MuJoCo draws an arrow half as long as its connector
        mujoco.mjv_connector(geom, kind, width, start, start + length * vector)
        scene.ngeom += 1

    def close(self) -> None:
        """Free the OpenGL context."""
        self._renderer.close()


def follow(focus: FloatArray, place: FloatArray, elapsed: float) -> FloatArray:
    """Return where a focus is that follows a place with the lag `LAG`, so many seconds [s] later (3,) [m]."""
    return np.asarray(place + math.exp(-elapsed / LAG) * (focus - place))


class PictureQuality(NamedTuple):
    """What pictures cost: samples of each pixel, lights beside each other, points along a shadow's map.

    Each light's shadow is sharp: their sum is soft at its border.
    """

    samples: int
    lights: int
    shadow_points: int


QUICK, FINE = PictureQuality(0, 2, 2048), PictureQuality(4, 5, 4096)
"""Of films, and of single pictures."""


def drawn_spec(
    robot: Robot, terrain: Terrain, width: int = WIDTH, height: int = HEIGHT,
    quality: PictureQuality = QUICK,
) -> Any:  # fmt: skip
    """Return an MjSpec of a robot with its meshes on its terrain, in light: to be drawn, not simulated.

    Parameters
    ----------
    robot, terrain
        Who and on what.
    width, height, quality
        Of pictures that are drawn off screen: size [pixels], and what they cost.
    """
    mujoco, spec = import_mujoco(), robot_spec(robot)
    add_ground(spec, terrain, 1.0)
    add_meshes(spec, robot)
    spec.visual.global_.offwidth, spec.visual.global_.offheight = width, height
    _add_light(mujoco, spec, quality)
    spec.stat.extent = 3.0  # what is drawn lies between 0.01 and 50 times this from the camera [m]
    for geom in spec.geoms:  # a foot that is a point is drawn as a small ball
        if geom.type == mujoco.mjtGeom.mjGEOM_SPHERE and geom.size[0] <= 0.0:
            geom.size[0] = POINT_SIZE
    spec.compiler.boundmass = spec.compiler.boundinertia = LIGHTEST  # links without mass are drawn, too
    return spec


def _add_light(mujoco: Any, spec: Any, quality: PictureQuality) -> None:
    """Add light, sky and a checked ground."""
    spec.visual.quality.offsamples = quality.samples
    spec.visual.quality.shadowsize = quality.shadow_points
    spec.visual.headlight.ambient = [0.42, 0.42, 0.42]
    spec.visual.headlight.diffuse = [0.30, 0.30, 0.30]
    spec.visual.headlight.specular = [0.05, 0.05, 0.05]
    for k in range(quality.lights):  # from all sides of one place above: a sun that is not a point
        angle = 2.0 * math.pi * k / quality.lights
        aside = SUN_RADIUS * np.array([math.cos(angle), math.sin(angle), 0.0])
        spec.worldbody.add_light(
            pos=SUN + aside, dir=-(SUN + aside), diffuse=[SUNLIGHT / quality.lights] * 3,
            specular=[0.1 / quality.lights] * 3, type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        )  # fmt: skip
    spec.add_texture(
        name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.93, 0.95, 0.97], rgb2=[0.74, 0.80, 0.86], width=64, height=64,
    )  # fmt: skip
    spec.add_texture(
        name="floor", type=mujoco.mjtTexture.mjTEXTURE_2D, builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=[0.91, 0.89, 0.85], rgb2=[0.84, 0.82, 0.77], width=256, height=256,
    )  # fmt: skip
    material = spec.add_material(name="floor", texuniform=True, texrepeat=[2.0, 2.0])
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "floor"
    ground = [geom for geom in spec.geoms if geom.name.startswith("ground")]
    for k, geom in enumerate(ground):  # treads alternate, so that they can be told apart
        tint = 0.87 if k % 2 else 1.0
        geom.material, geom.rgba = "floor", [tint, tint, tint, 1.0]


def log_arrows(log: Log, step: int, terrain: Terrain, scale: float) -> list[Arrow]:
    """Return the arrows of one step's measured forces; `scale` is the length of a newton [m/N]."""
    pairs = zip(log["contact_positions"][step], log["forces"][step], strict=True)
    return [(place, scale * terrain.frame(place[:2]) @ force, FORCE_COLOUR) for place, force in pairs]


def cone_lines(
    log: Log, step: int, terrain: Terrain, height: float | FloatArray, rays: int = 24, every: int = 1
) -> list[Arrow]:
    """Return the friction cones of the loaded contacts as lines.

    Parameters
    ----------
    log, step, terrain
        Whose contacts, when, on what.
    height
        Of the cones along the normal [m]: a number, or (p,) one for each contact.
    rays, every
        Sides of the polygon that stands for a rim; a line from the apex goes to each so many of its corners.
    """
    lines: list[Arrow] = []
    places, loads = log["contact_positions"][step], log["forces"][step][:, 2]
    heights = np.broadcast_to(height, loads.shape)
    for k in np.flatnonzero(loads > 0.0):
        rim = cone_rim(float(log["mu"][step]), float(heights[k]), terrain.frame(places[k, :2]), rays)
        lines += [(places[k], edge, CONE_COLOUR) for edge in rim[:-1:every]]
        lines += [(places[k] + a, b - a, CONE_COLOUR) for a, b in pairwise(rim)]
    return lines


def edge_lines(terrain: Terrain) -> list[Arrow]:
    """Return the upper edges of the ground's boxes, so that steps can be told apart."""
    lines: list[Arrow] = []
    for shape in terrain.shapes():
        if isinstance(shape, GroundBox):
            x, y, z = 0.5 * shape.size
            corners = shape.centre + np.array([[x, y, z], [x, -y, z], [-x, -y, z], [-x, y, z], [x, y, z]])
            lines += [(a, b - a, EDGE_COLOUR) for a, b in pairwise(corners)]
    return lines
