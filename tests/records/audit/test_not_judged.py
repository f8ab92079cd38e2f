"""A verdict names what it did not look at, and doubts a load that is not the robot's weight."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.records.log import Log
from tests.records.audit.logs import STAND, TROT, changed, log_of

CONTACT = ("forces", "gaps", "contact_velocities", "contact_positions", "mu", "time")
SAID = "friction, gap and sign hold; masses and outside forces were not judged"


def contacts_of(log: Log, scale: float = 1.0, mass: float = 1.0, names: tuple[str, ...] = CONTACT) -> Log:
    """Return the contacts of a run alone, forces and the fact mass scaled."""
    arrays = {name: np.array(log[name]) for name in names}
    arrays["forces"] *= scale
    return Log(arrays, {"mass": mass * log.fact("mass")})


def test_a_log_of_contacts_alone_says_that_masses_were_not_judged() -> None:
    report = sf.audit_log(contacts_of(log_of(TROT)))
    assert report.verdict == "lawful"
    assert SAID in report.sentence
    assert SAID in str(report)
    assert report.not_judged == ("masses and outside forces",)
    assert report.load_doubt == ""
    assert SAID in report.as_dict()["sentence"]


def test_a_log_with_the_motion_judges_masses_and_says_nothing_of_the_kind() -> None:
    report = sf.audit_log(log_of(TROT))
    assert report.not_judged == ()
    assert "not judged" not in report.sentence
    assert "all 13 laws that could be judged hold" in report.sentence


def test_a_hidden_force_and_a_wrong_mass_are_not_called_more_than_was_looked_at() -> None:
    for scale, mass in ((0.9, 1.0), (1.0, 1.1)):
        report = sf.audit_log(contacts_of(log_of(TROT), scale, mass))
        assert SAID in report.sentence


@pytest.mark.parametrize("run", [STAND, TROT], ids=lambda run: run.name)
@pytest.mark.parametrize(("scale", "mass"), [(0.77, 1.0), (1.0, 1.3), (1.3, 1.0)])
def test_a_load_that_is_not_the_weight_is_a_doubt_in_the_sentence(run, scale: float, mass: float) -> None:
    report = sf.audit_log(contacts_of(log_of(run), scale, mass))
    assert SAID in report.sentence
    assert "m g on average" in report.load_doubt
    assert report.load_doubt in report.sentence
    assert any(report.load_doubt in note for note in report.notes)


def test_the_reader_doubts_such_a_load_too_and_it_is_told_once() -> None:
    log = contacts_of(log_of(TROT), 0.77)
    read = sf.log_from_arrays({n: np.array(log[n]) for n in CONTACT}, facts=dict(log.facts))
    assert any("0.769 m g on average" in line for line in read.doubts)
    report = sf.audit_log(read)
    assert sum("m g on average" in note for note in report.notes) == 1


def test_slides_and_rebounds_are_named_without_velocities() -> None:
    bare = contacts_of(log_of(STAND), names=("forces", "gaps", "mu", "time"))
    report = sf.audit_log(bare)
    assert report.not_judged == ("masses and outside forces", "slides", "rebounds")
    assert f"{SAID}, nor were slides, nor were rebounds" in report.sentence


def test_a_broken_log_and_one_that_cannot_be_judged_speak_of_that_alone() -> None:
    log = contacts_of(log_of(TROT))
    forces = np.array(log["forces"])
    forces[300:400, 0, 2] = -50.0
    assert sf.audit_log(changed(log, forces=forces)).sentence.startswith("broken")
