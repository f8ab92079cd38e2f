"""What SOLVED asks beside a goal: forces moved the robot, no link hits, a finer run ends at the same place.

Three checks that share no arithmetic with the knots of a plan:

- **momentum**: Pinocchio's whole-body momentum at the knots, against that of the start plus gravity's, the
  ground's impulses and those of motors that push against the world;
- **links**: nothing but feet on the ground touches at any knot: as boxes and capsules (`robot_geometry`), two
  links also as they are; for robots that have shapes. Ditches that a motion passes over count as filled, and
  feet stay out of them and of steps at the knots and in the replay;
- **replay**: the plan's torques with feedback of its joints through steps of second order, ten to a knot::

      tau = tau_k + K (q_k + s (q_{k+1} - q_k) - q) + D ((q_{k+1} - q_k) / dt - v),
      K = effort / 0.2,    D = 0.02 s K

  Its joints must not run beyond their speed limits: where they do, landings in another world throw the robot.
  s is the share of the way that is over, K and D are of every joint with a motor: its whole effort at
  0.2 rad (or m), and 20 ms of damping. Torques stay within the limits. A knot's velocity is the one half-way
  to the next: so are its torques those from half a knot before it to half a knot after.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import SimulationError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import (
    SLIDES,
    Geometry,
    PairDetection,
    Robot,
    StepOptions,
    Stepper,
    Terrain,
    coal,
    robot_geometry,
)
from surefoot.motion.planning.stepped_ground import find_passed_ground
from surefoot.motion.planning.trajectory import TorquePolicy, Trajectory
from surefoot.motion.planning.transcription.planar import passive_joints

if TYPE_CHECKING:
    from surefoot.motion.planning.transcription.direct_problem import DirectProblem

MOMENTUM, APART, FAST = 0.01, 0.02, 1.05
"""Most that momentum may be off the impulses, as a share of the largest; most that the replay may end off the
plan [m]; and largest mean speed of a joint over a knot's length of it, over its limit."""
DEEP = 5e-3
"""How far links may be in each other [m]: boxes and capsules stand for their shapes."""
TOLD = 2
"""How many of the deepest hits are named."""
FINER = 10
"""Steps of the replay in a knot."""
WHOLE_EFFORT, DAMPING = 0.2, 0.02
"""Joint error at which the feedback gives a motor's whole effort [rad, m], and damping over stiffness [s]."""


@dataclass(frozen=True)
class Certificate:
    """What the checks said of a plan.

    Attributes
    ----------
    momentum
        Largest disagreement of momentum and impulses, over the largest momentum [-].
    apart
        How far from the plan's the replay's centre of mass ends [m], infinite where the replay was lost.
    speed
        Largest speed of a joint in the replay, as the mean over a knot's length, over its limit [-].
    hits
        What touches beside feet on the ground, by name, and how deep [m].
    seconds
        CPU time that the checks took [s].
    """

    momentum: float
    apart: float
    speed: float
    hits: dict[tuple[str, str], float]
    seconds: float

    @property
    def holds(self) -> bool:
        """Whether momentum and replay are within `MOMENTUM`, `APART` and `FAST`, and nothing hits."""
        close = self.momentum <= MOMENTUM and self.apart <= APART
        return close and self.speed <= FAST and not self.hits

    @property
    def facts(self) -> dict[str, float]:
        """By name, for a log."""
        return {
            "momentum_error": self.momentum, "replay_apart": self.apart, "replay_speed": self.speed,
            "replay_time": self.seconds,
        }  # fmt: skip

    def __str__(self) -> str:
        said = "" if self.momentum <= MOMENTUM else f"momentum is {self.momentum:.1%} off the impulses, "
        said += f"a replay at a tenth of the step ends {100.0 * self.apart:.2g} cm off"
        fast = [f"its joints run at {self.speed:.2g} times their limits"] if self.speed > FAST else []
        deepest = sorted(self.hits.items(), key=lambda hit: -hit[1])
        hits = [f"{a} goes {1e3 * depth:.0f} mm into {b}" for (a, b), depth in deepest[:TOLD]]
        more = [f"{len(deepest) - TOLD} more hits"] if len(deepest) > TOLD else []
        return ", ".join([f"forecast: {said}", *fast, *hits, *more])


