"""Run by an interpreter that has pydrake: boxes on a plane in, Drake's hydroelastic wrenches out, as JSON."""

from __future__ import annotations

import json
import sys
from typing import Any


def contact(case: dict[str, Any]) -> list[dict[str, Any]]:
    """Return force and moment about the centroid on a compliant box, and the area, of one pose and twist."""
    import numpy as np
    from pydrake.geometry import (
        AddCompliantHydroelasticProperties,
        AddContactMaterial,
        AddRigidHydroelasticProperties,
        Box,
        HalfSpace,
        ProximityProperties,
    )
    from pydrake.math import RigidTransform, RotationMatrix
    from pydrake.multibody.math import SpatialVelocity
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, ContactModel, CoulombFriction
    from pydrake.multibody.tree import SpatialInertia, UnitInertia
    from pydrake.systems.framework import DiagramBuilder

    builder, friction = DiagramBuilder(), CoulombFriction(case["mu"], case["mu"])
    plant, _ = AddMultibodyPlantSceneGraph(builder, 0.0)
    plant.set_contact_model(ContactModel.kHydroelastic)
    plant.set_stiction_tolerance(1e-6)
    inertia = SpatialInertia(1.0, np.zeros(3), UnitInertia.SolidBox(*case["size"]))
    body = plant.AddRigidBody("box", inertia)
    soft, hard = ProximityProperties(), ProximityProperties()
    AddContactMaterial(dissipation=case["dissipation"], friction=friction, properties=soft)
    AddCompliantHydroelasticProperties(1.0, case["modulus"], soft)
    AddContactMaterial(dissipation=0.0, friction=friction, properties=hard)
    AddRigidHydroelasticProperties(hard)
    plant.RegisterCollisionGeometry(body, RigidTransform(), Box(*case["size"]), "box", soft)
    plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), HalfSpace(), "ground", hard)
    plant.Finalize()
    diagram = builder.Build()
    context = plant.GetMyMutableContextFromRoot(diagram.CreateDefaultContext())
    return read(plant, context, body, case, RigidTransform, RotationMatrix, SpatialVelocity)


def read(plant: Any, context: Any, body: Any, case: dict[str, Any], *names: Any) -> list[dict[str, Any]]:
    """Put the box where the case says and read the contact."""
    transform, rotation, velocity = names
    pose = transform(rotation(case["rotation"]), case["position"])
    plant.SetFreeBodyPose(context, body, pose)
    plant.SetFreeBodySpatialVelocity(body, velocity(w=case["twist"][3:], v=case["twist"][:3]), context)
    results = plant.get_contact_results_output_port().Eval(context)
    found = []
    for k in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(k)
        surface, wrench = (
            info.contact_surface(),
            info.F_Ac_W(),
        )  # on the box, registered first
        found.append(
            {
                "force": [float(x) for x in wrench.translational()],
                "moment": [float(x) for x in wrench.rotational()],
                "centroid": [float(x) for x in surface.centroid()],
                "area": float(surface.total_area()),
            }
        )
    return found


if __name__ == "__main__":
    print(json.dumps([contact(case) for case in json.loads(sys.stdin.read())]))
