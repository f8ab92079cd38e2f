"""From intervals to findings with symptoms made up for it: episodes, their order, and what explains what."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.records.audit import diagnosis
from surefoot.records.audit.diagnosis import diagnose
from surefoot.records.audit.episode import Episode
from surefoot.records.audit.intervals import Interval
from surefoot.records.audit.limits import LIMITS
from surefoot.records.audit.log_context import Setting
from surefoot.records.audit.report import Finding
from surefoot.records.audit.symptoms import Evidence, Symptom

DT, T = 0.01, 700
BODY = 4
"""The column behind those of four contacts."""
NEAR, CERTAIN, SHARED = LIMITS.episodes.near, LIMITS.ranks.certain, LIMITS.ranks.shared
SURE, LIKELY = CERTAIN + 0.01, CERTAIN - 0.3


def setting(dt: float = DT, contacts: int = 4) -> Setting:
    names = tuple("abcd"[:contacts])
    return Setting(
        names, np.arange(contacts), names, 50.0, dt, 0.0, 0.0, 0.0, 0.0, 0.0, np.zeros(3), None, ""
    )


def symptom(name: str, strength: float, *checks: str, body: bool = False) -> Symptom:
    """Return a symptom that tells which rows of which interval it was shown."""

    def judge(episode: Episode) -> Evidence:
        core = episode.rows.core
        first = episode.rows.first
        shown = f"{first + core.start}-{first + core.stop - 1}"
        told = "; ".join(
            f"{one.check} {one.first}-{one.last} {one.value:g} {one.rows}" for one in episode.failed.values()
        )
        return Evidence(strength, f"{shown}: {told}")

    return Symptom(name, f"{name}'s cause", f"{name}'s confirm", f"{name}'s cure", judge, checks, body)


def interval(column: int, first: int, last: int, check: str = "pull", value: float = 1.0) -> Interval:
    return Interval(check, column, first, last, value, 0.5, last - first + 1)


def found(
    monkeypatch: pytest.MonkeyPatch, symptoms: list[Symptom], *intervals: Interval, contacts: int = 4,
    dt: float = DT,
) -> list[Finding]:  # fmt: skip
    monkeypatch.setattr(diagnosis, "SYMPTOMS", tuple(symptoms))
    log = sf.Log({"time": 2.0 + DT * np.arange(T), "forces": np.zeros((T, contacts, 3))}, {})
    return diagnose(log, setting(dt, contacts), intervals)


def places(findings: list[Finding]) -> list[tuple[str, str]]:
    return [(one.name, one.contact) for one in findings]


ONE = symptom("one", LIKELY, "pull")


def test_an_episode_is_told_with_its_times_and_words(monkeypatch: pytest.MonkeyPatch) -> None:
    (finding,) = found(monkeypatch, [ONE], interval(1, 100, 119))
    told = "100-119: pull 100-119 1 20"
    assert finding.start == pytest.approx(3.0)
    assert finding.end == pytest.approx(3.2)
    words = "one's cause", "one's confirm", "one's cure"
    assert finding == Finding("one", "b", finding.start, finding.end, told, *words, LIKELY)
    assert found(monkeypatch, [], interval(1, 100, 119)) == []
    assert found(monkeypatch, [ONE]) == []


@pytest.mark.parametrize(("gap", "count"), [(5, 1), (6, 2)])
def test_intervals_of_a_contact_are_joined_up_to_fifty_milliseconds(
    gap: int, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    pair = interval(1, 100, 109, value=3.0), interval(1, 109 + gap, 130, value=2.0)
    findings = found(monkeypatch, [ONE], *pair[::-1])
    assert len(findings) == count
    if count == 1:
        assert findings[0].evidence == "100-130: pull 100-130 3 27"
        assert findings[0].end == pytest.approx(2.0 + 1.31)


def test_an_interval_within_another_does_not_shorten_it(monkeypatch: pytest.MonkeyPatch) -> None:
    three = interval(1, 100, 200), interval(1, 110, 120, value=4.0), interval(1, 203, 210)
    (finding,) = found(monkeypatch, [ONE], *three)
    assert finding.evidence == "100-210: pull 100-210 4 120"


def test_checks_of_an_episode_stay_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    (finding,) = found(monkeypatch, [ONE], interval(1, 100, 110), interval(1, 104, 120, "slip", 7.0))
    assert finding.evidence == "100-120: pull 100-110 1 11; slip 104-120 7 17"


def test_neighbouring_rows_are_joined_where_the_step_is_not_known(monkeypatch: pytest.MonkeyPatch) -> None:
    for dt in (0.0, 1.0):  # or long
        for gap, count in ((1, 1), (2, 2)):
            pair = interval(1, 100, 109), interval(1, 109 + gap, 130)
            assert len(found(monkeypatch, [ONE], *pair, dt=dt)) == count


def test_the_first_forty_episodes_of_each_contact_are_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    many = [interval(column, 10 * k, 10 * k) for k in range(45) for column in (0, 2)]
    findings = found(monkeypatch, [ONE], *many)
    for name in "ac":
        mine = [one.start for one in findings if one.contact == name]
        assert mine == pytest.approx([2.0 + 0.1 * k for k in range(40)])


def test_the_strongest_symptom_speaks(monkeypatch: pytest.MonkeyPatch) -> None:
    three = [symptom("weak", 0.2, "pull"), symptom("strong", 0.4, "pull"), symptom("other", 0.9, "slip")]
    assert places(found(monkeypatch, three, interval(0, 5, 9))) == [("strong", "a")]


@pytest.mark.parametrize(("after", "name"), [(3, "moved"), (4, "pulled")])
def test_a_motion_that_went_wrong_later_is_a_consequence(
    after: int, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    pair = [symptom("moved", 0.5, "motion"), symptom("pulled", 0.3, "pull")]
    both = interval(0, 100, 120), interval(0, 100 + after, 120, "motion")
    assert places(found(monkeypatch, pair, *both)) == [(name, "a")]


def body(name: str, strength: float) -> Symptom:
    return symptom(name, strength, body=True)


@pytest.mark.parametrize(("foot", "whole", "expected"), [
    (LIKELY, ("outside force", LIKELY), ["one"]),  # a foot's wrong force explains the body's
    (LIKELY, ("outside force", SURE), ["outside force", "one"]),
    (LIKELY, ("teleport", LIKELY), ["teleport"]),  # the body's jump explains the feet's
    (SURE, ("teleport", LIKELY), ["one", "teleport"]),
    (CERTAIN, ("teleport", LIKELY), ["one", "teleport"]),
])  # fmt: skip
def test_what_explains_the_other_is_kept(
    foot: float, whole: tuple[str, float], expected: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    symptoms = [symptom("one", foot, "pull"), body(*whole)]
    findings = found(monkeypatch, symptoms, interval(0, 100, 110), interval(BODY, 105, 120))
    assert [one.name for one in findings] == expected


@pytest.mark.parametrize(("first", "last", "kept"), [
    (50, 93, True), (50, 95, False), (115, 130, False), (117, 130, True),
])  # fmt: skip
def test_what_is_fifty_milliseconds_apart_explains_nothing(
    first: int, last: int, kept: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    symptoms = [symptom("one", LIKELY, "pull"), body("outside force", LIKELY)]
    findings = found(monkeypatch, symptoms, interval(0, 100, 110), interval(BODY, first, last))
    assert ("outside force" in [one.name for one in findings]) == kept


@pytest.mark.parametrize(("columns", "joined"), [((0, 1), False), ((0, 1, 3), True), ((0, 1, 2, 3), True)])
def test_three_of_four_contacts_are_all(
    columns: tuple[int, ...], joined: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    findings = found(monkeypatch, [ONE], *[interval(k, 100 + k, 120 + k) for k in columns])
    assert [one.contact for one in findings] == (["all"] if joined else ["abcd"[k] for k in columns])
    if joined:
        assert findings[0].start == pytest.approx(3.0)
        assert findings[0].end == pytest.approx(3.21 + 0.01 * columns[-1])


def test_contacts_at_other_times_are_not_all(monkeypatch: pytest.MonkeyPatch) -> None:
    findings = found(monkeypatch, [ONE], *[interval(k, 100 * (k + 1), 100 * k + 120) for k in range(4)])
    assert [one.contact for one in findings] == list("abcd")


def test_the_words_of_all_are_those_of_the_strongest(monkeypatch: pytest.MonkeyPatch) -> None:
    def judge(episode: Episode) -> Evidence:
        return Evidence(0.1 * (1.0 + episode.column % 3), f"contact {episode.column}")

    grown = Symptom("grown", "", "", "", judge, ("pull",))
    (finding,) = found(monkeypatch, [grown], *[interval(k, 100, 120) for k in range(4)])
    assert (finding.contact, finding.evidence) == ("all", "contact 2")
    assert finding.strength == pytest.approx(0.3)


def test_a_single_contact_and_the_body_are_never_all(monkeypatch: pytest.MonkeyPatch) -> None:
    assert places(found(monkeypatch, [ONE], interval(0, 5, 9), contacts=1)) == [("one", "a")]
    whole = found(monkeypatch, [body("one", LIKELY)], interval(BODY, 5, 9))
    assert places(whole) == [("one", "body")]


def test_findings_come_by_strength_and_by_time(monkeypatch: pytest.MonkeyPatch) -> None:
    symptoms = [symptom("weak", 0.2, "pull"), symptom("strong", 0.3, "slip"), symptom("sure", SURE, "spike")]
    apart = [interval(0, 500, 505, "spike"), interval(1, 300, 310), interval(2, 100, 110),
             interval(3, 400, 410, "slip")]  # fmt: skip
    assert places(found(monkeypatch, symptoms, *apart)) == [
        ("sure", "a"), ("strong", "d"), ("weak", "c"), ("weak", "b"),
    ]  # fmt: skip


@pytest.mark.parametrize(("first", "order"), [(105, ["joint stop", "weak"]), (107, ["weak", "joint stop"])])
def test_a_joint_that_comes_to_its_stop_later_is_last(
    first: int, order: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    symptoms = [symptom("weak", 0.2, "pull"), symptom("joint stop", 0.4, "slip")]
    findings = found(monkeypatch, symptoms, interval(0, 100, 110), interval(1, first, 130, "slip"))
    assert [one.name for one in findings] == order


def test_all_contacts_come_before_one_that_is_little_stronger(monkeypatch: pytest.MonkeyPatch) -> None:
    for more, order in ((0.5, ["every", "single"]), (1.5, ["single", "every"])):
        symptoms = [symptom("every", 0.2, "pull"), symptom("single", 0.2 + more * SHARED, "slip")]
        shared = [interval(k, 100, 120) for k in (1, 2, 3)]
        findings = found(monkeypatch, symptoms, *shared, interval(0, 300, 310, "slip"))
        assert [one.name for one in findings] == order


def test_long_episodes_are_shown_by_their_first_four_thousand_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(diagnosis, "SYMPTOMS", (ONE,))
    count = 4200
    log = sf.Log({"time": DT * np.arange(count), "forces": np.zeros((count, 4, 3))}, {})
    (finding,) = diagnose(log, setting(), [interval(0, 100, 4150)])
    told: Any = finding.evidence
    assert told.startswith("100-4099: ")
    assert finding.end == pytest.approx(DT * 4151)
