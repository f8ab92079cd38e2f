"""Which controller walks a robot: by its feet."""

from __future__ import annotations

from surefoot.base.errors import ProblemError
from surefoot.mechanics import Actuators, Robot, Terrain
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.walking.walker import Walker
from surefoot.motion.walking.walking_body import VelocityCommand


def default_gait(robot: Robot) -> str:
    """Return the name of the gait that a robot walks with unless another is given.

    On two feet walk, on three wave, on four trot, on more tripod.
    """
    return {2: "walk", 3: "wave", 4: "trot"}.get(len(robot.feet), "tripod")


def walking_controller(
    robot: Robot,
    command: VelocityCommand,
    gait: str | ContactSchedule | None = None,
    terrain: Terrain | None = None,
    mu: float = 0.6,
    actuators: Actuators | None = None,
    dt: float = 1e-3,
    *,
    watch_friction: bool = False,
) -> Walker:
    """Return the controller that walks a robot with its default settings.

    Two flat feet are walked by `BipedController`, point feet by `WalkingController`.

    Parameters
    ----------
    robot
        With a floating base.
    command
        Wanted velocity over time.
    gait
        A name, or a schedule for the robot's feet; None for `default_gait`.
    terrain
        The ground that the controller believes in; None for flat.
    mu
        Friction that it believes in [-].
    actuators
        What it knows of the motors; None for ideal ones.
    dt
        Time between its steps [s].
    watch_friction
        Whether it believes in less friction where its feet slide; point feet only.

    Raises
    ------
    ModelError
        If the robot cannot walk.
    ProblemError
        If the gait does not fit the robot's feet, or two flat feet should find out terrain or friction.
    """
    chosen = default_gait(robot) if gait is None else gait
    if len(robot.feet) == 2 and all(foot.flat for foot in robot.feet):
        from surefoot.motion.walking.biped.settings import BipedSettings
        from surefoot.motion.walking.biped.walking import BipedController

        if not isinstance(chosen, str) and chosen.period == 0.0:
            raise ProblemError("two flat feet walk with a gait that repeats, not with a list of modes")
        if watch_friction or (terrain is not None and terrain.learns):
            raise ProblemError(f"{robot.name} has flat feet: it has to know terrain and friction")
        biped = BipedSettings(mu=mu, actuators=actuators)
        return BipedController(robot, command, chosen, terrain, biped, dt)
    from surefoot.motion.walking.walking_controller import WalkingController, WalkSettings

    settings = WalkSettings(mu=mu, watch_friction=watch_friction, actuators=actuators)
    return WalkingController(robot, command, chosen, terrain, settings, dt)
