"""The loop on a made-up wire, by a made-up clock: simulators, what is refused, who else commands."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.base.errors import SurefootError
from surefoot.motion.control.controller import JointTargets
from surefoot.motion.drive.foot_load import STEADY, FootLoad, hint, load_share
from surefoot.motion.drive.readings import ReadingLimits, ReadingWatch
from surefoot.motion.drive.robot_loop import RobotLoop
from surefoot.motion.drive.wire.dialect import dialect_of
from surefoot.motion.drive.wire.packed import PackedMessage
from surefoot.motion.drive.wire.simulator import SimulatorClock, simulator_limits
from surefoot.motion.drive.wire.survey import listen, refuse_void
from surefoot.motion.drive.wire.wired_loop import WiredLoop
from tests.motion.drive.bridge_replica import BridgeReplica, BusyReplica, HungReplica, MadeUpClock, SilentWire

GO2 = sf.load_robot("go2")
LEVEL, UP = np.array([0.0, 0.0, 0.0, 1.0]), np.array([0.0, 0.0, 9.81])


def wired_to(bridge: BridgeReplica) -> WiredLoop:
    """Return a loop at the other end of a simulator, made as `surefoot drive` makes it."""
    dialect = dialect_of(bridge.robot, simulator=bridge.ticking)
    heard = listen(bridge, dialect, 5.0)
    refused = {} if bridge.ticking else {"checksum 0": heard.messages}
    assert (heard.simulated, heard.ticking) == (not bridge.ticking, bridge.ticking)
    assert dict(heard.refused) == refused
    assert isinstance(bridge, BusyReplica) or heard.rate == pytest.approx(1.0 / bridge.dt)
    dt = 1.0 / heard.rate
    loop = RobotLoop(bridge.robot, dt, motors=dialect.motors, limits=simulator_limits(dt))
    clock = SimulatorClock(dt, heard.ticking)
    wired = WiredLoop(loop, bridge, dialect.of_simulator(), simulator=clock)
    wired.wait(5.0)
    return wired


RUNS = [
    (200.0, False, 0),
    *(
        pytest.param(rate, ticking, seed, marks=pytest.mark.long)
        for rate, ticking, seeds in ((200.0, False, 5), (500.0, False, 5), (200.0, True, 2), (500.0, True, 2))
        for seed in range(0 if (rate, ticking) != (200.0, False) else 1, seeds)
    ),
]


@pytest.mark.parametrize(("rate", "ticking", "seed"), RUNS)
def test_a_simulated_robot_stands_walks_and_sits(
    rate: float, ticking: bool, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Checksum 0, tick 0, mode 0, copies beside the thread that steps, torques held between commands."""
    bridge = BridgeReplica(GO2, rate, ticking=ticking, seed=seed)
    bridge.clock.rule(monkeypatch)
    wired = wired_to(bridge)
    heights: list[float] = []
    wired.watch = lambda _: heights.append(float(bridge.world.q_v()[0][2]))
    assert wired.outing([0.5, 0.0, 0.0], 5.0, "sit") == ""
    x, _, z = bridge.world.q_v()[0][:3]
    assert x > 2.0
    assert max(heights) > 0.32
    assert z < 0.2


LONGEST = {200.0: 0.05, 500.0: 0.08}
"""Pauses [s] that no walk falls in, by rate: of eight walks at 200 Hz with pauses up to 80 ms two fell."""
BUSY = [
    (200.0, 0),
    *(pytest.param(rate, seed, marks=pytest.mark.long) for rate in LONGEST for seed in range(1, 4)),
]


