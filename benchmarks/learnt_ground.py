"""Vary the settings of ground that a robot learns, one at a time, over what recorded walks have sensed.

Run: python -m benchmarks.learnt_ground [NAME...] [--factor 3 10] [--seeds 2] [--json] [--quick]. NAME is
"Class.setting" or a class; all of `HELD_IN` without one. Values are tried that are so many times a setting's
own, and so many times less.

Go2 walks over stairs, slopes, a pit and rough ground, seen and blind, and all that its ground is given is
kept: estimated states, scans, and where feet stand or look for ground. The ground is then learnt anew from it
with other values of a setting, and compared with the true one about the robot's way:

- height, slope: mean error of heights [m] and of slopes [-] that are seen, from 0.1 m behind to 0.6 m before
  the base; felt height, felt slope: the same of ground that is known by touch alone, to 0.3 m before it
- unknown: share of the scans of a walk over stairs by which they are not located
- tread: mean error of their tread and rise where steps are known [m]
- false: share of the scans of other walks by which there are stairs

The differences of walks are paired, as in `surefoot bench ablation`: a value is worse, or better, if the 95 %
interval of a measure's mean difference excludes zero and the mean changes by more than 2 %; one that is both
is worse. The choice of a setting is repeated if no value that was tried is better, and one is worse.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from benchmarks.ablation.varying import Setting, find_settings, place, shown
from benchmarks.printing import options
from benchmarks.terrain_knowledge import Walk
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError, unknown_name
from surefoot.base.spatial import heading_of
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.terrain import Terrain, read_terrain
from surefoot.motion.control.controller import Controller
from surefoot.motion.ground import (
    ground_belief,
    mapped_ground,
    stair_detection,
    stair_fit,
    touched_ground,
)
from surefoot.motion.ground.elevation_map import ElevationMap
from surefoot.motion.ground.mapped_ground import MappedGround
from surefoot.motion.ground.touched_ground import TouchedGround
from surefoot.motion.walking.walkers import walking_controller
from surefoot.worlds.running.height_scan import RangeSensor
from surefoot.worlds.running.sensors import SensorModel

STAIRS = {"stairs:0.12,0.3": (0.12, 0.3), "stairs:-0.12,0.3": (-0.12, 0.3), "stairs:0.08,0.25": (0.08, 0.25)}
"""Rise and tread of stairs that are seen [m]."""
WAYS = (
    *(("map", name) for name in (*STAIRS, "rough:1,0.04", "slope:15", "pit:0.6,2,0.08")),
    *(("blind", name) for name in ("rough:1,0.04", "slope:15", "stairs:0.05,0.3", "pit:0.6,2,0.11")),
)
"""What is known of the ground, and the terrain, of each walk."""
QUICK = (("map", "stairs:0.12,0.3"), ("blind", "rough:1,0.04"))
"""What `--quick` walks over."""
SPEED = 0.4
"""Of the walks [m/s]."""
DURATION = 5.0
"""Of a walk [s]."""
HELD_IN = {
    "MapSettings": ("", ()),
    "StairDetectionSettings": ("STAIR_DETECTION", (stair_detection,)),
    "StairFitSettings": ("STAIR_FIT", (stair_fit,)),
    "GroundEstimateSettings": ("GROUND_ESTIMATE", (ground_belief, touched_ground)),
    "TouchedGroundSettings": ("TOUCHED_GROUND", (touched_ground,)),
    "MappedGroundSettings": ("MAPPED_GROUND", (mapped_ground,)),
}
"""Classes of settings to the name of their value and the modules that read it; a map is given its own."""
LEARNT_IN = {"GroundEstimateSettings": ("blind",), "TouchedGroundSettings": ("blind",)}
"""What is known of the ground in walks over which a class is varied, if other than what is seen."""
FACTORS = (3.0, 10.0)
"""Values that are tried over a setting's own, and its own over them."""
WORTH = 0.02
"""Share of a measure that a difference must have to matter."""
FLOORS = {
    "height": 2e-3, "slope": 0.01, "unknown": 0.1, "tread": 2e-3, "false": 0.1, "felt height": 2e-3,
    "felt slope": 0.01,
}  # fmt: skip
"""Measures by name, with the least value over which a difference is put."""
AHEAD, FELT_AHEAD, ASIDE = (
    np.arange(-0.1, 0.61, 0.05),
    np.arange(-0.1, 0.31, 0.05),
    np.array([-0.15, 0.0, 0.15]),
)
"""Places about the base at which ground is compared, along its heading and to the left [m]."""


