"""What is run in both revisions: a table of `surefoot` commands, and one outing of `sf.RobotLoop`.

Only public names and the command's own options are used, so that the same table runs in trees whose modules
have other names.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

GROUPS = ("quadrupeds", "slow-gait", "bipeds", "stand", "loop")
"""What has a base of its own in `BASE`: a law that is replaced on purpose moves one of them on."""


@dataclass(frozen=True)
class Scenario:
    """A run whose log must stay the same to the last digit.

    Attributes
    ----------
    group
        Of `GROUPS`.
    command
        Options of `surefoot`; empty for the outing of `RobotLoop`.
    events
        YAML of `--scenario`; empty for none.
    velocities
        Lines of a velocity file, which `events` calls `speeds.txt`.
    """

    group: str
    command: str = ""
    events: str = ""
    velocities: str = ""

    def arguments(self, folder: Path) -> list[str]:
        """Return the command's words, after writing what it reads into a folder."""
        words = [*self.command.split(), "--no-video", "--no-report", "--json"]
        if self.velocities:
            (folder / "speeds.txt").write_text(self.velocities, encoding="utf-8")
        if self.events:
            file = folder / "events.yaml"
            file.write_text(self.events, encoding="utf-8")
            words += ["--scenario", str(file)]
        return words


SPEEDS = "0 0 0 0\n0.3 0.25 0 0\n1.3 1.0 0 0.3\n2.8 0 0.2 0\n3.4 0 0 0\n"
"""Time [s], forward, left [m/s], yaw rate [rad/s]: stand, walk, trot and stand again."""

SCENARIOS: dict[str, Scenario] = {
    "trot-pushed": Scenario(
        "quadrupeds", "walk go2 --push 0.8:60,50,0:0.2 --push 1.6:-40,-60,20:0.1 --seed 1 --duration 2.5"
    ),
    "trot-caught": Scenario("quadrupeds", "walk go2 --push 0.8:150,120,0:0.1 --seed 5 --duration 2.5"),
    "trot-leaps": Scenario("quadrupeds", "walk go2 --push 0.8:0,240,0:0.1 --duration 2.5"),
    "walk-slope-payload": Scenario(
        "slow-gait",
        "walk go2 --gait walk --velocity 0.3,0.1,0.2 --slope 8 --payload 2@0.05,0,0.1 --duration 3",
    ),
    "pace": Scenario("quadrupeds", "walk go2 --gait pace --velocity 0.6,0,0 --seed 2 --duration 2"),
    "bound-rigid": Scenario("quadrupeds", "walk go2 --gait bound --world rigid --duration 1.5"),
    "flying-trot": Scenario("quadrupeds", "walk go2 --gait flying_trot --velocity 1.2,0,0 --duration 2"),
    "auto-real-motors": Scenario(
        "quadrupeds",
        "walk go2 --gait auto --actuators real --collision full --duration 4.2",
        "velocity_file: speeds.txt\n",
        SPEEDS,
    ),
    "anymal-rigid-pushed": Scenario(
        "quadrupeds", "walk anymal_c --world rigid --push 0.8:0,150,0:0.15 --seed 3 --duration 2"
    ),
    "solo12-known-state": Scenario(
        "quadrupeds", "walk solo12 --velocity 0.3,0,0.4 --duration 2", "estimator: truth\nnoise: 0.5\n"
    ),
    "stairs-known": Scenario(
        "quadrupeds", "walk go2 --terrain stairs:0.1,0.3 --velocity 0.4,0,0 --duration 4"
    ),
    "stairs-seen": Scenario(
        "quadrupeds",
        "walk go2 --terrain stairs:0.1,0.3 --terrain-knowledge map --velocity 0.4,0,0 --duration 4",
    ),
    "rough-by-touch": Scenario(
        "quadrupeds",
        "walk a1 --terrain rough:3,0.04 --terrain-knowledge blind --velocity 0.4,0,0 --duration 3",
    ),
    "drop-by-touch": Scenario(
        "quadrupeds",
        "walk go2 --terrain pit:0.6,2,0.1 --terrain-knowledge blind --velocity 0.4,0,0 --duration 3",
    ),
    "ice-found": Scenario(
        "quadrupeds",
        "walk go2 --velocity 0.6,0,0 --duration 3",
        "ice:\n  - {lower: [0.3, -3], upper: [2, 3], mu: 0.1}\nbelieved_mu: auto\n",
    ),
    "late-targets": Scenario(
        "quadrupeds",
        "walk go1 --commands targets --dropout 1.2:0.03 --actuators real --seed 4 --duration 2",
        "control_rate: 250\ndelay: 0.005\nweak_joint: FL_calf_joint\ntorque_loss: 0.3\n",
    ),
    "g1-pushed": Scenario("bipeds", "walk g1 --velocity 0.3,0,0 --push 1.5:0,60,0:0.1 --seed 1 --duration 3"),
    "g1-rough-real-motors": Scenario(
        "bipeds", "walk g1 --velocity 0.2,0,0.2 --terrain rough:1,0.02 --actuators real --duration 2.5"
    ),
    "icub": Scenario("bipeds", "walk icub --velocity 0.15,0,0 --payload 1 --duration 2"),
    "stand-pushed": Scenario(
        "stand", "stand go2 --push 0.6:60,30,0:0.2 --push 1.2:0,-40,0:0.1 --lift FL_foot:2:2.8 --duration 3.5"
    ),
    "stand-anymal-rigid": Scenario(
        "stand", "stand anymal_c --world rigid --slope 10 --push 0.6:100,80,0:0.2 --duration 1.5"
    ),
    "stand-g1": Scenario("stand", "stand g1 --push 0.6:0,40,0:0.1 --duration 1.5"),
    "stand-slippery": Scenario(
        "stand", "stand go2 --slope 12 --payload 3 --seed 1 --duration 2", "ice:\n  - {from: 0.8, mu: 0.3}\n"
    ),
    "loop": Scenario("loop"),
}


def chosen(names: Sequence[str]) -> list[str]:
    """Return the scenarios that names of groups and of scenarios mean, in the table's order; all for none.

    Raises
    ------
    ValueError
        For a name that is neither.
    """
    unknown = [name for name in names if name not in GROUPS and name not in SCENARIOS]
    if unknown:
        known = ", ".join([*GROUPS, *SCENARIOS])
        raise ValueError(f"unknown scenario or group {unknown[0]!r}; there are {known}")
    return [name for name, one in SCENARIOS.items() if not names or name in names or one.group in names]
