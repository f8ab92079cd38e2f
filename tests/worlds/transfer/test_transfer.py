"""Whether a success is its simulator's: known losses and gains, and verdicts that will not lie."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.stats import binomtest, fisher_exact

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.worlds.transfer.shares import chance_of, difference_interval, share_interval
from surefoot.worlds.transfer.trial import TrialRun, departure
from surefoot.worlds.transfer.variants import STANDARD, Variant
from tests.robots import robot_of

mujoco = pytest.importorskip("mujoco")
NONE = np.zeros((300, 0))


def crate(mu: float = 0.5) -> Any:
    """Return a crate on a slope of 20 degrees, whose tangent is 0.364."""
    friction = f'friction="{mu} 0.005 0.0001"'
    geom = f'<geom name="box" type="box" size=".1 .1 .1" {friction}/>'
    body = f'<body name="crate" pos="0 0 .11" euler="0 20 0"><freejoint/>{geom}</body>'
    slope = f'<geom name="slope" type="plane" size="9 9 1" euler="0 20 0" {friction}/>'
    return mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{slope}{body}</worldbody></mujoco>")


def stays(model: Any, data: Any) -> bool:
    return math.hypot(data.qvel[0], data.qvel[1]) < 1e-6


def rows(report: Any) -> dict[str, Any]:
    return {row.world: row for row in report.worlds}


@pytest.mark.parametrize(("count", "of"), [(0, 10), (3, 10), (10, 10), (1, 1), (37, 80)])
def test_intervals_are_the_published_ones(count: int, of: int) -> None:
    """Wilson's against SciPy; Newcombe's against the example of his paper."""
    expected = binomtest(count, of).proportion_ci(method="wilson")
    assert share_interval(count, of) == pytest.approx((expected.low, expected.high), abs=1e-12)
    assert difference_interval((56, 70), (48, 80)) == pytest.approx((0.0524, 0.3339), abs=5e-5)
    low, high = difference_interval((count, of), (count, of))
    assert low < 0.0 < high
    for other in ((0, 10), (5, 10), (10, 10), (2, 3)):
        table = [[count, of - count], [other[0], other[1] - other[0]]]
        assert chance_of((count, of), other) == pytest.approx(fisher_exact(table).pvalue, rel=1e-9)
    assert difference_interval((0, 0), (count, of))[0] <= 0.0


@pytest.mark.long
def test_softness_that_fails_is_named_and_friction_that_is_gone_loses() -> None:
    """MuJoCo's crate creeps, the exact one stays; below the slope's tangent it slides by the closed form."""
    report = sf.transfer(
        crate(), NONE, ("mujoco-exact", "mujoco", "mujoco-exact:half-step", "mujoco-exact:mu-50%"), 8,
        success=stays,
    )  # fmt: skip
    found = rows(report)
    assert found["mujoco-exact"].successes == 8
    assert found["mujoco-exact:half-step"].verdict == "not told apart"
    assert report.lost == ("mujoco", "mujoco-exact:mu-50%")
    slid = found["mujoco-exact:mu-50%"]
    assert slid.contact == "slope on box"
    rate = 9.81 * (math.sin(math.radians(20.0)) - 0.25 * math.cos(math.radians(20.0)))
    landing = math.sqrt(2.0 * 0.01 / 9.81)
    # along x, from about when it lands
    fastest = math.sqrt(2.0 * 0.01 / (rate * math.cos(math.radians(20.0))))
    assert landing < slid.apart_at < landing + 1.2 * fastest
    assert "| mujoco-exact:mu-50% | 0 of 8 |" in "\n".join(report.table())
    assert str(report).startswith("8 of 8 runs succeed in mujoco-exact; beyond chance that is lost in 2 of ")
    assert report.as_dict()["lost"] == list(report.lost)


def test_a_world_is_never_apart_from_itself_and_few_seeds_prove_nothing() -> None:
    report = sf.transfer(crate(), NONE, ("mujoco-exact", "mujoco-exact"), 2, success=lambda m, d: True)
    again = report.worlds[1]
    assert math.isnan(again.apart_at)
    assert (again.contact, again.verdict) == ("", "not told apart")
    assert again.share[0] < 0.5
    flips = iter([True, True, True, True, False, False, False, True])
    chance = sf.transfer(crate(), NONE[:5], ("mujoco", "mujoco"), 4, success=lambda m, d: next(flips))
    assert chance.worlds[1].change[1] < 0.0  # three of four are lost, which chance does once in seven times
    assert chance.lost == ()
    none = sf.transfer(crate(), NONE, ("mujoco", "mujoco:stiff"), 3, success=lambda m, d: False)
    assert none.worlds[1].verdict == "nothing to lose"


def test_what_is_lost_in_a_run_is_no_success() -> None:
    """MuJoCo resets a state that is not finite, and goes on as if nothing had happened."""

    class Breaks:
        """Writes what is no number once."""

        def __init__(self) -> None:
            self.steps = self.resets = 0

        def reset(self) -> None:
            self.steps, self.resets = 0, self.resets + 1

        def __call__(self, model: Any, data: Any) -> None:
            self.steps += 1
            if self.steps == 1:
                data.qvel[0] = np.nan

    control = Breaks()
    report = sf.transfer(
        crate(), control, ("mujoco", "mujoco-exact:half-step"), 2, duration=0.4, success=lambda m, d: True
    )
    assert [row.successes for row in report.worlds] == [0, 0]
    assert control.resets == 4


def test_departures() -> None:
    """By place alone, and by the impulse that differs most before; what is no number is apart."""
    time, q = 0.01 * np.arange(5), np.zeros((5, 2))
    pushed = {"one": np.zeros((5, 3)), "two": np.zeros((5, 3))}
    first = TrialRun(True, time, q, pushed)
    moved = q.copy()
    moved[3:, 1] = 0.02
    other = {"one": np.ones((5, 3)), "two": np.zeros((5, 3))}
    other["two"][4] = 1e6
    assert departure(TrialRun(True, time, moved, other), first) == (pytest.approx(0.03), "one")
    assert math.isnan(departure(TrialRun(True, time, q + 0.009, other), first).time)
    lost = q.copy()
    lost[2:] = np.nan
    assert departure(TrialRun(False, time, lost, {}), first).time == pytest.approx(0.02)


def test_a_robot_and_its_controller_in_our_worlds() -> None:
    """A stance is held everywhere; limp joints fall everywhere."""
    robot = robot_of("go2")
    q = sf.place(robot)

    def hold(state: Any) -> Any:
        return 60.0 * (q[7:] - state.q[7:]) - 2.0 * state.v[6:]

    worlds = ("mujoco", "mujoco-exact:half-step", "mujoco:stiff", "rigid")
    report = sf.transfer(robot, hold, worlds, seeds=[5], duration=0.3)
    assert [row.successes for row in report.worlds] == [1, 1, 1, 1]
    assert {row.unsolved for row in report.worlds} == {0}
    limp = sf.transfer(robot, lambda state: np.zeros(12), ("mujoco", "mujoco-exact"), 1, duration=1.0)
    assert [row.successes for row in limp.worlds] == [0, 0]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ({"worlds": ("moon",)}, "unknown world 'moon'"),
        ({"worlds": ("rigid",)}, "unknown world 'rigid'"),
        ({"worlds": ("mujoco:soft",)}, "got 'soft'"),
        ({"worlds": ("mujoco:mu-120%",)}, "got 'mu-120%'"),
        ({"worlds": ("mujoco-exact:stiff",)}, "stiff is of the world mujoco"),
        ({"worlds": "mujoco"}, "a sequence of at least one world"),
        ({"worlds": (3,)}, "must be a text"),
        ({"seeds": 0}, "seeds"),
        ({"seeds": []}, "at least one seed"),
        ({"duration": 9.0}, "300 actions"),
        ({"duration": -1.0}, "duration"),
        ({"start": np.zeros(3)}, "start"),
    ],
)
def test_what_cannot_be_asked_is_said_in_a_line(words: dict[str, Any], told: str) -> None:
    with pytest.raises(ProblemError, match=told):
        sf.transfer(crate(), NONE, **words)


def test_other_arguments_are_refused_by_name() -> None:
    for model, control, told in (
        ("go2", NONE, "MjModel or a robot, got str"),
        (crate(), [[1.0]], "actions"),
        (crate(), lambda m, d: None, "takes a duration"),
        (robot_of("go2"), np.zeros((5, 12)), "takes a controller"),
    ):
        with pytest.raises(ProblemError, match=told):
            sf.transfer(model, control)
    one = Variant.read("mujoco-exact:half-step:mu+20%", ("mujoco-exact",))
    assert (one.engine, one.halved, one.stiff) == ("mujoco-exact", True, False)
    assert one.friction == pytest.approx(1.2)
    assert all(Variant.read(text, ("mujoco", "mujoco-exact")) for text in STANDARD)
