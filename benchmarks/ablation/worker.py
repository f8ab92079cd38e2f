"""Trials with some of the settings changed, one JSON line each, in a process of their own.

Run by `benchmarks.ablation.trials`: python -m benchmarks.ablation.worker JSON, with "changes" (settings by
"Class.setting"), "without" (the name of a behaviour), "tasks", "seeds" and "longest" [s] (null: each
task's own length).
"""

from __future__ import annotations

import json
import sys
from typing import Any

from benchmarks.ablation.changes import Changes, make_settings


def main(words: list[str]) -> None:
    """Carry out the trials of a request, task after task."""
    given = json.loads(words[0])
    lists = {name: tuple(value) for name, value in given["changes"].items() if isinstance(value, list)}
    changes = Changes(given["changes"] | lists)
    from benchmarks.ablation.walked import carry_out_task

    make_settings()
    changes.check()
    for task in given["tasks"]:
        for seed in given["seeds"]:
            print(
                json.dumps(_line(carry_out_task(task, seed, given["without"], given["longest"]))), flush=True
            )


def _line(found: dict[str, Any]) -> dict[str, Any]:
    """Return a record with None in place of numbers that are none."""
    return {
        key: None if isinstance(value, float) and value != value else value for key, value in found.items()
    }


if __name__ == "__main__":
    main(sys.argv[1:])
