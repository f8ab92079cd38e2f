"""The walking controller away from any world: plans, cones, safety and refusals."""

import numpy as np
import pytest

from surefoot.base.errors import ModelError
from surefoot.contact import Status
from surefoot.mechanics.robot import Robot, place
from surefoot.mechanics.terrain import FlatTerrain, SlopeTerrain, Terrain, rough_ground
from surefoot.motion.control.controller import RobotState
from surefoot.motion.gaits.gait import ModeSchedule
from surefoot.motion.ground.touched_ground import TouchedGround
from surefoot.motion.walking.behaviours import BEHAVIOURS, StandStill
from surefoot.motion.walking.behaviours.arbiter import LOGGED
from surefoot.motion.walking.behaviours.behaviour import Request, WalkView
from surefoot.motion.walking.walkers import walking_controller
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController, WalkSettings
from tests.motion.walking.behaviours.views import Wanting
from tests.robots import robot_of

FORWARD = VelocityCommand.constant(0.5)
ALL = np.ones(4, dtype=bool)


def test_a_standing_robot_gets_forces_that_carry_it() -> None:
    robot = robot_of("go2")
    state = RobotState(place(robot), np.zeros(robot.model.nv), 0.0, ALL)
    command = WalkingController(robot, FORWARD).step(state)
    assert command.attained
    assert command.active.all()
    assert command.forces[:, 2].sum() == pytest.approx(robot.mass * 9.81, rel=0.1)


def test_forces_follow_the_terrain_not_the_world() -> None:
    robot, slope = robot_of("go2"), SlopeTerrain(20.0)
    controller = WalkingController(robot, VelocityCommand.constant(0.0), terrain=slope)
    command = controller.step(RobotState(place(robot, slope), np.zeros(robot.model.nv), 0.0, ALL))
    world = np.einsum("nij,nj->i", command.frames, command.forces)
    assert world == pytest.approx([0.0, 0.0, robot.mass * 9.81], abs=0.1 * robot.mass * 9.81)
    assert command.frames[0][:, 2] == pytest.approx(slope.normal([0.0, 0.0]))


def test_the_gait_lifts_feet_after_the_start() -> None:
    robot = robot_of("go2")
    controller = WalkingController(robot, FORWARD, settings=WalkSettings(start=0.1))
    q, v = place(robot), np.zeros(robot.model.nv)
    lifted = [controller.step(RobotState(q, v, t, ALL)).active.tolist() for t in (0.0, 0.05, 0.15, 0.16)]
    assert lifted[0] == lifted[1] == [True] * 4
    assert False in lifted[2] or False in lifted[3]


def test_swing_feet_get_exactly_no_force() -> None:
    robot = robot_of("go2")
    controller = WalkingController(robot, FORWARD, settings=WalkSettings(start=0.0))
    q, v = place(robot), np.zeros(robot.model.nv)
    for t in np.arange(0.0, 0.2, 0.005):
        command = controller.step(RobotState(q, v, float(t), ALL))
        assert (command.forces[~command.active] == 0.0).all()


def test_a_robot_twice_as_fast_as_possible_is_slowed_and_said_so() -> None:
    controller = WalkingController(robot_of("go2"), VelocityCommand.constant(9.0))
    slowed, hurries = controller.notes
    assert "slowed to" in slowed
    assert "the trot hurries" in hurries
    assert 0.5 < controller.command.values[0, 0] < 3.0


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_state_that_is_not_finite_gives_a_safe_command(bad: float) -> None:
    robot = robot_of("go2")
    controller = WalkingController(robot, FORWARD)
    q, v = place(robot), np.zeros(robot.model.nv)
    controller.step(RobotState(q, v, 0.0, ALL))
    v[4], v[10] = bad, 2.0
    command = controller.step(RobotState(q, v, 0.021, ALL))
    assert command.torques[4] < 0.0  # slows the joint that moves
    assert not command.attained
    assert np.isfinite(command.torques).all()
    assert (np.abs(command.torques) <= robot.effort_limits).all()


def fallen(robot: Robot, angle: float) -> np.ndarray:
    """Return the configuration of a robot rolled by an angle [rad] about its length."""
    q = place(robot)
    q[3:7] = [np.sin(0.5 * angle), 0.0, 0.0, np.cos(0.5 * angle)]
    return q


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_on_its_back_nothing_is_attained(name: str) -> None:
    robot = robot_of(name)
    contact = np.ones(len(robot.feet), dtype=bool)
    still = RobotState(place(robot), np.zeros(robot.model.nv), 0.0, contact)
    walk = walking_controller(robot, VelocityCommand.constant(0.0))
    assert walk.step(still).attained
    for k, angle in enumerate((np.pi, 0.5 * np.pi, -1.2)):
        over = still._replace(q=fallen(robot, angle), time=0.001 * (k + 1))
        assert not walk.step(over).attained
        assert (
            not walking_controller(robot, VelocityCommand.constant(0.0))
            .step(over._replace(contact=None))
            .attained
        )
    assert walk.step(still._replace(q=fallen(robot, 0.2), time=0.004)).attained


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_without_contact_nothing_is_attained_unless_the_gait_flies(name: str) -> None:
    robot = robot_of(name)
    n = len(robot.feet)
    state = RobotState(place(robot), np.zeros(robot.model.nv), 0.0, np.ones(n, dtype=bool))
    walk = walking_controller(robot, VelocityCommand.constant(0.0))
    assert walk.step(state).attained
    for k in range(1, 60):
        assert not walk.step(state._replace(time=0.001 * k, contact=np.zeros(n, dtype=bool))).attained
    assert walk.step(state._replace(time=0.06)).attained


