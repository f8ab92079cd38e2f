"""Gamepads: recorded bytes become events, whole ones only, and a device that is not there is one line."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from surefoot.errors import ProblemError
from surefoot.simulation.joystick import (
    Joystick,
    JoystickEvent,
    find_joysticks,
    outside_dead_zone,
    parse_events,
)

RECORDED = bytes.fromhex(
    # as a pad tells them: how it stands (button 0, axis 0), stick up, half right, button 0 down and up
    "10a0b000 0000 81 00"
    "10a0b000 0000 82 00"
    "90a4b000 0180 02 01"
    "c4a4b000 0040 02 00"
    "10a8b000 0100 01 00"
    "9ca8b000 0000 01 00"
)


def test_recorded_bytes() -> None:
    events, rest = parse_events(RECORDED)
    assert rest == b""
    assert events == [
        JoystickEvent(False, 0, 0.0, True),
        JoystickEvent(True, 0, 0.0, True),
        JoystickEvent(True, 1, -1.0, False),
        JoystickEvent(True, 0, pytest.approx(0.5, abs=1e-4), False),
        JoystickEvent(False, 0, 1.0, False),
        JoystickEvent(False, 0, 0.0, False),
    ]


@pytest.mark.parametrize("cut", range(len(RECORDED) + 1))
def test_events_do_not_depend_on_where_they_are_cut(cut: int) -> None:
    first, rest = parse_events(RECORDED[:cut])
    second, end = parse_events(rest + RECORDED[cut:])
    assert [*first, *second] == parse_events(RECORDED)[0]
    assert end == b""


def test_the_dead_zone_ends_without_a_jump() -> None:
    assert outside_dead_zone(0.12) == 0.0
    assert 0.0 < outside_dead_zone(0.13) < 0.02
    assert outside_dead_zone(1.0) == 1.0
    assert outside_dead_zone(-0.6) == -outside_dead_zone(0.6)


def test_a_device_gives_what_came_and_never_waits(tmp_path: Path) -> None:
    path = tmp_path / "js0"
    os.mkfifo(path)
    joystick = Joystick(path)
    writer = os.open(path, os.O_WRONLY)
    try:
        assert list(joystick.events()) == []
        os.write(writer, RECORDED[:20])
        assert len(joystick.events()) == 2
        os.write(writer, RECORDED[20:])
        assert len(joystick.events()) == 4
        assert find_joysticks(tmp_path) == [path]
    finally:
        os.close(writer)
        joystick.close()
    assert list(joystick.events()) == []


def test_no_device_is_one_line(tmp_path: Path) -> None:
    assert find_joysticks(tmp_path) == []
    with pytest.raises(ProblemError, match=r"cannot read the gamepad .*js7: No such file"):
        Joystick(tmp_path / "js7")
