"""What MJCF can say that a tree of hinges and slides with motors cannot: found, so that it is named."""

from __future__ import annotations

from typing import Any

import numpy as np

SHOWN = 3
"""How many of a kind are named before the rest is counted."""


def beyond_a_tree(mujoco: Any, compiled: Any) -> list[str]:
    """Return one phrase for each kind of thing in a compiled model that would be lost.

    Equality constraints close chains or couple joints, springs of joints and tendons push at rest, and an
    actuator on anything but a joint has no torque limit of a joint. What takes power at most, damping and
    friction, and tendons that only measure are not among them.

    Parameters
    ----------
    mujoco
        The module.
    compiled
        MuJoCo's model.
    """
    c = compiled
    closed = [_equality(mujoco, c, k) for k in range(c.neq) if c.eq_active0[k]]
    sprung = [_list_unsupported(c.joint(k), k) for k in np.flatnonzero(c.jnt_stiffness > 0.0).tolist()]
    pulling = np.flatnonzero((c.tendon_stiffness > 0.0) | (c.tendon_limited > 0)).tolist()
    tendons = [_list_unsupported(c.tendon(k), k) for k in pulling]
    kinds = mujoco.mjtTrn
    joints = (int(kinds.mjTRN_JOINT), int(kinds.mjTRN_JOINTINPARENT))
    away = [
        _list_unsupported(c.actuator(k), k)
        for k in np.flatnonzero(~np.isin(c.actuator_trntype, joints)).tolist()
    ]
    found = {
        "equality constraint": closed, "joint with a spring": sprung,
        "tendon that pulls": tendons, "actuator that is not on a joint": away,
    }  # fmt: skip
    return [_phrase(kind, names) for kind, names in found.items() if names]


def _equality(mujoco: Any, compiled: Any, k: int) -> str:
    """Return an equality constraint in words: its kind, and what it ties."""
    kind = mujoco.mjtEq(int(compiled.eq_type[k])).name.removeprefix("mjEQ_").lower()
    objects = {"joint": mujoco.mjtObj.mjOBJ_JOINT, "tendon": mujoco.mjtObj.mjOBJ_TENDON}
    of = int(objects.get(kind, int(compiled.eq_objtype[k])))
    ids = [int(i) for i in (compiled.eq_obj1id[k], compiled.eq_obj2id[k]) if i >= 0]
    names = [mujoco.mj_id2name(compiled, of, i) or str(i) for i in ids]
    return f"{kind} of {' and '.join(names)}"


def _list_unsupported(item: Any, k: int) -> str:
    return item.name or f"number {k}"


def _phrase(kind: str, names: list[str]) -> str:
    rest = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    many = "" if len(names) == 1 else f" ({len(names)})"
    return f"{kind}{many}: {', '.join(names[:SHOWN])}{rest}"
