"""The motions that the contents of a file are, each by the names of its arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from surefoot.base.arrays import finite_array, positive_number
from surefoot.base.errors import ProblemError, shown
from surefoot.records.motions.bare_columns import ROOT, fields_of_rows
from surefoot.records.motions.field_names import (
    ANGLES,
    BODIES,
    BODY_NAMES,
    JOINT_NAMES,
    PLACES,
    QUATERNIONS,
    RATES,
    SPEEDS,
    STEPS,
    TIMES,
    TORQUES,
    TURNS,
    WHOLE,
)
from surefoot.records.motions.fields import FieldTable, MotionFields, shape_of
from surefoot.records.motions.named_columns import fields_of_columns, is_table


def motions_in(contents: Any, name: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield the motions of a file's contents, each with its name and its arrays.

    A motion is called by its key where there are several, and `name` otherwise.

    Raises
    ------
    ProblemError
        Where there is none.
    """
    if isinstance(contents, np.ndarray) and contents.ndim > 0:
        yield name, {"": contents}
    elif isinstance(contents, Mapping) and any(map(_is_over_time, contents.values())):
        yield name, contents
    elif isinstance(contents, Mapping | list | tuple) and len(contents) > 0:
        pairs = contents.items() if isinstance(contents, Mapping) else enumerate(contents)
        for key, inner in pairs:
            if not isinstance(inner, Mapping):
                raise ProblemError(f"it has no arrays of a motion: under {shown(key)} stands {shown(inner)}")
            yield str(key) if len(contents) > 1 else name, inner
    else:
        raise ProblemError(f"it has no arrays of a motion but {shown(contents)}")


def _is_over_time(value: Any) -> bool:
    """Tell whether a value is an array of numbers, or lists of them."""
    if isinstance(value, np.ndarray):
        return value.ndim >= 1 and value.dtype.kind in "biuf"
    return (
        isinstance(value, list | tuple)
        and len(value) > 0
        and isinstance(value[0], list | tuple | float | int)
    )


def fields_of(name: str, contents: Mapping[Any, Any], floating: bool) -> MotionFields:
    """Return the fields of one motion by the names of its arrays.

    Raises
    ------
    ProblemError
        Where the joints or the root are missing, or an array is ragged, not finite or of the wrong shape.
    """
    table = FieldTable(contents)
    columns = is_table(table.contents)
    if columns:
        out = fields_of_columns(table.contents, floating)
    else:
        out = _whole(table, floating) or _parts(table, floating)
    out.name = name
    out.names = table.texts(JOINT_NAMES) or out.names
    if out.names and len(out.names) != out.joints.shape[1]:
        raise ProblemError(f"it names {len(out.names)} joints and has angles of {out.joints.shape[1]}")
    _take_rate(table, out)
    _take_measurements(table, out)
    left = () if columns else set(table.contents) - table.used
    out.extra = {key: table.contents[key] for key in table.contents if key in left}
    return out


def _whole(table: FieldTable, floating: bool) -> MotionFields | None:
    """Return the fields of whole configurations, None where a file has none."""
    for name, turn in WHOLE.items():
        if table.key([name]) is None or (name == "joint_pos" and not _has_root(table)):
            continue
        rows = table.numbers([name])
        if not floating:
            return MotionFields("", rows)
        if rows.shape[1] <= ROOT:
            raise ProblemError(
                f"{name!r} has {rows.shape[1]} columns; place, quaternion and joints are more than {ROOT}"
            )
        return fields_of_rows(rows, turn)
    return None


def _has_root(table: FieldTable) -> bool:
    """Tell whether `joint_pos` begins with the root: by its names, or for want of another root."""
    shape = shape_of(table.value(["joint_pos"]))
    names = table.texts(JOINT_NAMES)
    if len(shape) != 2 or names:
        return len(shape) == 2 and shape[1] == len(names) + ROOT
    return not table.key(PLACES) and not table.key(place for place, _ in BODIES)


