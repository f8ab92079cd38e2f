"""Run by an interpreter that has pydrake: a task per line as JSON, poses out; imports nothing of ours."""

from __future__ import annotations

import json
import logging
import sys
from typing import Any


def cube_on_ground(task: dict[str, Any]) -> tuple[Any, Any]:
    """Return the plant of a cube over a half-space, and its simulator."""
    import numpy as np
    from pydrake.geometry import HalfSpace, ProximityProperties, Sphere
    from pydrake.math import RigidTransform, RotationMatrix
    from pydrake.multibody.plant import (
        AddMultibodyPlantSceneGraph,
        CoulombFriction,
        DiscreteContactApproximation,
    )
    from pydrake.multibody.tree import SpatialInertia, UnitInertia
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder

    mu, stiffness, relaxation = task["values"]
    radius = 1e-3
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, task["dt"])
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    size = task["inertia"] / task["mass"]
    body = plant.AddRigidBody(
        "cube", SpatialInertia(task["mass"], np.zeros(3), UnitInertia(size, size, size))
    )
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -task["gravity"]])

    def material(k: float, tau: float) -> Any:
        """Return the properties of one side: stiffnesses act in series, relaxation times add."""
        out = ProximityProperties()
        out.AddProperty("material", "point_contact_stiffness", k)
        out.AddProperty("material", "relaxation_time", tau)
        out.AddProperty("material", "coulomb_friction", CoulombFriction(mu, mu))
        return out

    ground = RigidTransform(RotationMatrix(np.array(task["axes"])), [0.0, 0.0, task["height"]])
    plant.RegisterCollisionGeometry(
        plant.world_body(), ground, HalfSpace(), "ground", material(2.0 * stiffness, 0.5 * relaxation)
    )
    inset = task["half"] - radius
    for k in range(8):
        place = [inset if k & 1 << a else -inset for a in range(3)]
        plant.RegisterCollisionGeometry(
            body,
            RigidTransform(place),
            Sphere(radius),
            f"corner{k}",
            material(2.0 * stiffness, 0.5 * relaxation),
        )
    plant.Finalize()
    return plant, Simulator(builder.Build())


def poses(task: dict[str, Any]) -> list[list[float]]:
    """Return positions [m] and quaternions (x, y, z, w) of every frame of every toss."""
    plant, simulator = cube_on_ground(task)
    context = simulator.get_mutable_context()
    inner = plant.GetMyMutableContextFromRoot(context)
    rows: list[list[float]] = []
    for start, frames in zip(task["starts"], task["frames"], strict=True):
        context.SetTime(0.0)
        plant.SetPositions(inner, [start[6], *start[3:6], *start[:3]])
        plant.SetVelocities(inner, [*start[10:], *start[7:10]])
        simulator.Initialize()
        for k in range(frames):
            if k:
                simulator.AdvanceTo(k * task["frame"])
            w, x, y, z, *place = plant.GetPositions(inner)
            rows.append([*place, x, y, z, w])
    return rows


def main() -> None:
    """Answer line after line."""
    logging.getLogger("drake").setLevel(logging.ERROR)
    for line in sys.stdin:
        try:
            answer = {"poses": poses(json.loads(line))}
        except Exception as error:
            text = (str(error).strip() or repr(error)).splitlines()[0]
            print(json.dumps({"error": text}), flush=True)
        else:
            print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
