"""`--scenario FILE`: what it says happens; what it cannot mean is one line, with the keys that are valid."""

from __future__ import annotations

import json
import re
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest
import yaml

from surefoot.app.cli.physics import contact_law
from surefoot.app.cli.scenario_file import SCHEMA, STAND_KEYS, WALK_KEYS, ScenarioFile
from surefoot.laws import Hertz, HuntCrossley, MujocoLaw, SpringDamper
from surefoot.records.log.reading import read_log

ROOT = Path(__file__).resolve().parents[3]
SCENARIOS = sorted((ROOT / "examples" / "scenarios").glob("*.yaml"))
FILES = ["--no-video", "--no-report"]


def schema() -> Any:
    """Return the JSON schema as it is shipped."""
    return json.loads(SCHEMA.read_text(encoding="utf-8"))


def written(folder: Path, text: str) -> Path:
    """Write a scenario and return its path."""
    path = folder / "scenario.yaml"
    path.write_text(text)
    return path


@pytest.fixture
def summary(answer: Any, tmp_path: Path) -> Any:
    """Return what runs a command on Go2 with a scenario or none: it gives the summary of a good run."""

    def run(scenario: Path | None, command: str, *words: str) -> Any:
        more = [] if scenario is None else ["--scenario", scenario]
        return answer(command, "go2", *words, *more, *FILES, "--out", tmp_path / "runs")

    return run


def test_one_schema_says_all_keys() -> None:
    """What the reader holds, what the two commands take and what the page tells are the schema's keys."""
    keys = set(schema()["properties"])
    page = (ROOT / "docs" / "scenarios.md").read_text(encoding="utf-8")
    rows = [line.split("|")[1] for line in page.splitlines() if line.startswith("| `")]
    assert keys == {f.name for f in fields(ScenarioFile)} == STAND_KEYS | WALK_KEYS
    assert keys == {name for row in rows for name in re.findall(r"`(\w+)`", row)}
    assert all(one["description"] for one in schema()["properties"].values())


@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: path.name)
def test_examples_are_valid_for_us_and_for_json_schema(path: Path) -> None:
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.Draft202012Validator(schema()).validate(yaml.safe_load(path.read_text()))
    assert ScenarioFile.read(path, STAND_KEYS | WALK_KEYS).given
    assert path.read_text().startswith("# yaml-language-server: $schema=../../src/surefoot/cli/scenario.sch")


def test_a_file_that_says_nothing_is_no_file(tmp_path: Path) -> None:
    assert ScenarioFile.read(written(tmp_path, ""), WALK_KEYS) == ScenarioFile.read(None, WALK_KEYS)


@pytest.mark.parametrize(
    ("said", "law"),
    [
        ({"name": "spring-damper", "stiffness": 2e4, "damping": 100.0}, SpringDamper(2e4, 100.0)),
        ({"name": "hunt-crossley", "stiffness": 2e5, "exponent": 1.5}, HuntCrossley(2e5, exponent=1.5)),
        ({"name": "sphere", "radius": 0.02, "modulus": 1e7}, Hertz.sphere(0.02, 1e7)),
        ({"name": "hertz", "stiffness": 1e6, "dissipation": 0.3}, Hertz(1e6, 0.3)),
        ({"name": "mujoco", "solref": (0.02, 1.0), "mass": 4.0}, MujocoLaw((0.02, 1.0), mass=4.0)),
    ],
)
def test_a_law_is_one_of_our_laws_with_exact_friction(said: dict[str, Any], law: Any) -> None:
    made = contact_law(said, 0.35)
    assert made.friction.mu == 0.35
    assert made == replace(law, friction=made.friction)


def test_stands_on_soft_ground(summary: Any, tmp_path: Path) -> None:
    soft = written(tmp_path, "law: {name: hunt-crossley, stiffness: 2e5, dissipation: 0.5}")
    found = summary(soft, "stand", "--world", "rigid", "--duration", "1")
    assert (found["stood"], found["laws_broken"]) == (True, [])


@pytest.mark.long
def test_walks_in_the_rigid_world_and_stands_on_mujocos_own_ground(summary: Any, tmp_path: Path) -> None:
    found = summary(None, "walk", "--world", "rigid", "--duration", "1")
    assert found["walked"] is True
    soft = ROOT / "examples" / "scenarios" / "mujoco_default.yaml"
    found = summary(soft, "stand", "--duration", "2")
    assert (found["stood"], found["laws_broken"]) == (True, [])
    assert found["laws"]["sinking"] > found["laws"]["penetration_max"] > 1e-3  # as its ground declares


@pytest.mark.long
def test_the_true_state_is_chosen(summary: Any, tmp_path: Path) -> None:
    known = summary(written(tmp_path, "estimator: truth"), "walk", "--duration", "1.2")
    estimated = summary(None, "walk", "--duration", "1.2")
    assert "estimate" not in known
    assert estimated["estimate"]["velocity_rms"] < 0.01
    assert estimated["velocity"]["forward"] != known["velocity"]["forward"]


