"""Scenes of boxes and balls, run in engines by their own shapes and words.

A scene is plain data: bodies (a box's `size` has three edges [m], a ball's its radius), gravity in the axes
of the ground, friction, restitution where an engine knows one, step and steps; `contact` are numbers of the
ground in an engine's own words, none its defaults. `until` ends a run when the first body rises above that
height. What an engine does not know it is not given.
"""

from __future__ import annotations

import contextlib
import io
import json
import math
import os
import subprocess
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.errors import MissingExtra, ModelError
from surefoot.base.spatial import quaternion_about
from surefoot.mechanics import Box, SlopeTerrain, Sphere
from surefoot.worlds.drake import drake_python
from surefoot.worlds.experiments.engines.scripts import run_timed
from surefoot.worlds.mujoco.spec import import_mujoco
from surefoot.worlds.mujoco.stepper.stepper import MujocoStepper
from surefoot.worlds.rigid.scene import Body, Scene, SceneWorld

NEWTON_PYTHON = "SUREFOOT_NEWTON_PYTHON"
"""Names an interpreter that has the package newton."""


def rigid(scene: dict[str, Any]) -> tuple[list[Any], float]:
    """Run ours, on a slope where the others turn gravity."""
    slope = SlopeTerrain(-scene["tilt"])
    R, bodies = slope.frame([0.0, 0.0]), []
    x, y, z, w = quaternion_about([0.0, 1.0, 0.0], math.atan2(R[0, 2], R[2, 2])).tolist()
    for k, given in enumerate(scene["bodies"]):
        shape = Box(tuple(given["size"])) if len(given["size"]) == 3 else Sphere(given["size"][0])
        place, speed = (tuple((R @ np.array(given[name])).tolist()) for name in ("place", "velocity"))
        bodies.append(Body(f"body{k}", shape, given["mass"], place, (x, y, z, w), speed))
    world = SceneWorld(Scene(bodies), slope, scene["mu"], scene["dt"], restitution=scene["restitution"])
    names = [body.name for body in bodies]
    return run_timed(
        scene, lambda _: world.step(), lambda: [R.T @ world.pose(name).position for name in names]
    )


def _mujoco_model(scene: dict[str, Any]) -> Any:
    """Return MuJoCo's model: its defaults, or a contact's words on an elliptic cone, solved to the end."""
    surface, option, contact = f'friction="{scene["mu"]}" ', "", scene.get("contact")
    if contact is not None:
        surface += "".join(f'{name}="{" ".join(f"{x!r}" for x in contact[name])}" ' for name in contact)
        option = 'cone="elliptic" tolerance="0" iterations="50"'
    if scene["mu"] == 0.0:
        surface += 'condim="1" '
    bodies = ""
    for given in scene["bodies"]:
        kind, scale = ("box", 0.5) if len(given["size"]) == 3 else ("sphere", 1.0)
        size, place = (" ".join(map(repr, x)) for x in ([scale * x for x in given["size"]], given["place"]))
        shape = f'<geom type="{kind}" size="{size}" mass="{given["mass"]!r}" {surface}/>'
        bodies += f'<body pos="{place}"><freejoint/>{shape}</body>'
    gravity = " ".join(map(repr, scene["gravity"]))
    return import_mujoco().MjModel.from_xml_string(
        f'<mujoco><option timestep="{scene["dt"]!r}" gravity="{gravity}" {option}/><worldbody>'
        f'<geom type="plane" size="9 9 1" {surface}/>{bodies}</worldbody></mujoco>'
    )


def mujoco(scene: dict[str, Any], mjx: bool = False, exact: bool = False) -> tuple[list[Any], float]:
    """Run MuJoCo, its model in MJX, or MuJoCo with Coulomb's law in place of its own."""
    library, model = import_mujoco(), _mujoco_model(scene)
    data = library.MjData(model)
    for k, given in enumerate(scene["bodies"]):
        data.qvel[6 * k : 6 * k + 3] = given["velocity"]
    if exact:
        model.opt.cone = library.mjtCone.mjCONE_ELLIPTIC
    if not mjx:
        own = MujocoStepper(model, restitution=scene["restitution"]).step if exact else None
        step = own or partial(library.mj_step, model)
        return run_timed(scene, lambda _: step(data), lambda: data.qpos.reshape(-1, 7)[:, :3].tolist())
    jax, engine = _import_mjx()
    held = [engine.put_data(model, data)]
    step, on_device = jax.jit(engine.step), engine.put_model(model)

    def forward(_: int) -> None:
        held[0] = step(on_device, held[0])
        held[0].qpos.block_until_ready()

    return run_timed(scene, forward, lambda: np.asarray(held[0].qpos).reshape(-1, 7)[:, :3].tolist())


def _import_mjx() -> Any:
    """Return JAX and MJX, in double precision."""
    try:
        import jax

        with contextlib.redirect_stdout(io.StringIO()):  # it prints which back ends are not here
            from mujoco import mjx
    except ImportError as error:
        raise MissingExtra("mujoco-mjx", "mjx") from error
    jax.config.update("jax_enable_x64", True)
    return jax, mjx


def bullet(scene: dict[str, Any]) -> tuple[list[Any], float]:
    """Run Bullet, which multiplies frictions and restitutions."""
    from surefoot.worlds.bullet.bullet_world import import_bullet

    library = import_bullet()
    here = {"physicsClientId": library.connect(library.DIRECT)}
    try:
        library.setGravity(*scene["gravity"], **here)
        library.setPhysicsEngineParameter(fixedTimeStep=scene["dt"], **here)
        ground = library.createMultiBody(
            0.0, library.createCollisionShape(library.GEOM_PLANE, **here), **here
        )
        surface = {"restitution": math.sqrt(scene["restitution"]), "lateralFriction": math.sqrt(scene["mu"])}
        library.changeDynamics(ground, -1, **surface, **here)
        made = []
        for given in scene["bodies"]:
            size = given["size"]
            words = {"halfExtents": [0.5 * x for x in size]} if len(size) == 3 else {"radius": size[0]}
            kind = library.GEOM_BOX if len(size) == 3 else library.GEOM_SPHERE
            shape = library.createCollisionShape(kind, **words, **here)
            made.append(library.createMultiBody(given["mass"], shape, -1, given["place"], **here))
            library.changeDynamics(made[-1], -1, **surface, **here)
            library.resetBaseVelocity(made[-1], given["velocity"], **here)

        def places() -> list[Any]:
            return [library.getBasePositionAndOrientation(body, **here)[0] for body in made]

        return run_timed(scene, lambda _: library.stepSimulation(**here), places)
    finally:
        library.disconnect(**here)


def elsewhere(scene: dict[str, Any], engine: str, solver: str = "") -> tuple[list[Any], float]:
    """Run an engine in a process of its own, see `scripts.py`."""
    if engine == "drake" and not drake_python.present():
        raise MissingExtra(drake_python.PACKAGE, drake_python.EXTRA)
    python = drake_python.interpreter() if engine == "drake" else os.environ.get(NEWTON_PYTHON, "")
    script = Path(__file__).with_name("scripts.py")
    task = json.dumps({**scene, "engine": engine, "solver": solver})
    done = subprocess.run([python, str(script)], input=task, capture_output=True, text=True, check=False)
    if done.returncode:
        why = done.stderr.strip().splitlines() or ["it ended"]
        raise ModelError(f"{engine}'s run failed: {why[-1][:200]}")
    places, seconds = json.loads(done.stdout.splitlines()[-1])
    return places, float(seconds)
