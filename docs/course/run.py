"""Run a page of the course by nbclient, once for both languages; compare with what is kept, or keep it."""

from __future__ import annotations

import json
import os
import re
from dataclasses import dataclass
from functools import cache
from itertools import zip_longest
from multiprocessing.util import Finalize
from typing import Any

import nbformat
from jupyter_client.manager import KernelManager
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError

from docs.course.kernel import TWIN
from docs.course.pages import (
    COURSE,
    LANGUAGES,
    UNKEPT,
    code,
    expressions,
    filled,
    kept,
    notebook,
    said,
    source,
    with_code,
)

_LIMIT = 300
"""Longest that a cell may take [s]."""
_ROUNDING = re.compile(r"\d(?:\.\d+)?e-(?:0[89]|[1-9]\d)\b")
"""A number that is another on another processor: what rounding left of zero."""
_ERROR = re.compile(r"\d(?:\.\d+)?e-0[1-7]\b")
"""The size of an error, where a solver's own limit left it: elsewhere in that decade or the next."""
_ZERO = re.compile(r"(?<![\w.])-(0\.0*)(?!\d)")
"""A zero whose sign is a processor's."""


@dataclass(frozen=True)
class Ran:
    """A page that was run: by language its source with fresh numbers, and its notebook with outputs.

    `left` has the words of figures that have no Chinese in `labels.yaml`.
    """

    name: str
    texts: dict[str, str]
    books: dict[str, Any]
    left: list[str]

    def faults(self) -> list[str]:
        """Return where the kept files say something else than this run did."""
        if not all((COURSE.parent / path).exists() for path in self.books["en"].metadata.get("needs", [])):
            return []  # what was kept came with files that are not here
        out = [
            f"{self.name}: a figure says {word!r}: translate in docs/course/labels.yaml" for word in self.left
        ]
        for language in LANGUAGES:
            path = source(self.name, language)
            text = path.read_text(encoding="utf-8")
            out += [f"{language}/{path.name}: {line}" for line in _differences(text, self.texts[language])]
            out += [
                f"{language}/{path.stem}.ipynb, code cell {number}: {fresh}, kept is {old}"
                for number, (old, fresh) in enumerate(
                    zip_longest(said(kept(self.name, language)), said(self.books[language])), 1
                )
                if not is_same(str(old), str(fresh))
            ]
        return out

    def keep(self) -> None:
        """Write sources and notebooks."""
        for language in LANGUAGES:
            path = source(self.name, language)
            path.write_text(self.texts[language], encoding="utf-8")
            text = nbformat.writes(self.books[language], version=4)
            path.with_suffix(".ipynb").write_text(text + "\n", encoding="utf-8")


def _differences(kept: str, fresh: str) -> list[str]:
    return [
        f"line {number}: {new.strip()}, kept is {old.strip()}"
        for number, (old, new) in enumerate(zip(kept.splitlines(), fresh.splitlines(), strict=False), 1)
        if not is_same(old, new)
    ][:5]


def is_same(kept: str, fresh: str) -> bool:
    """Return whether texts are the same to their digits, but for what processors make differ."""
    errors = [[float(one) for one in _ERROR.findall(text)] for text in (kept, fresh)]
    return _digits(kept) == _digits(fresh) and all(
        0.1 <= new / old <= 10.0 for old, new in zip(*errors, strict=True)
    )


def _digits(text: str) -> str:
    """Return a text as it is compared: without signs of zeros, with errors' sizes left out."""
    return _ERROR.sub("error", _ROUNDING.sub("rounding", _ZERO.sub(r" \1", text)))


