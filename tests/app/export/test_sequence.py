"""A contact sequence survives its file to the last bit, and a wrong file is named."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from surefoot.app.cli.main import main
from surefoot.app.export import (
    ContactSequence,
    SequencePhase,
    read_sequence,
    sequence_from_log,
    sequence_from_schedule,
    write_sequence,
)
from surefoot.app.export.sequence_file import SCHEMA, sequence_from_dict, sequence_to_dict
from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot import load_robot, place
from surefoot.mechanics.stance import PointContact, Stance
from surefoot.motion.gaits.library import named_gait
from surefoot.motion.planning import PlanSearch, plan_from, rollout
from tests.app.export.sequences import random_sequence


@pytest.mark.parametrize("seed", range(100))
def test_a_file_reads_back_the_same(seed: int, tmp_path: Path) -> None:
    sequence = random_sequence(seed)
    path = write_sequence(sequence, tmp_path / "contacts.json")
    again = read_sequence(path)
    assert sequence_to_dict(again) == sequence_to_dict(sequence)  # floats to the last bit
    kinds = [[type(c) for phase in one.phases for c in phase.stance] for one in (again, sequence)]
    assert kinds[0] == kinds[1]


@pytest.mark.long
def test_the_file_keeps_to_its_schema() -> None:
    jsonschema = pytest.importorskip("jsonschema")
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    for seed in range(20):
        jsonschema.validate(json.loads(json.dumps(sequence_to_dict(random_sequence(seed)))), schema)
    wrong = sequence_to_dict(random_sequence(0))
    wrong["phases"][0]["duration"] = -1.0
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(wrong, schema)


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    path = write_sequence(random_sequence(0), tmp_path / "contacts.json")
    with pytest.raises(ProblemError, match="exists already"):
        write_sequence(random_sequence(1), path)


def spoiled(path: str, value: object) -> dict:
    """Return a sequence's dictionary with one entry changed; "" for none."""
    content = copy.deepcopy(sequence_to_dict(random_sequence(3, patches=False)))
    *way, last = path.split(".")
    at = content
    for key in way:
        at = at[int(key)] if key.isdigit() else at[key]
    if value is None:
        del at[last]
    else:
        at[last] = value
    return content


@pytest.mark.parametrize(
    ("path", "value", "told"),
    [
        ("version", 2, "version"),
        ("version", True, "version True"),
        ("frames", None, "frames is missing"),
        ("frames", ["LF_FOOT"], "unknown frame"),
        ("colour", "red", "unknown key"),
        ("mass", -1.0, "mass"),
        ("friction", {"facets": 2, "fit": "inner"}, "facets"),
        ("phases", [], "at least one phase"),
        ("phases.0.duration", 0.0, r"phases\[0\].*duration"),
        ("phases.0.contacts.0.mu", -0.1, r"contacts\[0\].*mu"),
        ("phases.0.contacts.0.rotation", [[1, 0, 0], [0, 1, 0], [0, 0, 2]], "rotation"),
        ("phases.0.contacts.0.normal_max", -5.0, "normal_max"),
        ("phases.0.contacts.0.force", [0.0, 1.0], "force"),
        ("phases.0.contacts.0.halfspaces", {"A": [[1.0, 0.0, 0.0]], "b": [0.0]}, "halfspaces"),
    ],
)
def test_a_wrong_file_is_named(path: str, value: object, told: str) -> None:
    with pytest.raises(ProblemError, match=told):
        sequence_from_dict(spoiled(path, value))


@pytest.mark.parametrize("text", ["", "[1, 2", "7", "null", "[" * 100000])
def test_what_is_no_sequence_is_refused(text: str, tmp_path: Path) -> None:
    path = tmp_path / "contacts.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ProblemError, match=r"contacts\.json"):
        read_sequence(path)


def feet() -> Stance:
    places = (("FL", 0.2, 0.1), ("FR", 0.2, -0.1), ("RL", -0.2, 0.1), ("RR", -0.2, -0.1))
    return Stance([PointContact((x, y, 0.0), name=n) for n, x, y in places])


def test_a_schedule_becomes_phases_of_its_feet() -> None:
    trot = named_gait("trot", 4, period=0.5)
    sequence = sequence_from_schedule(trot, feet(), (0.1, 1.1), mass=16.0)
    assert sequence.duration == pytest.approx(1.0)
    for time in np.linspace(0.11, 1.09, 49):
        on = trot.contacts([time])[0]
        names = tuple(n for n, down in zip(sequence.frames, on, strict=True) if down)
        assert sequence.touching(time - 0.1) == names


def test_a_sequence_with_a_foot_twice_is_refused() -> None:
    twice = Stance([PointContact((0.0, 0.0, 0.0), name="L"), PointContact((0.1, 0.0, 0.0), name="L")])
    with pytest.raises(ProblemError, match="twice"):
        ContactSequence([SequencePhase(0.1, twice)], ("L",))


@pytest.fixture(scope="module")
def landing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan's file: Go2 falls from 5 cm onto its feet."""
    robot = load_robot("go2")
    q = place(robot)
    q[2] += 0.05
    motion = rollout(
        robot, q, np.zeros(18), lambda k, a, v: 60.0 * (q[7:] - a[7:]) - 2.0 * v[6:], dt=0.002, steps=150
    )
    plan = plan_from(motion, robot, PlanSearch("fall", "none", 0.0, True, 0, 0.0))
    return plan.save(tmp_path_factory.mktemp("plan") / "fall.npz")


def test_a_plan_becomes_a_sequence(landing: Path) -> None:
    from surefoot.records.log.reading import read_log

    log = read_log(landing)
    sequence = sequence_from_log(log)
    assert sequence.phases[0].names == ()  # it flies first
    assert sequence.phases[0].duration == pytest.approx(np.sqrt(2 * 0.05 / 9.81), abs=0.02)
    assert sequence.phases[-1].names == tuple(log.fact("feet"))
    assert sequence.duration == pytest.approx(0.3)
    loads = sequence.phases[-1].forces.reshape(-1, 3)[:, 2]
    assert (loads > 0.0).all()


def test_the_command_exports_a_plan(landing: Path, tmp_path: Path, answer: Any) -> None:
    forms = [word for form in ("sequence", "casadi", "ocs2") for word in ("--to", form)]
    facts = answer("export", landing, *forms, "--out", tmp_path / "out")
    names = {"contacts.json", "contacts_casadi.py", "gait.info", "friction.info"}
    assert {Path(f).name for f in facts["files"]} == names
    again = next(f for f in facts["files"] if f.endswith(".json"))
    assert main(["export", again, "--to", "drake", "--facets", "4", "--out", str(tmp_path / "two")]) == 0
    assert "4 facets" in next((tmp_path / "two").rglob("contacts_drake.py")).read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["nowhere.json"], "nowhere.json"),
        (["nowhere.npz"], "nowhere.npz"),
        (["{plan}", "--to", "matlab"], "valid names"),
        (["{plan}", "--facets", "2"], "facets"),
        (["{plan}", "--facets", "5", "--to", "crocoddyl"], "even"),
    ],
)
def test_wrong_input_is_one_line(
    landing: Path, tmp_path: Path, arguments: list[str], told: str, capfd: pytest.CaptureFixture[str]
) -> None:
    given = [a.format(plan=landing) for a in arguments]
    assert main(["export", *given, "--out", str(tmp_path / "out")]) == 2
    said = capfd.readouterr()
    assert told in said.err
    assert said.err.count("\n") == 1
    assert not (tmp_path / "out").exists()
