"""The state of a MuJoCo world as a value, and how a world goes on from one to the last bit.

MuJoCo steps from its integration state [1]_ alone: time, q, v, activations, the warm start of its solver and
what acts from outside. Beside it friction lasts, which is part of the model, the impulses that an exact step
starts from, and what the last step has left to be read: contacts belong to the configuration before the step,
and no state brings them back.

References
----------
.. [1] MuJoCo's documentation, chapter Programming, section "State": mjSTATE_INTEGRATION.
"""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.base.errors import ProblemError
from surefoot.worlds.interface.world_state import WorldState, digest, fill
from surefoot.worlds.mujoco.stepper.impulse_memory import Impulses, read_memory
from surefoot.worlds.mujoco.substeps import WholeStep

MADE = (
    "body_parentid", "body_pos", "body_quat", "body_mass", "body_inertia", "body_ipos", "body_iquat",
    "jnt_type", "jnt_axis", "jnt_pos", "jnt_range", "jnt_stiffness", "dof_armature", "dof_damping",
    "dof_frictionloss", "dof_solref", "dof_solimp", "geom_type", "geom_bodyid", "geom_size", "geom_pos",
    "geom_quat", "geom_contype", "geom_conaffinity", "geom_condim", "geom_margin", "geom_gap", "pair_geom1",
    "pair_geom2", "pair_solref", "pair_solimp", "hfield_data", "hfield_size", "actuator_gainprm",
    "actuator_biasprm", "actuator_gear", "actuator_ctrlrange", "actuator_forcerange", "qpos0",
)  # fmt: skip
"""Arrays of a model that no step changes, by which two worlds are known to be made in the same way."""
CHANGED = ("geom_friction", "pair_friction", "geom_priority", "geom_solref", "geom_solimp")
"""Arrays of a model that change during a run: with friction, and where it is another under each foot."""


def _digest_model(world: Any) -> str:
    """Return a digest of what a world was made with."""
    model, option = world.model, world.model.opt
    numbers = [getattr(model, name) for name in MADE]
    options = [option.timestep, option.integrator, option.solver, option.cone, option.iterations]
    options += [option.tolerance, option.disableflags, option.enableflags, *option.gravity]
    return digest(world.robot, world.terrain, *numbers, np.array(options, dtype=np.float64), world.dt)


def _whole(world: Any) -> tuple[Any, NDArray[np.float64]]:
    """Return which of MuJoCo's states is whole, and room for it."""
    mujoco = world.mujoco
    spec = mujoco.mjtState.mjSTATE_INTEGRATION
    return spec, np.zeros(mujoco.mj_stateSize(world.model, spec))


def mujoco_state(world: Any) -> WorldState:
    """Return a copy of all that lasts in a `MujocoWorld` from one step to the next."""
    spec, physics = _whole(world)
    world.mujoco.mj_getState(world.model, world.data, physics, spec)
    own: dict[str, Any] = {"physics": physics} | {name: getattr(world.model, name).copy() for name in CHANGED}
    if world.stepper is not None:
        own |= world.stepper.last_impulses()._asdict()
    reading = copy.deepcopy(world.contacts())
    touching = sorted(world.touching())
    return WorldState(world.kind, _digest_model(world), own, world.applied.copy(), reading, touching)


def _impulses(own: dict[str, Any]) -> Impulses:
    """Return the impulses of a state, or raise for what cannot be any."""
    parts: dict[str, Any] = {name: own.get(name) for name in Impulses._fields}
    for name, part in parts.items():
        if not isinstance(part, np.ndarray):
            raise ProblemError(f"{name} of the world's state must be an array, got {type(part).__name__}")
    impulses = Impulses(**parts)
    read_memory(impulses)
    return impulses


def resume_mujoco(world: Any, state: WorldState) -> WholeStep:
    """Put a world into a state; return what the last step has left to be read, until the next one.

    Raises
    ------
    ProblemError
        For a state of another world, or arrays that do not fit; nothing has changed.
    """
    state.check(world.kind, _digest_model(world))
    mujoco, model, data = world.mujoco, world.model, world.data
    spec, physics = _whole(world)
    own = state.own
    impulses = None if world.stepper is None else _impulses(own)
    fill([
        ("applied", world.applied.copy(), state.applied),
        ("physics", physics, own.get("physics")),
        *((name, getattr(model, name), own.get(name)) for name in CHANGED),
    ])  # fmt: skip
    mujoco.mj_resetData(model, data)
    mujoco.mj_setState(model, data, physics, spec)
    # Places and contacts of now, for who looks at the data; it leaves another warm start behind.
    world.forward()
    mujoco.mj_setState(model, data, physics, spec)
    if impulses is not None:
        world.stepper.resume(data, impulses)
    return WholeStep(copy.deepcopy(state.reading), tuple((a, b) for a, b in state.touching))