def run(name: str) -> Ran:
    """Run a page.

    Raises
    ------
    RuntimeError
        If a cell fails; its message names page and cell.
    """
    texts = {language: source(name, language).read_text(encoding="utf-8") for language in LANGUAGES}
    texts["zh"] = with_code(texts["zh"], code(texts["en"]))
    books = {language: notebook(text) for language, text in texts.items()}
    if [c.cell_type for c in books["en"].cells] != [c.cell_type for c in books["zh"].cells]:
        raise RuntimeError(f"{name}: texts and code stand in another order in Chinese")
    values: dict[str, list[Any]] = {language: [] for language in LANGUAGES}
    book = books["en"]
    client = NotebookClient(
        nbformat.v4.new_notebook(cells=[*book.cells, nbformat.v4.new_code_cell()]),
        timeout=_LIMIT,
        coalesce_streams=True,  # a slow machine sends what is printed in parts
        km=_kernel(),
    )
    with client.setup_kernel():
        _ask(client, "get_ipython().reset()")
        _ask(client, "from docs.course import kernel as _kernel; _kernel.set_up()")
        for number, (cell, twin) in enumerate(zip(book.cells, books["zh"].cells, strict=True)):
            if cell.cell_type == "code":
                _execute(client, name, cell, number)
            else:
                wanted = {"en": expressions(cell.source), "zh": expressions(twin.source)}
                if any(wanted.values()):
                    for language, one in wanted.items():
                        values[language] += json.loads(_ask(client, f"_kernel.values({one!r})"))
        client.kc.stop_channels()  # the kernel stays for the next page
    left = _share(books)
    for language in LANGUAGES:
        texts[language] = filled(texts[language], values[language], language)
        for cell, fresh in zip(books[language].cells, notebook(texts[language]).cells, strict=True):
            cell.source = fresh.source
    return Ran(name, texts, books, left)


@cache
def _kernel() -> KernelManager:
    """Return this process's kernel: page after page is run in it, what they import is imported once."""
    manager = KernelManager(kernel_name="python3")
    paths = [COURSE.parent, COURSE.parent / "src", os.environ.get("PYTHONPATH", "")]
    manager.start_kernel(
        extra_arguments=["--IPKernelApp.log_level=50"],
        cwd=str(COURSE.parent),
        env=os.environ | {"PYTHONPATH": os.pathsep.join(map(str, paths))},
    )
    Finalize(manager, manager.shutdown_kernel, kwargs={"now": True}, exitpriority=0)
    return manager


def _ask(client: NotebookClient, text: str) -> str:
    """Run a line that is not the page's; return what it prints."""
    cell = nbformat.v4.new_code_cell(text)
    client.execute_cell(cell, -1, store_history=False)  # the cell behind the page's
    return "".join(
        output.text for output in cell.outputs if output.output_type == "stream" and output.name == "stdout"
    )


def _execute(client: NotebookClient, name: str, cell: Any, number: int) -> None:
    try:
        client.execute_cell(cell, number)
    except CellExecutionError as error:
        fault = f"course/en/{name}.md, cell {number}: {error.ename}: {error.evalue}"
        raise RuntimeError(fault) from error
    for output in cell.outputs:
        if output.output_type == "error":  # while its figures were drawn
            raise RuntimeError(f"course/en/{name}.md, cell {number}: {output.ename}: {output.evalue}")
    cell.outputs = [
        output
        for output in cell.outputs
        if UNKEPT not in cell.metadata.get("tags", []) and output.get("name") != "stderr"
    ]


def _share(books: dict[str, Any]) -> list[str]:
    """Give the Chinese notebook the outputs, with its own figures; return what these left in English."""
    count, left = 0, []
    for cell, twin in zip(books["en"].cells, books["zh"].cells, strict=True):
        if cell.cell_type != "code":
            continue
        count += 1
        cell.execution_count = twin.execution_count = count
        cell.metadata.pop("execution", None)
        twin.outputs = [nbformat.from_dict(json.loads(json.dumps(output))) for output in cell.outputs]
        for output, other in zip(cell.outputs, twin.outputs, strict=True):
            if output.output_type == "display_data" and TWIN in output.data:
                chinese = other.data.pop(TWIN)
                left += chinese["left"]
                del output.data[TWIN]
                other.data["image/png"], other.data["text/plain"] = chinese["image"], chinese["alt"]
                other.metadata["image/png"]["alt"] = chinese["alt"]
    for book in books.values():
        book.metadata.pop("language_info", None)  # its version is the machine's
    return left
