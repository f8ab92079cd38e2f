"""The notebooks of the examples: a pair each, small and without traces of a machine, and they run."""

from __future__ import annotations

import base64
import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from docs import notebooks

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = notebooks.programs()
TRACES = re.compile(r"(?<![\w.])/(?:home|root|tmp|usr|opt|Users)\b|site-packages|[A-Z]:\\|0x[0-9a-f]{6,}")
"""Paths and addresses, which another machine has others of."""
NUMBER = re.compile(r"-?\d+(?:\.\d*)?(?:e[-+]?\d+)?")


def name_of(path: Path) -> str:
    return path.stem


def read(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.with_suffix(".ipynb").read_text(encoding="utf-8"))
    return found


def outputs_of(notebook: dict[str, Any]) -> list[dict[str, Any]]:
    return [output for cell in notebook["cells"] for output in cell.get("outputs", [])]


def pictures_of(notebook: dict[str, Any]) -> list[bytes]:
    datas = [output["data"] for output in outputs_of(notebook) if "data" in output]
    return [base64.b64decode(data["image/png"]) for data in datas if "image/png" in data]


def texts_of(notebook: dict[str, Any]) -> list[str]:
    """Return all that was printed, cell by cell."""
    return [
        "".join("".join(output["text"]) for output in cell["outputs"] if output["output_type"] == "stream")
        for cell in notebook["cells"]
        if cell["cell_type"] == "code"
    ]


def test_there_are_ten_and_each_is_listed() -> None:
    page = (ROOT / "docs" / "notebooks.md").read_text(encoding="utf-8")
    assert len(PROGRAMS) == 10
    assert sorted(path.stem for path in notebooks.FOLDER.glob("*.ipynb")) == [p.stem for p in PROGRAMS]
    for path in PROGRAMS:
        title = notebooks.read_cells(path)[0][1].splitlines()[0].removeprefix("# ")
        assert f"[{title}](../examples/notebooks/{path.stem}.ipynb)" in page


@pytest.mark.parametrize("path", PROGRAMS, ids=name_of)
def test_a_notebook_is_its_program_and_ends_in_a_picture(path: Path) -> None:
    assert notebooks.differences(path) == [], "python -m docs.notebooks writes it"
    notebook = read(path)
    cells = notebook["cells"]
    code = "\n".join("".join(c["source"]) for c in cells if c["cell_type"] == "code")
    lines = [line for line in code.splitlines() if line.strip() and not line.strip().startswith("#")]
    assert 15 <= len(lines) <= 40, f"{len(lines)} lines of code"
    assert sum(c["cell_type"] == "markdown" for c in cells) >= 3
    assert any("image/png" in output.get("data", {}) for output in cells[-1]["outputs"])


@pytest.mark.parametrize("path", PROGRAMS, ids=name_of)
def test_what_is_kept_is_small_and_tells_nothing_of_a_machine(path: Path) -> None:
    notebook = read(path)
    assert all(len(picture) <= notebooks.PICTURE_BYTES for picture in pictures_of(notebook))
    assert [cell["id"] for cell in notebook["cells"]] == [
        f"cell-{k}" for k in range(1, len(notebook["cells"]) + 1)
    ]
    assert {cell["execution_count"] for cell in notebook["cells"] if cell["cell_type"] == "code"} == {None}
    assert all(not cell["metadata"] for cell in notebook["cells"])
    for output in outputs_of(notebook):
        text = "".join(output.get("text", "")) + "".join(output.get("data", {}).get("text/plain", ""))
        assert not TRACES.search(text), text
        assert output["output_type"] in {"stream", "display_data"}
        assert set(output.get("data", {})) <= {"text/plain", "image/png"}


def test_jupytext_reads_the_same_cells() -> None:
    jupytext = pytest.importorskip("jupytext")
    for path in PROGRAMS:
        cells = [(cell.cell_type, cell.source) for cell in jupytext.read(path).cells]
        assert cells == notebooks.read_cells(path)


