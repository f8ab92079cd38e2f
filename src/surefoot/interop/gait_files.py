"""Gaits in OCS2's file format: mode sequences and switching times in Boost's INFO notation.

A file lists its gaits and holds one block for each::

    list
    {
      [0] trot
    }
    trot
    {
      modeSequence
      {
        [0] LF_RH
        [1] RF_LH
      }
      switchingTimes
      {
        [0] 0.00
        [1] 0.25
        [2] 0.50
      }
    }

Modes are named by the stance feet (LF, RF, LH, RH in this order; STANCE for all, FLY for none) or
given as numbers. A block with ``eventTimes`` in place of ``switchingTimes`` is a mode schedule.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np

from surefoot.arrays import BoolArray
from surefoot.errors import ProblemError, unknown_name
from surefoot.stance.contact_schedule import ContactSchedule
from surefoot.stance.gait import Gait, ModeSchedule, mode_feet
from surefoot.text_files import read_text

QUADRUPED = ("LF", "RF", "LH", "RH")
BIPED = ("LF", "RF")
LABELS: dict[int, tuple[str, ...]] = {2: BIPED, 4: QUADRUPED}

Tree: TypeAlias = "dict[str, str | Tree]"


def mode_name(number: int, labels: Sequence[str] = QUADRUPED) -> str:
    """Return OCS2's name of a mode.

    >>> mode_name(9), mode_name(15), mode_name(0)
    ('LF_RH', 'STANCE', 'FLY')
    """
    return named_mode(mode_feet(number, len(labels)), labels)


def named_mode(stands: Sequence[bool] | BoolArray, labels: Sequence[str]) -> str:
    """Return OCS2's name of the mode in which the feet (n,) stand that are said to."""
    if all(stands):
        return "STANCE"
    return "_".join(name for name, on in zip(labels, stands, strict=True) if on) or "FLY"


def mode_from_name(name: str, labels: Sequence[str] = QUADRUPED) -> int:
    """Return the number of a mode given by name or as a number.

    Raises
    ------
    ProblemError
        If the name holds an unknown foot; the message lists the valid ones.

    Examples
    --------
    >>> mode_from_name("RF_LH"), mode_from_name("STANCE")
    (6, 15)
    """
    if name == "STANCE":
        return int(2 ** len(labels) - 1)
    if name == "FLY":
        return 0
    if name.isdigit():
        mode_feet(int(name), len(labels))
        return int(name)
    number = 0
    for foot in name.split("_"):
        if foot not in labels:
            raise ProblemError(unknown_name(f"foot in mode {name!r}:", foot, [*labels, "STANCE", "FLY"]))
        bit = 1 << (len(labels) - 1 - labels.index(foot))
        if number & bit:
            raise ProblemError(f"mode {name!r} names {foot} twice")
        number |= bit
    return number


def read_gaits(path: Path | str, feet: int = 4) -> dict[str, ContactSchedule]:
    """Read every gait and mode schedule of a file.

    Parameters
    ----------
    path
        A file in OCS2's format.
    feet
        Number of feet: 4 or 2.

    Raises
    ------
    ProblemError
        If the file cannot be read, its braces do not match, or a gait in it is wrong.
    """
    out = parse_gaits(read_text(path, "the gait file"), feet)
    if not out:
        raise ProblemError(f"{path} holds no gait: a block with modeSequence and switchingTimes")
    return out


def parse_gaits(text: str, feet: int = 4) -> dict[str, ContactSchedule]:
    """Return every gait and mode schedule in a text; see `read_gaits`."""
    if feet not in LABELS:
        raise ProblemError(f"OCS2's modes name 2 or 4 feet, got {feet}")
    labels = LABELS[feet]
    out: dict[str, ContactSchedule] = {}
    for name, block in _blocks(_parse(text)):
        modes = [mode_from_name(m, labels) for m in _entries(name, "modeSequence", block)]
        if "switchingTimes" in block:
            times = _numbers(name, "switchingTimes", block)
            out[name] = Gait(name, np.array(times) - times[0], modes, feet)
        elif "eventTimes" in block:
            out[name] = ModeSchedule(_numbers(name, "eventTimes", block), modes, feet)
        else:
            raise ProblemError(f"gait {name} needs switchingTimes or eventTimes")
    return out