EVERY = 0.066
"""Time between comparisons of ground that is not seen [s]."""


@dataclass
class Sensed:
    """What learnt ground was given in a walk, step by step, and where the robot truly was."""

    knowledge: str
    ground: str
    seed: int
    begun: tuple[Any, ...] = ()
    steps: list[tuple[Any, ...]] = field(default_factory=list)
    true_q: FloatArray = field(default_factory=lambda: np.zeros((0, 7)))
    times: FloatArray = field(default_factory=lambda: np.zeros(0))


class Keeping:
    """Keeps what a ground is given from its start on; mixed in before its class."""

    def __init__(self, kept: Sensed) -> None:
        super().__init__()
        self._kept = kept

    def start(self, state: Any, ground: FloatArray, height: float, radius: float) -> None:
        """See `BeliefTerrain.start`; a walk that begins anew is kept from there."""
        self._kept.begun = (_copied(state), ground.copy(), height, radius)
        self._kept.steps.clear()
        super().start(state, ground, height, radius)  # type: ignore[misc]

    def observe(self, state: Any, *parts: Any) -> None:
        """See `BeliefTerrain.observe`."""
        self._kept.steps.append((_copied(state), *(part.copy() for part in parts)))
        super().observe(state, *parts)  # type: ignore[misc]


class KeepingMap(Keeping, MappedGround):
    """A mapped ground that keeps what it is given."""


class KeepingTouch(Keeping, TouchedGround):
    """A touched ground that keeps what it is given."""


def _copied(state: Any) -> Any:
    return state._replace(q=state.q.copy(), v=state.v.copy())


@dataclass(frozen=True)
class KeptWalk(Walk):
    """A walk on learnt ground that keeps what it is given."""

    kept: Sensed | None = None

    def controller(self, robot: Robot, terrain: Terrain) -> Controller:
        """See `Walk.controller`."""
        assert self.kept is not None
        ground = (KeepingMap if self.kept.knowledge == "map" else KeepingTouch)(self.kept)
        return walking_controller(robot, self.command, self.gait, ground, self.counted_on, self.motors(robot))


def record(knowledge: str, ground: str, seed: int) -> Sensed:
    """Return what the learnt ground of a walk was given."""
    kept = Sensed(knowledge, ground, seed)
    walk = KeptWalk(
        velocity=(SPEED, 0.0, 0.0), terrain=ground, believed_mu=0.6, knowledge=knowledge,
        options={"collision": "full"}, sensors=SensorModel(heights=False),
        scanner=RangeSensor() if knowledge == "map" else None, kept=kept,
    )  # fmt: skip
    log = walk.log(seed, DURATION)
    kept.true_q, kept.times = np.asarray(log["q"])[:, :7], np.asarray(log["time"])
    kept.steps = list(_needed(kept.steps))
    return kept


def _needed(steps: Sequence[tuple[Any, ...]]) -> Iterator[tuple[Any, ...]]:
    """Yield the steps of which a ground learns: scans and the poses they are of, changes of the feet."""
    times = np.array([state.time for state, *_ in steps])
    posed = {int(np.argmin(np.abs(times - s.scan.time))) for s, *_ in steps if s.scan is not None}
    before, compared = np.zeros(0, dtype=bool), -np.inf
    for k, step in enumerate(steps):
        state, _, stance, sought, _ = step
        due = state.time - compared > EVERY
        if due or k in posed or state.scan is not None or sought.any() or not np.array_equal(stance, before):
            yield step
            compared = state.time if due else compared
        before = stance


