"""Build the documentation site: `python -m docs.site` writes docs/build/html, or says what is wrong."""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from docs.site.assemble import ROOT, assemble
from docs.site.links import broken_links, loaded_from_outside, undocumented
from docs.site.reference import public_names

BUILD = ROOT / "docs" / "build"
PLACES = {"en": ("html", "en"), "zh": ("html/zh", "zh_CN")}
"""By language: where its pages go, and Sphinx's name for it."""
PARTIAL = "suppress_warnings=toc.not_included,ref.python,myst.xref_missing"
"""With some of the course's pages only, links to the others lead nowhere; the rest is as in conf.py."""


def main() -> int:
    """Assemble, build both languages, look for broken links; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pages", nargs="*", help="names of course pages to run (default: all)")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    given, start = parser.parse_args(), time.monotonic()
    shutil.rmtree(BUILD / "html", ignore_errors=True)  # what an older build left must not hide a broken link
    trees = assemble(BUILD, given.pages, given.jobs)
    ran = time.monotonic() - start
    for language, tree in trees.items():
        words = [] if given.pages is None else ["-D", PARTIAL]
        code = sphinx(tree, BUILD / PLACES[language][0], PLACES[language][1], given.jobs, words)
        if code:
            return code
    html = BUILD / "html"
    names = [name for names in public_names().values() for name in names if name != "laws"]
    faults = broken_links(html) + loaded_from_outside(html) + undocumented(html, names)
    if given.pages is not None:
        faults = [fault for fault in faults if "course/" not in fault]
    print("\n".join(faults) if faults else f"{html / 'index.html'}: no broken link, nothing from outside")
    print(f"course {ran:.0f} s, all {time.monotonic() - start:.0f} s")
    return 1 if faults else 0


def sphinx(source: Path, out: Path, language: str, jobs: int, more: Sequence[str] = ()) -> int:
    """Run Sphinx, warnings as errors, with `more` words of its command line."""
    words = [
        "-q",
        "-W",
        "--keep-going",
        "-E",
        "-j",
        str(jobs),
        "-c",
        str(Path(__file__).parent),
        "-D",
        f"language={language}",
        *more,
    ]
    cache = source.with_name(f"cache-{language}")
    return subprocess.call([sys.executable, "-m", "sphinx", *words, "-d", str(cache), str(source), str(out)])


if __name__ == "__main__":
    sys.exit(main())
