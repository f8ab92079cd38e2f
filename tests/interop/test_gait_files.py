"""OCS2's gait files: modes by name, round trips, and errors that name what is wrong."""

from pathlib import Path

import pytest

from surefoot.errors import ProblemError
from surefoot.interop.gait_files import (
    format_gaits,
    mode_from_name,
    mode_name,
    parse_gaits,
    read_gaits,
    write_gaits,
)
from surefoot.stance.gait import Gait, ModeSchedule
from surefoot.stance.gait_library import gait_names, named_gait

# LF, RF, LH, RH from the most significant bit: the numbering of OCS2's switched models
NUMBERS = {
    "FLY": 0, "RH": 1, "LH": 2, "LH_RH": 3, "RF": 4, "RF_RH": 5, "RF_LH": 6, "RF_LH_RH": 7, "LF": 8,
    "LF_RH": 9, "LF_LH": 10, "LF_LH_RH": 11, "LF_RF": 12, "LF_RF_RH": 13, "LF_RF_LH": 14, "STANCE": 15,
}  # fmt: skip

TEXT = """
; two gaits on few lines
trot
{
  modeSequence { [0] LF_RH
                 [1] RF_LH }   # a comment
  switchingTimes
  {
    [0] 1.0
    [1] 1.3
    [2] 1.6
  }
}
initialModeSchedule
{
  modeSequence
  {
    [0] STANCE
    [1] 9
    [2] "STANCE"
  }
  eventTimes
  {
    [0] 0.5
    [1] 0.8
  }
}
"""


def test_modes_have_the_numbers_of_ocs2() -> None:
    for name, number in NUMBERS.items():
        assert mode_from_name(name) == number
        assert mode_name(number) == name
    assert mode_from_name("LF", ("LF", "RF")) == 2


def test_a_text_is_read() -> None:
    found = parse_gaits(TEXT)
    trot, schedule = found["trot"], found["initialModeSchedule"]
    assert isinstance(trot, Gait)
    assert isinstance(schedule, ModeSchedule)
    assert trot.modes.tolist() == [9, 6]
    assert trot.switching == pytest.approx([0.0, 0.3, 0.6])
    assert schedule.modes.tolist() == [15, 9, 15]
    assert schedule.event_times.tolist() == [0.5, 0.8]


@pytest.mark.parametrize("feet", [2, 4])
def test_every_gait_survives_a_round_trip(feet: int, tmp_path: Path) -> None:
    gaits = {name: named_gait(name, feet) for name in gait_names(feet)}
    path = write_gaits(gaits, tmp_path / "gait.info")
    back = read_gaits(path, feet)
    assert list(back) == list(gaits)
    for name, gait in gaits.items():
        again = back[name]
        assert isinstance(again, Gait)
        assert again.modes.tolist() == gait.modes.tolist()
        assert again.switching == pytest.approx(gait.switching, rel=1e-10)
    with pytest.raises(ProblemError, match="exists already"):
        write_gaits(gaits, path)


def test_a_mode_schedule_survives_a_round_trip() -> None:
    schedule = named_gait("trot").schedule(1.0, start=0.4)
    back = parse_gaits(format_gaits({"walkoff": schedule}))["walkoff"]
    assert isinstance(back, ModeSchedule)
    assert back.modes.tolist() == schedule.modes.tolist()
    assert back.event_times == pytest.approx(schedule.event_times, rel=1e-10)


def _block(modes: str, times: str, key: str = "switchingTimes") -> str:
    return f"g\n{{\nmodeSequence\n{{\n{modes}\n}}\n{key}\n{{\n{times}\n}}\n}}\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (_block("[0] LF_XX", "[0] 0 [1] 1"), "unknown foot in mode 'LF_XX': 'XX'; valid names: FLY, LF"),
        (_block("[0] LF_LF", "[0] 0 [1] 1"), "names LF twice"),
        (_block("[0] STANCE [2] LF", "[0] 0 [1] 1"), r"modeSequence lacks entry \[1\]"),
        (_block("[0] STANCE", "[0] 0 [1] x"), "switchingTimes must hold numbers"),
        (_block("[0] STANCE", "[0] 0 [1] 1", "times"), "needs switchingTimes or eventTimes"),
        (_block("[0] LF_RH [1] RF_LH", "[0] 0 [1] 0.5 [2] 0.3"), "events overlap"),
        (_block("[0] STANCE", "[0] 0 [1] 1")[:-2], "'{' without '}'"),
        ("}", "'}' without '{'"),
        ("{", "'{' without a name"),
    ],
)
def test_wrong_files_are_told(text: str, message: str) -> None:
    with pytest.raises(ProblemError, match=message):
        parse_gaits(text)


def test_missing_and_empty_files_are_told(tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match="cannot read the gait file"):
        read_gaits(tmp_path / "none.info")
    (tmp_path / "empty.info").write_text("; nothing\n")
    with pytest.raises(ProblemError, match="holds no gait"):
        read_gaits(tmp_path / "empty.info")
