"""Limits on the size of a robot's file, held before any parser builds something of it.

Parsers work on what they are given: Pinocchio's runs out of stack on a chain of thousands of links, its Data
grows with the cube of the joints (0.7 GB at 200, 4.4 GB at 400), MuJoCo's unrolls replicates in replicates.
The file is read as a stream of tags here, and nothing of it is kept.
"""

from __future__ import annotations

import math
from pathlib import Path
from xml.parsers import expat

from surefoot.base.errors import ModelError

MOST_BYTES = 64_000_000
"""Bytes of a file, includes among them each by themselves."""
MOST_JOINTS = 250
"""Joints that move: a humanoid with two hands has about 80."""
MOST_LINKS = 1000
"""Links or bodies, and how deep tags may nest; parsers call themselves for each of a chain."""
MOST_PARTS = 100_000
"""Tags of an MJCF file, with those that replicates repeat: terrains of boxes have thousands."""
MOST_CELLS = 1 << 26
"""Numbers of a texture, a height field or MuJoCo's own memory in an MJCF file [-]: 64 million."""
MOST_FILES = 50
"""Files that one MJCF file includes."""


def check_size(path: Path) -> None:
    """Refuse a file whose robot would be too large to build; what is no XML is left to its parser.

    Raises
    ------
    ModelError
        Naming the count and the limit.
    """
    _Counter(path).count(path)


class _Counter:
    """Counts tags of a file and of those that it includes."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.links = self.joints = self.parts = self.files = 0
        self.urdf = False

    def count(self, path: Path, times: int = 1) -> None:
        """Count one file, whose tags stand for so many each."""
        self.files += 1
        if self.files > MOST_FILES:
            raise self._refusal("files", f"{self.files}", MOST_FILES)
        try:
            if path.stat().st_size > MOST_BYTES:
                raise self._refusal("bytes", f"{path.stat().st_size} in {path.name}", MOST_BYTES)
            file = path.open("rb")
        except OSError:
            return  # its parser says so
        repeats = [times]
        parser = expat.ParserCreate()

        def begin(tag: str, given: dict[str, str]) -> None:
            repeats.append(min(repeats[-1] * _repetition(tag, given), 1 << 62))
            if len(repeats) > MOST_LINKS:
                raise self._refusal("nested tags", f"{len(repeats)}", MOST_LINKS)
            self._take(tag, given, repeats[-1])
            if tag in ("include", "model") and given.get("file"):
                self.count(path.parent / given["file"], repeats[-1])

        parser.StartElementHandler = begin
        parser.EndElementHandler = lambda tag: repeats.pop()
        with file:
            try:
                parser.ParseFile(file)
            except ModelError:
                raise
            except (expat.ExpatError, ValueError):
                return  # its parser says so

    def _take(self, tag: str, given: dict[str, str], times: int) -> None:
        """Count a tag."""
        if self.parts == 0:
            self.urdf = tag == "robot"
        self.parts += times
        self.links += times * (tag in ("link", "body"))
        if tag == "joint":  # those of URDF's transmissions have no type, those of MJCF's tendons name another
            moves = (
                given.get("type", "fixed") != "fixed" if self.urdf else not {"joint", "joint1"} & set(given)
            )
            self.joints += times * moves
        for kind, number, most in (
            ("links", self.links, MOST_LINKS), ("joints that move", self.joints, MOST_JOINTS),
            ("tags", self.parts, MOST_PARTS), ("numbers", _cells(tag, given), MOST_CELLS),
        ):  # fmt: skip
            if number > most:
                raise self._refusal(kind, f"{number} in <{tag}>" if kind == "numbers" else f"{number}", most)

    def _refusal(self, kind: str, found: str, most: int) -> ModelError:
        return ModelError(f"{self.path} is too large for a robot: {kind}: {found}, at most {most} are read")


def _repetition(tag: str, given: dict[str, str]) -> int:
    """Return how often MuJoCo makes what a tag holds."""
    if tag not in ("replicate", "composite", "flexcomp"):
        return 1
    counts = [_whole(word) for word in given.get("count", "1").split()]
    return max(1, math.prod(counts))


def _cells(tag: str, given: dict[str, str]) -> int:
    """Return how many numbers a tag asks memory for."""
    if tag == "texture":
        return 3 * _whole(given.get("width", "0")) * max(_whole(given.get("height", "0")), 1)
    if tag == "hfield":
        return _whole(given.get("nrow", "0")) * _whole(given.get("ncol", "0"))
    if tag == "size":
        small = (_whole(given.get(key, "0")) for key in ("nuserdata", "nkey", "nconmax", "njmax"))
        return max(*small, _bytes(given.get("memory", "0")) // 32, _bytes(given.get("nstack", "0")))
    return 0


def _bytes(text: str) -> int:
    """Return a number of bytes as MuJoCo reads it: 16K, 3M, 1G."""
    unit = {"k": 10, "m": 20, "g": 30, "t": 40, "p": 50, "e": 60}.get(text[-1:].lower())
    return _whole(text if unit is None else text[:-1]) << (unit or 0)


def _whole(text: str) -> int:
    """Return a whole number, 0 for what is none: its parser says so."""
    try:
        return min(abs(int(float(text))), 1 << 40)
    except (ValueError, OverflowError):
        return 0
