"""Wrong input of public functions as a table: one line of ours that names what was expected, at once."""

from __future__ import annotations

import contextlib
import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

import surefoot as sf
from tests.robots import go2

FEET = [[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.15, 0], [-0.2, -0.15, 0]]
COM, NOTHING = [0.0, 0.0, 0.3], np.zeros(6)
STANCE = sf.Stance([sf.PointContact(p, mu=0.6) for p in FEET])
BOUNDED = sf.Stance([sf.PointContact(p, mu=0.6, normal_max=1e4) for p in FEET])
PROBLEM = sf.ContactProblem(np.eye(3), [0.0, 0.0, -1.0], 0.5)
LOG = sf.Log({"time": [0.0]})
SHARE = sf.ForceDistributor(0.6)
NO_STANCES: list[Any] = [None, FEET, "stance", 3, STANCE.contacts]
NO_MASSES: list[Any] = ["15", None, 0.0, -1.0, np.nan, np.inf, 1e200, [15.0]]
NO_POINTS: list[Any] = ["com", None, [0.0, 0.0], [np.nan, 0, 0], [np.inf, 0, 0], [1e200, 0, 0], [[0], [0, 0]]]
NO_WRENCHES: list[Any] = ["w", [[1.0], [1.0, 2.0]], [np.nan] * 6, [1e200, 0, 0, 0, 0, 0], {}]
NO_FACETS: list[Any] = [10**6, 2, -1, 3.5, np.nan, "x"]
NO_LOGS: list[Any] = [np.zeros(3), None, 3, {}, [1, 2]]
NO_PATHS: list[Any] = [3, None, [], np.zeros(2), "zero\0byte.npz", "x" * 300 + ".npz"]
NO_FRICTION: list[Any] = ["x", -0.1, np.nan, None]
NO_ROBOTS: list[Any] = ["go2", None, 3]
NO_TERRAINS: list[Any] = ["flat", 3, STANCE]
NO_NUMBERS: list[Any] = ["x", None, np.nan]
NO_ARRAYS: list[Any] = [
    "x", 10**5000, [10**400], np.array(1 + 1j), np.complex128(1), [[1], [2, 3]], sp.eye(3) * 1j,
    np.ma.array([1.0, 2.0, 3.0], mask=[0, 1, 0]), np.array(["1", "2", "3"]), np.ones(3).tolist,
]  # fmt: skip

