"""Twenty fixed commands of each family; ``python -m tests.motion.drive.wire_table`` writes their bytes.

The numbers are sixteenths and the like, so that they are exact in single precision. The bytes in
`wire_table.json` are ours. On 2026-11-26 they were compared with those that unitree_sdk2_python packs and
seals under Cyclone DDS 0.10.2: all forty were equal.
"""

from __future__ import annotations

import base64
import json
from pathlib import Path

import numpy as np

import surefoot as sf
from surefoot.motion import JointTargets
from surefoot.motion.drive.wire.dialect import dialect_of

TABLE = Path(__file__).with_name("wire_table.json")
COUNT, MACHINE = 20, 5
"""Commands of a family, and a humanoid's `mode_machine`."""


def targets(k: int, joints: int) -> JointTargets:
    """Return the targets of command k, joints in the order of the motors."""
    j = np.arange(joints)
    q, dq = ((7 * j + 3 * k) % 41 - 20) / 16.0, ((5 * j + 11 * k) % 37 - 18) / 8.0
    return JointTargets(q, dq, (j + k) % 9 * 2.5, (j + 2 * k) % 5 * 0.125, ((3 * j + k) % 61 - 30) / 4.0)


def packed(name: str) -> list[bytes]:
    """Return the bytes of a robot's commands."""
    robot = sf.load_robot(name)
    dialect = dialect_of(robot)
    return [bytes(dialect.command_message(targets(k, robot.joints), MACHINE).data) for k in range(COUNT)]


def main() -> None:
    """Write the table anew."""
    table = {name: [base64.b64encode(data).decode() for data in packed(name)] for name in ("go2", "g1")}
    TABLE.write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