def test_a_gait_that_flies_attains_its_flight() -> None:
    robot = robot_of("go2")
    schedule = ModeSchedule([0.2, 0.3, 0.6], [15, 0, 15, 15], feet=4)
    walk = WalkingController(robot, FORWARD, schedule, settings=WalkSettings(start=0.0))
    state = RobotState(place(robot), np.zeros(robot.model.nv), 0.0, ALL)
    walk.step(state)
    assert walk.step(state._replace(time=0.25, contact=~ALL)).attained


def test_a_quaternion_of_zeros_is_invalid() -> None:
    for name in ("go2", "g1"):
        robot = robot_of(name)
        q = place(robot)
        contact = np.ones(len(robot.feet), dtype=bool)
        walk = walking_controller(robot, FORWARD)
        walk.step(RobotState(q, np.zeros(robot.model.nv), 0.0, contact))
        q[3:7] = 0.0
        command = walk.step(RobotState(q, np.zeros(robot.model.nv), 0.001, contact))
        assert command.status is Status.INVALID
        assert not command.attained


def test_a_mode_schedule_serves_as_a_gait() -> None:
    robot = robot_of("go2")
    schedule = ModeSchedule([0.2, 0.4, 0.6], [15, 9, 6, 15], feet=4)
    controller = WalkingController(robot, FORWARD, schedule, settings=WalkSettings(start=0.0))
    q, v = place(robot), np.zeros(robot.model.nv)
    assert controller.step(RobotState(q, v, 0.0, ALL)).active.all()
    assert not controller.step(RobotState(q, v, 0.3, ALL)).active.all()


def test_friction_that_a_behaviour_asks_for_is_that_of_the_step_alone() -> None:
    class Ice(StandStill):
        """Asks for little friction between two times [s]."""

        def propose(self, view: WalkView) -> Request:
            return Request(mu=0.1) if 0.1 < view.time < 0.2 else super().propose(view)

    robot, settings = robot_of("go2"), WalkSettings(behaviours=(Ice, *BEHAVIOURS))
    walker, q = WalkingController(robot, FORWARD, settings=settings), place(robot)
    v, own = np.zeros(robot.model.nv), settings.mu * settings.friction_share
    v[1] = 0.5  # pushed aside, which takes friction
    counted, most = [], []
    for time in (0.0, 0.15, 0.25):
        command = walker.step(RobotState(q, v, time, ALL))
        counted.append(walker.whole_body.mu)
        sideways = np.hypot(command.forces[:, 0], command.forces[:, 1])
        most.append(float((sideways / command.forces[:, 2]).max()))
    assert counted == [own, 0.1, own]
    assert most[1] <= 0.1 + 1e-9 < most[2]
    walker.step(RobotState(q, v, 0.15, ALL))
    walker.reset()
    assert walker.whole_body.mu == own


@pytest.mark.parametrize(("gait", "terrain", "refused"), [
    ("trot", FlatTerrain(), {"search", "hold"}),
    ("stand", FlatTerrain(), {"search", "hold", "step_times"}),
    ("trot", TouchedGround(), set()),
])  # fmt: skip
def test_what_a_walk_cannot_do_nobody_gets(gait: str, terrain: Terrain, refused: set[str]) -> None:
    robot, settings = robot_of("go2"), WalkSettings(behaviours=(Wanting,))
    walker = WalkingController(robot, VelocityCommand.constant(0.0), gait, terrain, settings)
    command = walker.step(RobotState(place(robot), np.zeros(robot.model.nv), 0.0, ALL))
    granted = {name for name, rank in zip(LOGGED, command.asked_by, strict=True) if rank >= 0}
    assert granted == set(LOGGED) - refused


def test_what_cannot_walk_is_refused() -> None:
    with pytest.raises(ModelError, match="panda cannot walk"):
        WalkingController(robot_of("panda"), FORWARD)


def test_feet_are_lifted_less_at_ease_on_known_flat_ground_and_in_full_off_course() -> None:
    robot = robot_of("go2")
    apexes = []
    for terrain, push in ((FlatTerrain(), 0.0), (FlatTerrain(), 0.4), (rough_ground(1, 0.02), 0.0)):
        controller = WalkingController(robot, VelocityCommand.constant(0.0), "trot", terrain)
        q, v = place(robot), np.zeros(robot.model.nv)
        for k in range(900):
            v[1] = push if k > 400 else 0.0
            controller.step(RobotState(q, v, 1e-3 * k, ALL))
        apexes.append(controller.state.swing.clearance / controller.height)
    settings = WalkSettings()
    assert apexes[0] == pytest.approx(settings.ease * settings.clearance, rel=0.3)
    assert apexes[1:] == pytest.approx([settings.clearance] * 2, rel=1e-6)


@pytest.mark.long
@pytest.mark.parametrize(("speed", "most"), [(0.5, 0.31), (1.0, 0.37)])
def test_cost_of_transport(speed: float, most: float) -> None:
    """No more than the better of two learned policies needs, in the same hard world by the same function."""
    from dataclasses import replace

    from benchmarks.stacks.stack import Surefoot
    from benchmarks.stacks.tasks import TASKS
    from benchmarks.stacks.trial import carry_out

    done = carry_out(Surefoot(), replace(TASKS["speed-0.5"], asked=(speed, 0.0, 0.0)), 31)
    assert done.lawful
    assert done.measures.velocity_error < 0.02
    assert done.measures.cost_of_transport < most