def certify(
    trajectory: Trajectory, robot: Robot, terrain: Terrain, problem: DirectProblem | None = None
) -> Certificate:
    """Return what the checks say of a lawful motion; `problem` where more touches than feet the ground."""
    begun = time.process_time()
    momentum = momentum_error(trajectory, robot, terrain)
    apart, speed, replay = replay_plan(trajectory, robot, terrain, problem)
    between = find_passed_ground(terrain, robot, trajectory.q[0], trajectory.q[-1])
    hits = link_hits(trajectory, robot, between or terrain)
    if between is not None:
        hits |= foot_hits(np.vstack([trajectory.q, replay]), robot, between)
    return Certificate(momentum, apart, speed, hits, time.process_time() - begun)


def foot_hits(configurations: FloatArray, robot: Robot, between: Terrain) -> dict[tuple[str, str], float]:
    """Return which feet are deeper than `DEEP` in what a motion passes over (T, nq): names to depth [m]."""
    feet = np.array([robot.foot_positions(q) for q in configurations])
    depths = (robot.contact_points.foot_radii - between.gap(feet)).max(axis=0)
    named = zip(robot.foot_names, depths.tolist(), strict=True)
    return {(name, "the ditch or step that it passes"): depth for name, depth in named if depth > DEEP}


def link_hits(trajectory: Trajectory, robot: Robot, terrain: Terrain) -> dict[tuple[str, str], float]:
    """Return what is deeper in another than `DEEP` at a knot, but feet in the ground: names to depth [m]."""
    if not robot.collision.geometryObjects:
        return {}
    found, feet = dict[tuple[str, str], float](), set(robot.foot_names)
    geometry = robot_geometry(robot)
    near = PairDetection(robot.model.copy(), robot, geometry, terrain, trajectory.dt)
    meet = _own_shapes(robot, geometry)
    for q in trajectory.q:
        gaps = near.at(q).gaps
        for contact in np.flatnonzero(gaps < -DEEP):
            # ground of boxes has pieces, which come first or last
            one, other = sorted(near.names[near.group[contact]], key=lambda name: name.startswith("ground"))
            other = "ground" if other.startswith("ground") else other
            if one.split(":")[0] not in feet if other == "ground" else meet(near.data, one, other):
                found[one, other] = max(found.get((one, other), 0.0), -float(gaps[contact]))
    return found


def _own_shapes(robot: Robot, geometry: Geometry) -> Callable[[Any, str, str], bool]:
    """Return whether two links, by name, overlap as they are, meshes and all, in Pinocchio's data."""
    import pinocchio

    library = coal()
    shapes = {
        s.name: (s.joint, pinocchio.SE3(s.rotation, s.position), s.shape.solid()) for s in geometry.solids
    }
    shapes |= {o.name: (o.parentJoint, o.placement, o.geometry) for o in robot.collision.geometryObjects}

    def meet(data: Any, one: str, other: str) -> bool:
        placed = []
        for joint, place, shape in (shapes[one], shapes[other]):
            pose = data.oMi[joint] * place
            placed += [shape, library.Transform3s(pose.rotation, pose.translation)]
        return bool(library.collide(*placed, library.CollisionRequest(), library.CollisionResult()))

    return meet


def momentum_error(trajectory: Trajectory, robot: Robot, terrain: Terrain) -> float:
    """Return the largest disagreement of whole-body momentum and impulses, over the largest momentum.

    Linear momentum, along the axes in which nothing bolts the robot to the world; 0 for a robot that is.
    """
    import pinocchio

    t, model, data = trajectory, robot.model, robot.model.createData()
    given = [np.array(pinocchio.computeCentroidalMomentum(model, data, q, v).linear)
             for q, v in zip(t.q, t.v, strict=True)]  # fmt: skip
    frames = [terrain.frame(xy) for xy in t.positions[:-1, :, :2].reshape(-1, 2)]
    pushes = np.einsum("kij,kj->ki", np.array(frames).reshape(-1, 3, 3), t.impulses.reshape(-1, 3))
    changes = pushes.reshape(*t.impulses.shape[:2], 3).sum(axis=1)
    changes[:, 2] -= t.dt * robot.mass * GRAVITY
    axes = np.arange(3)
    if not robot.floating:
        slides = _slides(model)
        for joint, axis in slides:
            changes[:, axis] += t.dt * t.torques[:, joint]
        axes = np.unique([axis for _, axis in slides]).astype(np.int64)
    off = np.diff(np.array(given), axis=0) - changes
    most = max(float(np.linalg.norm(given, axis=1).max()), t.dt * robot.mass * GRAVITY)
    return float(np.abs(np.cumsum(off, axis=0)[:, axes]).max(initial=0.0)) / most


