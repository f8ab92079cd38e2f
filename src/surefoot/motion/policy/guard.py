"""A guard around a policy: torques whose contact forces would leave their cones are changed.

Torques τ and feet that stand fast imply contact forces: with M a + h = Sᵀ τ + Jᵀ f and J a = -drift - κ J v,

    (J M⁻¹ Jᵀ) f = -drift - κ J v - J M⁻¹ (Sᵀ τ - h).

A foot that this f would pull on is on its way up and is left out. Where all the others push within their
cones, the command passes as it is. Else the accelerations a that it would have with that f become tasks of
`WholeBodyController`, which finds the nearest that forces on the exact cones and motors within their limits
can give.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.kernels import kernel
from surefoot.base.numerics.cholesky import cholesky, solve_columns, solve_lower, solve_upper
from surefoot.base.numerics.points import contact_jacobian, point_velocity
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import FlatTerrain, Terrain
from surefoot.motion.control.controller import Command, Controller, RobotState, Wrapper
from surefoot.motion.control.damping import computable_pose
from surefoot.motion.control.whole_body import Tasks, WholeBodyController
from surefoot.motion.control.whole_body_kernels import place_points

RATE = 20.0
"""Rate κ at which feet that stand are to stop [1/s]."""
ROUNDS = 3
"""How often feet are left out that forces would pull on."""
SOFTENING = 1e-7
"""Share by which the diagonal of J M⁻¹ Jᵀ grows: four corners of a sole share what they cannot tell apart."""


class Guard(Wrapper):
    """A controller whose torques are changed when, and only when, they imply forces outside the cones.

    Parameters
    ----------
    controller
        Whose commands are guarded; joint targets count as the torques that they give now.
    mu
        Friction that may be counted on [-].
    terrain
        The ground that is believed in, for its normals; None for flat.

    Attributes
    ----------
    steps, changed
        How many commands there were since the last reset, and how many of them were changed.

    Raises
    ------
    ProblemError
        For a controller that knows no robot.
    """

    def __init__(self, controller: Controller, mu: float = 0.6, terrain: Terrain | None = None) -> None:
        super().__init__(controller)
        known = getattr(controller, "robot", None)
        if known is None:
            raise ProblemError("a guard needs a robot: its controller knows of none")
        self.mu = real_number("mu", mu, low=0.0)
        self.robot, self._terrain = known, FlatTerrain() if terrain is None else terrain
        self._body = WholeBodyController(known, self.mu, baumgarte=(0.0, RATE))
        self._points, self._level = known.contact_points, np.tile(np.eye(3), (len(known.feet), 1, 1))
        self._frame_of = np.array(self._points.frames)
        self.posture = getattr(controller, "posture", None)
        self._forget()

    def _forget(self) -> None:
        self._body.reset()
        self.steps = self.changed = 0

    def warm_up(self, state: RobotState) -> None:
        """Compile all that a step may call."""
        super().warm_up(state)
        self._solve(state, np.zeros(self.robot.joints), always=True)
        self.reset()

    def step(self, state: RobotState) -> Command:
        """Return the controller's command, or the nearest one whose contact forces are lawful."""
        command, joints = self.controller.step(state), self.robot.joints
        self.steps += 1
        if state.contact is None or not computable_pose(state.q, state.v):
            return command
        torques, limits = command.torques, self.robot.effort_limits
        if command.joint_targets is not None:
            wanted = command.joint_targets.torques(state.q[-joints:], state.v[-joints:])
            torques = np.minimum(np.maximum(wanted, -limits), limits)
        answer = self._solve(state, torques)
        if answer is None:
            return command
        self.changed += 1
        return type(command)(
            **{
                **vars(command), "torques": answer.torques, "forces": answer.forces, "joint_targets": None,
                "attained": answer.feasible, "status": answer.distribution,
            }
        )  # fmt: skip

    def _solve(self, state: RobotState, torques: FloatArray, always: bool = False) -> Any:
        """Return the answer of whole-body control; None for torques that imply lawful forces."""
        body, points = self._body, self._points
        now, views = body.update(state.q, state.v), body._views
        frames = self._frames(now.centres)
        on, forces, accelerations = implied_forces(
            views.mass_matrix, views.bias, views.twists, points.foot_support, points.foot,
            body.foot_rotations, views.frame_places[self._frame_of], points.centres, points.foot_radii,
            frames, now.drifts, state.v, torques, np.asarray(state.contact),
        )  # fmt: skip
        sideways = np.hypot(forces[:, 0], forces[:, 1])
        if not on.any() or (not always and (sideways <= self.mu * forces[:, 2]).all()):
            return None
        stands, swings, push = reference_motion(
            on, forces, accelerations, views.twists, points.foot_support, points.foot, frames, now.centres,
            now.drifts,
        )  # fmt: skip
        turn, gaps = now.rotation @ accelerations[3:6], np.zeros(len(stands))
        push[2] -= body.mass * GRAVITY
        return body.solve(
            Tasks(stands, push / body.mass, turn, swings, accelerations[6:], forces, frames, gaps)
        )

    def _frames(self, centres: FloatArray) -> FloatArray:
        """Return the grounds' frames under (n, 3) feet: (n, 3, 3)."""
        if self._terrain.text == "flat":
            return self._level
        return np.array([self._terrain.frame(place[:2]) for place in centres])


