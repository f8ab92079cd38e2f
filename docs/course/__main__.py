"""Run pages of the course, and write what they give into both languages: `python -m docs.course 52.2.1`.

Without names all pages are run. With `--check` nothing is written: exit code 1 and a line for every number,
text or figure that is no longer what is kept. A page whose header names a module that is not installed (ECOS
has no wheel for every Python) is left out, and said.
"""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor

from docs.course.pages import missing, names, only, pair_faults
from docs.course.run import run


def main(words: list[str] | None = None) -> int:
    """Run, then keep or compare; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pages", nargs="*", help="names of pages, or how they begin (default: all)")
    parser.add_argument("--check", action="store_true", help="compare with what is kept; write nothing")
    parser.add_argument("--jobs", type=int, default=1, help="pages at once")
    given = parser.parse_args(words)
    try:
        chosen = only(given.pages, names())
    except ValueError as error:
        parser.error(str(error))
    lacks = {name: module for name in chosen if (module := missing(name))}
    for name, module in lacks.items():
        print(f"{name} is left out: {module} is not installed")
    chosen = [name for name in chosen if name not in lacks]
    with ProcessPoolExecutor(given.jobs) as pool:
        faults = [line for lines in pool.map(_check if given.check else _keep, chosen) for line in lines]
    print(
        "\n".join(faults) if faults else f"{len(chosen)} pages {'are current' if given.check else 'written'}"
    )
    return 1 if faults else 0


def _check(name: str) -> list[str]:
    try:
        return pair_faults(name) + run(name).faults()
    except RuntimeError as error:
        return [str(error)]


def _keep(name: str) -> list[str]:
    try:
        run(name).keep()
    except RuntimeError as error:
        return [str(error)]
    return []


if __name__ == "__main__":
    sys.exit(main())
