"""Every answer draws itself, on axes of its own or given ones, and says in a sentence what it is."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.export.sequence import ContactSequence, SequencePhase
from surefoot.app.viz.drawings import DRAWINGS, VIZ, drawing_of, png_of
from surefoot.app.viz.style import GOOD, blank_figure, friction_colour
from surefoot.base.drawn import Drawn
from surefoot.base.errors import MissingExtra, ProblemError
from surefoot.motion.planning.plan import PlanSearch, plan_from
from surefoot.records.audit.report import AuditReport
from surefoot.records.identification.force_model import FootForces
from surefoot.records.identification.toss_errors import TossErrors
from surefoot.records.identification.toss_fit import Estimate, TossFit
from surefoot.records.identification.walked_robot import RobotFit
from surefoot.worlds.replay.windows import ReplayReport, WindowReplay
from surefoot.worlds.sweep import SweepResult, sweep_from_dict
from surefoot.worlds.transfer.transfer import TransferReport, WorldTransfer
from tests.pickled_values import VALUES


@pytest.fixture(autouse=True)
def no_figure_stays() -> Iterator[None]:
    """Close what pyplot keeps, where another test has loaded it."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


def fit() -> TossFit:
    errors = TossErrors(*np.random.default_rng(0).uniform(size=(3, 20)))
    nothing: Any = None
    return TossFit(
        "rigid", {}, errors, None, np.zeros((0, 7)), None, nothing, None, 0.0, 0.0, 0.0, 1.0, 1.0, ()
    )


def sweep(folder: Path) -> SweepResult:
    ranges = {"mu": [0.1, 1.0], "slope": [0, 30]}
    settings = {"body": "box", "size": 0.1, "height": 0.1}
    asked = {"experiment": "drop", "samples": 20, "seed": 3, "settings": settings, "ranges": ranges}
    return sf.run_sweep(sweep_from_dict(asked), folder, backend="serial")


def intervals() -> dict[str, Estimate]:
    return {"payload": Estimate(2.0, 1.5, 2.5, "kg"), "delay": Estimate(0.01, -0.01, 0.03, "s")}


def outcomes(robot: sf.Robot, q: Any) -> dict[str, Any]:
    """What became of runs, and what was fitted to them."""
    still = sf.Motion(
        robot, np.tile(q, (40, 1)) + 0.002 * np.sin(np.arange(40))[:, None] * (np.arange(19) == 2), 30.0
    )
    report = sf.certify_motion(robot, still)
    time = np.arange(0.0, 4.0, 0.0025)
    down = (time[:, None] / 0.5 + np.array([0.0, 0.5])) % 1.0 < 0.6
    raw = sf.Log({"time": time, "foot_sensors": 80.0 * down + 20.0}, {"feet": ["left", "right"]})
    window = {"outcome": "done", "way": 1.0, "logged_way": 1.0, "tilt": 0.02, "broken": ()}
    windows = (
        WindowReplay(0.0, 1.0, drift=0.01, lost="", **window),
        WindowReplay(1.0, 2.0, drift=0.2, lost="it fell", **window),
    )
    rows = [
        WorldTransfer("mujoco", 8, 8, (0.7, 1.0), (0.0, 0.0), "reference", np.nan, "", 0),
        WorldTransfer("mujoco-exact", 1, 8, (0.0, 0.4), (-0.9, -0.4), "lost", 0.2, "floor", 0),
    ]
    feet = [sf.PointContact((x, 0.0, 0.0), name=n) for n, x in (("L", 0.1), ("R", -0.1))]
    phases = [SequencePhase(0.3, sf.Stance(feet)), SequencePhase(0.2, sf.Stance(feet[:1]))]
    forces = np.random.default_rng(1).normal(10.0, 1.0, (50, 3))
    parts = (forces, forces - 2.0, forces + 2.0, forces[:, 2], forces[:, 2] > 9.5, np.array([0.3]))
    return {
        "Motion": still,
        "Repair": sf.repair_motion(report),
        "ContactTimes": sf.contact_times(raw),
        "ForceEstimate": sf.estimate_forces(robot, q, np.zeros(18), np.zeros(18), np.zeros(12)),
        "ForceModel": VALUES["ForceModel"](),
        "FootForces": FootForces(np.arange(50) * 0.01, *parts, np.full(50, 0.2)),
        "RobotFit": RobotFit(intervals(), ("a note",)),
        "ReplayReport": ReplayReport("mujoco", "rigid", "lost", "it fell", windows, ()),
        "TransferReport": TransferReport(tuple(rows)),
        "ContactSequence": ContactSequence(phases, ("L", "R"), robot="biped"),
        "Verdicts": sf.can_stand_batch(
            [robot.stance(q, mu=mu) for mu in (0.2, 0.6)], [[0.0, 0.0, 0.3], [2.0, 0.0, 0.3]], 15.0
        ),
    }


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    robot = sf.load_robot("go2")
    q = sf.place(robot)
    stance = robot.stance(q, mu=0.6)
    G, g = np.eye(6) / 4.0, np.array([0.3, 0.0, -1.0, 0.9, 0.2, -1.0])
    problem = sf.ContactProblem(G, g, 0.6)
    motion = sf.rollout(robot, q, np.zeros(18), np.zeros((10, 12)), dt=0.01)
    plan = plan_from(motion, robot, PlanSearch("fall", "none", 0.0, True, 0, 0.0))
    return {
        "FrictionCone": sf.FrictionCone(0.6),
        "FrictionPyramid": sf.FrictionCone(0.6).polyhedral(6, "outer"),
        "PolyhedralCone": sf.wrench_cone(stance, facets=4, about=robot.com(q)),
        "Sole": sf.Sole(0.22, 0.09, 0.6),
        "ContactProblem": problem,
        "Certified": sf.solve(problem),
        "BatchSolution": sf.solve_batch([G] * 5, [g] * 5, 0.6),
        "Robot": robot,
        "Stance": stance,
        "Verdict": sf.can_stand(stance, robot.com(q), robot.mass),
        "Region": sf.com_region(stance, robot.mass),
        "StanceCone": sf.StanceCone(stance),
        "ContactSchedule": sf.named_gait("trot"),
        "Plan": plan,
        "Log": plan.rows(slice(0, 8)),
        "AuditReport": sf.audit_log(plan),
        "BatchReport": sf.audit_batch({"forces": np.ones((60, 3, 4, 3))}, 0.01, 0.6, mass=9.0),
        "MotionReport": sf.certify_motion(robot, sf.Motion(robot, np.tile(q, (30, 1)), 30.0, "still")),
        "TossFit": fit(),
        **outcomes(robot, q),
        "SweepResult": sweep(tmp_path_factory.mktemp("sweep")),
    }


