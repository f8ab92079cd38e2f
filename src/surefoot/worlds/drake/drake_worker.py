"""Run by an interpreter that has pydrake: a scene, then step after step, as lines of JSON; nothing of ours.

Joints come as a tree (`engine_world.py`), the contact's numbers are Drake's own. An answer holds places and
velocities joint by joint as Drake has them, and the forces of the contact points.
"""

from __future__ import annotations

import json
import logging
import sys
from typing import Any

import numpy as np


class DrakeScene:
    """A tree of joints on a terrain."""

    def __init__(self, scene: dict[str, Any]) -> None:
        from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, DiscreteContactApproximation
        from pydrake.systems.analysis import Simulator
        from pydrake.systems.framework import DiagramBuilder

        logging.getLogger("drake").setLevel(logging.ERROR)  # its own import sets the level
        builder = DiagramBuilder()
        self.dt = scene["dt"]
        self.plant, self.graph = AddMultibodyPlantSceneGraph(builder, self.dt)
        kind = getattr(DiscreteContactApproximation, "k" + scene["approximation"].capitalize())
        self.plant.set_discrete_contact_approximation(kind)
        if scene["near_rigid"] is not None:
            self.plant.set_sap_near_rigid_threshold(scene["near_rigid"])
        self.plant.mutable_gravity_field().set_gravity_vector(scene["gravity"])
        self.material, self.mu = scene["material"], scene["mu"]
        self.geometries: list[Any] = []
        self.bodies = [self.plant.world_body()]
        joints = [self.add(joint, index) for index, joint in enumerate(scene["joints"])]
        self.rows = {self.touch(*sphere): row for row, sphere in enumerate(scene["spheres"])}
        for shape in scene["ground"]:
            self.ground(shape)
        self.plant.Finalize()
        self.plant.set_stiction_tolerance(scene["stiction"])
        self.positions = [k for j in joints for k in span(j.position_start(), j.num_positions())]
        self.velocities = [k for j in joints for k in span(j.velocity_start(), j.num_velocities())]
        diagram = builder.Build()
        self.simulator = Simulator(diagram)
        self.root = self.simulator.get_mutable_context()
        self.context = self.plant.GetMyMutableContextFromRoot(self.root)
        self.effort = self.plant.get_applied_generalized_force_input_port()
        self.results = self.plant.get_contact_results_output_port()
        self.count = 0

    def add(self, joint: dict[str, Any], index: int) -> Any:
        """Return a joint, added with its body."""
        from pydrake.math import RigidTransform, RotationMatrix
        from pydrake.multibody.tree import (
            FixedOffsetFrame,
            PrismaticJoint,
            QuaternionFloatingJoint,
            RevoluteJoint,
            SpatialInertia,
            UnitInertia,
        )

        mass, com, moments = joint["mass"], np.array(joint["com"]), np.array(joint["inertia"])
        about = (moments / mass if mass > 0.0 else np.zeros((3, 3))) + np.dot(com, com) * np.eye(3)
        unit = about - np.outer(com, com)
        inertia = SpatialInertia(
            mass, com, UnitInertia(*unit.diagonal(), unit[0, 1], unit[0, 2], unit[1, 2]), True
        )
        body = self.plant.AddRigidBody(f"body{index}", inertia)
        parent = self.bodies[joint["parent"]]
        self.bodies.append(body)
        pose = RigidTransform(RotationMatrix(np.array(joint["rotation"])), joint["place"])
        frame = self.plant.AddFrame(FixedOffsetFrame(f"place{index}", parent.body_frame(), pose))
        name = f"joint{index}"
        if joint["kind"] == "free":
            return self.plant.AddJoint(QuaternionFloatingJoint(name, frame, body.body_frame()))
        kind = RevoluteJoint if joint["kind"] == "revolute" else PrismaticJoint
        low, high, damping = joint["low"], joint["high"], joint.get("damping", 0.0)
        return self.plant.AddJoint(kind(name, frame, body.body_frame(), joint["axis"], low, high, damping))

    def touch(self, joint: int, place: list[float], radius: float) -> Any:
        """Return the geometry of a contact sphere on the body of a joint, place and radius in [m]."""
        from pydrake.geometry import Sphere

        return self.register(self.bodies[joint], np.eye(3), place, Sphere(radius))

    def ground(self, shape: dict[str, Any]) -> None:
        """Add a half-space, or a box of full lengths [m]."""
        from pydrake.geometry import Box, HalfSpace

        made = Box(*shape["size"]) if "size" in shape else HalfSpace()
        self.register(self.plant.world_body(), shape["rotation"], shape["place"], made)

    def register(self, body: Any, rotation: Any, place: Any, shape: Any) -> Any:
        """Return the id of a new collision geometry; those of one body never meet each other."""
        from pydrake.math import RigidTransform, RotationMatrix

        pose = RigidTransform(RotationMatrix(np.array(rotation)), place)
        geometry = self.plant.RegisterCollisionGeometry(
            body, pose, shape, f"geometry{len(self.geometries)}", self.properties(self.mu)
        )
        self.geometries.append(geometry)
        return geometry

    def properties(self, mu: float) -> Any:
        """Return the material of each side; of two equal frictions Drake makes the same."""
        from pydrake.geometry import ProximityProperties
        from pydrake.multibody.plant import CoulombFriction

        out = ProximityProperties()
        for name, value in self.material.items():
            out.AddProperty("material", name, value)
        out.AddProperty("material", "coulomb_friction", CoulombFriction(mu, mu))
        return out

    def reset(self, q: list[float], v: list[float]) -> dict[str, Any]:
        """Start anew."""
        self.root.SetTime(0.0)
        self.count = 0
        values, rates = np.zeros(len(q)), np.zeros(len(v))
        values[self.positions], rates[self.velocities] = q, v
        self.plant.SetPositions(self.context, values)
        self.plant.SetVelocities(self.context, rates)
        self.effort.FixValue(self.context, np.zeros(len(v)))
        self.simulator.Initialize()
        return self.state()

    def throw(self, starts: list[list[float]], frames: list[int], steps: int) -> dict[str, Any]:
        """Return the places in every frame, so many steps apart, from starts with places and velocities."""
        out = []
        for start, count in zip(starts, frames, strict=True):
            out.append(self.reset(start[: len(self.positions)], start[len(self.positions) :])["q"])
            for _ in range(1, count):
                self.count += steps - 1
                self.advance()
                out.append(self.state()["q"])
        return {"q": out}

    def step(self, effort: list[float]) -> dict[str, Any]:
        """Take a step under (nv,) generalised forces [N, N m]."""
        given = np.zeros(len(effort))
        given[self.velocities] = effort
        self.effort.FixValue(self.context, given)
        self.advance()
        return {**self.state(), "contacts": self.contacts()}

    def advance(self) -> None:
        """Go on by a step."""
        self.count += 1
        # half a step short of the next: k updates have then been made, whatever rounding does to times
        self.simulator.AdvanceTo((self.count - 0.5) * self.dt)

    def friction(self, mu: float) -> dict[str, Any]:
        """Change the friction [-] everywhere."""
        from pydrake.geometry import RoleAssign

        context = self.graph.GetMyMutableContextFromRoot(self.root)
        for geometry in self.geometries:
            self.graph.AssignRole(
                context, self.plant.get_source_id(), geometry, self.properties(mu), RoleAssign.kReplace
            )
        return {}

    def state(self) -> dict[str, Any]:
        """Return positions and velocities in the tree's order."""
        q, v = self.plant.GetPositions(self.context), self.plant.GetVelocities(self.context)
        return {"q": q[self.positions].tolist(), "v": v[self.velocities].tolist()}

    def contacts(self) -> list[list[float]]:
        """Return sphere, force on it [N] and normal away from the ground, world axes, contact by contact."""
        results, out = self.results.Eval(self.context), []
        for k in range(results.num_point_pair_contacts()):
            info = results.point_pair_contact_info(k)
            pair, force, normal = info.point_pair(), info.contact_force(), info.point_pair().nhat_BA_W
            row = self.rows.get(pair.id_B)  # the force is that on B, the normal points from B to A
            if row is None:
                row, force, normal = self.rows[pair.id_A], -force, -normal
            out.append([row, *force, *-normal])
        return out


def span(start: int, count: int) -> range:
    """Return `count` indices from `start` on."""
    return range(start, start + count)


def main() -> None:
    """Answer line after line: a scene, then what its methods are asked for."""
    scene: Any = None
    for line in sys.stdin:
        try:
            name, *values = json.loads(line)
            if name == "scene":
                scene, answer = DrakeScene(*values), {}
            else:
                answer = getattr(scene, name)(*values)
        except Exception as error:
            answer = {"error": (str(error).strip() or repr(error)).splitlines()[0]}
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
