"""MuJoCo's step beside the exact one: what each costs, and what each does to bodies with a closed form.

    python -m benchmarks.mujoco_exact [--quick]
    python -m benchmarks.mujoco_exact --models FOLDER

Price is CPU time of the thread, both steps in turn in one run; MuJoCo has elliptic cones and its own settings
otherwise. Accuracy is also asked of MuJoCo's best: small steps, impratio 100 and ten iterations without slip.
With ``--models`` what gymnasium and dm_control ship is stepped under random actions.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from benchmarks.mujoco_exact.accuracy import ACCURACY, runs_compared
from benchmarks.mujoco_exact.models import MODEL_HEAD, find_models, model_rows, run_models
from benchmarks.mujoco_exact.price import Price, prices
from benchmarks.printing import show, table

PRICE_HEAD = ("scene", "exact [µs]", "p99", "mj_step [µs]", "p99", "ratio", "allowed", "unsolved")


def _price_row(p: Price) -> list[str]:
    """Return a row of the prices."""
    return [
        p.name, f"{p.exact[0]:.1f}", f"{p.exact[1]:.0f}", f"{p.soft[0]:.1f}", f"{p.soft[1]:.0f}",
        f"{p.exact[0] / p.soft[0]:.1f}", f"{p.allowed:.0f}", f"{p.unsolved} of {p.steps}",
    ]  # fmt: skip


def _show_models(folder: Path, seconds: float, hold: int, seed: int, as_json: bool) -> None:
    """Print the table of other people's models, and which of them did not run."""
    if not find_models(folder):
        raise typer.BadParameter(
            f"{folder} holds no model of gymnasium or dm_control: pip install --no-deps --target FOLDER "
            "gymnasium dm_control"
        )
    runs = list(run_models(folder, seconds, hold, seed))
    title = f"{seconds:g} s of random actions, each for {hold} steps, seed {seed}"
    show([table(MODEL_HEAD, model_rows(runs), title)], as_json)
    for run in runs:
        if run.said:
            print(f"{run.name}: {run.said}", file=sys.stderr)


def main(
    quick: bool = False,
    models: Annotated[
        Path | None, typer.Option(help="Folder with gymnasium and dm_control: their models instead.")
    ] = None,
    seconds: float = 10.0,
    hold: Annotated[int, typer.Option(min=1, help="Steps for which an action is held.")] = 1,
    seed: int = 0,
    as_json: Annotated[bool, typer.Option("--json")] = False,
) -> None:
    """Print the tables of price and accuracy, or of other people's models."""
    if models is not None:
        _show_models(models, seconds, hold, seed, as_json)
        return
    kinds = runs_compared()
    found = [_price_row(p) for p in prices(quick)]
    accurate = [[name, *(measure(*kind) for kind in kinds.values())] for name, measure in ACCURACY.items()]
    show(
        [
            table(PRICE_HEAD, found, "CPU time of a step, median and 99th percentile"),
            table(["what", *kinds], accurate, "accuracy, MuJoCo with elliptic cones"),
        ],
        as_json,
    )


if __name__ == "__main__":
    typer.run(main)
