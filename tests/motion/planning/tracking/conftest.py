from __future__ import annotations

import pytest

from surefoot.mechanics.robot import load_robot
from surefoot.motion.planning.tracking import Reference
from tests.motion.planning.tracking.hops import hop


@pytest.fixture(scope="module")
def jump() -> Reference:
    return hop(load_robot("go2"), 1.6, 0.8)