@kernel
def implied_forces(
    M: FloatArray, bias: FloatArray, twists: FloatArray, support: BoolArray, foot: IntArray,
    rotations: FloatArray, places: FloatArray, offsets: FloatArray, radii: FloatArray, frames: FloatArray,
    drifts: FloatArray, v: FloatArray, torques: FloatArray, stands: BoolArray,
) -> tuple[BoolArray, FloatArray, FloatArray]:  # fmt: skip
    """Return which points stand, forces on them, contact frames [N], and accelerations; see the module.

    Parameters
    ----------
    M, bias, twists
        (nv, nv), (nv,), (6, nv): dynamics, and data.J.
    support, foot, rotations, places, offsets, radii, frames
        Of n feet and p points, see `place_points` and `contact_jacobian`.
    drifts, v, torques, stands
        (n, 6) accelerations of feet at zero joint acceleration; (nv,); (joints,) [N m]; (n,).
    """
    nv, n, p = len(v), len(radii), len(foot)
    arms, normals = np.empty((n, 3)), np.empty((n, 3))
    point_frames, points, J = np.empty((p, 3, 3)), np.empty((p, 3)), np.empty((3 * p, nv))
    place_points(frames, foot, rotations, places, offsets, radii, normals, arms, point_frames, points)
    contact_jacobian(twists, support, foot, points, point_frames, J)
    # B = M⁻¹ [Jᵀ, Sᵀ τ - h]
    L, B = M.copy(), np.empty((nv, 3 * p + 1))
    B[:, : 3 * p] = J.T
    for i in range(nv):
        B[i, 3 * p] = (torques[i - 6] if i >= 6 else 0.0) - bias[i]
    forces, on = np.zeros((p, 3)), np.zeros(p, dtype=np.bool_)
    for k in range(p):
        on[k] = stands[foot[k]]
    if not cholesky(L):
        return np.zeros(p, dtype=np.bool_), forces, np.zeros(nv)
    solve_columns(L, B)
    left = np.empty(3 * p)
    for r in range(3 * p):
        left[r] = -RATE * np.dot(J[r], v) - np.dot(J[r], B[:, 3 * p].copy())
        for i in range(3):
            left[r] -= point_frames[r // 3, i, r % 3] * drifts[foot[r // 3], i]
    for _ in range(ROUNDS):
        at = np.array([3 * k + i for k in range(p) if on[k] for i in range(3)])
        m = len(at)
        G, f = np.empty((m, m)), left[at]
        for a in range(m):
            for b in range(m):
                G[a, b] = np.dot(J[at[a]], B[:, at[b]].copy())
        for a in range(m):
            G[a, a] *= 1.0 + SOFTENING
        forces[:] = 0.0
        if m == 0 or not cholesky(G):
            break
        solve_lower(G, f)
        solve_upper(G, f)
        pulled = False
        for a in range(m):
            forces[at[a] // 3, at[a] % 3] = f[a]
        for k in range(p):
            if on[k] and forces[k, 2] <= 0.0:  # on its way up
                on[k], pulled = False, True
        if not pulled:
            break
    accelerations = B[:, 3 * p].copy()
    for k in range(p):
        for i in range(3):
            if not on[k]:
                forces[k, i] = 0.0
            accelerations += forces[k, i] * B[:, 3 * k + i]
    return on, forces, accelerations


@kernel
def reference_motion(
    on: BoolArray, forces: FloatArray, accelerations: FloatArray, twists: FloatArray, support: BoolArray,
    foot: IntArray, frames: FloatArray, centres: FloatArray, drifts: FloatArray,
) -> tuple[BoolArray, FloatArray, FloatArray]:  # fmt: skip
    """Return which feet stand (n,), accelerations (n, 6) of feet, the sum of forces (3,) [N]; world axes.

    Arguments as for `implied_forces`, which gives the first three; `centres` (n, 3) of the feet [m].
    """
    stands, push, swings = np.zeros(len(frames), dtype=np.bool_), np.zeros(3), drifts.copy()
    for k in range(len(foot)):
        if on[k]:
            stands[foot[k]] = True
            push += frames[foot[k]] @ forces[k]
    for k in range(len(frames)):
        for j in range(len(accelerations)):
            if support[k, j]:
                x, y, z = point_velocity(twists, j, centres[k, 0], centres[k, 1], centres[k, 2])
                swings[k, 0] += x * accelerations[j]
                swings[k, 1] += y * accelerations[j]
                swings[k, 2] += z * accelerations[j]
                swings[k, 3:] += twists[3:, j] * accelerations[j]
    return stands, swings, push
