"""Where the CoM region, the support polygon and the ZMP region differ, and why."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.equilibrium.polygons import intersection
from surefoot.equilibrium.region import Region, polygon_area
from surefoot.equilibrium.regions import com_region, support_polygon, zmp_region
from surefoot.stance import Stance

PLENTY = 20.0
"""A friction coefficient that is never the reason."""
_SAME = 0.01


@dataclass(frozen=True)
class RegionComparison:
    """Three regions of one stance, and sentences about their differences.

    Attributes
    ----------
    com, zmp
        Regions of the centre of mass (standing still) and of the zero-moment point (for the given
        centre of mass); zmp is None where its plane would go through the centre of mass.
    support
        (k, 2) corners of the support polygon.
    sentences
        Where they differ and why, one difference each.
    """

    com: Region
    zmp: Region | None
    support: FloatArray
    sentences: tuple[str, ...]


def compare_regions(stance: Stance, com: FloatArray, mass: float, tol: float = 1e-3) -> RegionComparison:
    """Work out the three regions of a stance, com (3,) [m] and mass [kg], and explain where they differ.

    Why is found by experiment: the regions are worked out again with plenty of friction.
    """
    support = support_polygon(stance)
    still = com_region(stance, mass, tol)
    moving = _zmp(stance, com, mass, tol)
    slippery = stance.with_friction(PLENTY)
    sentences = [_com_sentence(stance, still, com_region(slippery, mass, tol), support, tol)]
    if moving is not None:
        rich = _zmp(slippery, com, mass, tol)
        assert rich is not None
        sentences.append(_zmp_sentence(stance, moving, rich, support, tol))
    return RegionComparison(still, moving, support, tuple(sentences))


def _zmp(stance: Stance, com: FloatArray, mass: float, tol: float) -> Region | None:
    middle = float(stance.positions[:, 2].mean()) if len(stance) else 0.0
    if abs(com[2] - middle) < 1e-6:
        return None
    return zmp_region(stance, com, mass, tol)


def _com_sentence(stance: Stance, region: Region, rich: Region, support: FloatArray, tol: float) -> str:
    if region.empty:
        if not rich.empty:
            return "Nowhere can the centre of mass be held: the friction is not enough at any place."
        return "Nowhere can the centre of mass be held, with any friction."
    squeezed = region.force_limit < np.inf
    beyond = "contacts squeeze each other" if squeezed else "tilted contacts and walls push back"
    parts = _differences(stance, region, rich, support, tol, ("friction is short there", beyond))
    if not parts:
        return "The CoM region is the support polygon: friction suffices everywhere above it."
    return f"The CoM region {parts}."


def _zmp_sentence(stance: Stance, region: Region, rich: Region, support: FloatArray, tol: float) -> str:
    if region.empty:
        return "No zero-moment point is possible at constant height for this centre of mass."
    short = "the contact force cannot lean that far within the friction"
    beyond = "contacts are not in one level plane"
    parts = _differences(stance, region, rich, support, tol, (short, beyond))
    if not parts:
        return "The ZMP region is the support polygon: contacts are in one level plane and friction suffices."
    return f"The ZMP region {parts}."


def _differences(
    stance: Stance, region: Region, rich: Region, support: FloatArray, tol: float, why: tuple[str, str]
) -> str:
    """Return what a region lacks of the support polygon and adds to it, for which reasons; empty if neither.

    `why` is the reason for a lack that more friction (the `rich` region) mends, and for an addition.
    """
    lacks, adds = overlap_loss(support, region.inner), overlap_loss(region.inner, support)
    whole = polygon_area(support)
    size = max(whole, polygon_area(region.inner), tol * tol)
    parts = []
    if lacks > _SAME * size:
        recovered = overlap_loss(support, rich.inner) <= 0.5 * lacks
        reason = why[0] if recovered else _shape_reason(stance)
        parts.append(f"leaves out {_percent(lacks, whole)} of the support polygon: {reason}")
    if adds > _SAME * size:
        parts.append(f"reaches beyond the support polygon by {_percent(adds, whole)} of its area: {why[1]}")
    return "; it ".join(parts)


def _shape_reason(stance: Stance) -> str:
    """Return why more friction does not help."""
    points = stance.points()
    if points.bounded or stance.bounded:
        return "contacts reach their bounds on the normal force"
    if float(points.rotations[:, 2, 2].min(initial=1.0)) < 0.3:
        return "the contacts on walls carry no weight there"
    return "contacts are tilted or at different heights, and can only push"


def _percent(part: float, whole: float) -> str:
    return f"{100.0 * part / whole:.0f} %" if whole > 0.0 else "all"


def overlap_loss(a: FloatArray, b: FloatArray) -> float:
    """Return the area [m²] of a convex polygon `a` (k, 2) that is not in the convex polygon `b` (l, 2)."""
    return max(0.0, polygon_area(a) - polygon_area(clip(a, b)))


def clip(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the intersection of two convex, counter-clockwise polygons, (k, 2) and (m, 2) corners [m]."""
    if len(a) < 3 or len(b) < 3:
        return np.zeros((0, 2))
    corners = np.vstack([a, b])
    edges = np.vstack([np.roll(p, -1, axis=0) - p for p in (a, b)])
    outward = np.column_stack([edges[:, 1], -edges[:, 0]])
    middle = a.mean(axis=0)
    return intersection(outward, (outward * corners).sum(axis=1), middle, 2.0 * float(np.ptp(a)))
