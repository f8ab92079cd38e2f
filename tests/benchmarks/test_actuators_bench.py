"""The bench of actuators: what its rows say, on one short walk."""

from __future__ import annotations

from benchmarks import actuators
from benchmarks.printing import cells
from surefoot.simulation.faults import Faults


def test_a_row_holds_what_the_walk_came_to() -> None:
    walk = actuators.Walk(wired=actuators.TARGETS, faults=Faults(delay=0.003))
    cells = dict(zip(actuators.COLUMNS, actuators.row(walk, 1, 1.2), strict=True))
    assert cells["walked"] == cells["laws and limits kept"] == "1 of 1"
    assert 0.0 < float(cells["slip [mm]"]) < 2.0
    assert 30 < int(cells["fastest joint [%]"]) < 100
    assert cells["beyond its speed [%]"] == "0"
    assert cells["links touched"] == "0 of 1"


def test_the_tables_hold_what_their_names_say() -> None:
    assert {w.velocity[0] for w in actuators.speeds().values()} == {0.5, 1.0, 1.5, 2.0}
    late = actuators.delays()
    assert {name: w.faults.delay for name, w in late.items() if name.startswith("5 ms")} == dict.fromkeys(
        (f"5 ms, {name}" for name in actuators.WIRINGS), 0.005
    )
    shown = cells(actuators.table("none", {}, 1, 1.0))
    assert shown["columns"] == ["walk", *actuators.COLUMNS]
    assert shown["rows"] == []