def _slides(model: Any) -> list[tuple[int, int]]:
    """Return index and axis of the slides that push against the world; none where a body is bolted."""
    out, rails = list[tuple[int, int]](), {0}
    for joint in range(1, model.njoints):
        kind = str(model.joints[joint].shortname())
        if model.parents[joint] in rails and kind in SLIDES:
            rails.add(joint)
            out.append((int(model.joints[joint].idx_v), SLIDES.index(kind)))
        elif model.parents[joint] == 0:
            return []
    return out


def feedback(trajectory: Trajectory, robot: Robot) -> TorquePolicy:
    """Return the torques (joints,) of a plan with feedback of its joints, by step of the replay, q and v."""
    t, joints = trajectory, robot.joints
    effort = np.where(passive_joints(robot), 0.0, robot.effort_limits)
    most = np.abs(t.torques).max(axis=0)
    effort = np.where(effort < 1e6, effort, most)
    stiff = effort / WHOLE_EFFORT

    def torques(step: int, q: FloatArray, v: FloatArray) -> FloatArray:
        # In knots, and half a one behind the torques: in the first half no way is known, the start is held.
        at = (step + 0.5) / FINER - 0.5
        k, here = min(step // FINER, len(t) - 1), min(max(int(np.floor(at)), 0), len(t) - 1)
        way = t.q[here + 1, -joints:] - t.q[here, -joints:] if at > 0.0 else np.zeros(joints)
        off = t.q[here, -joints:] + (at - here) * way - q[-joints:]
        given = t.torques[k] + stiff * off + DAMPING * stiff * (way / t.dt - v[-joints:])
        return np.asarray(np.clip(given, -effort, effort))

    return torques


def replay_plan(
    trajectory: Trajectory, robot: Robot, terrain: Terrain, problem: DirectProblem | None = None
) -> tuple[float, float, FloatArray]:
    """Return how far from the plan's end a replay by steps of second order ends [m], and its joints' speed.

    The speed is the largest over its limit, see `Certificate`; infinite both where the replay is lost. The
    configurations (T, nq) that it went through come third.

    Where bodies touch beside feet on the ground (`problem`), by first-order steps of a tenth of the knot:
    what touches there are points on slides, whose motion between impulses has nothing of second order.
    """
    t, fine = trajectory, trajectory.dt / FINER
    torques, steps = feedback(t, robot), FINER * len(t) + FINER // 2
    if problem is not None and problem.touches:
        from surefoot.motion.planning.transcription.pair_rollout import rollout_with_pairs

        finer = replace(problem, dt=fine, knots=steps, reference=None, windows={})
        motion = rollout_with_pairs(finer, torques)
        went = motion.q
    else:
        stepper = Stepper(robot, terrain, StepOptions(dt=fine))
        state, went = stepper.start(t.q[0], t.v[0]), np.empty((steps, robot.model.nq))
        try:
            for k in range(steps):
                state = stepper.step(state, torques(k, state.q, state.v), mu=t.mu).state
                went[k] = state.q
        except SimulationError:
            return np.inf, np.inf, went[:k]
    end, angles = went[-1], went[:, -robot.joints :]
    apart = float(np.linalg.norm(robot.com(end) - robot.com(t.q[-1])))
    ways = (
        np.abs(angles[FINER:] - angles[:-FINER]) / t.dt
    )  # in coarse knots the feedback makes joints tremble
    use = float((ways / robot.speed_limits).max())
    return (apart, use, went) if np.isfinite(apart) else (np.inf, np.inf, went[:0])
