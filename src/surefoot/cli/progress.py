"""A progress bar on stderr, for commands that take a while."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def progress_bar(shown: bool, label: str, total: float) -> Iterator[Callable[[float], None] | None]:
    """Show a progress bar on stderr while the context lasts, and yield the function that moves it."""
    if not shown:
        yield None
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    from surefoot.cli.console import plain_console

    columns = (TextColumn(label), BarColumn(), TextColumn("{task.percentage:.0f} %"), TimeElapsedColumn())
    with Progress(*columns, console=plain_console(stderr=True), transient=True) as bar:
        task = bar.add_task(label, total=total if math.isfinite(total) else None)
        yield lambda done: bar.update(task, completed=done)
