"""Notebooks of the examples: each is a program in cells, and what it showed when it was run.

Run: python -m docs.notebooks [NAME...] runs the programs of examples/notebooks and writes the .ipynb beside
each; with --check nothing is run or written, and the exit code is 1 if a notebook has other cells than its
program.

The program is the source: Jupytext's percent format, which `jupytext --sync` and editors know. What is kept
of a run is what a reader looks at: texts and pictures, without times, paths and numbers of runs.
"""

from __future__ import annotations

import argparse
import base64
import io
import json
import os
import re
import sys
import tempfile
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parents[1] / "examples" / "notebooks"
PICTURE_BYTES = 60_000
"""Largest picture that is kept; one above it loses colours first."""
SECONDS = 600
"""Longest run of a cell."""
_CELL = re.compile(r"^# %%(?: \[(markdown)\])?\n", re.MULTILINE)
_COMPILES = re.compile(r"compiling .* once per machine.*")
_METADATA = {
    "jupytext": {"formats": "ipynb,py:percent"},
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"name": "python"},
}


def programs() -> list[Path]:
    """Return the programs, in their order."""
    return sorted(FOLDER.glob("[0-9]*.py"))


def read_cells(path: Path) -> list[tuple[str, str]]:
    """Return the cells of a program: "markdown" or "code", and the text.

    Raises
    ------
    ValueError
        If something stands before the first cell.
    """
    before, *parts = _CELL.split(path.read_text(encoding="utf-8"))
    if before.strip():
        raise ValueError(f"{path.name}: no cell begins with {before.strip().splitlines()[0]!r}")
    cells = []
    for kind, body in zip(parts[::2], parts[1::2], strict=True):
        text = body.strip("\n")
        if kind:
            text = "\n".join(line.removeprefix("#").removeprefix(" ") for line in text.splitlines())
        cells.append((kind or "code", text))
    return cells


def blank_notebook(path: Path) -> dict[str, Any]:
    """Return the notebook of a program without outputs; a cell's id is its place."""
    cells: list[dict[str, Any]] = []
    for number, (kind, text) in enumerate(read_cells(path), 1):
        cell = {"cell_type": kind, "id": f"cell-{number}", "metadata": {}, "source": text}
        cells.append(cell | ({"execution_count": None, "outputs": []} if kind == "code" else {}))
    return {"cells": cells, "metadata": _METADATA, "nbformat": 4, "nbformat_minor": 5}


def execute(path: Path) -> dict[str, Any]:
    """Run a program as a notebook, in a folder of its own, and return the notebook with what it showed.

    Raises
    ------
    nbclient.exceptions.CellExecutionError
        If a cell fails.
    ValueError
        If a cell wrote to standard error.
    """
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.from_dict(blank_notebook(path))
    with tempfile.TemporaryDirectory() as folder:
        places = {"IPYTHONDIR": f"{folder}/ipython", "JUPYTER_RUNTIME_DIR": f"{folder}/jupyter"}
        resources = {"metadata": {"path": folder}}
        client = NotebookClient(
            notebook, timeout=SECONDS, kernel_name="python3", resources=resources, coalesce_streams=True,
            extra_arguments=["--IPKernelApp.log_level=40"],  # errors alone: it warns of its own sockets
        )  # fmt: skip
        client.execute(env=os.environ | places)
    made: dict[str, Any] = json.loads(json.dumps(notebook))
    for cell in made["cells"]:
        cell["metadata"] = {}
        if cell["cell_type"] == "code":
            cell["execution_count"] = None
            cell["outputs"] = [kept for output in cell["outputs"] if (kept := tidy_output(output, path))]
    made["metadata"] = _METADATA
    return made


def tidy_output(output: dict[str, Any], path: Path) -> dict[str, Any] | None:
    """Return what is kept of an output: its text, or its picture with a text; None for nothing."""
    if output["output_type"] == "stream":
        text = _COMPILES.sub("", output["text"]) if output["name"] == "stderr" else output["text"]
        if output["name"] == "stderr" and text.strip():
            raise ValueError(f"{path.name} wrote to standard error: {text.strip()}")
        return {"name": "stdout", "output_type": "stream", "text": text} if text.strip() else None
    data = {kind: output["data"][kind] for kind in ("text/plain", "image/png") if kind in output["data"]}
    if "image/png" in data:
        small = shrink_picture(base64.b64decode(data["image/png"]))
        data["image/png"] = base64.b64encode(small).decode("ascii")
    return {"data": data, "metadata": {}, "output_type": "display_data"}


def shrink_picture(data: bytes) -> bytes:
    """Return a PNG picture of `PICTURE_BYTES` at most, of as many colours as that allows."""
    from PIL import Image

    image = Image.open(io.BytesIO(data)).convert("RGB")
    for colours in (256, 128, 64, 32, 16):
        if len(data) <= PICTURE_BYTES:
            break
        out = io.BytesIO()
        image.quantize(colours, dither=Image.Dither.NONE).save(out, "png", optimize=True)
        data = out.getvalue()
    return data


def write_notebook(path: Path) -> Path:
    """Run a program and write its notebook; return its path."""
    import nbformat

    target = path.with_suffix(".ipynb")
    text = nbformat.writes(nbformat.from_dict(execute(path)))  # texts line by line
    target.write_text(text + "\n", encoding="utf-8")
    return target


def differences(path: Path) -> list[str]:
    """Return in which cells a program's notebook says something else than the program; empty for none."""
    target = path.with_suffix(".ipynb")
    if not target.exists():
        return [f"{target.name} is missing"]
    cells = json.loads(target.read_text(encoding="utf-8"))["cells"]
    there = [(cell["cell_type"], "".join(cell["source"])) for cell in cells]
    asked = read_cells(path)
    if len(there) != len(asked):
        return [f"{target.name} has {len(there)} cells, {path.name} {len(asked)}"]
    return [
        f"{target.name}, cell {number}"
        for number, (one, other) in enumerate(zip(there, asked, strict=True), 1)
        if one != other
    ]


def main() -> int:
    """Write notebooks, or check them; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="programs without their ending; all without a name")
    parser.add_argument("--check", action="store_true", help="run and write nothing")
    given = parser.parse_args()
    known = {path.stem: path for path in programs()}
    if unknown := [name for name in given.names if name not in known]:
        parser.error(f"there is no notebook {', '.join(unknown)}; there are {', '.join(known)}")
    chosen = [known[name] for name in given.names or known]
    if given.check:
        faults = [fault for path in chosen for fault in differences(path)]
        print("\n".join(faults))
        return int(bool(faults))
    for path in chosen:
        print(write_notebook(path).name)
    return 0


if __name__ == "__main__":
    sys.exit(main())
