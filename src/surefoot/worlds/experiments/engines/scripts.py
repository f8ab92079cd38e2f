"""Run by an interpreter that has pydrake or Newton: a scene as JSON comes in, where its bodies were goes out.

Nothing of ours is imported: see `runners.py` for what a scene is.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np


def drake(scene: dict[str, Any]) -> tuple[list[Any], float]:
    """Return places (n + 1, bodies, 3) [m] and the seconds that the steps took."""
    from pydrake import geometry
    from pydrake.math import RigidTransform
    from pydrake.multibody import plant as plants
    from pydrake.multibody.math import SpatialVelocity
    from pydrake.multibody.tree import SpatialInertia
    from pydrake.systems import analysis
    from pydrake.systems.framework import DiagramBuilder

    builder, dt = DiagramBuilder(), scene["dt"]
    cenic = scene["solver"] == "cenic"
    plant, graph = plants.AddMultibodyPlantSceneGraph(builder, 0.0 if cenic else dt)
    config = geometry.SceneGraphConfig()
    if scene["solver"] in ("hydroelastic", "cenic"):
        config.default_proximity_properties.compliance_type = "compliant"
    contact = scene.get("contact", {})
    if "approximation" in contact:
        kind = "k" + contact["approximation"].capitalize()
        plant.set_discrete_contact_approximation(getattr(plants.DiscreteContactApproximation, kind))
    if contact.get("near_rigid") is not None:
        plant.set_sap_near_rigid_threshold(contact["near_rigid"])
    graph.set_config(config)
    plant.mutable_gravity_field().set_gravity_vector(scene["gravity"])
    friction = plants.CoulombFriction(scene["mu"], scene["mu"])
    ground, surface = geometry.ProximityProperties(), geometry.ProximityProperties()
    for side in (ground, surface):
        geometry.AddContactMaterial(friction=friction, properties=side)
        for name, value in contact.get("material", {}).items():
            side.AddProperty("material", name, value)
    if config.default_proximity_properties.compliance_type == "compliant":
        geometry.AddRigidHydroelasticProperties(ground)
    level = RigidTransform()
    plant.RegisterCollisionGeometry(plant.world_body(), level, geometry.HalfSpace(), "ground", ground)
    bodies = []
    for k, given in enumerate(scene["bodies"]):
        size, mass = given["size"], given["mass"]
        shape = geometry.Box(*size) if len(size) == 3 else geometry.Sphere(size[0])
        inertia = SpatialInertia.SolidBoxWithMass(mass, *size) if len(size) == 3 else (
            SpatialInertia.SolidSphereWithMass(mass, size[0]))  # fmt: skip
        bodies.append(plant.AddRigidBody(f"body{k}", inertia))
        plant.RegisterCollisionGeometry(bodies[-1], level, shape, f"shape{k}", surface)
    plant.Finalize()
    if "stiction" in contact:
        plant.set_stiction_tolerance(contact["stiction"])
    simulator = analysis.Simulator(builder.Build())
    if cenic:
        analysis.ApplySimulatorConfig(analysis.SimulatorConfig(integration_scheme="cenic"), simulator)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    for body, given in zip(bodies, scene["bodies"], strict=True):
        plant.SetFreeBodyPose(context, body, RigidTransform(given["place"]))
        plant.SetFreeBodySpatialVelocity(body, SpatialVelocity(np.zeros(3), given["velocity"]), context)
    simulator.Initialize()

    def places() -> list[Any]:
        return [plant.EvalBodyPoseInWorld(context, body).translation().tolist() for body in bodies]

    def step(k: int) -> None:
        simulator.AdvanceTo((k + (1.0 if cenic else 0.5)) * dt)  # just one update, whatever rounding does

    return run_timed(scene, step, places)


def newton(scene: dict[str, Any]) -> tuple[list[Any], float]:
    """Return places (n + 1, bodies, 3) [m] and the seconds that the steps took."""
    import newton as engine
    import warp

    builder = engine.ModelBuilder(gravity=warp.vec3(*scene["gravity"]))
    surface = engine.ModelBuilder.ShapeConfig(mu=scene["mu"], restitution=scene["restitution"], density=0.0)
    builder.add_ground_plane(cfg=surface)
    for given in scene["bodies"]:
        size, mass = np.array(given["size"]), given["mass"]
        squares = size**2 if len(size) == 3 else np.full(3, 2.4 * size[0] ** 2)
        moments = np.diag(mass / 12.0 * (squares.sum() - squares))
        at = warp.transform(warp.vec3(*given["place"]), warp.quat_identity())
        body = builder.add_body(xform=at, mass=mass, inertia=warp.mat33(*moments.ravel().tolist()))
        half = dict(zip(("hx", "hy", "hz"), (0.5 * size).tolist(), strict=False))
        if len(size) == 3:
            builder.add_shape_box(body, **half, cfg=surface)
        else:
            builder.add_shape_sphere(body, radius=float(size[0]), cfg=surface)
    with warp.ScopedDevice("cpu"):
        model = builder.finalize()
        solver = getattr(engine.solvers, "Solver" + scene["solver"])(model)
        state, after, control = model.q_v(), model.q_v(), model.control()
        pipeline = engine.CollisionPipeline(model)
        contacts = pipeline.contacts()
        speeds = np.array([[*given["velocity"], 0.0, 0.0, 0.0] for given in scene["bodies"]])
        state.body_qd.assign(speeds)
        state.joint_qd.assign(speeds.ravel())
        both = [state, after]

        def step(k: int) -> None:
            both[0].clear_forces()
            pipeline.collide(both[0], contacts)
            solver.step(both[0], both[1], control, contacts, scene["dt"])
            both.reverse()

        return run_timed(scene, step, lambda: both[0].body_q.numpy()[:, :3].tolist())


def run_timed(
    scene: dict[str, Any], step: Callable[[int], object], places: Callable[[], list[Any]]
) -> tuple[list[Any], float]:
    """Return places before the first and after every step, and what the steps but the first took [s]."""
    out, spent, until = [places()], 0.0, scene.get("until", np.inf)
    for k in range(scene["steps"]):
        begin = time.process_time()
        step(k)
        spent += time.process_time() - begin if k else 0.0  # the first may compile
        out.append(places())
        if out[-1][0][2] > max(until, out[-2][0][2]):
            break
    return out, spent * scene["steps"] / max(scene["steps"] - 1, 1)


if __name__ == "__main__":
    given = json.load(sys.stdin)
    found = {"drake": drake, "newton": newton}[given["engine"]](given)
    print("\n" + json.dumps(found))