TABLE: dict[str, tuple[Callable[[Any], Any], list[Any], str]] = {
    "stance": (sf.Stance, [sf.PointContact(FEET[0]), sf.PointContact, 3, None, [3], "a"], "contacts"),
    "stand stance": (lambda x: sf.can_stand(x, COM, 15.0), NO_STANCES, "stance must be a Stance"),
    "stand mass": (lambda x: sf.can_stand(STANCE, COM, x), NO_MASSES, "mass must be"),
    "bounded mass": (lambda x: sf.can_stand(BOUNDED, COM, x), NO_MASSES, "mass must be"),
    "stand com": (lambda x: sf.can_stand(STANCE, x, 15.0), NO_POINTS, "com"),
    "stand wrench": (lambda x: sf.can_stand(STANCE, COM, 15.0, x), NO_WRENCHES, "external_wrench"),
    "stand facets": (lambda x: sf.can_stand(STANCE, COM, 15.0, facets=x), NO_FACETS, "facets"),
    "friction stance": (lambda x: sf.friction_needed(x, COM, 15.0), NO_STANCES, "stance must be"),
    "friction mass": (lambda x: sf.friction_needed(STANCE, COM, x), NO_MASSES, "mass must be"),
    "region stance": (lambda x: sf.com_region(x, 15.0), NO_STANCES, "stance must be"),
    "region mass": (lambda x: sf.com_region(STANCE, x), NO_MASSES, "mass must be"),
    "region bounds": (lambda x: sf.com_region(STANCE, 15.0, limits=x), ["x", 3], "limits must be"),
    "stands push": (lambda x: sf.can_stand_batch([STANCE], COM, 15.0, x), NO_WRENCHES, "external_wrench"),
    "share wish": (lambda x: SHARE.solve(np.eye(6)[:, :3], NOTHING, x), ["x", object()], "reference must"),
    "problem": (
        lambda x: sf.ContactProblem(**({"G": np.eye(3), "g": np.zeros(3), "mu": 0.5} | x)),
        [{n: x} for n in ("G", "g", "mu", "normal_max", "facets", "bilateral", "fit") for x in NO_ARRAYS],
        "^(the entries of )?G|^g|^mu|^normal_max|^facets|^bilateral|^unknown fit",
    ),
    "mpc": (
        lambda x: sf.ConvexMpc(1.0, np.eye(3), **x),
        [{name: value} for name in ("feet", "horizon", "max_iterations") for value in (None, 0, 1.5)],
        "feet|horizon|max_iterations",
    ),
    "mpc weights": (lambda x: sf.ConvexMpc(1.0, np.eye(3), weights=x), [3, None], "weights must be"),
    "mpc time": (lambda x: sf.ConvexMpc(1.0, np.eye(3)).shift(x), [*NO_NUMBERS, np.inf], "elapsed"),
    "cone stance": (lambda x: sf.wrench_cone(x, COM), NO_STANCES, "stance must be"),
    "share stance": (lambda x: sf.distribute(x, NOTHING), NO_STANCES, "stance must be"),
    "halfspaces": (lambda x: STANCE.halfspaces(facets=x), NO_FACETS, "facets"),
    "no name": (STANCE.without, ["x", None], "valid names: none, nothing has a name"),
    "contact": (sf.PointContact, ["abc", None, [0, 0], [np.nan] * 3, [10**400, 0, 0]], "position"),
    "cone": (sf.FrictionCone, NO_FRICTION, "mu"),
    "pyramid": (sf.FrictionCone(0.5).polyhedral, NO_FACETS, "facets"),
    "solve": (sf.solve, [{"G": np.eye(3)}, np.eye(3), None, "p"], "problem must be a ContactProblem"),
    "solver": (lambda x: sf.solve(PROBLEM, solver=x), ["x", None, 3], "valid names: |solver"),
    "each call": (
        lambda x: sf.ContactSolver(1, 0.5).solve(**({"G": np.eye(3), "g": np.zeros(3)} | x)),
        [{n: x} for n in ("G", "g", "out") for x in [*NO_ARRAYS, np.frombuffer(bytes(120)).reshape(5, 3)]],
        "^G must|^g must|^out must be a writable",
    ),
    "batch": (
        lambda x: sf.solve_batch(**({"G": np.eye(3)[None], "g": np.zeros((1, 3)), "mu": 0.5} | x)),
        [{n: x} for n in ("G", "g", "mu", "tol") for x in NO_ARRAYS],
        "^G must|^g must|^mu must|^tol must",
    ),
    "settings": (
        lambda x: sf.ContactSolver(**({"contacts": 4, "mu": 0.5} | x)),
        [{"mu": -1.0}, {"law": "glue"}, {"law": None}, {"tol": np.nan}, {"contacts": 0}, {"contacts": 1.5}],
        "^mu|^unknown law|^tol|^contacts must be",
    ),
    "wrt": (lambda x: sf.trajectory_gradient(max, min, wrt=x), [[], (), "x", 3, None], "wrt must be"),
    "audit": (sf.audit_log, NO_LOGS, "arrays become one by sf.log_from_arrays"),
    "lawful": (sf.assert_lawful, NO_LOGS, "sf.log_from_arrays"),
    "log file": (sf.read_log, NO_PATHS, "a file is named by a text or a Path"),
    "problem file": (sf.read_problem, NO_PATHS, "a file is named by"),
    "stance file": (sf.read_stance, NO_PATHS, "a file is named by"),
    "sequence file": (sf.read_sequence, NO_PATHS, "a file is named by"),
    "sweep file": (sf.read_sweep, NO_PATHS, "a file is named by"),
    "faults": (lambda x: next(sf.seeded_faults(LOG, seed=x)), [-1, "x", None, np.eye(2)], "seed must be"),
    "residuals": (lambda x: sf.residuals(PROBLEM, x), NO_ARRAYS, "forces must"),
    "proof": (lambda x: sf.check_proof(PROBLEM, x), NO_ARRAYS, "direction must"),
    "kept": (lambda x: sf.carry_over(np.zeros((3, 3)), x), [*NO_ARRAYS[1:], [0.5], [True], [3]], "kept must"),
    "ranks": (lambda x: sf.redundancy(PROBLEM, tol=x), [*NO_NUMBERS, -1.0, np.complex128(1)], "tol must"),
    "law": (lambda x: sf.translate(x, to="mujoco", mass=1.0), ["x", None, 3], "law must be a SoftLaw"),
    "weighed": (lambda x: sf.can_stand(STANCE, COM, x), [np.complex128(15)], "mass must be a number"),
    "rows": (lambda x: sf.wrench_cone(STANCE, COM, most_rows=x), NO_NUMBERS, "most_rows must"),
    "rigid ground": (lambda x: sf.RigidWorld(go2(), x), NO_TERRAINS, "terrain must be a Terrain"),
    "arrays": (
        lambda x: sf.log_from_arrays({"net_forces_w": np.zeros((5, 1, 3))}, **({"dt": 0.1} | x)),
        [{"dt": x} for x in (*NO_NUMBERS, 0.0)] + [{n: x} for n in ("frames", "facts") for x in ("x", [1])],
        "^give the array time|^frames must|^facts must",
    ),
    "saved": (LOG.save, [*NO_PATHS, "", "/", "no/x.npz"], "named by|read, not|cannot"),
    "written": (lambda x: sf.write_problem(PROBLEM, x), [*NO_PATHS, "no/x.npz"], "named by|cannot write"),
    "robot": (sf.load_robot, ["nope", "nope.urdf", 3, None, ""], "robot|file"),
    "feet": (lambda x: sf.load_robot("go2", feet=x), [3, [3], "toe", ["FL_foot"] * 2, {"a"}], "feet|foot"),
    "place robot": (sf.place, NO_ROBOTS, "robot must be a Robot, as sf.load_robot"),
    "place ground": (lambda x: sf.place(go2(), x), NO_TERRAINS, "terrain must be a Terrain"),
    "stance ground": (lambda x: go2().stance(terrain=x), NO_TERRAINS, "terrain must be a Terrain"),
    "stance mu": (lambda x: go2().stance(mu=x), ["x", [1.0, 2.0], -1.0, np.nan], "mu"),
    "stance q": (lambda x: go2().stance(x), ["q", [1.0], np.zeros(19), np.full(19, np.nan)], "q"),
    "mujoco": (sf.MujocoWorld, NO_ROBOTS, "robot must be a Robot"),
    "rigid": (sf.RigidWorld, NO_ROBOTS, "robot must be a Robot"),
    "world mu": (lambda x: sf.MujocoWorld(go2(), mu=x), NO_FRICTION, "mu"),
    "world ground": (lambda x: sf.MujocoWorld(go2(), x), NO_TERRAINS, "terrain must be a Terrain"),
    "duration": (sf.Scenario, [-1.0, 0.0, *NO_NUMBERS, np.inf], "duration of a scenario"),
    "scenario mu": (lambda x: sf.Scenario(1.0, x), ["x", -1.0, np.nan], "mu of a scenario"),
    "pushes": (lambda x: sf.Scenario(1.0, pushes=x), [3, ["x"], sf.Push(0, (1, 0, 0), 1)], "pushes of a"),
    "push": (
        lambda x: sf.Scenario(1.0, pushes=[sf.Push(*x)]),
        [("a", (1, 0, 0), 1), (0, (1, 0), 1), (0, (np.nan, 0, 0), 1), (0, (1, 0, 0), -1)], "of a push",
    ),
    "ice": (lambda x: sf.Scenario(1.0, ice=[sf.Ice(0, x)]), NO_FRICTION, "mu of ice"),
    "seed": (lambda x: sf.Scenario(1.0, seed=x), [-1, 0.5, "x", np.nan], "seed of a scenario"),
    "gait": (sf.named_gait, ["hop", 3, None], "unknown gait for 4 feet .*; valid names: bound"),
    "slope": (sf.SlopeTerrain, [*NO_NUMBERS, 91.0], "slope|degrees|angle"),
    "planned": (lambda x: sf.plan(x, "jump"), ["go2", 3], "robot must be a Robot"),
    "task": (lambda x: sf.plan(go2(), x), ["jmp", 3, None], "unknown task .*; valid names: backflip"),
}  # fmt: skip
CASES = [(name, k) for name, (_, values, _) in TABLE.items() for k in range(len(values))]


