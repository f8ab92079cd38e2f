"""The state of a rigid world as a value, and what a world goes on from to the last bit."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.mechanics import State
from surefoot.worlds.interface.world_state import WorldState, digest


def _digest_world(world: Any) -> str:
    """Return a digest of what a world was made with."""
    model, control, geometry = world.model, world.control, world.stepper.geometry
    masses = np.array([[one.mass, *one.lever, *one.inertia.ravel()] for one in model.inertias])
    solids = [] if geometry is None else [(solid.name, solid.joint, solid.shape) for solid in geometry.solids]
    places = [] if geometry is None else [[*s.position, *s.rotation.ravel()] for s in geometry.solids]
    motors = None if world.actuators is None else world.actuators.name
    options = world.stepper.options if control is None else control.options
    words = repr((options, motors, solids)).encode()
    tol = 0.0 if control is None else control.tol
    numbers = (masses, model.armature, places, world.dt, tol, np.frombuffer(words, np.uint8))
    return digest(world.robot, world.terrain, *numbers)


def rigid_state(world: Any, state: State) -> WorldState:
    """Return a copy of all that lasts in a `RigidWorld`, whose stepper has come to `state`."""
    own = {
        "state": state.as_plain(), "mu": world.mu,
        "found": (world.unsolved, world.worst_residual, world.law_error),
        "control": None if world.control is None else world.control.remembered(),
        "energy": world.energy(), "work": world.contact_work(),
    }  # fmt: skip
    applied = np.array(world.applied, dtype=np.float64)
    touching = sorted(world.touching())
    return WorldState(type(world).__name__, _digest_world(world), own, applied, world.contacts(), touching)


def read_rigid_state(world: Any, now: State, state: WorldState) -> State:
    """Return the stepper's state of a world's, after checking that it is of such a world.

    Raises
    ------
    ProblemError
        For a state of another world, or arrays that do not fit.
    """
    state.check(type(world).__name__, _digest_world(world))
    return State.from_plain(state.own["state"], now)
