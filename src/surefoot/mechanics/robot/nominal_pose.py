"""The pose that a robot stands in, and its feet there: from its files, or with its legs bent."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics.robot import catalog
from surefoot.mechanics.robot.foot import Foot, catalog_feet
from surefoot.mechanics.robot.nominal import bend_legs

if TYPE_CHECKING:
    from surefoot.mechanics.robot.foot_reading import FootSource

NOMINAL_POSES = ("standing", "half_sitting")
"""Names of the poses of an SRDF file that are nominal ones, the first that it has."""
FOLDED = "its keyframe is no pose to stand in, as its feet cannot be told there: it stands on bent legs"
"""Note of a robot whose file has a pose in which its feet would be guesses."""


def file_pose(model: Any, srdf: Path | None, entry: catalog.CatalogEntry) -> FloatArray | None:
    """Return the SRDF's standing pose (nq,), None without one."""
    import pinocchio

    if srdf is None:
        return None
    pinocchio.loadReferenceConfigurations(model, str(srdf), False)
    poses = {item.key(): np.array(item.data()) for item in model.referenceConfigurations}
    pose = next(
        (poses[n] for n in (NOMINAL_POSES if entry.pose is None else (entry.pose,)) if n in poses), None
    )
    if pose is not None:
        for joint, title in zip(model.joints, model.names, strict=True):
            for end in (end for end in entry.bent if title.endswith(end)):
                pose[joint.idx_q] = entry.bent[end]
    return pose


def feet_and_pose(
    source: FootSource,
    names: Sequence[str],
    pose: FloatArray | None,
    fixed: bool,
    entry: catalog.CatalogEntry,
) -> tuple[tuple[Foot, ...], FloatArray]:
    """Return the feet and the nominal pose (nq,): the file's or, without one, feet under bent legs.

    A pose of the file in which a foot would be a guess, as one that lies folded, is none to stand in.
    """
    from surefoot.mechanics.robot.foot_reading import FootGuess  # not needed to import the package

    try:
        return _feet_at(source, names, pose, fixed, entry)
    except FootGuess as guess:
        if pose is None or fixed:
            raise
        try:
            return _feet_at(source, names, None, fixed, entry)
        except FootGuess:
            raise guess from None


def _feet_at(
    source: FootSource,
    names: Sequence[str],
    pose: FloatArray | None,
    fixed: bool,
    entry: catalog.CatalogEntry,
) -> tuple[tuple[Foot, ...], FloatArray]:
    """Return the feet and the nominal pose (nq,), the given one if there is one."""
    import pinocchio

    from surefoot.mechanics.robot.foot_reading import read_feet

    model = source.model
    q = np.array(pinocchio.neutral(model)) if pose is None else pose
    if pose is None and fixed:
        low, high = model.lowerPositionLimit, model.upperPositionLimit
        usable = np.isfinite(low) & np.isfinite(high) & ((q < low) | (q > high))
        with np.errstate(invalid="ignore"):  # joints without limits have no middle
            q = np.where(usable, 0.5 * (low + high), q)
    elif pose is None:
        q[3:7] = entry.upright
        q[7:] = np.clip(q[7:], model.lowerPositionLimit[7:], model.upperPositionLimit[7:])
    shaped = bool(entry.shapes) and set(names) <= set(entry.feet)
    feet = catalog_feet(model, entry, names) if shaped else read_feet(source, names, q)
    if pose is not None or fixed:
        return feet, q
    bent = bend_legs(model, q, feet)
    if not shaped and not any(foot.flat for foot in feet):  # soles stay level, legs turn balls
        feet = read_feet(source, names, bent)
    return feet, bent
