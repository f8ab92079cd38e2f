"""Tables whose columns are named one by one, as the first line of a CSV file does."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from surefoot.base.errors import ProblemError
from surefoot.records.motions.field_names import RATES, TIMES
from surefoot.records.motions.fields import MotionFields, frames, shape_of

COUNTERS = ("frame", "index", "frame_id", "frame_index", "", "unnamed: 0")
"""Names of columns that count the frames."""
_ROOT = re.compile(r"root|base|pelvis|trans|pos|float|trunk|torso")
_TURN = re.compile(r"quat|rot|ori|orn|q$")


def is_table(contents: Mapping[str, Any]) -> bool:
    """Tell whether all that a file has are eight or more columns of one length."""
    shapes = {shape_of(value) for value in contents.values()}
    return len(contents) >= 8 and len(shapes) == 1 and len(next(iter(shapes))) == 1


def fields_of_columns(contents: Mapping[str, Any], floating: bool) -> MotionFields:
    """Return the fields of a table: the root's columns by the letters that end their names, joints by theirs.

    Raises
    ------
    ProblemError
        Where columns of the root are missing, or no joint is named.
    """
    parts: dict[str, dict[str, str]] = {"place": {}, "quaternion": {}}
    joints = list[str]()
    for key in contents:
        low = key.strip().lower()
        if low in (*TIMES, *COUNTERS, *RATES):
            continue
        part = _root_part(low)
        if part and low[-1] not in parts[part]:
            parts[part][low[-1]] = key
        else:
            joints.append(key)
    begin = ", ".join(list(contents)[:8])
    if floating and (set(parts["place"]) != set("xyz") or set(parts["quaternion"]) != set("wxyz")):
        raise ProblemError(
            f"its first line names no root place x, y, z and quaternion w, x, y, z: it begins with {begin}"
        )
    if not joints:
        raise ProblemError(f"its first line names no joints: it begins with {begin}")
    out = MotionFields("", _stack(contents, joints, "joints"), names=tuple(joints))
    if floating:
        out.place = _stack(contents, [parts["place"][axis] for axis in "xyz"], "the root's place")
        out.quaternion = _stack(contents, [parts["quaternion"][axis] for axis in "xyzw"], "the quaternion")
        out.turn, out.certain = "xyzw", True
    return out


def _root_part(low: str) -> str:
    """Return which part of the root a column is of by its name in lower case, empty for none."""
    about = low[:-1].rstrip("_. ")
    if low[-1:] not in tuple("wxyz") or len(low) > 24 or "joint" in low:
        return ""
    if _TURN.search(about) or low[-1] == "w":
        return "quaternion"
    return "place" if not about or _ROOT.search(about) else ""


def _stack(contents: Mapping[str, Any], keys: list[str], named: str) -> Any:
    """Return (T, k) numbers of columns."""
    return frames(named, np.column_stack([np.asarray(contents[key], dtype=np.float64) for key in keys]))
