"""A MuJoCo world made from the Pinocchio model itself, so that both engines hold the same robot.

MuJoCo's own conventions stop in this file: quaternions (w, x, y, z), base velocity [linear in world
axes; angular in base axes], contact frames with the normal first. By default joints are ideal torque sources
without friction or rotor inertia, and only the feet's spheres touch the ground.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Unpack, cast

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, IntArray, finite_array, real_number, whole_number
from surefoot.base.errors import ProblemError, SimulationError
from surefoot.base.kernels import VECTOR, entry_point
from surefoot.base.memory import Remade
from surefoot.base.numerics.vectors import finite_vector, largest
from surefoot.base.spatial import base_velocity, quaternion_wxyz
from surefoot.mechanics import Actuators, Geometry, Robot, Terrain
from surefoot.records import Log
from surefoot.worlds.interface.actuated import equipped
from surefoot.worlds.interface.world import ContactReading, ground_of
from surefoot.worlds.interface.world_state import WorldState
from surefoot.worlds.mujoco.actuators import fit_actuators
from surefoot.worlds.mujoco.centripetal import step_with_centripetal
from surefoot.worlds.mujoco.foot_reader import DataViews, FootReader
from surefoot.worlds.mujoco.links import add_links, generalised_force
from surefoot.worlds.mujoco.readings import pinocchio_state as pinocchio_state
from surefoot.worlds.mujoco.readings import to_pinocchio
from surefoot.worlds.mujoco.record_softness import exact_softness, world_softness
from surefoot.worlds.mujoco.resuming import mujoco_state, resume_mujoco
from surefoot.worlds.mujoco.spec import (
    CONTACT_TIME,
    GroundLaw,
    Softness,
    compile_spec,
    set_point_friction,
    surface_of,
)
from surefoot.worlds.mujoco.spec import add_ground as add_ground
from surefoot.worlds.mujoco.spec import import_mujoco as import_mujoco
from surefoot.worlds.mujoco.spec import robot_spec as robot_spec
from surefoot.worlds.mujoco.stepper.stepper import MujocoStepper
from surefoot.worlds.mujoco.substeps import MOST_SUBSTEPS, WholeStep, mean_reading
from surefoot.worlds.rigid.rigid_world import chosen_geometry

LARGEST = 1e10
"""Speed from which MuJoCo itself calls a state bad [rad/s, m/s]."""
HEAVIEST = 1e9
"""Largest payload [kg]: MuJoCo's numbers end at 1e10."""