def write_gaits(gaits: Mapping[str, ContactSchedule], path: Path | str) -> Path:
    """Write gaits and mode schedules to a new file in OCS2's format and return its path.

    Raises
    ------
    ProblemError
        If the file exists already, or a schedule is not for two or four feet.
    """
    target = Path(path)
    if target.exists():
        raise ProblemError(f"{target} exists already")
    target.write_text(format_gaits(gaits))
    return target


def format_gaits(gaits: Mapping[str, ContactSchedule]) -> str:
    """Return gaits and mode schedules as text in OCS2's format."""
    parts = [listed("list", list(gaits))]
    for name, gait in gaits.items():
        if gait.feet not in LABELS or not isinstance(gait, (Gait, ModeSchedule)):
            raise ProblemError(
                f"gait {name} cannot be written: OCS2's modes name 2 or 4 feet, got {gait.feet}"
            )
        labels = LABELS[gait.feet]
        times, key = (
            (gait.switching, "switchingTimes") if isinstance(gait, Gait) else (gait.event_times, "eventTimes")
        )
        modes = listed("modeSequence", [mode_name(int(m), labels) for m in gait.modes])
        parts.append(block(name, modes + listed(key, [f"{t:.12g}" for t in times])))
    return "\n".join("\n".join(part) + "\n" for part in parts)


def listed(name: str, entries: Sequence[str]) -> list[str]:
    """Return the lines of a list in INFO notation: ``[0] a``, ``[1] b`` and so on."""
    return block(name, [f"[{k}] {entry}" for k, entry in enumerate(entries)])


def block(name: str, lines: Sequence[str]) -> list[str]:
    """Return the lines of a block in INFO notation."""
    return [name, "{", *("  " + line for line in lines), "}"]


def _blocks(tree: Tree, name: str = "gait") -> list[tuple[str, Tree]]:
    """Return every block that holds a mode sequence, with its name."""
    if "modeSequence" in tree:
        return [(name, tree)]
    return [found for key, value in tree.items() if isinstance(value, dict) for found in _blocks(value, key)]


def _entries(name: str, key: str, block: Tree) -> list[str]:
    """Return the values of a list ``[0] a [1] b ...`` in order."""
    items = block[key]
    if not isinstance(items, dict):
        raise ProblemError(f"gait {name}: {key} must be a block")
    out = []
    for k in range(len(items)):
        value = items.get(f"[{k}]")
        if not isinstance(value, str):
            raise ProblemError(f"gait {name}: {key} lacks entry [{k}]")
        out.append(value)
    return out


def _numbers(name: str, key: str, block: Tree) -> list[float]:
    values = _entries(name, key, block)
    try:
        return [float(v) for v in values]
    except ValueError as error:
        raise ProblemError(f"gait {name}: {key} must hold numbers: {error}") from error


def _parse(text: str) -> Tree:
    """Return INFO notation as nested dictionaries; ``;`` and ``#`` start comments."""
    words: list[list[str]] = []
    for line in text.splitlines():
        plain = re.split(r"[;#]", line)[0]
        words.extend(
            [part] if part in "{}" else part.split() for part in re.split(r"([{}])", plain) if part.strip()
        )
    root: Tree = {}
    stack, last = [root], ""
    for entry in words:
        if entry == ["{"]:
            if not last:
                raise ProblemError("gait file: '{' without a name before it")
            inner: Tree = {}
            stack[-1][last] = inner
            stack.append(inner)
            last = ""
        elif entry == ["}"]:
            if len(stack) == 1:
                raise ProblemError("gait file: '}' without '{'")
            stack.pop()
            last = ""
        else:
            pairs = _pairs(entry)
            for key, value in pairs:
                if key in stack[-1]:
                    raise ProblemError(f"gait file: {key} is given twice")
                stack[-1][key] = value
            last = pairs[-1][0]
    if len(stack) > 1:
        raise ProblemError("gait file: '{' without '}'")
    return root


def _pairs(words: list[str]) -> list[tuple[str, str]]:
    """Split the words of a line into keys and values; several ``[k] value`` pairs may share a line."""
    if all(re.fullmatch(r"\[\d+\]", w) for w in words[::2]) and len(words) % 2 == 0:
        return [(key, value.strip('"')) for key, value in zip(words[::2], words[1::2], strict=True)]
    return [(words[0].strip('"'), " ".join(words[1:]).strip('"'))]
