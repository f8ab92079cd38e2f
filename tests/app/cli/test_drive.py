"""`surefoot drive` on a made-up wire, with a simulated robot at its other end."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

import surefoot as sf
from surefoot.app.cli import drive
from surefoot.app.cli.main import main
from surefoot.app.cli.signals import ends_softly
from surefoot.motion.drive.wire import dds_config
from surefoot.motion.drive.wire.dialect import Dialect, dialect_of
from surefoot.motion.drive.wire.packed import PackedMessage
from tests.motion.drive.bridge_replica import BridgeReplica, SilentWire

GO2 = sf.load_robot("go2")
SHORT = ("drive", "go2", "--duration", "1", "--json")
ETHERNET = (
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='eth0'/></Interfaces></General></Domain>"
    "</CycloneDDS>"
)


class Interrupted(BridgeReplica):
    """A simulator whose user presses Ctrl-C at a time."""

    when = float("inf")

    def receive(self, timeout: float) -> PackedMessage | None:
        """See `BridgeReplica`."""
        if self.time > self.when:
            self.when = float("inf")
            os.kill(os.getpid(), signal.SIGINT)
        return super().receive(timeout)


@pytest.fixture
def bridge(monkeypatch: pytest.MonkeyPatch) -> BridgeReplica:
    """A simulator at the other end of whatever `drive` opens."""
    made = Interrupted(GO2, 200.0)
    made.clock.rule(monkeypatch)

    @contextmanager
    def wire_end(model: Any, *_: Any, simulator: bool = False, **__: Any) -> Iterator[tuple[Any, Dialect]]:
        yield made, dialect_of(model, simulator)

    monkeypatch.setattr(drive, "wire_end", wire_end)
    monkeypatch.delenv(dds_config.VARIABLE, raising=False)
    return made


@pytest.mark.long
def test_a_simulator_is_told_by_itself(bridge: BridgeReplica, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*SHORT]) == 0
    assert json.loads(capsys.readouterr().out)["fault"] == ""
    assert bridge.world.q_v()[0][0] > 0.2
    assert bridge.world.q_v()[0][2] < 0.2


def test_a_simulator_beyond_this_machine_is_not(
    bridge: BridgeReplica, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*SHORT, "--interface", "eth0", "--yes-real-robot"]) == 2
    error = capsys.readouterr().err
    assert "readings with checksum 0" in error
    assert "--simulator" in error
    assert not bridge.sent


@pytest.mark.parametrize("when", [1.5, 5.5])
@pytest.mark.long
def test_an_ignored_interrupt_is_still_the_emergency_stop(
    bridge: Interrupted, capsys: pytest.CaptureFixture[str], when: float
) -> None:
    """As after ``surefoot drive &`` in a script: the shell hands on that SIGINT is ignored."""
    bridge.when = when
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        assert main([*SHORT]) == 1
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)
    assert json.loads(capsys.readouterr().out)["fault"] == "interrupted"
    last = [PackedMessage(bridge.dialect.command, data) for data in bridge.sent[-90:]]
    assert not any(message["motor_cmd.kp"].any() for message in last)
    assert bridge.time < when + 1.5


IN_THE_BACKGROUND = """
import os, signal, sys, time
from surefoot.app.cli.signals import ends_softly
emergency = sys.argv[1] == "drive"
with ends_softly(emergency=emergency):
    try:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.2)
        print("stood on")
    except KeyboardInterrupt:
        print("stopped")
"""


@pytest.mark.parametrize(("who", "said"), [("drive", "stopped"), ("walk", "stood on")])
def test_what_a_script_started_in_the_background_hears_ctrl_c(who: str, said: str) -> None:
    """Bash starts it with SIGINT ignored; only what moves a robot takes that back."""
    script = f'"$0" -c "$1" {who} & wait $!'
    command = ["bash", "-c", script, sys.executable, IN_THE_BACKGROUND]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.stdout.strip() == said, done.stderr


def test_signals_are_given_back() -> None:
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    with ends_softly(emergency=True):
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert {number: signal.getsignal(number) for number in before} == before


def test_a_second_commander_is_named(bridge: BridgeReplica, capsys: pytest.CaptureFixture[str]) -> None:
    bridge.others = ("surefoot, process 12 on desk",)
    assert main([*SHORT]) == 2
    assert "somebody else commands the robot: surefoot, process 12 on desk" in capsys.readouterr().err
    assert not bridge.sent


def test_silence_gets_a_hint_beside_the_json(
    bridge: BridgeReplica, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bridge, "receive", lambda timeout: SilentWire.receive(bridge, timeout))
    assert main([*SHORT]) == 2
    out, error = capsys.readouterr()
    assert not out
    assert "nothing heard for 5 s" in error
    assert "no robot speaks on the wire: 30 s without a state" in error


def test_the_user_s_configuration_of_dds_counts(
    bridge: BridgeReplica, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """One that may lead to a robot asks for the same yes as an interface that may."""
    file, wrong = tmp_path / "dds.xml", tmp_path / "wrong.xml"
    file.write_text(ETHERNET, encoding="utf-8")
    wrong.write_text("<CycloneDDS>", encoding="utf-8")
    for text, said in (
        (ETHERNET, "--yes-real-robot"),
        (str(wrong), "is no XML"),
        ("/no/file", "cannot be read"),
    ):
        monkeypatch.setenv(dds_config.VARIABLE, text)
        assert main([*SHORT]) == 2
        assert said in capsys.readouterr().err
    assert main([*SHORT, "--dds-config", str(file)]) == 2  # a file goes before the environment
    assert "--yes-real-robot" in capsys.readouterr().err
    assert not bridge.sent


def test_configurations_of_dds() -> None:
    plain = dds_config.dds_config("lo")
    assert "<ParticipantIndex>auto</ParticipantIndex>" in plain
    assert "name='lo'" in plain
    quiet = "<CycloneDDS><Domain><Tracing><Verbosity>none</Verbosity></Tracing></Domain></CycloneDDS>"
    base, _, own = dds_config.dds_config("lo", quiet).partition(",")
    assert (base, own) == (plain, quiet)  # what comes later has the last word
    assert "name='lo'" not in dds_config.dds_config("lo", ETHERNET)
    assert not dds_config.leads_outside("lo", quiet)
    assert not dds_config.leads_outside("lo", ETHERNET.replace("name='eth0'", "address='127.0.0.1'"))
    for outside in (ETHERNET, ETHERNET.replace("name='eth0'", "autodetermine='true'")):
        assert dds_config.leads_outside("lo", outside)
    assert dds_config.leads_outside("eth0")
    with pytest.raises(sf.ProblemError, match="'eth1' is not among those of the DDS configuration: eth0"):
        dds_config.dds_config("eth1", ETHERNET)