def _parts(table: FieldTable, floating: bool) -> MotionFields:
    """Return the fields of a file that has root and joints apart."""
    joints = table.numbers(ANGLES)
    if joints is None:
        listed = ", ".join(ANGLES[:6])
        raise ProblemError(f"it has no joint angles under any of {listed}, ...; it holds {table.listed}")
    out = MotionFields("", joints)
    if not floating:
        return out
    out.place = table.numbers(PLACES, 3, len(joints))
    names = [name for name in table.lower if name.removesuffix("_xyzw").removesuffix("_wxyz") in TURNS]
    if names:
        out.quaternion = table.numbers(names, 4, len(joints))
        out.certain = names[0][-4:] in QUATERNIONS
        out.turn = names[0][-4:] if out.certain else TURNS[names[0]]
    if out.place is None or out.quaternion is None:
        _take_root_of_bodies(table, out)
    for what, value, known in (("place", out.place, PLACES), ("quaternion", out.quaternion, tuple(TURNS))):
        if value is None:
            listed = ", ".join(known[:5])
            raise ProblemError(
                f"it has no {what} of the root under any of {listed}, ...; it holds {table.listed}"
            )
    return out


def _take_root_of_bodies(table: FieldTable, out: MotionFields) -> None:
    """Take the root's place and quaternion from the first of the bodies, where a file has those."""
    for place, turn in BODIES:
        if table.key([place]) is None or table.key([turn]) is None:
            continue
        places = finite_array(place, table.value([place]))
        turns = finite_array(turn, table.value([turn]))
        rows = len(out.joints)
        if places.ndim != 3 or turns.ndim != 3 or len(places) != rows or len(turns) != rows:
            shapes = f"({rows}, bodies, 3) and ({rows}, bodies, 4), got {places.shape} and {turns.shape}"
            raise ProblemError(f"{place} and {turn} must have shapes {shapes}")
        out.place, out.quaternion, out.turn = places[:, 0], turns[:, 0], "wxyz"
        return


def _take_rate(table: FieldTable, out: MotionFields) -> None:
    """Take the rate and the times."""
    rate, step = table.single(RATES), table.single(STEPS)
    if rate is not None:
        out.rate = positive_number(*rate, "Hz")
    elif step is not None:
        out.rate = 1.0 / positive_number(*step, "s")
    key, rows = table.key(TIMES), len(out.joints)
    if key is None or shape_of(table.contents[key]) not in ((rows,), (rows, 1)):
        return
    table.used.add(key)
    out.times = finite_array(key, np.ravel(table.contents[key]))
    back = np.flatnonzero(np.diff(out.times) <= 0.0)
    if len(back):
        before, after = out.times[back[0]], out.times[back[0] + 1]
        raise ProblemError(f"its times do not rise: {key}[{back[0] + 1}] = {after:g} s after {before:g} s")


def _take_measurements(table: FieldTable, out: MotionFields) -> None:
    """Take velocities, torques and places of bodies where their shapes fit; else they stay among the rest."""
    rows, count = out.joints.shape
    speeds, torques = _as_joints(table, SPEEDS, rows, count), _as_joints(table, TORQUES, rows, count)
    out.speeds = speeds
    if torques is not None:
        out.torques = torques
        table.used.add(str(table.key(TORQUES)))
    bodies = table.value(place for place, _ in BODIES)
    shape = shape_of(bodies)
    if len(shape) == 3 and shape[0] == rows and shape[2] == 3:
        out.bodies = finite_array("the bodies' places", bodies)
        listed = table.texts(BODY_NAMES)
        out.body_names = listed if len(listed) == shape[1] else ()


def _as_joints(table: FieldTable, names: tuple[str, ...], rows: int, count: int) -> Any:
    """Return (T, n) numbers of the joints, without a root's six before them; None where shapes do not fit."""
    value = table.value(names)
    if shape_of(value) not in ((rows, count), (rows, count + 6)):
        return None
    return finite_array(str(table.key(names)), value)[:, -count:]
