"""Listening before anything is commanded: who speaks, how often, what of it is void, who else commands."""

from __future__ import annotations

import time as clock
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from surefoot.base.errors import SurefootError
from surefoot.motion.drive.wire.dialect import TICK, Dialect
from surefoot.motion.drive.wire.packed import PackedMessage
from surefoot.motion.drive.wire.transport import Transport

HINT_AFTER = 5.0
"""Silence after which a hint says what to look at [s]."""
LISTEN, ENOUGH = 1.0, 100
"""Longest time for which messages are counted [s], and messages that are enough."""
ACQUAINTANCE = 0.5
"""Shortest time in which other commanders are found, once the robot is [s]."""
FEW = 20
"""Messages without checksum, tick and modes that make a simulator unmistakable."""
RATES = (100.0, 125.0, 200.0, 250.0, 400.0, 500.0)
"""Rates of readings that a loop can be made for [Hz]."""
SIMULATOR_HINT = "Unitree's simulators leave these out: for one of them add --simulator"


def refusals_in_words(counts: Counter[str]) -> str:
    """Return in words how many readings were refused, and why."""
    return ", ".join(f"{n:,} reading{'s' * (n != 1)} with {why}" for why, n in counts.most_common())


@dataclass
class Survey:
    """What was heard while nothing was commanded.

    Attributes
    ----------
    messages
        How many came.
    refused
        How many of them were void, by reason.
    arrivals
        When they came [s].
    ticks
        The robot's ticks in them.
    moding
        How many said a mode of a motor.
    """

    messages: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    arrivals: list[float] = field(default_factory=list)
    ticks: list[int] = field(default_factory=list)
    moding: int = 0

    def note(self, message: PackedMessage, dialect: Dialect, now: float) -> None:
        """Count a message that came at a time [s]."""
        self.messages += 1
        if why := dialect.refusal(message):
            self.refused[why] += 1
        self.arrivals.append(now)
        self.ticks.append(int(message["tick"]))
        self.moding += bool(message["motor_state.mode"].any())

    @property
    def simulated(self) -> bool:
        """Whether it is unmistakable that a simulator speaks: no checksum, no tick and no mode, ever."""
        bare = self.refused["checksum 0"] == self.messages >= FEW
        return bare and not any(self.ticks) and not self.moding

    @property
    def ticking(self) -> bool:
        """Whether the robot's clock moves."""
        return len(set(self.ticks)) > 1

    @property
    def rate(self) -> float:
        """The rate of `RATES` that is nearest to that of new readings, by ticks or else by arrival [Hz]."""
        if self.messages < FEW:
            return RATES[-1]
        ticks = np.diff(np.unique(self.ticks))
        if len(ticks):
            told = 1.0 / (TICK * float(np.median(ticks)))
        else:
            told = (self.messages - 1) / max(self.arrivals[-1] - self.arrivals[0], 1e-9)
        return min(RATES, key=lambda rate: abs(float(np.log(rate / told))))


def listen(
    end: Transport, dialect: Dialect, seconds: float, *, slow: bool = False,
    hint: Callable[[str], None] = lambda _: None,
) -> Survey:  # fmt: skip
    """Return what is heard of a robot, for at most `LISTEN` from its first word on.

    Parameters
    ----------
    end, dialect
        Of the wire, and what is spoken there.
    seconds
        How long the first word is waited for [s].
    slow
        Whether the robot waits for an answer, so that one message is all that comes.
    hint
        Called with what to look at if nothing is heard for a while.

    Raises
    ------
    SurefootError
        If nobody speaks, or somebody else commands the robot.
    """
    survey, begin = Survey(), clock.perf_counter()
    hinted = False
    while not survey.messages:
        left = begin + seconds - clock.perf_counter()
        if left <= 0.0:
            raise SurefootError(f"no robot speaks on the wire: {seconds:g} s without a state")
        message = end.receive(min(left, 0.5))
        if message is not None:
            survey.note(message, dialect, clock.perf_counter())
        elif not hinted and clock.perf_counter() - begin >= min(HINT_AFTER, seconds):
            hinted = True
            hint(_what_to_look_at(end))
    first = clock.perf_counter()
    while (now := clock.perf_counter()) - first < LISTEN:
        if (slow or survey.messages >= ENOUGH) and now - first >= ACQUAINTANCE:
            break
        message = end.receive(0.02)
        if message is not None:
            survey.note(message, dialect, clock.perf_counter())
    refuse_rivals(end)
    return survey


def refuse_void(survey: Survey) -> None:
    """Refuse to go on where all that the robot says is void.

    Raises
    ------
    SurefootError
        With what is wrong with how many readings.
    """
    if sum(survey.refused.values()) == survey.messages:
        raise SurefootError(
            f"the robot speaks, but nothing that it says can be used: {refusals_in_words(survey.refused)}. "
            f"{SIMULATOR_HINT}"
        )


def refuse_rivals(end: Transport) -> None:
    """Refuse to go on where somebody else commands the robot.

    Raises
    ------
    SurefootError
        Naming them.
    """
    if rivals := end.rivals():
        raise SurefootError(
            f"somebody else commands the robot: {'; '.join(rivals)}. End it first: two masters tear at the "
            "motors (one that was killed is forgotten after about 10 s)"
        )


def _what_to_look_at(end: Transport) -> str:
    """Return what to look at while nothing is heard."""
    near = end.neighbours()
    seen = f"{len(near)} other DDS program{'s' * (len(near) != 1)} ({'; '.join(near)})" if near else "nobody"
    said = "none of them says rt/lowstate for this robot" if near else "nothing is discovered"
    return (
        f"nothing heard for {HINT_AFTER:g} s. On this interface and domain {seen} can be seen: {said}. Look "
        "at: is the robot or simulator running; --domain (0 on robots, 1 in Unitree's simulators); "
        "--interface (`ip link`); CYCLONEDDS_URI and --dds-config; a firewall"
    )
