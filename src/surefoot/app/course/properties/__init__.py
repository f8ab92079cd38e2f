"""What right answers obey, a module for each section of the chapter."""

from __future__ import annotations

from collections.abc import Iterable

from surefoot.app.course.answer import Properties, Property
from surefoot.base.lazy_table import LazyTable

SECTIONS: LazyTable[Properties] = LazyTable(
    "section",
    {
        f"52.{number}": f"surefoot.app.course.properties.{name}:PROPERTIES"
        for number, name in enumerate(
            ("laws", "cones", "softenings", "jacobians", "momentum", "flight", "sharing", "soft", "learning"),
            1,
        )
    },
)
"""Section to its properties, imported when they are needed."""


def properties_of(exercise: str) -> Iterable[Property]:
    """Return the properties of an exercise."""
    return SECTIONS.load(exercise.rpartition(".")[0]).of(exercise)
