"""The site's search: English by words, Chinese by pairs of characters, since no spaces part its words."""

from __future__ import annotations

import re
from itertools import pairwise

from sphinx.search.en import SearchEnglish


class SearchPairs(SearchEnglish):
    """Search that finds any piece of a Chinese text, on a page without a server, too.

    Sphinx takes a run of Chinese characters for one word, and finds parts of it only where they are three
    characters or more and no page has them as a run of their own.
    """

    lang = "pairs"
    js_splitter_code = r"""
var splitQuery = (query) =>
  (query.match(/[\u4e00-\u9fff]+|(?:(?![\u4e00-\u9fff])[\p{L}\p{N}_])+/gu) ?? []).flatMap((run) =>
    /^[\u4e00-\u9fff]{2}/.test(run) ? [...run].slice(1).map((next, k) => run[k] + next) : [run]);
"""

    def split(self, input: str) -> list[str]:
        """Return the words of a text: for a run of Chinese each character and each pair of neighbours."""
        words: list[str] = []
        for run in _RUN.findall(input):
            chinese = "\u4e00" <= run[0] <= "\u9fff"
            words += [*run, *map("".join, pairwise(run))] if chinese else [run]
        return words


_RUN = re.compile(r"[\u4e00-\u9fff]+|[^\W\u4e00-\u9fff]+")
