"""The bench of actuators: what its rows say, on one short walk."""

from __future__ import annotations

from benchmarks import actuators
from surefoot.simulation.faults import Faults


def test_a_row_holds_what_the_walk_came_to() -> None:
    walk = actuators.Walk(wired=actuators.TARGETS, faults=Faults(delay=0.003))
    cells = dict(zip(actuators.COLUMNS, actuators.row(walk, 1, 1.2), strict=True))
    assert cells["walked"] == cells["laws and limits kept"] == "1 of 1"
    assert 0.0 < float(cells["slip [mm]"]) < 2.0
    assert 30 < int(cells["fastest joint [%]"]) < 100
    assert cells["beyond its speed [%]"] == "0"
    assert cells["links touched"] == "0 of 1"
