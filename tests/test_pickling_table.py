"""Every public class, and what public functions return, by pickle, cloudpickle, deepcopy and spawn.

Each copy has the same values in it. That what has a memory goes on to the last bit is in `test_pickling`.
"""

from __future__ import annotations

import copy
import inspect
import multiprocessing
import pickle
from collections.abc import Mapping
from contextlib import suppress
from enum import Enum
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from tests.pickled_values import ANSWERS, VALUES
from tests.test_pickling import COPIES

EVERYTHING = VALUES | ANSWERS
PLAIN = (str, bytes, bool, int, type(None), Enum, type)


def public_classes(module: ModuleType, prefix: str = "") -> set[str]:
    """Return the names of the public classes of a module and of the modules that it shows."""
    out = set[str]()
    for name in dir(module):
        one = getattr(module, name)
        if name.startswith("_") or (prefix and inspect.ismodule(one)):
            continue
        if inspect.isclass(one):
            out.add(prefix + name)
        elif inspect.ismodule(one) and not prefix:
            out |= public_classes(one, f"{name}.")
    return out


def alike(one: Any, two: Any, seen: dict[int, Any]) -> bool:
    """Return whether two values hold the same; what engines and compilers made counts by its class."""
    if type(one) is not type(two):
        return False
    if id(one) in seen:
        return True
    seen[id(one)] = one  # alive: what takes its place in memory is another value
    if isinstance(one, sf.Robot):
        return (one.name, one.mass, one.joint_names) == (two.name, two.mass, two.joint_names)
    if isinstance(one, PLAIN):
        return bool(one == two)
    if isinstance(one, float | np.generic | np.ndarray) and np.asarray(one).dtype != object:
        return np.array_equal(one, two, equal_nan=np.asarray(one).dtype.kind in "fc")
    if isinstance(one, Mapping):
        return list(one) == list(two) and all(alike(one[key], two[key], seen) for key in one)
    if isinstance(one, tuple | list | np.ndarray):
        return len(one) == len(two) and all(alike(a, b, seen) for a, b in zip(one, two, strict=True))
    return not type(one).__module__.startswith("surefoot") or alike(kept(one), kept(two), seen)


def kept(value: Any) -> Any:
    """Return what a copy of one of our values must have: what it reduces to, less what is worked out anew."""
    made, arguments, *state = value.__reduce_ex__(4)
    if state and isinstance(state[0], dict):
        cached = {name for name in state[0] if isinstance(getattr(type(value), name, None), cached_property)}
        state[0] = {name: one for name, one in state[0].items() if name not in cached}
    return made.__name__, arguments, *state[:1]


def same(one: Any, two: Any) -> bool:
    """Return whether a copy is one."""
    return alike(one, two, {}) and (str(one) == str(two) or not isinstance(one, Exception))


def test_the_table_has_every_public_class() -> None:
    assert set(VALUES) == public_classes(sf)


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("name", EVERYTHING)
def test_a_copy_holds_the_same(name: str, how: str) -> None:
    value = EVERYTHING[name]()
    kind = getattr(sf, name, None)
    assert not inspect.isclass(kind) or kind is sf.Controller or isinstance(value, kind)
    assert same(value, COPIES[how](value))


@pytest.mark.parametrize("name", [name for name in VALUES if not name.endswith("Error")])
def test_a_copy_of_what_was_looked_at_holds_the_same(name: str) -> None:
    """What an answer works out when it is read is worked out anew in a copy, or goes with it."""
    value = VALUES[name]()
    for part in dir(type(value)):
        if not part.startswith("_") and isinstance(
            inspect.getattr_static(value, part), property | cached_property
        ):
            with suppress(sf.SurefootError):
                getattr(value, part)
    assert same(value, pickle.loads(pickle.dumps(value)))


def test_a_sole_that_has_answered_is_copied() -> None:
    sole = sf.Sole(0.6, 0.2, 0.1)
    wrench = [1.0, 0.5, 20.0, 0.1, -0.2, 0.05]
    answers = sole.margin(wrench), sole.contains(wrench), sole.friction_needed(wrench)
    for how in COPIES.values():
        twin = how(sole)
        assert (twin.margin(wrench), twin.contains(wrench), twin.friction_needed(wrench)) == answers


def given_back(value: Any) -> Any:
    """Return what another process is given."""
    return value


@pytest.mark.long
def test_another_process_gives_all_of_them_back() -> None:
    values = {name: make() for name, make in EVERYTHING.items()}
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        there = dict(zip(values, pool.map(given_back, values.values()), strict=True))
    assert [name for name, value in values.items() if not same(value, there[name])] == []


@pytest.mark.parametrize(
    "name", ["ContactProblem", "Stance", "InvariantEkf", "Log", "audit_log", "RobotLoop"]
)
def test_the_judge_sees_a_copy_that_lost_something(name: str) -> None:
    spoiled = copy.deepcopy(value := EVERYTHING[name]())
    if name == "RobotLoop":
        spoiled.time += 1.0
    elif name == "Log":
        spoiled.arrays["forces"][0] += 1.0
    else:
        for of, one in vars(spoiled).items():
            object.__setattr__(spoiled, of, one + 1 if isinstance(one, np.ndarray) else "other")
    assert not same(value, spoiled)


def test_terms_that_no_pickle_takes_are_python_s_own_refusal() -> None:
    from tests.pickled_values import policy

    own = copy.deepcopy(policy())
    own._feed._functions["mine"] = lambda state: state.v[:1]
    with pytest.raises((pickle.PicklingError, AttributeError), match="lambda"):
        pickle.dumps(own)