def test_velocities_come_from_a_file(summary: Any, tmp_path: Path) -> None:
    (tmp_path / "speeds.txt").write_text("0 0.2 0 0\n0.5 0 0.1 0.2\n")
    files = written(tmp_path, "velocity_file: speeds.txt")
    summary(files, "walk", "--duration", "1.2")
    (folder,) = (tmp_path / "runs").iterdir()
    command = read_log(folder / "log.npz")["command"]
    assert command[600, 0] > 0.1
    assert command[-1].tolist() == pytest.approx([0.0, 0.1, 0.2], abs=0.02)


def test_a_weak_motor_gives_less_than_it_is_asked_for(summary: Any, tmp_path: Path) -> None:
    weak = written(tmp_path, "weak_joint: FL_calf_joint\ntorque_loss: 0.5")
    found = summary(weak, "stand", "--duration", "1")
    whole = summary(None, "stand", "--duration", "1")
    assert found["stood"] is True
    assert found["base"]["position_max"] > 1.5 * whole["base"]["position_max"]


LAW = "law: {name: spring-damper, stiffness: 2e4}"
WRONG = [
    ("frction: 0.2", [], "unknown key 'frction'; valid names: believed_mu, control_rate, delay"),
    ("ice: [{from: 1, mu: 0.1, until: 2}]", [], "unknown key of ice[0] 'until'; valid names: from, lower"),
    ("ice: [{from: 1}]", [], "ice[0] needs the key 'mu'"),
    ("ice: [{mu: 0.1}]", [], "ice takes from and mu, or lower, upper and mu, got mu"),
    ("ice: [{from: 1, mu: 1e9}]", [], "ice[0] mu must be a number from 0 to 1000, got '1e9'"),
    ("ice: [{from: 2, mu: 0.1}]", ["--duration", "2"], "starts at 2 s, when the run is over"),
    ("ice: {mu: 1}", [], "ice must be a list, got {'mu': 1}"),
    ("ice: [{lower: [0, 1], upper: [0, 2], mu: 0.1}]", [], "a patch of ice reaches from"),
    ("ice: [{lower: [0], upper: [0, 2], mu: 0.1}]", [], "ice[0] lower must be a list of 2 entries, got [0]"),
    (LAW, [], "law is of --world rigid, got --world mujoco"),
    ("solref: [0.02, 1]", ["--world", "rigid"], "solref is of --world mujoco"),
    ("solref: [0.02, -1]", [], "solref"),
    ("solref: [a, b]", [], "solref[0] must be a number, got 'a'"),
    ("law: {name: rubber}", ["--world", "rigid"], "unknown law name 'rubber'; valid names: hertz"),
    ("law: {name: spring-damper, radius: 1}", ["--world", "rigid"], "'radius'; valid names: damping, stiff"),
    ("law: {name: spring-damper}", ["--world", "rigid"], "the law spring-damper needs stiffness"),
    ("law: {name: sphere, radius: .nan}", ["--world", "rigid"], "law radius must be a number >= 0, got nan"),
    (f"delay: 1{'0' * 400}", [], "delay must be a number from 0 to 1, got 1000"),
    ("delay: true", [], "delay must be a number from 0 to 1, got True"),
    ("substeps: 1.5", [], "substeps must be a whole number from 1 to 64, got 1.5"),
    ("weak_joint: nose", [], "unknown joint 'nose'"),
    ("weak_joint: 1", [], "weak_joint must be a text, got 1"),
    ("- 1", [], "the file must be a mapping of keys, got [1]"),
    ("a: [", [], "is not YAML"),
]
OF_WALK = [
    ("estimator: oracle", [], "unknown estimator 'oracle'; valid names: inekf, truth"),
    ("noise: -1", [], "noise must be a number from 0 to 100"),
    ("believed_mu: much", [], "believed_mu must be a number from 0 to 1000, got 'much'"),
    ("period: 0", [], "period must be"),
    ("velocity_file: none.txt", [], "cannot read the velocity file"),
    ("control_rate: 333", [], "control_rate must be 1000 over a whole number"),
    ("control_rate: 0", [], "control_rate must be a number from 20 to 1000"),
    ("latency: fast", [], "latency must be a number from 0 to 0.03, got 'fast'"),
    ("latency: 1", [], "latency must be a number from 0 to 0.03, got 1"),
    ("period: 0.4", ["--planner", "contact-implicit"], "takes no --gait or period"),
    ("latency: 0.01", ["--planner", "contact-implicit"], "takes no --commands"),
]
OF_STAND = [("estimator: truth", [], "unknown key for this command 'estimator'; valid names: delay, ice")]


@pytest.mark.parametrize(
    ("command", "text", "options", "words"),
    [
        *(("stand", *case) for case in WRONG[1:] + OF_STAND),
        *(("walk", *case) for case in WRONG[:6] + OF_WALK),
    ],
)
def test_what_a_file_cannot_mean_is_one_line(
    command: str,
    text: str,
    options: list[str],
    words: str,
    tmp_path: Path,
    printed: Any,
) -> None:
    path = written(tmp_path, text)
    out = tmp_path / "runs"
    said = printed(command, "go2", *options, *FILES, "--scenario", path, "--out", out, code=2)
    assert words in said
    assert said.count("\n") == 1
    assert not [file for file in out.rglob("*") if file.is_file()]