def test_every_class_with_a_drawing_has_a_case(answers: dict[str, Any]) -> None:
    assert {name.partition(".")[2] for name in DRAWINGS} == {*answers}
    for name, answer in answers.items():
        assert isinstance(answer, Drawn)
        assert drawing_of(answer) is next(d for key, d in DRAWINGS.items() if key.endswith(f".{name}"))
        assert callable(resolve_name(f"{VIZ}.{drawing_of(answer).function}"))


@pytest.mark.parametrize("name", [name.partition(".")[2] for name in DRAWINGS])
def test_an_answer_draws_itself(name: str, answers: dict[str, Any], tmp_path: Path) -> None:
    from matplotlib.image import imread

    answer = answers[name]
    assert all(hasattr(axis, "add_patch") for axis in np.ravel(answer.plot()))
    image = sf.picture(answer, tmp_path / "picture.png")
    assert imread(image)[..., :3].std() > 0.02  # something is on it
    if drawing_of(answer).panels:
        with pytest.raises(ProblemError, match="panels of its own"):
            answer.plot(blank_figure().add_subplot())
    else:
        given = blank_figure().add_subplot(projection="3d" if drawing_of(answer).space else None)
        assert answer.plot(given) is given


@pytest.mark.parametrize("name", ["FrictionCone", "FrictionPyramid", "Robot", "Stance", "Verdict"])
def test_what_stands_in_space_is_drawn_on_plane_axes_as_well(name: str, answers: dict[str, Any]) -> None:
    axes = blank_figure().add_subplot()
    assert answers[name].plot(axes) is axes
    assert axes.lines


@pytest.mark.parametrize("name", [name.partition(".")[2] for name in DRAWINGS])
def test_an_answer_is_a_sentence_and_a_line(name: str, answers: dict[str, Any]) -> None:
    text, line = str(answers[name]), repr(answers[name])
    assert len(text) < 400
    assert text[-1] == "."
    assert len(line) < 200
    assert line.isprintable()
    assert not line.startswith("<")


def test_sentences_say_what_a_person_wants() -> None:
    robot = sf.load_robot("go2")
    q = sf.place(robot)
    slope = sf.SlopeTerrain(35.0)
    stance = robot.stance(sf.place(robot, slope), mu=0.6, terrain=slope)
    assert str(robot.stance(q)) == "Stance of 4 points, mu 0.6: FL_foot, FR_foot, RL_foot, RR_foot."
    assert str(sf.can_stand(robot.stance(q), robot.com(q), robot.mass)).startswith(
        "It can stand: 4 contacts, "
    )
    assert str(sf.can_stand(stance, robot.com(q), robot.mass)).startswith("It cannot stand: no forces")
    assert str(sf.FrictionCone(1.0)) == "Friction cone of mu 1: forces up to 45 deg from the normal."
    assert "-7.61 % at most" in str(sf.FrictionCone(0.6).polyhedral(8, "inner"))
    assert str(sf.Sole(0.22, 0.09, 0.6)) == "A sole of 22 x 9 cm with 4 corners, mu 0.6."
    assert str(sf.Stance([sf.SoleContact([0, 0, 0], sf.Sole(0.2, 0.1))])) == "Stance of 1 sole, mu 0.6."