@pytest.mark.parametrize(("rate", "seed"), BUSY)
@pytest.mark.long
def test_a_busy_computer_ends_no_walk(rate: float, seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Torques come up to 2.5 ms late, and the simulator stands still for 50 or 80 ms at times."""
    bridge = BusyReplica(GO2, rate, seed=seed, lag=2.5e-3, pauses=3.0, longest=LONGEST[rate])
    bridge.clock.rule(monkeypatch)
    wired = wired_to(bridge)
    assert wired.outing([0.5, 0.0, 0.0], 5.0, "sit") == ""
    x, _, z = bridge.world.q_v()[0][:3]
    assert x > 2.0
    assert z < 0.2


@pytest.mark.long
@pytest.mark.parametrize("seed", range(5))
def test_longer_pauses_may_fell_a_robot_but_the_loop_gives_none_up(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    bridge = BusyReplica(GO2, 200.0, seed=seed, lag=2.5e-3, pauses=3.0, longest=0.08)
    bridge.clock.rule(monkeypatch)
    assert wired_to(bridge).outing([0.5, 0.0, 0.0], 5.0, "sit") in ("", "the robot has fallen")


@pytest.mark.long
def test_a_biped_whose_feet_leave_the_ground_gets_targets_still(monkeypatch: pytest.MonkeyPatch) -> None:
    """A step of the loop never raises, also where somebody lifts a robot that balances."""
    robot = sf.load_robot("g1")
    bridge = HungReplica(robot, True)
    bridge.clock.rule(monkeypatch)
    monkeypatch.setattr(FootLoad, "nothing", property(lambda _: False))
    wired = wired_to(bridge)
    balanced = []
    wired.watch = lambda loop: balanced.append(loop.mode.value == "stand")
    wired.outing([0.3, 0.0, 0.0], 1.0, "damp")
    assert any(balanced)


HUNG = [
    ("go2", True),
    *(pytest.param(*one, marks=pytest.mark.long) for one in (("go2", False), ("g1", True))),
]


@pytest.mark.parametrize(("name", "level"), HUNG)
@pytest.mark.long
def test_a_robot_that_hangs_says_that_its_feet_carry_nothing(
    name: str, level: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Straps that hold its trunk level let it stretch its legs; it does not balance on air."""
    robot = sf.load_robot(name)
    bridge = HungReplica(robot, level)
    bridge.clock.rule(monkeypatch)
    wired = wired_to(bridge)
    lowest: list[float] = []
    wired.watch = lambda _: lowest.append(float(robot.foot_positions(bridge.world.q_v()[0])[:, 2].min()))
    fault = wired.outing([0.5, 0.0, 0.0], 5.0, "sit")
    assert "the feet carry nothing" in fault
    assert wired.loop.mode.value == "damp"
    assert min(lowest) > 0.03  # it does hang
    if level:
        assert fault.startswith("the feet carry nothing")
        assert bridge.time < 8.0


@pytest.mark.parametrize("rate", [100.0, 200.0, 500.0])
def test_patience_ends_in_damping_that_ends_again(rate: float) -> None:
    """Ten steps of 5 ms add up to a little less than 50 ms: a silence of that length is no fault either."""
    dt = 1.0 / rate
    watch = ReadingWatch(GO2, dt, simulator_limits(dt))
    still = np.zeros(12)
    assert watch.look(sf.RobotReadings(0.0, LEVEL, np.zeros(3), UP, GO2.nominal[7:], still, still), 0.0)
    count = 0
    while not watch.blind:
        count += 1
        watch.look(None, count * dt)
        assert not watch.contradictory
    assert count * dt == pytest.approx(watch.limits.patience, abs=0.51 * dt)


def test_what_feet_carry() -> None:
    """From the torques of a pose: against the weight itself, on the ground and in the air."""
    q, still = GO2.nominal, np.zeros(12)
    data = GO2.model.createData()
    weight = pinocchio.computeGeneralizedGravity(GO2.model, data, q)[6:]
    feet = GO2.foot_positions(q)
    step, rows = 1e-6, np.zeros((12, 12))  # differences of the feet's places by the joints' angles
    for j in range(12):
        moved = q.copy()
        moved[7 + j] += step
        rows[:, j] = ((GO2.foot_positions(moved) - feet) / step).ravel()
    for share in (0.0, 0.1, 0.3, 1.0):
        force = np.tile([1.0, -2.0, share * GO2.mass * 9.81 / 4.0], 4)
        torques = weight - rows.T @ force
        reading = sf.RobotReadings(0.0, LEVEL, np.zeros(3), UP, q[7:], still, torques)
        assert load_share(GO2, reading) == pytest.approx(share, abs=1e-3)
        load = FootLoad(GO2)
        load.look(STEADY, reading)
        assert load.nothing == (share < 0.15)
        assert (hint(GO2, reading) != "") == (share < 0.5)
        load.look(0.0, reading)  # on its way: what was is forgotten
        assert not load.nothing
    load.look(STEADY, sf.RobotReadings(0.0, LEVEL, np.zeros(3), UP, q[7:], still, still))
    load.look(STEADY, None)
    assert not load.nothing
    assert hint(GO2, None)


class SaysOne(SilentWire):
    """A robot that lies still, in messages that somebody spoils."""

    def __init__(self, clock: MadeUpClock, **spoiled: object) -> None:
        super().__init__(clock)
        self.dialect, self.spoiled, self.count = dialect_of(GO2), spoiled, 0

    def receive(self, timeout: float) -> PackedMessage | None:
        """Let 2 ms pass, and say the state."""
        self.clock.now += 0.002
        self.count += 1
        still = np.zeros(12)
        noise = 1e-4 * np.sin(self.count + np.arange(12))
        reading = sf.RobotReadings(
            self.count * 0.002, LEVEL, np.zeros(3), UP, GO2.nominal[7:] + noise, still, still
        )
        message = self.dialect.state_message(reading)
        for name, value in self.spoiled.items():
            field = name if name in message.layout.places else f"motor_state.{name}"
            message[field] = value
        if "crc" not in self.spoiled:
            message.seal()
        return PackedMessage(self.dialect.state, bytes(message.data))


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> MadeUpClock:
    made = MadeUpClock()
    made.rule(monkeypatch)
    return made


@pytest.mark.parametrize(
    ("spoiled", "said"),
    [
        ({"crc": 0}, "readings with checksum 0"),
        ({"crc": 7}, "readings with a wrong checksum"),
        ({"mode": np.zeros(12)}, "readings with motors in mode 0"),
        ({"mode": [1, 1, 6]}, "readings with motors in mode 6"),
    ],
)
def test_what_is_refused_is_named_and_counted(
    clock: MadeUpClock, spoiled: dict[str, object], said: str
) -> None:
    wire = SaysOne(clock, **spoiled)
    heard = listen(wire, wire.dialect, 5.0)
    assert not heard.simulated
    with pytest.raises(SurefootError, match=f"{heard.messages} {said}.*--simulator"):
        refuse_void(heard)
    loop = RobotLoop(GO2, motors=wire.dialect.motors)
    wired = WiredLoop(loop, wire, wire.dialect)
    for _ in range(1200):
        wired.step()
    with pytest.raises(SurefootError, match=rf"cannot stand: no reading came.*1,\d+ {said}"):
        wired.go("stand")


def test_only_what_leaves_out_everything_is_a_simulator_by_itself(clock: MadeUpClock) -> None:
    everything = {"crc": 0, "tick": 0, "mode": np.zeros(12)}
    wire = SaysOne(clock, **everything)
    assert listen(wire, wire.dialect, 5.0).simulated
    for left_out in everything:
        wire = SaysOne(clock, **{name: value for name, value in everything.items() if name != left_out})
        assert not listen(wire, wire.dialect, 5.0).simulated
    sound = SaysOne(clock)
    heard = listen(sound, sound.dialect, 5.0)
    refuse_void(heard)
    assert (heard.rate, heard.refused.total(), heard.simulated) == (500.0, 0, False)


def test_a_simulator_s_dialect_still_refuses_what_is_wrong() -> None:
    robot, simulator = dialect_of(GO2), dialect_of(GO2, simulator=True)
    still = np.zeros(12)
    message = robot.state_message(
        sf.RobotReadings(1.0, LEVEL, np.zeros(3), UP, GO2.nominal[7:], still, still)
    )
    message["crc"] = 0
    assert simulator.readings(message) is not None
    message["crc"] = 7
    assert simulator.refusal(message) == "a wrong checksum"
    message["motor_state.mode"] = [1, 0, 1]  # a motor that does not obey among others that do
    assert simulator.refusal(message.seal()) == "motors in mode 0"
    assert robot.refusal(message) == "motors in mode 0"


def test_silence_gets_a_hint_and_an_end(clock: MadeUpClock) -> None:
    hints: list[tuple[float, str]] = []
    wire, begin = SilentWire(clock, near=("python3, process 7 on desk",)), clock.now
    with pytest.raises(SurefootError, match="30 s without a state"):
        listen(wire, dialect_of(GO2), 30.0, hint=lambda text: hints.append((clock.now - begin, text)))
    ((after, text),) = hints
    assert 5.0 <= after < 6.0
    for what in ("python3, process 7", "--domain", "--interface", "CYCLONEDDS_URI", "--dds-config"):
        assert what in text


def test_nobody_drives_a_robot_that_somebody_else_commands(clock: MadeUpClock) -> None:
    wire = SaysOne(clock)
    wire.others = ("surefoot, process 12 on desk",)
    with pytest.raises(SurefootError, match="somebody else commands the robot: surefoot, process 12 on desk"):
        listen(wire, wire.dialect, 5.0)


@pytest.mark.parametrize("when", [0, 30, 700])
def test_a_second_commander_ends_the_drive_damped(clock: MadeUpClock, when: int) -> None:
    """Whether it comes before the first step, while the robot is damped, or on its way up."""
    wire = SaysOne(clock)
    loop = RobotLoop(GO2, motors=wire.dialect.motors)

    def watch(_: RobotLoop) -> None:
        if len(wire.sent) >= when:
            wire.others = ("python, process 9",)

    wired = WiredLoop(loop, wire, wire.dialect, watch=watch)
    fault = wired.outing([0.0, 0.0, 0.0], 1.0, "sit")
    assert fault == "somebody else commands the robot, too: python, process 9"
    assert loop.mode.value == "damp"
    last = PackedMessage(wire.dialect.command, wire.sent[-1])
    assert not np.any(last["motor_cmd.kp"])
    assert (last["motor_cmd.kd"][:12] > 0.0).all()


def test_a_simulator_s_time_is_its_ticks_or_the_arrival() -> None:
    arrival = SimulatorClock(0.002, ticking=False)
    assert arrival.stamp(0.0, 10.0) == 10.0
    assert arrival.stamp(0.0, 10.001) is None  # too soon: one step is answered once
    assert arrival.stamp(0.0, 10.0021) == 10.0021
    ticking = SimulatorClock(0.002, ticking=True)
    stamps = [ticking.stamp(told, 10.0 + 1e-3 * k) for k, told in enumerate((0.0, 0.0, 0.002, 0.002, 0.004))]
    assert stamps == [0.0, None, 0.002, None, 0.004]
    assert ticking.stamp(0.0, 11.0) == 0.0  # reset: it is for the watch on readings to say what that means


def test_limits_of_a_simulator_allow_for_copies_of_two_steps() -> None:
    usual, fast, slow = ReadingLimits(), simulator_limits(0.002), simulator_limits(0.005)
    assert usual.mismatch < fast.mismatch < slow.mismatch
    assert (fast.tilt, fast.beyond) == (usual.tilt, usual.beyond)


def test_targets_of_a_second_dialect_are_its_own() -> None:
    """Messages are kept for their dialect: one for a simulator does not write into a robot's."""
    robot = dialect_of(GO2)
    first = robot.command_message(JointTargets(*np.ones((5, 12))))
    robot.of_simulator().command_message(JointTargets(*np.zeros((5, 12))))
    assert float(first["motor_cmd.q"][0]) == 1.0


class SlowRobot(SaysOne):
    """A robot in slow motion that is held up, and says again what nobody answered."""

    def __init__(self, clock: MadeUpClock, holds: dict[int, float], twice: dict[int, float]) -> None:
        super().__init__(clock)
        self.holds, self.twice, self.here, self._last = holds, twice, 1, b""

    def partners(self) -> int:
        """Return whether the robot is there."""
        return self.here

    def receive(self, timeout: float) -> PackedMessage | None:
        """Say the next state, nothing while the robot is held up, or the last state again."""
        if (hold := self.holds.get(self.count, 0.0)) > 0.0:
            self.clock.now += timeout
            self.holds[self.count] = hold - timeout
            return None
        if (pause := self.twice.pop(self.count, None)) is not None:
            self.clock.now += pause
            return PackedMessage(self.dialect.state, self._last)
        message = super().receive(timeout)
        self._last = b"" if message is None else bytes(message.data)
        return message


def test_in_slow_motion_a_robot_that_is_held_up_is_waited_for(clock: MadeUpClock) -> None:
    """However long; what it says again is no new step, and is answered again where the answer was lost."""
    wire = SlowRobot(clock, {5: 40.0, 9: 3.0}, {7: 1.0, 8: 0.01})
    loop = RobotLoop(GO2, motors=wire.dialect.motors)
    wired = WiredLoop(loop, wire, wire.dialect, slow=True)
    for _ in range(20):
        wired.step()
    assert wire.count == 20
    assert len(wire.sent) == 21  # the answer to the seventh, twice
    assert wire.sent[7] == wire.sent[6]
    assert loop.fault == ""
    assert loop.time == pytest.approx(19 * 0.002)
    wire.holds[20], wire.here = 1e9, 0
    for _ in range(100):
        wired.step()  # it has gone: as silence of any robot
    assert loop.watch.blind
