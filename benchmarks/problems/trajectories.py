"""Trajectories of wanted wrenches from simulated stands, for measuring what a warm start is worth."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.problems.allocations import Instance, instances_of

ROBOT, DURATION = "go2", 4.0


@dataclass(frozen=True)
class Scene:
    """A stand of `surefoot stand go2 --slope S --mu MU --push ... --duration 4`.

    Attributes
    ----------
    name
        What the table calls it.
    slope
        Of the ground [deg].
    mu
        Its friction, which the controller knows.
    pushes
        Start [s], force [N] and duration [s] of each push.
    """

    name: str
    slope: float
    mu: float
    pushes: tuple[tuple[float, tuple[float, float, float], float], ...]


SCENES = (
    Scene("flat", 0.0, 0.6, ((1.0, (60.0, 30.0, 0.0), 0.2), (2.5, (-40.0, 60.0, 0.0), 0.2))),
    Scene("ice", 0.0, 0.15, ((1.0, (20.0, 10.0, 0.0), 0.3), (2.5, (-20.0, 15.0, 0.0), 0.3))),
    Scene("slope", 20.0, 0.5, ((1.0, (20.0, 20.0, 0.0), 0.2), (2.5, (-20.0, 20.0, 0.0), 0.2))),
    Scene("sliding", 20.0, 0.5, ((1.0, (60.0, 30.0, 0.0), 0.2), (2.5, (-30.0, 60.0, 0.0), 0.2))),
)


def simulate(scene: Scene, duration: float = DURATION) -> list[Instance]:
    """Run the stand for some time [s] and return its allocations, one per control step.

    Raises
    ------
    MissingExtra
        If MuJoCo or Pinocchio is not installed.
    """
    from surefoot.mechanics.robot import load_robot, place
    from surefoot.mechanics.terrain import FlatTerrain, SlopeTerrain
    from surefoot.motion.standing.standing_controller import StandingController
    from surefoot.motion.standing.standing_plan import StandingPlan
    from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
    from surefoot.worlds.running.run import Push, Scenario, run
    from surefoot.worlds.running.scenario import START_DEPTH

    robot = load_robot(ROBOT)
    terrain = SlopeTerrain(scene.slope) if scene.slope else FlatTerrain()
    q = place(robot, terrain)
    controller = StandingController(robot, StandingPlan(robot, terrain, q), terrain, q, scene.mu)
    scenario = Scenario(
        duration, scene.mu, [Push(*push) for push in scene.pushes], start=q, depth=START_DEPTH
    )
    log = run(MujocoWorld(robot, terrain, scene.mu), controller, scenario)
    return instances_of({**log.facts, **log.arrays})
