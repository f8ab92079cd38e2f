"""Run by an interpreter that has pydrake: a task in as JSON, the track out; it imports nothing of ours."""

from __future__ import annotations

import json
import sys
from typing import Any


def track(task: dict[str, Any]) -> dict[str, list[float]]:
    """Return gaps [m] and speeds [m/s] of a mass on a slide over a half-space."""
    import numpy as np
    from pydrake.geometry import HalfSpace, ProximityProperties, Sphere
    from pydrake.math import RigidTransform
    from pydrake.multibody.plant import (
        AddMultibodyPlantSceneGraph,
        CoulombFriction,
        DiscreteContactApproximation,
    )
    from pydrake.multibody.tree import PrismaticJoint, SpatialInertia, UnitInertia
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder

    settings, radius = task["settings"], 1.0
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, task["dt"])
    approximation = settings["discrete_contact_approximation"]
    kind = getattr(DiscreteContactApproximation, "k" + approximation.capitalize())
    plant.set_discrete_contact_approximation(kind)
    if approximation == "sap":
        plant.set_sap_near_rigid_threshold(0.0)
    body = plant.AddRigidBody(
        "mass", SpatialInertia(task["mass"], np.zeros(3), UnitInertia.SolidSphere(radius))
    )
    plant.AddJoint(PrismaticJoint("slide", plant.world_frame(), body.body_frame(), [0, 0, 1]))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -task["gravity"]])
    shapes = ((plant.world_body(), HalfSpace()), (body, Sphere(radius)))
    for owner, shape in shapes:
        properties = ProximityProperties()
        for name, value in settings["each_body"].items():
            properties.AddProperty("material", name, value)
        properties.AddProperty("material", "coulomb_friction", CoulombFriction(0.5, 0.5))
        plant.RegisterCollisionGeometry(owner, RigidTransform(), shape, f"{shape}", properties)
    plant.Finalize()
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetPositions(context, [radius + task["gap"]])
    plant.SetVelocities(context, [task["speed"]])
    simulator.Initialize()
    gaps, speeds = [task["gap"]], [task["speed"]]
    for k in range(1, task["steps"] + 1):
        simulator.AdvanceTo(k * task["dt"])
        gaps.append(float(plant.GetPositions(context)[0]) - radius)
        speeds.append(float(plant.GetVelocities(context)[0]))
        if task["until"] == "apart" and gaps[-1] > 0.0 and speeds[-1] > 0.0:
            break
    return {"gaps": gaps, "speeds": speeds}


if __name__ == "__main__":
    print(json.dumps(track(json.loads(sys.stdin.read()))))