class MujocoWorld(Remade):
    """A robot on a terrain in MuJoCo; see `surefoot.worlds.interface.world.World` for the methods.

    Parameters
    ----------
    robot
        Who stands.
    terrain
        None for flat ground.
    mu
        Friction of the ground [-].
    dt
        Length of a step [s].
    payload, payload_position
        Point mass fixed to the base [kg], unknown to any controller, and where: (3,) base axes [m].
    collision
        What may touch: "feet", "full" for all links, with the ground and with each other, or a geometry.
    actuators
        Its motors: "ideal", "real", or a value; see `surefoot.mechanics.robot.actuators`.
    **law
        ``solref``, ``solimp``: MuJoCo's softness of the ground, in its own words (`surefoot.translate` has
        others): time constant and damping ratio [s, -], or minus stiffness and damping; (dmin, dmax, width,
        midpoint, power), width [m]. Of fewer than five numbers MuJoCo's defaults are the rest. None for close
        to rigid.
        ``exact=True``: contacts keep Coulomb's law exactly and limits are hard, `MujocoStepper` takes the
        steps; ``restitution`` is of exact contacts [-].

    Attributes
    ----------
    mujoco, model, data
        The module, and MuJoCo's own.
    applied
        (joints,) torques that the motors gave in the last step [N m].
    ground_geoms, base_body
        Numbers of the ground's geoms and of the base's body there; 0 for a base that is fixed.
    substeps
        Steps of MuJoCo in one of these; see `divide`.
    stepper
        What takes the steps of an exact world, its certificates included; None for MuJoCo itself.

    Raises
    ------
    ProblemError
        For numbers that MuJoCo would not take, or would silently replace.
    """

    substeps = 1
    stepper: MujocoStepper | None = None
    _own_softness = False
    _unsolved_before = 0

    def __init__(
        self,
        robot: Robot,
        terrain: Terrain | None = None,
        mu: float = 0.6,
        dt: float = 1e-3,
        payload: float = 0.0,
        *,
        collision: str | Geometry = "feet",
        actuators: str | Actuators = "ideal",
        payload_position: ArrayLike = (0.0, 0.0, 0.0),
        **law: Unpack[GroundLaw],
    ) -> None:
        mujoco = import_mujoco()
        solref, solimp = self._choose_law(**law)
        robot, self.actuators = equipped(robot, actuators)
        self.robot, self.dt = robot, real_number("dt", dt, low=1e-6)
        self.terrain, self._own_softness = ground_of(terrain), solref is None
        self.payload = real_number("payload", payload, low=0.0, high=HEAVIEST)
        self.payload_position = finite_array("payload_position", payload_position, (3,))
        spec = robot_spec(robot, self.payload, self.payload_position)
        fit_actuators(spec, robot, self.actuators)
        add_ground(spec, self.terrain, real_number("mu", mu, low=0.0), solref, solimp)
        geometry = chosen_geometry(robot, collision)
        if geometry is not None:
            add_links(mujoco, spec, robot, geometry, surface_of(mu, solref, solimp))
        spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE  # 4.0.0: the sparse Hessian is wrong
        spec.option.timestep = self.dt
        self.mujoco = mujoco
        spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET  # a lost state is an error
        self.model = compile_spec(spec, robot.name)
        if self.model.ntree == 1:  # looking for islands in one tree takes 1 us, and finds it
            self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ISLAND
        points = robot.contact_points
        feet = np.array([int(self.model.geom(f"foot:{n}").id) for n in points.names], dtype=np.int64)
        self._take(feet, int(self.model.body("base:0").id) if robot.floating else 0, geometry is not None)

    def _choose_law(
        self, solref: Softness = None, solimp: Softness = None, exact: bool = False, restitution: float = 0.0
    ) -> tuple[Softness, Softness]:
        """Note whose contacts these are; refuse softness of exact ones, and restitution of soft ones."""
        if exact and not (solref is None and solimp is None):
            raise ProblemError("solref and solimp are of MuJoCo's soft contacts, exact ones have none")
        if restitution and not exact:
            raise ProblemError(
                "restitution is of exact contacts (exact=True): MuJoCo's bounce by their solref"
            )
        self._restitution = real_number("restitution", restitution, low=0.0, high=1.0)
        self._exact = bool(exact)
        return solref, solimp

    @property
    def kind(self) -> str:
        """What logs and states call this world: that with exact contacts is another one."""
        name = type(self).__name__
        return f"{name.removesuffix('World')}ExactWorld" if self._exact and "Exact" not in name else name

    def forward(self) -> None:
        """Have the data tell of its state as it is: places, contacts, and their forces."""
        self._reader.ahead = 0.0
        if self.stepper is None:
            self.mujoco.mj_forward(self.model, self.data)
        else:
            self.stepper.reset()
            self.stepper.forward(self.data)

    def _step_exactly(self) -> None:
        """Make a step whose velocities are those that the laws of contact tie to its impulses."""
        cast(MujocoStepper, self.stepper).step(self.data)
        self.mujoco.mj_comVel(self.model, self.data)  # of the feet where the step began, at its end's speed
        self._reader.ahead = self.model.opt.timestep

    def _take(self, feet: IntArray, base: int, links: bool, floors: Sequence[int] = ()) -> None:
        """Make data for the model, with (p,) geoms of the feet and the base's body; see `collision`."""
        mujoco, robot = self.mujoco, self.robot
        names = [self.model.geom(i).name for i in range(self.model.ngeom)]
        self.ground_geoms = list(floors) or [i for i, name in enumerate(names) if name.startswith("ground")]
        self.data = mujoco.MjData(self.model)
        self._before = np.zeros(self.model.nq), np.zeros(self.model.nv)
        self.applied = np.zeros(robot.joints)
        self.contact_foot = robot.contact_points.foot
        self.base_body = base
        self._views = DataViews.of(self.data, robot.base_dof, base)
        self._reader = FootReader(
            mujoco, self.model, self.data, robot, self.terrain, feet, self.ground_geoms, self._views, links
        )
        self._advance: Callable[[], None] = partial(mujoco.mj_step, self.model, self.data)
        if self._exact:
            self.stepper = MujocoStepper(self.model, restitution=self._restitution)
            self._advance = self._step_exactly
        self._turn, self._largest = entry_point(to_pinocchio, VECTOR, VECTOR), entry_point(largest, VECTOR)
        self.reset(robot.nominal)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self.data.time)

    def count_centripetal(self) -> None:
        """Have feet count the acceleration that MuJoCo leaves out, see `worlds.mujoco.centripetal`.

        Exact contacts are of velocities, which leave out none.
        """
        if self.stepper is not None:
            return
        self._advance = partial(
            step_with_centripetal, self.mujoco, self.model, self.data, self._reader.feet.owner
        )

    def divide(self, substeps: int) -> None:
        """Make each step in so many of MuJoCo's, 1 to 64, on ground as many times as fast as the default.

        Torques and pushes stay, contacts are means. A foot that strikes a riser at 2 m/s is 2 mm
        inside it after a step of 1 ms, a quarter of that after one of four. Softness that was chosen stays.

        Raises
        ------
        ProblemError
            For a number that is none of these.
        """
        real_number("substeps", substeps, low=1, high=MOST_SUBSTEPS)
        self.substeps = whole_number("substeps", substeps, low=1)
        self.model.opt.timestep = self.dt / self.substeps
        if self._own_softness:
            self.model.geom_solref[self.ground_geoms, 0] = CONTACT_TIME / self.substeps
            self.model.pair_solref[:, 0] = CONTACT_TIME / self.substeps

    def reset(self, q: FloatArray, v: FloatArray | None = None) -> None:
        """Put the robot at (nq,) q [m, -, rad], (nv,) v [m/s, rad/s] in Pinocchio's order, at time 0."""
        q = self.robot.configuration(q)
        v = None if v is None else finite_array("v", v, (self.robot.model.nv,))
        self.mujoco.mj_resetData(self.model, self.data)
        self._whole: WholeStep | None = None
        self.data.qpos[:] = q
        self.data.qvel[:] = 0.0 if v is None else v
        if self.robot.floating:
            self.data.qpos[3:7] = quaternion_wxyz(q[3:7])
            if v is not None:
                self.data.qvel[:3] = base_velocity(q, v)
        self.forward()
        self._count_from_here()

    def _count_from_here(self) -> None:
        """Begin to count the steps whose contacts MuJoCo solves softly, see `unsolved`."""
        self._unsolved_before = 0 if self.stepper is None else self.stepper.unsolved

    @property
    def unsolved(self) -> int:
        """Steps since `reset` or `resume` whose contacts were to be exact, and that MuJoCo solved softly."""
        return 0 if self.stepper is None else self.stepper.unsolved - self._unsolved_before

    @property
    def state(self) -> WorldState:
        """A copy of all that lasts from one step to the next, MuJoCo's warm start included."""
        return mujoco_state(self)

    def resume(self, state: WorldState) -> None:
        """Go on from a state of a world that was made in the same way.

        Raises
        ------
        ProblemError
            For a state of another world; nothing has changed.
        """
        self._whole = resume_mujoco(self, state)
        self.applied = state.applied.copy()
        self._count_from_here()

    def _lasting(self) -> tuple[WorldState, int, bool]:
        """See `Remade`: the state, and what was asked of the steps."""
        centripetal = isinstance(self._advance, partial) and self._advance.func is step_with_centripetal
        return self.state, self.substeps, centripetal

    def _go_on(self, lasting: tuple[WorldState, int, bool]) -> None:
        """See `Remade`."""
        state, substeps, centripetal = lasting
        if substeps != 1:
            self.divide(substeps)
        if centripetal:
            self.count_centripetal()
        self.resume(state)

    def q_v(self) -> tuple[FloatArray, FloatArray]:
        """Return q (nq,) [m, -, rad] and v (nv,) [m/s, rad/s] in Pinocchio's order."""
        q, v = self._views.qpos.copy(), self._views.qvel.copy()
        if self.robot.floating:
            self._turn(q, v)
        return q, v

    def step(self, torques: FloatArray, push: FloatArray | None = None) -> None:
        """Advance by `dt` under (joints,) torques [N m] and a (3,) force on the base [N], world axes.

        Raises
        ------
        ProblemError
            For torques or a push of the wrong shape, or not finite. Nothing has moved.
        SimulationError
            Where the state stops being finite, or exceeds MuJoCo's own largest number, 1e10. The world stays
            in the state before the step.
        """
        self._drive(torques)
        if push is None:
            self._views.push.fill(0.0)
        elif self.base_body:
            self._views.push[:] = finite_vector("push", push, 3)
        if self.substeps == 1:
            self._whole = None
            self._advance()
        else:
            self._whole = self._advance_finely()
        if not self._largest(self._views.qvel) < LARGEST:
            raise self._undo_step()
        self._note_torques()

    def _advance_finely(self) -> WholeStep:
        """Advance in parts; return what the ground did and what touched in them."""
        parts: list[ContactReading] = []
        touching = set[tuple[str, str]]()
        for _ in range(self.substeps):
            self._advance()
            reading, beside = self._reader.read(parts[-1] if parts else None)
            parts.append(reading)
            if beside:
                touching.update(self._reader.touching())
        mean, rest = mean_reading(parts)
        if rest.any() and mean.others is not None:
            effort = generalised_force(
                self.mujoco, self.model, self.data, self._reader.feet.bodies, mean.positions, rest
            )
            mean.others[:] += effort
        return WholeStep(mean, tuple(sorted(touching)))

    def _drive(self, torques: FloatArray) -> None:
        """Have the motors give (joints,) torques [N m] in the next step, if they can; keep the state."""
        given = finite_vector("torques", torques, self.robot.joints).copy()
        if self.actuators is not None:
            given = self.actuators.given(given, self._views.qvel[self.robot.base_dof :])
        self._views.effort[:], self.applied = given, given
        self._keep()

    def _keep(self) -> None:
        """Keep q and v, for a step that is to be undone."""
        self._before[0][:], self._before[1][:] = self._views.qpos, self._views.qvel

    def _note_torques(self) -> None:
        """Note what the motors gave in the last step, where only the step tells."""

    def _undo_step(self) -> SimulationError:
        """Return to the state before the last step; return the error that names the joint at fault."""
        data, (qpos, qvel) = self.data, self._before
        time = data.time - self.dt
        self.mujoco.mj_resetData(self.model, data)
        data.qpos[:], data.qvel[:], data.time = qpos, qvel, time
        self.forward()
        fastest = int(np.argmax(np.abs(qvel)))
        joint = self.model.joint(int(self.model.dof_jntid[fastest])).name.split(":", 1)[-1]
        return SimulationError("motion", time, self.dt, joint, float(abs(qvel[fastest])))

    @property
    def mu(self) -> float:
        """Friction of the ground [-]."""
        return float(self.model.geom_friction[self.ground_geoms[0], 0])

    def set_friction(self, mu: float) -> None:
        """Change the friction of the ground [-], from the next step on."""
        self.model.geom_friction[self.ground_geoms, 0] = max(real_number("mu", mu, low=0.0), 1e-5)

    set_point_friction = set_point_friction

    def softness(self, log: Log) -> dict[str, Any]:
        """Return what the ground's softness means in a run: `sinking` [m], `creep` [m/s], `stopping` [m].

        Whether contacts rebound and how fast they come out of the ground, too. Exact contacts have none, see
        `exact_softness`.
        """
        if self.stepper is not None:
            return exact_softness(self.dt / self.substeps, self.unsolved, log)
        load = float(np.linalg.norm(self.model.opt.gravity)) * (self.robot.mass + self.payload)
        return world_softness(
            self.mujoco, self.model, self.ground_geoms[0], self._reader.feet.bodies, log, load
        )

    def contacts(self) -> ContactReading:
        """Return forces, gaps and velocities at the feet's spheres during the last step.

        A foot that touches two surfaces, in a corner, tells of the one that bears more; what the other gives
        comes with the forces on other links, in a world that has them.
        """
        return self._reader.read().contacts if self._whole is None else self._whole.contacts

    def touching(self) -> list[tuple[str, str]]:
        """Return the names of links, feet or ground that touched in the last step, without feet on ground."""
        return self._reader.touching() if self._whole is None else list(self._whole.touching)
