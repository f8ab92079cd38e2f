"""What a run leaves where something cannot be written or drawn: the rest, and a line that says why."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import surefoot.app.cli.run_files as module
from surefoot.app.cli.console import plain_console
from surefoot.app.cli.run_files import RunFiles
from surefoot.base.errors import MissingExtra, ProblemError, WriteError

FULL = OSError(28, "No space left on device")


def raising(error: Exception) -> Callable[..., Any]:
    """Return a function that leaves half a file and raises an error."""

    def fail(*places: Any) -> None:
        path = places[-1]
        if not path.is_dir():
            path.write_text("half")
        raise error

    return fail


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RunFiles:
    """Return the files of a run whose log says nothing."""
    monkeypatch.setattr(module, "busy_line", lambda log: [])
    return RunFiles(SimpleNamespace(), tmp_path)  # type: ignore[arg-type]  # it is only handed on


def said(files: RunFiles, draw: Callable[..., Any] | None = None) -> str:
    """Return what is printed of a run."""
    text = io.StringIO()
    files.publish(plain_console(file=text), "a run", ("it stood", True), ((), ["3 s"]), draw)
    return text.getvalue()


def test_a_full_disk_costs_the_files_that_do_not_fit(files: RunFiles) -> None:
    files.write("a.txt", raising(FULL))
    files.write("b.txt", lambda path: path.write_text("whole"))
    files.write_summary({"fell": False})
    assert not (files.folder / "a.txt").exists()  # no half file
    assert (files.folder / "b.txt").read_text() == "whole"
    assert (files.folder / "summary.json").read_text().strip() == '{\n  "fell": false\n}'
    assert files.unwritten == [f"cannot write {files.folder / 'a.txt'}: No space left on device"]
    files.write("c.txt", raising(WriteError("c.txt", FULL, "; its rows are kept")))
    assert files.unwritten[1:] == ["cannot write c.txt: No space left on device; its rows are kept"]
    printed = said(files)
    assert all(line in printed for line in (*files.unwritten, "3 s", "it stood"))
    assert f"files: {files.folder}" in printed
    assert "report:" not in printed


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (ProblemError("nothing moved"), "nothing moved"),
        (MissingExtra("matplotlib", "viz"), "pictures left out: matplotlib is not installed"),
        (FULL, "No space left on device"),
    ],
)
def test_a_run_is_not_lost_for_want_of_a_picture(files: RunFiles, error: Exception, words: str) -> None:
    printed = said(files, raising(error))
    assert words in printed
    assert "it stood" in printed
    assert f"report: {files.folder / 'report.html'}" in printed
    assert "3 s" in (files.folder / "report.html").read_text()


@pytest.mark.parametrize(
    ("error", "words"),
    [(KeyboardInterrupt(), "no video: interrupted"), (FULL, "No space left on device"), (None, "")],
)
def test_a_film_is_shown_on_the_page_or_it_is_said_why_not(
    files: RunFiles, error: BaseException | None, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def film(log: Any, robot: Any, terrain: Any, path: Path, progress: Any, height: int) -> Path:
        path.write_bytes(b"film")
        if error is not None:
            raise error
        return path

    monkeypatch.setattr("surefoot.app.viz.film.write_video", film)
    files.film(None, None, None)  # type: ignore[arg-type]  # the film above needs none
    printed = said(files, lambda log, folder: [])
    page = (files.folder / "report.html").read_text()
    assert words in printed
    assert ("Forces as the world reports them" in page) == (error is None)
    if error is FULL:
        assert not (files.folder / "film.mp4").exists()
    assert not files.unwritten


def test_an_empty_folder_is_not_named(files: RunFiles) -> None:
    printed = said(files)
    assert "files:" not in printed
    assert "report:" not in printed
