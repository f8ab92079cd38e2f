"""MuJoCo's step with exact contacts: everything before and after the constraints stays MuJoCo's."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.kernels import entry_point
from surefoot.base.memory import Remade
from surefoot.contact import Status
from surefoot.worlds.mujoco.memory_places import FIRST_BYTE, all_memory, place_of
from surefoot.worlds.mujoco.spec import import_mujoco
from surefoot.worlds.mujoco.stepper import addresses
from surefoot.worlds.mujoco.stepper.certificate import StepCertificate
from surefoot.worlds.mujoco.stepper.data_guard import DataGuard, foreign_rows, in_turn
from surefoot.worlds.mujoco.stepper.implicit import ImplicitInertia
from surefoot.worlds.mujoco.stepper.impulse_memory import LEAST_ROOM, Impulses, memory_room, read_memory
from surefoot.worlds.mujoco.stepper.instant import Evaluation
from surefoot.worlds.mujoco.stepper.private_model import TOUCHING, PrivateModel, leave_out, soft_geoms
from surefoot.worlds.mujoco.stepper.rows import SLOWEST, START, STEP
from surefoot.worlds.mujoco.stepper.runge_kutta import finish_runge_kutta
from surefoot.worlds.mujoco.stepper.stage import (
    BLOCKS,
    ERROR,
    FOREIGN,
    LAST,
    PUSHED,
    SPEED,
    STAGE_TYPES,
    STEPS,
    VIOLATION,
    exact_stage,
)
from surefoot.worlds.mujoco.stepper.step_derivative import MujocoDerivative, differentiate
from surefoot.worlds.mujoco.stepper.step_problem import RESTS, ProblemStepper

SHARE = 0.2
"""Share of a penetration, and of an equality's error, that is undone in a step [-]: beside the motion, so
that it gives no speed. A judgement: gone in 20 steps, and curvature of one step does not overshoot."""
REACH = 1e-3
"""Distance from which contacts and limits are looked at [m, rad]: what closes a larger gap in one step is
caught in the step after. A judgement: a foot at 0.5 m/s and 2 ms."""
ACCEPTED = 1e-6
"""Velocity error over the speed of approach up to which a step is kept [-]; see `StepCertificate`."""


class MujocoStepper(Remade, ProblemStepper):
    """`mujoco.mj_step` with Coulomb's law for contacts, and hard limits, equalities and dry friction.

    ``stepper.step(data)`` takes the place of ``mujoco.mj_step(model, data)``: collision, actuation, passive
    forces, sensors, callbacks and integrators (Euler, implicit, implicitfast, RK4) stay MuJoCo's, and forces,
    accelerations and sensors in the data are those of the exact laws. Limits and contacts are unilateral,
    with sliding, spinning and rolling friction in MuJoCo's elliptic cone (friction of condim 3, 4, 6, two
    sliding coefficients); equalities allow no velocity; dry friction of joints is a bound. A violation of
    positions is undone beside the motion, see `share`. A stepper is for one thread at a time.

    Parameters
    ----------
    model
        MuJoCo's MjModel; it is not changed, and changes of its numbers are followed. Pyramidal cones are
        stepped as elliptic ones, sparse rows as dense: in `model`, a copy, which `mujoco.mj_contactForce` has
        to be given.
    restitution
        Share of the approach speed with which contacts and limits open again [-].
    share
        Of a penetration, and of an equality's error, that a step undoes [-].
    soft
        Patterns of names of geoms whose contacts stay MuJoCo's soft ones, as ``"rubber_*"``.
    tol
        Velocity error to reach, over the speed of approach [-].

    Attributes
    ----------
    model
        The copy that is stepped.
    certificate
        Of the last step, see `StepCertificate`.
    steps, unsolved
        Steps so far, and those whose constraints MuJoCo solved softly.

    Raises
    ------
    ProblemError
        For what is no model, or asks for what the stepper does not know, by name.

    Examples
    --------
    >>> import mujoco
    >>> body = '<body pos="0 0 0.1"><freejoint/><geom type="box" size="0.1 0.1 0.1"/></body>'
    >>> world = f'<worldbody><geom type="plane" size="9 9 1"/>{body}</worldbody>'
    >>> text = f'<mujoco><option cone="elliptic"/>{world}</mujoco>'
    >>> model = mujoco.MjModel.from_xml_string(text)
    >>> data = mujoco.MjData(model)
    >>> stepper = MujocoStepper(model)
    >>> data.qvel[0] = 3.0
    >>> for _ in range(1000):
    ...     stepper.step(data)
    >>> (data.qpos[:3].round(4) + 0.0).tolist(), stepper.certificate.status.value
    ([0.4557, 0.0, 0.1], 'solved')
    """

    def __init__(
        self, model: Any, *, restitution: float = 0.0, share: float = SHARE, soft: str | Sequence[str] = (),
        tol: float = 1e-8,
    ) -> None:  # fmt: skip
        self._mujoco = mujoco = import_mujoco()
        if not isinstance(model, mujoco.MjModel):
            raise ProblemError(f"MujocoStepper takes an MjModel, got {type(model).__name__}")
        self._made_of = model, {"restitution": restitution, "share": share, "soft": soft, "tol": tol}
        self._private = PrivateModel(mujoco, model, REACH)
        self.model = self._private.model
        self.restitution = real_number("restitution", restitution, low=0.0, high=1.0)
        self.share = real_number("share", share, low=0.0, high=1.0)
        self.tol = real_number("tol", tol, low=0.0, high=ACCEPTED)
        self._soft = soft_geoms(model, (soft,) if isinstance(soft, str) else tuple(soft))
        self.steps = self.unsolved = 0
        self._told, self._push = np.zeros(8), np.zeros(model.nv)
        self._memory = memory_room(LEAST_ROOM)
        self._guard = DataGuard(mujoco, self.model)
        self._ready: Any = None
        self._bound = False
        self._twin: MujocoStepper | None = None
        self._implicit: ImplicitInertia | None = None
        self._arena = addresses.arena_words(mujoco)
        self._layout = addresses.contact_places(mujoco)
        self._memory_views = all_memory()
        self._option = self.model.opt
        self._settings = np.array([
            0.0, self.share, self.tol, REACH, self.restitution, 0.0, self._private.limit_reach, 0.0,
        ])  # fmt: skip
        self._call = entry_point(exact_stage, *STAGE_TYPES)
        self._status = Status.SOLVED
        self._no_damping, self._no_dense = np.zeros(0), np.zeros((0, 0))
        self._damping = self.model.dof_damping
        bits = mujoco.mjtDisableBit
        self._undamped = int(bits.mjDSBL_EULERDAMP) | int(bits.mjDSBL_DAMPER)
        self._fwdinv = int(mujoco.mjtEnableBit.mjENBL_FWDINV)
        self._plain_damping = not np.any(model.dof_dampingpoly) and not np.any(
            np.array(model.jnt_actuatorid) != -1
        )
        if self._private.pyramids and model.ngeom:
            warnings.warn(
                "this model has pyramidal cones: it is stepped with elliptic ones (stepper.model), as exact "
                'friction is round; option cone="elliptic" says so in the file',
                stacklevel=2,
            )

    @property
    def certificate(self) -> StepCertificate:
        """What was solved in the last step."""
        t = self._told
        return StepCertificate(
            self._status, float(t[ERROR]), float(t[SPEED]), int(t[BLOCKS]), int(t[STEPS]), float(t[VIOLATION])
        )

    def reset(self) -> None:
        """Forget the last impulses: the next step starts from none."""
        self._told[LAST] = 0.0

    def last_impulses(self) -> Impulses:
        """Return a copy of the impulses that the next step starts from, for `resume`."""
        return Impulses.of(self._memory, int(self._told[LAST]))

    def resume(self, data: Any, impulses: Impulses) -> None:
        """Go on with a data from impulses that a stepper of such a model remembered, to the last bit."""
        memory = read_memory(impulses)
        if self._guard.is_new(data):
            self._bind(data)
        self._memory, self._told[LAST] = memory, len(impulses.keys)

    def _lasting(self) -> Any:
        """See `Remade`: the last step's impulses and what it told."""
        return self.steps, self.unsolved, self._status, self._told.copy(), [a.copy() for a in self._memory]

    def _go_on(self, lasting: Any) -> None:
        """See `Remade`."""
        self.steps, self.unsolved, self._status, self._told, memory = lasting
        self._memory = tuple(memory)

    @in_turn
    def step(self, data: Any) -> None:
        """Advance the data by a time step, in place of ``mujoco.mj_step``."""
        self._begin(data)
        self._finish(data, halves=False)

    @in_turn
    def step_first(self, data: Any) -> None:
        """Do what ``mujoco.mj_step1`` does."""
        self._begin(data)
        self._ready = data

    @in_turn
    def step_second(self, data: Any, halves: bool = False) -> None:
        """Do what is left of the step after `step_first`, as ``mujoco.mj_step2`` does.

        That takes Euler's method for RK4: `halves` says so. Where `step_first` of this data was not the last
        call it is done first: constraints that others make are not those that are solved.
        """
        if self._ready is not data:
            self._begin(data)
        self._finish(data, halves)

    def _begin(self, data: Any) -> None:
        """Evaluate what depends on positions and velocities."""
        self._private.follow()
        self._mujoco.mj_step1(self.model, data)

    def _finish(self, data: Any, halves: bool) -> None:
        """Find forces and accelerations, and integrate."""
        mujoco, model = self._mujoco, self.model
        self._ready = None
        mujoco.mj_fwdActuation(model, data)
        mujoco.mj_fwdAcceleration(model, data)
        self._constrain(data)
        data.flg_rnepost = False
        mujoco.mj_sensorAcc(model, data)
        mujoco.mj_checkAcc(model, data)
        if self._option.enableflags & self._fwdinv:
            mujoco.mj_compareFwdInv(model, data)
        integrator = self._option.integrator
        pushed = self._pushed
        if integrator == _EULER:
            mujoco.mj_Euler(model, data)
        elif integrator == _RK4:
            if halves:
                mujoco.mj_Euler(model, data)
            else:
                finish_runge_kutta(mujoco, model, data, self._stage_of)
        else:
            mujoco.mj_implicit(model, data)
        if pushed:
            mujoco.mj_integratePos(model, data.qpos, self._push, model.opt.timestep)
        self.steps += 1

    def step_half(self, data: Any) -> None:
        """Do what ``mujoco.mj_step2`` does, Euler's method where the model asks for RK4."""
        self.step_second(data, halves=True)

    @in_turn
    def forward(self, data: Any) -> None:
        """Do what ``mujoco.mj_forward`` does: forces and accelerations of the state, exact ones."""
        mujoco, model = self._mujoco, self.model
        self._ready = None
        self._private.follow()
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_sensorPos(model, data)
        energy = model.opt.enableflags & int(mujoco.mjtEnableBit.mjENBL_ENERGY)
        if energy:
            mujoco.mj_energyPos(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_sensorVel(model, data)
        if energy:
            mujoco.mj_energyVel(model, data)
        control = mujoco.get_mjcb_control()
        if control is not None:
            control(model, data)
        mujoco.mj_fwdActuation(model, data)
        mujoco.mj_fwdAcceleration(model, data)
        self._constrain(data)
        data.flg_rnepost = False
        mujoco.mj_sensorAcc(model, data)

    @in_turn
    def derivative(self, data: Any) -> MujocoDerivative:
        """Return the derivatives of the step of a data, which stays as it is; see `MujocoDerivative`.

        Raises
        ------
        ProblemError
            For RK4 and soft contacts, for a step that is not solved, and where contacts come and go.
        """
        if self._option.integrator == _RK4 or self._soft.size:
            raise ProblemError("derivative knows no RK4 and no soft contacts")
        if self._twin is None:
            self._twin = self.twin(tol=1e-10)
        return differentiate(Evaluation(self._mujoco, self._twin, data))

    def _stage_of(self, data: Any, velocity: FloatArray) -> None:
        """Evaluate a stage of RK4 at the data's state; the law is that of a step from a velocity (nv,)."""
        mujoco, model = self._mujoco, self.model
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        control = mujoco.get_mjcb_control()
        if control is not None:
            control(model, data)
        mujoco.mj_fwdActuation(model, data)
        mujoco.mj_fwdAcceleration(model, data)
        self._constrain(data, velocity)

    def _constrain(self, data: Any, start: FloatArray | None = None) -> None:
        """Fill the constraint forces and the accelerations; see `exact_stage`."""
        mujoco, model = self._mujoco, self.model
        if self._soft.size and data.nefc:
            self._harden(data)
        count = data.nefc
        self._pushed, self._status = False, Status.SOLVED
        if count == 0 or (self._soft.size and self._all_soft(data)):
            self._told[:] = 0.0
            mujoco.mj_fwdConstraint(model, data)
            return
        if count > len(self._memory[2]):
            self._memory = memory_room(2 * count, self._memory)
        settings = self._settings
        settings[STEP], settings[START] = self._option.timestep, 0.0
        if start is not None:
            settings[START] = place_of(start)
        if self.restitution:
            settings[SLOWEST] = RESTS * settings[STEP] * float(np.linalg.norm(self._option.gravity))
        if data.nJ != count * model.nv:
            raise foreign_rows()
        failed = self._call(
            *self._memory_views, self._fixed, self._arena, self._layout, count, settings, self._soft,
            *self._inertia(data), self._memory, self._told, self._push,
        )  # fmt: skip
        if failed == FOREIGN:
            raise foreign_rows()
        if failed:
            if failed > 0 and self._told[ERROR] <= ACCEPTED:
                self._status = Status.ALMOST
            else:
                self._soften(data)
                return
        self._pushed = self._told[PUSHED] != 0.0

    def _inertia(self, data: Any) -> tuple[FloatArray, FloatArray]:
        """Return what the integrator takes implicitly: (nv,) damping, or the (nv, nv) inertia; else none."""
        integrator = self._option.integrator
        if integrator == _EULER:
            if self._plain_damping and not self._option.disableflags & self._undamped:
                return self._damping, self._no_dense
            return self._private.damping(data.qvel), self._no_dense
        if integrator == _RK4:
            return self._no_damping, self._no_dense
        if self._implicit is None:
            self._implicit = ImplicitInertia(self._mujoco, self.model)
        return self._no_damping, self._implicit.fill(data)

    def _bind(self, data: Any) -> None:
        """Find where a data lies, and the model's arrays; the stage finds the data's own."""
        model = self.model
        parts = [model.M_rownnz, model.M_rowadr, model.M_colind, model.dof_treeid]
        places = [0] * len(addresses.OF_DATA) + [place_of(part) for part in parts]
        struct = (self._guard.address - FIRST_BYTE) // 8
        sizes = [struct, model.nv, data.M.size, model.ntree]
        self._fixed: IntArray = np.array([*places, *sizes], dtype=np.int64)
        self._ready = None
        if self._bound:  # the impulses of a copy are those of its first data
            self.reset()
        self._bound = True

    def _harden(self, data: Any) -> None:
        """Let soft contacts be seen from where the model says, not from the reach on."""
        contact = data.contact
        soft = self._soft[contact.geom].any(axis=1) if data.ncon else np.zeros(0, bool)
        if soft.any():
            contact.includemargin[soft] -= self._private.reach
            leave_out(contact, soft)
            self._mujoco.mj_makeConstraint(self.model, data)
            self._mujoco.mj_projectConstraint(self.model, data)
            self._mujoco.mj_referenceConstraint(self.model, data)

    def _all_soft(self, data: Any) -> bool:
        """Return whether nothing but soft contacts holds the mechanism."""
        if data.ne or data.nf or data.nl:
            return False
        on = data.contact.efc_address >= 0
        return bool(self._soft[data.contact.geom[on]].any(axis=1).all())

    def _soften(self, data: Any) -> None:
        """Have MuJoCo solve the step softly, and count it."""
        mujoco, plain = self._mujoco, self._private.plain
        self.unsolved += 1
        self._status, self._told[LAST] = Status.STALLED, 0.0
        contact = data.contact
        if data.ncon:
            # what rests exactly is at a distance of rounding: MuJoCo would let it fall
            contact.includemargin[contact.dist >= contact.includemargin] += TOUCHING
            leave_out(contact, np.ones(data.ncon, dtype=bool))
        mujoco.mj_makeConstraint(plain, data)
        mujoco.mj_projectConstraint(plain, data)
        mujoco.mj_referenceConstraint(plain, data)
        mujoco.mj_fwdConstraint(plain, data)


_EULER, _RK4 = 0, 1
"""MuJoCo's numbers of integrators."""
