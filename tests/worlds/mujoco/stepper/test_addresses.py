"""Where MuJoCo's arrays lie: what compiled code reads is what the bindings give."""

from __future__ import annotations

import ctypes
import gc
import types
from typing import Any

import mujoco
import numpy as np
import pytest

import surefoot as sf
from surefoot.worlds.mujoco.stepper import addresses

from .scenes import box, scene


def _address(array: Any) -> int:
    return int(array.__array_interface__["data"][0])


@pytest.mark.long
def test_words_of_the_arena_are_the_fields_of_any_data() -> None:
    """Contacts, limits, dry joints and tendons; many data, whatever lies behind their structs."""
    arm = """<body pos="1 0 2"><joint name="j" type="hinge" range="-1 1" limited="true" frictionloss="0.1"/>
    <geom size="0.1"/></body>"""
    rope = '<tendon><fixed limited="true" range="-1 -0.1"><joint joint="j" coef="1"/></fixed></tendon>'
    held = scene(box() + arm, extra=rope)
    words, kept = addresses.arena_words(mujoco), []
    for turn in range(40):
        data = mujoco.MjData(held)
        data.qpos[2] -= 0.002 * turn
        mujoco.mj_forward(held, data)
        # what allocates behind a struct: copies of addresses, which a search would take for fields
        kept.append([np.full(3, _address(data.contact.dist)), data])
        here = (ctypes.c_int64 * (int(words.max()) + 1)).from_address(data._address)
        found = [here[int(w)] for w in words]
        count = len(addresses.ARENA)
        assert found[:count] == [_address(getattr(data, name)) for name in addresses.ARENA], turn
        assert found[count + 1 :] == [_address(getattr(data, name)) for name in addresses.OF_DATA], turn
        if data.ncon:
            assert found[count] == _address(data.contact.dist)
        if turn % 7 == 0:
            kept.clear()
            gc.collect()


@pytest.mark.long
def test_the_places_do_not_depend_on_what_lies_in_memory() -> None:
    """Asked anew among other allocations: one answer (a search found another once in 150)."""
    rng, kept = np.random.default_rng(5), []
    first = addresses.arena_words(mujoco)
    for _ in range(300):
        np.testing.assert_array_equal(addresses.arena_words.__wrapped__(mujoco), first)
        kept.append(np.zeros(int(rng.choice([3, 1000, 20_000, 40_000]))))
        if len(kept) > 50:
            kept.pop(int(rng.integers(len(kept))))


@pytest.mark.parametrize("missing", ["energy", "efc_J", "everything"])
def test_a_mujoco_that_keeps_its_data_otherwise_is_refused(
    missing: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line that names the version, and nothing is read."""
    structs = pytest.importorskip("mujoco.introspect.structs")
    fields = [f for f in structs.STRUCTS["mjData"].fields if f.name != missing]
    known = {} if missing == "everything" else {"mjData": types.SimpleNamespace(fields=fields)}
    monkeypatch.setattr(structs, "STRUCTS", known)
    with pytest.raises(sf.SurefootError, match=f"MuJoCo {mujoco.__version__} keeps"):
        addresses.arena_words.__wrapped__(mujoco)
