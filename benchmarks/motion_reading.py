"""How often conventions of motion files are guessed rightly, and how often a wrong one is named.

    python -m benchmarks.motion_reading --folder FOLDER [--robot g1] [--fps 30] [--seed 1] [--every 1] [--all]

Every motion below the folder is read as it stands, and its doubts are counted. It is then spoilt in one way
at a time and read again without a word of what was done: as a bare table, and as the pickles of GMR have it,
whose names say xyzw and depth first. A reading is right where its configurations are those from before;
otherwise the spoiling is named where a doubt is about it. What is neither is missed: the last column names
it, with `--all` every motion.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.records.motions.joint_orders import breadth_first, mirror_names

Arrays = tuple[Any, Any, Any]
"""Place (T, 3), quaternion (T, 4) as x, y, z, w and joints (T, n) of a motion."""
ENDINGS = (".csv", ".pkl", ".npz", ".npy", ".joblib")


def _order(robot: sf.Robot, names: Any) -> Any:
    return [robot.joint_names.index(name) for name in names]


def spoilers(robot: sf.Robot, rng: np.random.Generator) -> dict[str, tuple[str, Callable[[Arrays], Arrays]]]:
    """Return ways to spoil a motion by name: what a doubt must be about, and what it makes of the arrays."""
    breadth = _order(robot, breadth_first(robot))
    mirror = mirror_names(robot)
    sides = _order(robot, [mirror[name] for name in robot.joint_names])
    shuffle = rng.permutation(robot.joints)
    legs = [
        k
        for k, name in enumerate(robot.joint_names)
        if any(w in name for w in ("hip", "knee", "ankle", "leg"))
    ]
    mixed = np.arange(robot.joints)
    mixed[legs] = rng.permutation(legs)
    return {
        "as it is": ("", lambda m: m),
        "quaternion wxyz": ("quaternion", lambda m: (m[0], m[1][:, [3, 0, 1, 2]], m[2])),
        "quaternion inverse": ("quaternion", lambda m: (m[0], m[1] * [-1, -1, -1, 1], m[2])),
        "breadth first": ("joint order", lambda m: (m[0], m[1], m[2][:, breadth])),
        "breadth, wxyz": ("joint order", lambda m: (m[0], m[1][:, [3, 0, 1, 2]], m[2][:, breadth])),
        "sides exchanged": ("joint order", lambda m: (m[0], m[1], m[2][:, sides])),
        "joints shuffled": ("joint order", lambda m: (m[0], m[1], m[2][:, shuffle])),
        "legs' joints shuffled": ("joint order", lambda m: (m[0], m[1], m[2][:, mixed])),
        "degrees": ("units", lambda m: (m[0], m[1], np.degrees(m[2]))),
        "centimetres": ("units", lambda m: (100.0 * m[0], m[1], m[2])),
    }


def as_files(robot: sf.Robot, arrays: Arrays, rate: float) -> dict[str, tuple[Any, float | None]]:
    """Return what files of two formats would hold of a motion, and the rate to give."""
    place, quaternion, joints = arrays
    return {
        "table": (np.hstack(arrays), rate),
        "gmr": ({"fps": rate, "root_pos": place, "root_rot": quaternion, "dof_pos": joints}, None),
        "named": (
            {
                "fps": rate,
                "root_pos": place,
                "root_quat_xyzw": quaternion,
                "joint_pos": joints,
                "joint_names": np.array(robot.joint_names),
            },
            None,
        ),
    }


def motions(folder: Path, robot: sf.Robot, fps: float, every: int) -> Iterator[sf.Motion]:
    """Yield the motions below a folder that can be read."""
    paths = sorted(path for path in folder.rglob("*") if path.suffix.lower() in ENDINGS)
    for path in paths[::every]:
        try:
            yield from sf.read_motions(path, robot, fps=fps if path.suffix.lower() == ".csv" else None)
        except sf.SurefootError as error:
            print(f"  not read: {error}")


def verdict(motion: sf.Motion, read: sf.Motion, about: str) -> str:
    """Return whether a spoilt motion was read rightly, or what was done to it named."""
    same = np.abs(np.abs(np.einsum("ti,ti->t", motion.q[:, 3:7], read.q[:, 3:7])) - 1.0).max() < 1e-6
    if (
        same
        and np.abs(motion.q[:, :3] - read.q[:, :3]).max() < 1e-6
        and np.abs(motion.q[:, 7:] - read.q[:, 7:]).max() < 1e-6
    ):
        told = not about or any(about in note for note in read.notes)
        return "right" if told else "untold"
    return "named" if any(about in doubt for doubt in read.doubts) else "missed"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--robot", default="g1")
    parser.add_argument("--fps", type=float, default=30.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--all", action="store_true")
    given = parser.parse_args()
    robot, rng = sf.load_robot(given.robot), np.random.default_rng(given.seed)
    counts: dict[tuple[str, str], dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    doubts: dict[str, list[str]] = defaultdict(list)
    for motion in motions(given.folder, robot, given.fps, given.every):
        for doubt in motion.doubts:
            doubts[doubt.split(":")[0]].append(motion.name)
        if not motion.doubts:
            doubts["none"].append(motion.name)
        arrays = (motion.q[:, :3], motion.q[:, 3:7], motion.q[:, 7:])
        for name, (about, spoil) in spoilers(robot, rng).items():
            for form, (contents, rate) in as_files(robot, spoil(arrays), motion.rate).items():
                try:
                    found = verdict(motion, sf.read_motion(contents, robot, fps=rate), about)
                except sf.SurefootError:
                    found = "refused"
                counts[name, form][found].append(motion.name)
    print("doubts as read: " + ", ".join(f"{name} {len(which)}" for name, which in sorted(doubts.items())))
    for name in ("quaternion", "joint order", "units"):
        if doubts.get(name):
            print(f"  {name}: {', '.join(doubts[name])}")
    words = ("right", "named", "refused", "untold", "missed")
    print(f"{'spoilt by':24s}{'form':8s}" + "".join(f"{word:>9s}" for word in words))
    for (name, form), said in counts.items():
        row = "".join(f"{len(said[word]):9d}" for word in words)
        bad = said["missed"] + said["untold"]
        shown = bad if given.all else bad[:3]
        print(f"{name:24s}{form:8s}{row}  {', '.join(shown)}{' ...' if len(shown) < len(bad) else ''}")


if __name__ == "__main__":
    main()
