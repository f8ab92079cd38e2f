"""The price of `sf.rl.AuditWrapper` beside the plain environment: CPU of the process, blocks in turn.

``python -m benchmarks.wrapper_price`` (gymnasium and MuJoCo must be installed) steps gymnasium's environments
under random actions, resets included, block by block plain and wrapped with the same seeds and actions, and
compares observations, rewards and ends bit by bit on the way.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console

import surefoot as sf
from benchmarks.printing import report, table

ENVIRONMENTS = ("Ant-v5", "Humanoid-v5", "Walker2d-v5", "Hopper-v5")
BLOCKS, TRIES = 6, 5
"""Blocks of each kind, and how often each is run: the least counts, other processes only add to it."""


@dataclass(frozen=True)
class WrapperPrice:
    """What a step of an environment costs [µs of CPU].

    Attributes
    ----------
    name
        Of the environment.
    plain, wrapped
        Means over the blocks, each the least of its tries, resets included.
    cost
        Of wrapped over plain, less one [-].
    steps, episodes
        In all wrapped blocks.
    rate
        Share of the simulation's steps that was judged [-], the least of all episodes.
    broken
        Episodes in which a law is broken.
    same
        Whether every observation, reward and end was that of the plain environment.
    """

    name: str
    plain: float
    wrapped: float
    cost: float
    steps: int
    episodes: int
    rate: float
    broken: int
    same: bool


def price(name: str, steps: int, blocks: int = BLOCKS, tries: int = TRIES) -> WrapperPrice:
    """Measure one environment, `steps` of it in a block, each block so many times."""
    import gymnasium

    plain, wrapped = gymnasium.make(name), sf.rl.AuditWrapper(gymnasium.make(name))
    infos: list[dict[str, Any]] = []
    for env in (plain, wrapped):
        _block(env, 0, steps, [])  # kernels, caches
    times, same = [], True
    for block in range(1, blocks + 1):
        spent: dict[bool, list[float]] = {False: [], True: []}
        for k in range(tries):
            order = (plain, wrapped) if k % 2 else (wrapped, plain)
            found = {env is wrapped: _block(env, block, steps, [] if k else infos) for env in order}
            for audited, (seconds, _) in found.items():
                spent[audited].append(seconds)
            same &= all(np.array_equal(a, b) for a, b in zip(found[False][1], found[True][1], strict=True))
        times.append((min(spent[False]), min(spent[True])))
    for env in (plain, wrapped):
        env.close()
    plainly, audited = (1e6 * np.mean(times, axis=0) / steps).tolist()
    return WrapperPrice(
        name, plainly, audited, audited / plainly - 1.0, blocks * steps, len(infos),
        min((info["rate"] for info in infos), default=float("nan")),
        sum(info["verdict"] == "broken" for info in infos), same,
    )  # fmt: skip


def _block(env: Any, seed: int, steps: int, infos: list[dict[str, Any]]) -> tuple[float, list[Any]]:
    """Return the CPU of a block [s], and all that it gave."""
    env.action_space.seed(seed)
    actions = [env.action_space.sample() for _ in range(steps)]
    first, _ = env.reset(seed=seed)
    seen, paid, ends = [first], [], []
    begun = time.process_time()
    for action in actions:
        now, reward, terminated, truncated, info = env.step(action)
        seen.append(now)
        paid.append(reward)
        ends.append((terminated, truncated))
        if "audit" in info:
            infos.append(info["audit"])
        if terminated or truncated:
            now, info = env.reset()
            seen.append(now)
    return time.process_time() - begun, [np.array(seen), np.array(paid), np.array(ends)]


def measure(steps: int, blocks: int, tries: int = TRIES) -> Iterator[WrapperPrice]:
    """Yield the price on every environment."""
    for name in ENVIRONMENTS:
        yield price(name, steps, blocks, tries)


def main(
    quick: Annotated[bool, typer.Option("--quick", help="Short blocks.")] = False,
    out: Annotated[Path | None, typer.Option(help="Write the JSON to a new folder below this one.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Measure what auditing every episode costs beside the plain environment."""
    rows = list(measure(100, 2, 1) if quick else measure(1000, BLOCKS))

    def in_words(console: Console) -> None:
        heads = ("environment", "plain", "audited", "more", "episodes", "broken", "steps judged", "results")
        cells = [
            (
                r.name, f"{r.plain:.0f}", f"{r.wrapped:.0f}", f"{100.0 * r.cost:.1f} %", str(r.episodes),
                str(r.broken), f"{100.0 * r.rate:.0f} %", "the same" if r.same else "others",
            )
            for r in rows
        ]  # fmt: skip
        console.print(table(heads, cells, "an environment's step, CPU microseconds, resets included"))

    report({"environments": [asdict(r) for r in rows]}, as_json, in_words, out=out, name="wrapper-price")


if __name__ == "__main__":
    typer.run(main)
