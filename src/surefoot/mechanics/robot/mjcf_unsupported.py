"""What MJCF can say that a tree of hinges and slides with motors cannot, and why a file is none: in words."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.errors import mujoco_line

SHOWN = 3
"""How many of a kind are named before the rest is counted."""
MOST_FILES, MOST_BYTES = 100, 1_000_000
"""Files beside a model that are searched for one that includes it, at most, and their size [-, bytes]."""
_LACKING = re.compile(r"(?:^|\s)(\w+) '([^']+)' not found")


def unreadable_mjcf(path: Path, error: Exception) -> str:
    """Return why a file is no model: what MuJoCo says, or that it is a part of another file, and of which."""
    said = mujoco_line(error)
    lacking = _LACKING.search(said)
    if lacking is None:
        return f"{path} is not an MJCF that MuJoCo can read: {said}"
    kind, name = lacking.group(1), lacking.group(2)
    wholes = _files_that_include(path)
    which = f", {' or '.join(wholes)}" if wholes else ""
    return (
        f"{path} is not a whole model: it names the {kind} {name}, which it does not have. If it is a part "
        f"of another file, load the one that includes it{which}"
    )


def _files_that_include(path: Path) -> list[str]:
    """Return the files beside one that include it, by name."""
    word = re.compile(rf"""<include\s+file=["'](?:\./)?{re.escape(path.name)}["']""")
    found = []
    for other in sorted(path.parent.glob("*.xml"))[:MOST_FILES]:
        if other != path and other.stat().st_size <= MOST_BYTES:
            text = other.read_text(encoding="utf-8", errors="replace")
            found += [other.name] if word.search(text) else []
    return found[:SHOWN]


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
