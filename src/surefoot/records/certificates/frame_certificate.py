"""The proof of one frame's verdict, as arrays that anyone can check."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.records.certificates.frame_data import FrameData
from surefoot.records.certificates.frame_kernels import solve_frame, sum_forces, workspace
from surefoot.records.certificates.touching_points import TouchingPoints


@dataclass(frozen=True, eq=False)
class FrameCertificate:
    """What a frame needs, what its contacts and motors can give, and the best forces with what they leave.

    All is over m g, moments and torques over `arm` m g. The first six dimensions are force and moment about
    the centre of mass, world axes; the others are torques beyond a limit of a motor, which only count above
    zero::

        left = needed - sum maps[:, c] @ forces[c],    left[6:] = max(left[6:], 0)
        share = |left|,    forces[c] in the cone |f_t| <= mu[c] f_n  (0: a ray along the third axis)

    `residual` proves that nobody's forces do better: ``maps[:, c].T @ residual`` lies in the polar of every
    cone and ``residual[6:] >= 0``, so that every choice leaves at least ``needed @ residual / |residual|``.

    Attributes
    ----------
    frame, time
        Which frame, and when [s].
    needed
        (d,) [-].
    maps
        (d, c, 3) from forces in contact axes [-].
    mu
        (c,) friction of the cones [-].
    names, places, axes
        (c,) points, (c, 3) where they are in the world [m], (c, 3, 3) their axes, the third one the cone's.
    forces
        (c, 3) best ones, in contact axes [m g].
    residual
        (d,) [-].
    share, bound
        What the forces leave, and what none leave less than [m g].
    joints
        (d - 6,) names of the joints whose torque limits are the other dimensions.
    torques, torque_low, torque_high
        (j,) of all joints with those forces, and what the motors can give [N m, N].
    mass, arm
        [kg], and the length by which moments are divided [m].
    """

    frame: int
    time: float
    needed: FloatArray
    maps: FloatArray
    mu: FloatArray
    names: tuple[str, ...]
    places: FloatArray
    axes: FloatArray
    forces: FloatArray
    residual: FloatArray
    share: float
    bound: float
    joints: tuple[str, ...]
    torques: FloatArray
    torque_low: FloatArray
    torque_high: FloatArray
    mass: float
    arm: float

    @property
    def forces_world(self) -> FloatArray:
        """(c, 3) the best forces in world axes [N]."""
        return np.asarray(self.mass * GRAVITY * np.einsum("cij,cj->ci", self.axes, self.forces))


def certificate_of(
    data: FrameData, points: TouchingPoints, joints: tuple[str, ...], k: int
) -> FrameCertificate:
    """Return the certificate of a frame whose window is whole, solved anew."""
    model = data.model
    work = workspace(len(model.points.body), len(model.tree.mass), len(model.motion.joints))
    count, rows, share, bound, _ = solve_frame(model, k, work)
    contacts, joint = work.contacts, work.joint
    d = 6 + rows
    # a torque below its lower limit counts as one above zero, too
    sign = np.concatenate([np.ones(6), np.where(joint[:rows] % 2 == 1, 1.0, -1.0)])
    rays = contacts.mu[:count] <= 0.0
    force = work.forces[:count].copy()
    force[rays, :2] = 0.0
    unit = model.rules.mass * GRAVITY * model.rules.arm
    return FrameCertificate(
        k,
        k * model.window.step,
        sign * work.b[:d],
        np.ascontiguousarray(np.moveaxis(contacts.maps[:count, :, :d] * sign, 2, 0)),
        contacts.mu[:count].copy(),
        tuple(points.names[model.points.owner[p]] for p in contacts.point[:count]),
        contacts.places[:count] + model.motion.com[k],
        contacts.frames[:count].copy(),
        force,
        sign * work.r[:d],
        float(share),
        float(bound),
        tuple(joints[n // 2] for n in joint[:rows]),
        work.torques * unit,
        model.motors.low[k].copy(),
        model.motors.high[k].copy(),
        model.rules.mass,
        model.rules.arm,
    )


def link_wrenches(data: FrameData, points: TouchingPoints) -> dict[str, FloatArray]:
    """Return what the best forces of each link sum to, see `MotionReport.contact_wrenches`."""
    links = [points.links[p] for p in data.model.points.owner]
    names = list(dict.fromkeys(links))
    group = np.array([names.index(link) for link in links], dtype=np.int64)
    sums = np.full((len(data.model.motion.com), len(names), 6), np.nan)
    sums[data.frames] = 0.0
    sum_forces(data.model, data.frames, group, sums)
    pressed = np.nan_to_num(np.abs(sums)).max(axis=(0, 2), initial=0.0) > 0.0
    return {name: sums[:, n] for n, name in enumerate(names) if pressed[n]}