def learn(sensed: Sensed, map_settings: Any = None) -> dict[str, float]:
    """Return the measures of ground that is learnt from what a walk has sensed; NaN for those it has not."""
    truth, seen = read_terrain(sensed.ground), sensed.knowledge == "map"
    ground = MappedGround() if seen else TouchedGround()
    if map_settings is not None and isinstance(ground, MappedGround):
        ground.map = ElevationMap(map_settings)
    ground.start(*sensed.begun)
    found: dict[str, list[float]] = {name: [] for name in FLOORS}
    compared = -np.inf
    for state, *parts in sensed.steps:
        ground.observe(state, *parts)
        if (state.scan is None) if seen else (state.time - compared < EVERY):
            continue
        compared = state.time
        row = min(int(np.searchsorted(sensed.times, state.time - 1e-9)), len(sensed.times) - 1)
        errors = _errors(ground, state.q, truth, sensed.true_q[row], AHEAD if seen else FELT_AHEAD)
        for name, error in zip(("height", "slope"), errors, strict=True):
            found[name if seen else f"felt {name}"].append(error)
        if isinstance(ground, MappedGround):
            _judge_stairs(ground, STAIRS.get(sensed.ground), found)
    return {name: float(np.mean(values)) if values else float("nan") for name, values in found.items()}


def _judge_stairs(
    ground: MappedGround, true: tuple[float, float] | None, found: dict[str, list[float]]
) -> None:
    """Append what is known of stairs, of which the rise and tread are true; None where there are none."""
    steps = ground.watch.steps
    if true is None:
        found["false"].append(float(steps is not None))
        return
    found["unknown"].append(float(ground.watch.flight is None))
    if steps is not None:
        found["tread"].append(abs(steps.rise - true[0]) + abs(steps.tread - true[1]))


def _errors(
    believed: Terrain, q: FloatArray, truth: Terrain, true_q: FloatArray, ahead: FloatArray
) -> tuple[float, float]:
    """Return the mean errors of height [m] and slope [-] about a base, each ground seen from its own base."""
    heights, slopes = [], []
    for terrain, base in ((believed, q), (truth, true_q)):
        c, s = heading_of(base[3:7])[:2]
        along, aside = (part.ravel() for part in np.meshgrid(ahead, ASIDE, indexing="ij"))
        places = base[:2] + np.column_stack([c * along - s * aside, s * along + c * aside])
        heights.append(terrain.height(places) - base[2])
        gradient = terrain.gradient(places)
        slopes.append(gradient @ np.array([[c, -s], [s, c]]))
    off = np.linalg.norm(slopes[0] - slopes[1], axis=1)
    return float(np.abs(heights[0] - heights[1]).mean()), float(off.mean())


@contextmanager
def changed(name: str, value: Any) -> Iterator[Any]:
    """Change a setting by "Class.setting" for a while; yield the map's settings, None for its own."""
    owner, _, own = name.partition(".")
    if owner == "MapSettings":
        yield replace(ElevationMap().settings, **{own: value})
        return
    held, modules = HELD_IN[owner]
    before = getattr(modules[0], held)
    for module in modules:
        vars(module)[held] = replace(before, **{own: value})
    try:
        yield None
    finally:
        for module in modules:
            vars(module)[held] = before


Measures = Sequence[Mapping[str, float]]


def compare(before: Measures, after: Measures) -> dict[str, tuple[float, bool, bool]]:
    """Return by measure the relative difference of its mean, and whether it is worse or better."""
    from scipy.stats import t

    out = {}
    for name, floor in FLOORS.items():
        pairs = np.array([(a[name], b[name]) for a, b in zip(before, after, strict=True)])
        pairs = pairs[np.isfinite(pairs).all(axis=1)]
        if len(pairs) < 3:
            continue
        change = pairs[:, 1] - pairs[:, 0]
        mean = float(change.mean())
        wide = float(t.ppf(0.975, len(change) - 1)) * float(change.std(ddof=1)) / len(change) ** 0.5
        share = mean / max(float(pairs[:, 0].mean()), floor)
        sure = abs(mean) > wide and abs(share) > WORTH
        out[name] = (share, bool(sure and mean > 0.0), bool(sure and mean < 0.0))
    return out


