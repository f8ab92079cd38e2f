"""The stepper's own copy of a model: elliptic cones, dense rows, contacts seen a little before they touch.

The user's model is not touched; numbers that are changed in it are followed.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from fnmatch import fnmatchcase
from typing import Any

import numba
import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.errors import ProblemError
from surefoot.base.kernels import INTEGER, entry_point, inline_kernel, kernel
from surefoot.worlds.mujoco.memory_places import all_memory, place_of
from surefoot.worlds.mujoco.stepper.addresses import option_offsets, option_words

FOLLOWED = (
    "body_mass", "body_inertia", "body_ipos", "body_iquat", "body_pos", "body_quat", "body_gravcomp",
    "body_invweight0", "dof_invweight0", "dof_M0", "geom_friction", "geom_pos", "geom_quat", "geom_size",
    "geom_surfacevel", "dof_damping", "dof_armature", "dof_frictionloss", "jnt_stiffness", "jnt_range",
    "qpos_spring", "actuator_gainprm", "actuator_biasprm", "actuator_ctrlrange", "actuator_forcerange",
    "actuator_gear", "pair_friction", "eq_data", "tendon_stiffness", "tendon_damping", "tendon_frictionloss",
    "tendon_range", "geom_solref", "geom_solimp", "geom_solmix", "pair_solref", "pair_solimp",
)  # fmt: skip
"""Arrays of a model whose changes between two steps are followed."""
FOLLOWED_CHOICES = ("geom_priority", "geom_contype", "geom_conaffinity", "geom_condim", "pair_dim")
"""The same of whole numbers."""
WORDS, HALVES, TABLE = numba.int64[::1], numba.int32[::1], numba.int64[:, ::1]
TOUCHING = 1e-6
"""Distance up to which contacts and limits touch where MuJoCo solves a step softly [m, rad]. A judgement: far
above rounding, far below what its contacts sink."""
OWN_OPTIONS = ("cone", "jacobian", "solver", "disableflags")
"""Options that the copies have of their own; all others are followed."""


def refuse(mujoco: Any, model: Any) -> None:
    """Raise a `ProblemError` that names what a model asks for and the stepper does not do."""
    enabled, flags = int(model.opt.enableflags), mujoco.mjtEnableBit
    asked = {
        "flex bodies": model.nflex > 0,
        "plugins": model.nplugin > 0,
        "the integrator discrete": int(model.opt.integrator) > int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST),
        "contact overrides (flag override)": enabled & int(flags.mjENBL_OVERRIDE),
        "sleeping (flag sleep)": enabled & int(flags.mjENBL_SLEEP),
        "adhesion of contacts": bool(getattr(model, "flg_adhesion", False)),
        "speculative contacts (flag speculative)": enabled & int(getattr(flags, "mjENBL_SPECULATIVE", 0)),
        "tendons with inertia": bool(np.any(model.tendon_armature)),
    }
    found = [name for name, has in asked.items() if has]
    if found:
        raise ProblemError(f"MujocoStepper does not know {', '.join(found)}, which this model asks for")


@kernel
def follow_changes(
    words: IntArray, table: IntArray, halves: IntArray, choices: IntArray, place: int, known: IntArray
) -> bool:
    """Copy what differs from one place to two others, (n, 4) from, to, to, number, of whole words and halves.

    Returns whether the words from `place` on are those that are known (m,).
    """
    _copy_changed(words, table)
    _copy_changed(halves, choices)
    return not _differ(words[place:], known, known.size)


@inline_kernel
def _differ(one: IntArray, two: IntArray, count: int) -> bool:
    other = one[0] ^ one[0]
    for i in range(count):  # without a branch: nearly always nothing has changed
        other |= one[i] ^ two[i]
    return bool(other != 0)


@inline_kernel
def _copy_changed(entries: IntArray, table: IntArray) -> None:
    for k in range(table.shape[0]):
        one, two, three = entries[table[k, 0] :], entries[table[k, 1] :], entries[table[k, 2] :]
        if _differ(one, two, table[k, 3]):
            for i in range(table[k, 3]):
                if one[i] != two[i]:
                    two[i] = three[i] = one[i]


def soft_geoms(model: Any, patterns: Sequence[str]) -> FloatArray:
    """Return (ngeom,) 1 for geoms whose name fits a pattern, (0,) without patterns."""
    if not patterns:
        return np.zeros(0)
    names = [model.geom(g).name for g in range(model.ngeom)]
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in names):
            known = ", ".join(sorted(filter(None, names))[:20]) or "no geom has a name"
            raise ProblemError(f"soft: no geom is called {pattern!r}; there are {known}")
    return np.array([float(any(fnmatchcase(name, p) for p in patterns)) for name in names])


def leave_out(contact: Any, which: BoolArray) -> None:
    """Leave contacts out that are apart, of some (c,): without rows, of which MuJoCo leaves old numbers."""
    apart = which & (contact.dist >= contact.includemargin) & (contact.exclude == 0)
    contact.exclude[apart], contact.efc_address[apart] = 1, -1


class PrivateModel:
    """A copy of a model as the stepper needs it, which follows the original.

    Attributes
    ----------
    model
        For MuJoCo's stages: contacts are seen from `reach` on [m].
    plain
        The same without the reach, for what MuJoCo solves softly.
    pyramids
        Whether the original has pyramids for cones.
    """

    def __init__(self, mujoco: Any, original: Any, reach: float) -> None:
        refuse(mujoco, original)
        self.original, self._mujoco = original, mujoco
        self.reach = reach
        self.pyramids = int(original.opt.cone) == int(mujoco.mjtCone.mjCONE_PYRAMIDAL)
        self.plain = self._copy()
        self.model = self._copy()
        self._widen(self.model)
        _, self._words, self._halves = all_memory()
        self._table = self._rows(FOLLOWED, np.float64)
        self._choices = self._rows(FOLLOWED_CHOICES, np.int32)
        self._option, count = option_words(mujoco, original)
        self._known = np.zeros(count, dtype=np.int64)
        self._copy_changes = entry_point(follow_changes, WORDS, TABLE, HALVES, TABLE, INTEGER, WORDS)
        self.follow()

    def _rows(self, names: Sequence[str], kind: type) -> IntArray:
        """Return where arrays of a kind are, in the original and in both copies; see `follow_changes`."""
        rows = list[tuple[int, ...]]()
        for name in names:
            arrays = [getattr(model, name) for model in (self.original, *self._both)]
            if arrays[0].size and arrays[0].dtype == kind:
                rows.append((*map(place_of, arrays), arrays[0].size))
        return np.array(rows, dtype=np.int64).reshape(-1, 4)

    @property
    def _both(self) -> tuple[Any, Any]:
        return self.model, self.plain

    def _copy(self) -> Any:
        """Return a copy with elliptic cones and dense rows."""
        mujoco, model = self._mujoco, copy.copy(self.original)
        model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        model.opt.solver = mujoco.mjtSolver.mjSOL_NEWTON
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ISLAND)
        return model

    def _widen(self, model: Any) -> None:
        """Let contacts and limits be seen from the reach on."""
        model.geom_margin[:] += 0.5 * self.reach
        model.pair_margin[:] += self.reach
        model.body_margin[:] += self.reach
        kinds = self._mujoco.mjtSensor
        asked = set(map(int, model.sensor_type)) & {
            int(kinds.mjSENS_JOINTLIMITPOS), int(kinds.mjSENS_TENDONLIMITPOS),
        }  # fmt: skip
        if not asked:  # else their readings would begin at the reach
            model.jnt_margin[:] += self.reach
            model.tendon_margin[:] += self.reach
            self.plain.jnt_margin[:] += TOUCHING
            self.plain.tendon_margin[:] += TOUCHING
        self.limit_reach = 0.0 if asked else self.reach

    def follow(self) -> None:
        """Take over what was changed in the original since the last step."""
        if not self._copy_changes(
            self._words, self._table, self._halves, self._choices, self._option, self._known
        ):
            self._take_options()

    def _take_options(self) -> None:
        """Take over the options of the original."""
        refuse(self._mujoco, self.original)
        option = self.original.opt
        for model in self._both:
            own = model.opt
            for name in option_offsets(self._mujoco).keys() - set(OWN_OPTIONS):
                setattr(own, name, getattr(option, name))
            own.disableflags = int(option.disableflags) | int(self._mujoco.mjtDisableBit.mjDSBL_ISLAND)
        self._known[:] = self._words[self._option : self._option + self._known.size]

    def damping(self, qvel: FloatArray) -> FloatArray:
        """Return what Euler's method takes implicitly (nv,) [N s/m, N m s/rad]; (0,) for none."""
        model, bits = self.model, self._mujoco.mjtDisableBit
        off = int(bits.mjDSBL_EULERDAMP) | int(bits.mjDSBL_DAMPER)
        if int(model.opt.disableflags) & off:
            return np.zeros(0)
        linear, poly = np.array(model.dof_damping), np.array(model.dof_dampingpoly).reshape(model.nv, -1)
        for joint, actuator in self._dampers():
            here = model.dof_jntid == joint
            gear = float(model.actuator_gear.reshape(-1, 6)[model.actuator_outadr[actuator], 0]) ** 2
            linear[here] += model.actuator_damping[actuator] * gear
            poly[here] += model.actuator_dampingpoly.reshape(-1, poly.shape[1])[actuator] * gear
        powers = np.arange(1, poly.shape[1] + 1)
        # the slope of v (b + Σ c_i |v|^i)
        slope = linear + ((powers + 1) * poly * np.abs(qvel)[:, None] ** powers).sum(axis=1)
        return slope if slope.any() else np.zeros(0)

    def _dampers(self) -> list[tuple[int, int]]:
        """Return pairs of a joint and an actuator that damps it."""
        model, out = self.model, []
        kinds = (int(self._mujoco.mjtTrn.mjTRN_JOINT), int(self._mujoco.mjtTrn.mjTRN_JOINTINPARENT))
        for joint, actuator in enumerate(np.array(model.jnt_actuatorid).tolist()):
            if actuator >= 0:
                out.append((joint, actuator))
            elif actuator < -1:
                same = np.array(model.actuator_trnid).reshape(-1, 2)[:, 0] == joint
                same &= np.isin(model.actuator_trntype, kinds)
                out += [(joint, int(a)) for a in np.flatnonzero(same)]
        return out