@pytest.mark.parametrize(("name", "k"), CASES, ids=[f"{name} {k}" for name, k in CASES])
@pytest.mark.filterwarnings("error")
def test_it_is_refused_in_one_line(name: str, k: int) -> None:
    call, values, words = TABLE[name]
    with pytest.raises(sf.SurefootError, match=words) as found:
        call(values[k])
    assert "\n" not in str(found.value)
    assert len(str(found.value)) < 500


NONSENSE: list[Any] = [3, "x", None, np.nan, [1, 2], {}, np.zeros(3), np.full((3, 3), np.nan), object(), -1]
MADE_BY_US = {"Status", "Robot", "Controller"}
"""Names that are not called by users: an enum, what `load_robot` makes, a protocol."""
PUBLIC = [n for n in sf.__all__ if callable(getattr(sf, n)) and n not in MADE_BY_US]


@pytest.mark.parametrize("name", PUBLIC)
@pytest.mark.filterwarnings("ignore")
def test_nonsense_in_all_arguments_is_refused_as_ours(name: str) -> None:
    called = getattr(sf, name)
    if inspect.isclass(called) and issubclass(called, BaseException):
        return
    parameters = inspect.signature(called).parameters.values()
    needed = [
        p for p in parameters if p.default is p.empty and p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)
    ]
    named = [{p.name: value for p in needed} for value in NONSENSE]
    if not needed:
        named = [{p.name: value} for p in parameters if p.kind < p.VAR_KEYWORD for value in NONSENSE]
    for arguments in named:
        with contextlib.suppress(sf.SurefootError):
            called(**arguments)