def vary(one: Setting, walks: Sequence[Sensed], before: Measures, factors: Sequence[float]) -> dict[str, Any]:
    """Return what comes of other values of a setting, each side outwards until one is worse."""
    own, tried = place(one.value), []
    values = one.values(None, factors)
    for side in (1.0, -1.0):
        beyond = sorted(
            (v for v in values if side * (place(v) - own) > 0.0), key=lambda v: abs(place(v) - own)
        )
        for value in beyond:
            try:
                with changed(one.name, value) as map_settings:
                    after = [learn(walk, map_settings) for walk in walks]
            except ProblemError:
                break  # a value that another one of the class does not allow
            found = compare(before, after)
            worse = [name for name, (_, bad, _) in found.items() if bad]
            better = [name for name, (_, _, good) in found.items() if good]
            shares = {name: round(share, 4) for name, (share, *_) in found.items()}
            tried.append((value, worse, better, shares))
            if worse:
                break
    tried.sort(key=lambda row: place(row[0]))
    return {"setting": one.name, "value": one.value, "verdict": _verdict(one.value, tried), "tried": tried}


def kinds_of(one: Setting) -> tuple[str, ...]:
    """Return what is known of the ground in the walks that a setting has to do with."""
    return LEARNT_IN.get(one.name.partition(".")[0], ("map",))


def walks_of(one: Setting, walks: Sequence[Sensed], before: Measures) -> tuple[list[Sensed], Measures]:
    """Return the walks that a setting has to do with, and their measures."""
    kinds = kinds_of(one)
    chosen = [k for k, walk in enumerate(walks) if walk.knowledge in kinds]
    return [walks[k] for k in chosen], [before[k] for k in chosen]


def _verdict(own: Any, tried: Sequence[tuple[Any, list[str], list[str], Any]]) -> str:
    better = [value for value, worse, good, _ in tried if good and not worse]
    if better:
        return "better: " + "; ".join(map(shown, better))
    if not any(worse for _, worse, _, _ in tried):
        return "not decided: all values tried do as well"
    good = sorted([own, *(value for value, worse, _, _ in tried if not worse)], key=place)
    return f"as good from {shown(good[0])} to {shown(good[-1])}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print what comes of each setting."""
    parser = options(__doc__, "a seed of two walks, one value each way", seeds=2)
    parser.add_argument("names", nargs="*", help="settings or classes of them (default: all)")
    parser.add_argument(
        "--factor", type=float, nargs="+", default=FACTORS, help="of values over the setting's own"
    )
    given = parser.parse_args(arguments)
    if not all(1.0 < factor < float("inf") for factor in given.factor):
        raise ProblemError(f"--factor must be above 1 and finite, got {', '.join(map(shown, given.factor))}")
    chosen: list[Setting] = []
    for name in given.names or HELD_IN:
        if name.partition(".")[0] not in HELD_IN:
            raise ProblemError(unknown_name("class of settings", name, tuple(HELD_IN)))
        chosen += find_settings(name)
    ways, seeds = (QUICK, 1) if given.quick else (WAYS, given.seeds)
    kinds = {kind for one in chosen for kind in kinds_of(one)}
    walks = [record(*way, seed) for way in ways if way[0] in kinds for seed in range(1, seeds + 1)]
    before = [learn(walk) for walk in walks]
    rows, factors = [], given.factor[:1] if given.quick else given.factor
    for one in chosen:
        rows.append(vary(one, *walks_of(one, walks, before), factors))
        if not given.json:
            print(f"{one.name} = {shown(one.value)}: {rows[-1]['verdict']}")
            for value, worse, better, shares in rows[-1]["tried"]:
                marks = {**dict.fromkeys(worse, "*"), **dict.fromkeys(better, "+")}
                cells = (f"{name} {share:+.1%}{marks.get(name, '')}" for name, share in shares.items())
                print(f"    {shown(value)}: " + ", ".join(cells), flush=True)
    if given.json:
        print(json.dumps(rows))


if __name__ == "__main__":
    main()
