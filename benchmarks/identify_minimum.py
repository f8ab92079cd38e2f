"""Whether a fit to tosses ended at a minimum: by how much each parameter alone still lowers its loss.

After a fit every parameter is moved alone to both sides, by moves that the search itself does not make, and
the loss is computed anew by its definition. A table names the best of them; none should lower it by 0.5 %.

    python -m benchmarks.identify_minimum tosses.npz --model elbow.urdf
    python -m benchmarks.identify_minimum tosses.npz --law growing-friction --moves 4
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.records.identification.identify import identify
from surefoot.records.identification.toss_errors import LOST
from surefoot.records.identification.toss_fit import BodyFit
from surefoot.records.identification.toss_model import ThrownModel, TossModel
from surefoot.records.identification.toss_refit import list_parameters, simulate_around
from surefoot.records.identification.tosses import Tosses, read_tosses

SHORTEST, LONGEST = 0.15, 20.0
"""Moves to either side [steps of the parameter], evenly spread in their logarithm."""
ENOUGH = 0.005
"""Share of the loss that no parameter alone should take off."""


class Fall(NamedTuple):
    """The best move of one parameter: where it is, where it leads, and the change of the loss [-]."""

    name: str
    value: float
    best: float
    change: float


def robust_mean(rows: FloatArray, frames: IntArray, scale: FloatArray) -> float:
    """Return the loss of `toss_loss` by its definition, toss by toss [widths].

    Of the (N, m) rows the first three columns are places, the others turns, robust from scale (2,) on.
    """
    square = np.square(np.clip(np.nan_to_num(rows, nan=LOST), -LOST, LOST))
    losses = []
    for toss in np.split(square, np.cumsum(frames)[:-1]):
        place, turn = (np.sqrt(part.sum(axis=1).mean()) for part in (toss[:, :3], toss[:, 3:]))
        turned = np.hypot(scale[1], turn) - scale[1]
        losses.append(np.hypot(scale[0], place) - scale[0] + turned * scale[0] / scale[1])
    return float(np.mean(losses))


def find_falls(
    tosses: Tosses, law: TossModel, found: BodyFit, values: FloatArray, moves: int
) -> tuple[float, list[Fall]]:
    """Return the loss at a fit, and the best move of each parameter; tosses are upright."""
    own, simulate = list_parameters(law, found), simulate_around(tosses, law, found)
    here = np.append(values, [found.values[p.name] for p in own[len(values) :]])
    frames, scale = tosses.frames, np.ones(2) if found.scale is None else found.scale
    loss = robust_mean(simulate(here), frames, scale)
    sizes = np.geomspace(SHORTEST, LONGEST, moves)
    falls = []
    for k, p in enumerate(own):
        tried = np.unique(np.clip(here[k] + p.step * np.concatenate([-sizes, sizes]), p.low, p.high))
        points = [np.concatenate([here[:k], [value], here[k + 1 :]]) for value in tried if value != here[k]]
        losses = [robust_mean(simulate(point), frames, scale) for point in points]
        if losses:
            best = int(np.argmin(losses))
            falls.append(Fall(p.name, float(here[k]), float(points[best][k]), losses[best] / loss - 1.0))
    return loss, falls


def show_falls(loss: float, falls: list[Fall]) -> None:
    """Print a table, and whether a parameter alone takes off `ENOUGH`."""
    print(f"training loss {loss:.5f} widths\n")
    print("| | value | best of the others | loss there |", "| --- | --- | --- | --- |", sep="\n")
    for one in falls:
        print(f"| {one.name} | {one.value:.5g} | {one.best:.5g} | {100.0 * one.change:+.2f} % |")
    lower = [one.name for one in falls if one.change < -ENOUGH]
    print(f"\nlower by {100.0 * ENOUGH:g} % alone: {', '.join(lower) or 'none'}")


def main(arguments: Sequence[str] | None = None) -> None:
    """Fit, move, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("tosses")
    parser.add_argument("--model")
    parser.add_argument("--law", default="rigid")
    parser.add_argument("--moves", type=int, default=8, help="to either side of each parameter")
    given = parser.parse_args(arguments)
    law, recorded = ThrownModel(given.law), read_tosses(given.tosses)
    fit = identify(recorded, law, model=given.model)
    print(fit, *fit.notes, f"{fit.evaluations:.0f} simulations of all tosses", sep="\n")
    values = np.array([fit[p.name].value for p in law.parameters])
    show_falls(*find_falls(fit.found.upright(recorded), law, fit.found, values, given.moves))


if __name__ == "__main__":
    main()
