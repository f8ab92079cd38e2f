"""The JSON schemas that editors are given say what the readers' models say.

`python -m tests.test_file_schemas` writes them.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from surefoot.app.cli.scenario_file import SCHEMA as SCENARIO
from surefoot.app.cli.scenario_keys import Scenario
from surefoot.app.export.sequence_file import SCHEMA as SEQUENCE
from surefoot.app.export.sequence_keys import Sequence
from surefoot.base.file_models import schema_text

SCHEMAS: list[tuple[Path, type[Any]]] = [(SCENARIO, Scenario), (SEQUENCE, Sequence)]


@pytest.mark.parametrize(("path", "form"), SCHEMAS, ids=lambda value: getattr(value, "name", ""))
def test_a_schema_is_current(path: Path, form: type[Any]) -> None:
    assert path.read_text(encoding="utf-8") == schema_text(form)


@pytest.mark.parametrize(("path", "form"), SCHEMAS, ids=lambda value: getattr(value, "name", ""))
def test_a_schema_is_one(path: Path, form: type[Any]) -> None:
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.Draft202012Validator.check_schema(json.loads(path.read_text(encoding="utf-8")))


if __name__ == "__main__":
    for path, form in SCHEMAS:
        path.write_text(schema_text(form), encoding="utf-8")