@pytest.mark.parametrize(
    "path",
    [pytest.param(p, marks=pytest.mark.long if k else [], id=p.stem) for k, p in enumerate(PROGRAMS)],
)
def test_a_notebook_runs_and_prints_what_is_kept(path: Path) -> None:
    """Words alone are compared: another processor rounds otherwise."""
    pytest.importorskip("nbclient", reason="nbclient runs notebooks")
    pytest.importorskip("ipykernel", reason="ipykernel is the kernel of notebooks")
    if path.stem >= "02":
        pytest.importorskip("pinocchio")
    if path.stem[:2] in {"04", "05", "06", "10"}:
        pytest.importorskip("mujoco")
    made, kept = notebooks.execute(path), read(path)
    for new, old in zip(texts_of(made), texts_of(kept), strict=True):
        assert NUMBER.sub("#", new).split() == NUMBER.sub("#", old).split()
    assert len(pictures_of(made)) == len(pictures_of(kept))


def test_cells_of_a_program(tmp_path: Path) -> None:
    path = tmp_path / "one.py"
    path.write_text("# %% [markdown]\n# # Sum\n#\n# Text.\n\n# %%\nx = 1\n\n\n# %%\nx\n")
    assert notebooks.read_cells(path) == [("markdown", "# Sum\n\nText."), ("code", "x = 1"), ("code", "x")]
    assert notebooks.differences(path) == ["one.ipynb is missing"]
    notebook = notebooks.blank_notebook(path)
    path.with_suffix(".ipynb").write_text(json.dumps(notebook))
    assert notebooks.differences(path) == []
    notebook["cells"][2]["source"] = "y"
    path.with_suffix(".ipynb").write_text(json.dumps(notebook))
    assert notebooks.differences(path) == ["one.ipynb, cell 3"]
    path.with_suffix(".ipynb").write_text(json.dumps(notebook | {"cells": []}))
    assert notebooks.differences(path) == ["one.ipynb has 0 cells, one.py 3"]
    path.write_text("import os\n# %%\n")
    with pytest.raises(ValueError, match="no cell begins with 'import os'"):
        notebooks.read_cells(path)


def test_what_is_kept_of_an_output() -> None:
    path = Path("one.py")
    page = {
        "output_type": "execute_result",
        "data": {"text/plain": "x", "text/html": "<p>x"},
        "metadata": {"a": 1},
    }
    assert notebooks.tidy_output(page, path) == {
        "output_type": "display_data", "data": {"text/plain": "x"}, "metadata": {}
    }  # fmt: skip
    stream = {"output_type": "stream", "name": "stderr"}
    text = "compiling f and 3 kernels below it, once per machine: 6 s\n"
    assert notebooks.tidy_output(stream | {"text": text}, path) is None
    with pytest.raises(ValueError, match="standard error: trouble"):
        notebooks.tidy_output(stream | {"text": "trouble\n"}, path)


def test_a_large_picture_loses_colours() -> None:
    image = pytest.importorskip("PIL.Image")
    import io

    import numpy as np

    field = np.random.default_rng(0).integers(0, 40, (260, 260, 3)).astype(np.uint8)
    out = io.BytesIO()
    image.fromarray(field).save(out, "png")
    assert len(out.getvalue()) > notebooks.PICTURE_BYTES
    small = notebooks.shrink_picture(out.getvalue())
    assert len(small) <= notebooks.PICTURE_BYTES
    assert image.open(io.BytesIO(small)).size == (260, 260)


def test_what_runs_notebooks_is_installed_for_the_tests() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    assert extras["dev"][0].startswith("surefoot[course")
    course = " ".join(extras["course"])
    pins = (ROOT / "constraints.txt").read_text(encoding="utf-8")
    for name in ("nbclient", "ipykernel"):
        assert name in course
        assert f"\n{name}==" in pins
