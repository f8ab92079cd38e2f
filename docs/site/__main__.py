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


def main() -> int:
    """Assemble, build both languages, look for broken links; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    given, start = parser.parse_args(), time.monotonic()
    shutil.rmtree(BUILD / "html", ignore_errors=True)  # what an older build left must not hide a broken link
    for language, tree in assemble(BUILD).items():
        code = sphinx(tree, BUILD / PLACES[language][0], PLACES[language][1], given.jobs)
        if code:
            return code
    html = BUILD / "html"
    shutil.copytree(
        ROOT / "docs" / "images", html / "docs" / "images"
    )  # README's pictures are HTML of its own
    names = [name for names in public_names().values() for name in names if name != "laws"]
    faults = broken_links(html) + loaded_from_outside(html) + undocumented(html, names)
    print("\n".join(faults) if faults else f"{html / 'index.html'}: no broken link, nothing from outside")
    print(f"{time.monotonic() - start:.0f} s")
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
        *(
            ["-D", "nb_code_prompt_show=显示检验单元的代码", "-D", "nb_code_prompt_hide=收起代码"]
            if language == "zh_CN"
            else []
        ),
        *more,
    ]
    cache = source.with_name(f"cache-{language}")
    return subprocess.call([sys.executable, "-m", "sphinx", *words, "-d", str(cache), str(source), str(out)])


if __name__ == "__main__":
    sys.exit(main())
