"""A progress bar on stderr, for commands that take a while."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def progress_bar(shown: bool, label: str, total: float) -> Iterator[Callable[[float], None] | None]:
    """Show a progress bar on a terminal while the context lasts; yield the function that moves it."""
    from surefoot.cli.console import plain_console

    screen = plain_console(stderr=True)
    if not shown or not screen.is_terminal:
        yield None
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn(label), BarColumn(), TextColumn("{task.percentage:.0f} %"), TimeElapsedColumn())
    with Progress(*columns, console=screen, transient=True) as bar:
        task = bar.add_task(label, total=total if math.isfinite(total) else None)
        yield lambda done: bar.update(task, completed=done)