def test_forces_are_a_row_a_contact_and_in_world_axes_beside() -> None:
    """A sole's wrench, a wall's force: one vocabulary, whatever the contacts are."""
    sole = sf.SoleContact([0.1, 0.0, 0.0], sf.Sole(0.2, 0.1), name="sole")
    wall = sf.PointContact([0.6, 0.1, 0.9], mu=0.5, normal=[-1.0, 0.0, 0.0], name="hand")
    stance = sf.Stance([sole, wall])
    verdict = sf.can_stand(stance, [0.12, 0.01, 0.7], 20.0)
    assert verdict
    assert verdict.forces.shape == verdict.world_forces.shape == (2, 3)
    assert verdict.stacked.shape == (9,)
    np.testing.assert_array_equal(verdict.forces[1], verdict.by_contact()[1])
    np.testing.assert_allclose(verdict.world_forces.sum(axis=0), [0.0, 0.0, 20.0 * 9.81], atol=1e-6)
    np.testing.assert_allclose(verdict.world_forces[1, 0], -verdict.forces[1, 2], atol=1e-12)
    with pytest.raises(ProblemError, match="unknown axes 'base'; valid names: contact, world"):
        stance.force_rows(verdict.stacked, "base")  # type: ignore[arg-type]
    assert len(repr(stance.halfspaces(8))) < 100
    assert stance.plot(forces=verdict.stacked).collections
    assert stance.plot(forces=verdict.forces).collections
    with pytest.raises(ProblemError, match="forces must have shape"):
        stance.plot(forces=[1.0, 2.0])


def test_the_solver_of_the_loop_is_told_the_friction() -> None:
    solver = sf.ContactSolver(contacts=1, mu=0.6)
    answer = solver.solve(np.eye(3) / 4.0, np.array([0.3, 0.0, -1.0]))
    assert answer.plot(mu=0.6).get_title() == "SOLVED: 1 of 1 press, 0 at the border"
    with pytest.raises(ProblemError, match=r"plot\(mu="):
        answer.plot()


def test_a_section_is_where_the_cone_ends() -> None:
    contact = sf.PointContact([0.0, 0.0, 0.0], mu=0.5)
    cone = sf.StanceCone(sf.Stance([contact]))
    border = cone.plot().lines[0].get_xydata()
    np.testing.assert_allclose(np.hypot(*border.T), 0.5, rtol=1e-5)


def test_stances_of_a_trot_are_bars_of_its_duty() -> None:
    axes = sf.named_gait("trot").plot(until=0.4)
    bars = axes.collections[0].get_paths()
    width = sum(float(np.ptp(path.vertices[:, 0])) for path in bars)
    assert width / 0.4 == pytest.approx(float(sf.named_gait("trot").duty[0]), abs=0.01)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: sf.FrictionCone(0.6).plot(side=8), "picture 'side'; valid names: facets, fit"),
        (lambda: sf.FrictionCone(0.6).plot("here"), "axes must be Matplotlib's"),
        (lambda: sf.picture(3.0), "there is no picture of 3.0; there are of FrictionCone"),
        (lambda: sf.Stance([]).plot(), None),
        (lambda: sf.StanceCone(sf.Stance([])).plot(), "a stance without contacts"),
        (lambda: sf.named_gait("trot").plot(feet=["a"]), "feet must be 4 names, got 1"),
        (lambda: sf.Log({"time": np.arange(3.0)}).plot(), "nothing to draw"),
    ],
)  # fmt: skip
def test_what_cannot_be_drawn_says_so(call: Callable[[], Any], words: str | None) -> None:
    if words is None:
        call()
        return
    with pytest.raises(ProblemError, match=words.replace("(", r"\(")):
        call()


def test_a_notebook_sees_sentence_and_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    cone = sf.FrictionCone(0.6)
    assert png_of(cone).startswith(b"\x89PNG")
    html = cone._repr_html_()
    assert html is not None
    assert html.startswith("<p>Friction cone of mu 0.6")
    assert "data:image/png;base64," in html
    drawings = import_module("surefoot.app.viz.drawings")

    def fail(answer: object) -> bytes:
        raise MissingExtra("matplotlib", "viz")

    monkeypatch.setattr(drawings, "png_of", fail)
    assert cone._repr_html_() is None
    assert cone._repr_png_() is None


def test_a_figure_is_pyplots_where_that_is_loaded() -> None:
    import matplotlib.pyplot as plt

    before = set(plt.get_fignums())
    axes = sf.FrictionCone(0.6).plot()
    assert axes.figure.number in {*plt.get_fignums()} - before
    plt.close(axes.figure)
    png_of(sf.FrictionCone(0.6))
    assert set(plt.get_fignums()) == before
    assert "matplotlib.pyplot" in sys.modules


def test_colours_tell_how_near_the_border_a_force_is() -> None:
    assert friction_colour(0.0) == GOOD
    assert friction_colour(0.99) != friction_colour(0.5)
    assert friction_colour(1.0) == "#b3001b"


def test_a_report_names_its_counts() -> None:
    text = repr(AuditReport("broken", (), {"gap": 3}, (), {}, (), (), 10, 0.0, 1.0, (), 9.81))
    assert text == "AuditReport('broken', 3 violations, 0 symptoms, task='unknown', 10 rows)"
