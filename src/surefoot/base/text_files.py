"""What people write by hand: text and YAML files, and tables in them whose keys are known."""

from __future__ import annotations

import json
import math
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from surefoot.base.errors import ProblemError, one_line, shown, unknown_name

MOST = 64_000_000
"""Bytes of a text that are read at most: a device never ends."""


def path_of(value: object) -> Path:
    """Return the path that a text or path names, or raise for what is neither or names nothing anywhere."""
    text = isinstance(value, (str, Path)) and "\0" not in str(value)
    if not text or max(map(len, Path(str(value)).parts), default=0) > 255:  # letters of a name
        raise ProblemError(f"a file is named by a text or a Path that a disk can hold, got {shown(value)}")
    return Path(str(value))


def free_path(path: Path | str) -> Path:
    """Return a path that nothing stands at, or refuse it: nothing that exists is overwritten."""
    place = path_of(path)
    if place.exists():
        raise ProblemError(f"{place} exists already")
    return place


def read_text(path: Path | str, what: str = "") -> str:
    """Return what a text file holds, or with "-" the standard input; `what` it is of, for the message.

    Raises
    ------
    ProblemError
        If it cannot be read, is not text, or is longer than `MOST`.
    """
    named = f"cannot read {what}{' ' if what else ''}{path}: "
    try:
        if str(path) == "-":
            content = sys.stdin.buffer.read(MOST + 1)
        else:
            with path_of(path).open("rb") as file:
                content = file.read(MOST + 1)
        if len(content) > MOST:
            raise ProblemError(f"{named}longer than {MOST // 1_000_000} MB")
        return content.decode("utf-8-sig")
    except OSError as error:
        raise ProblemError(f"{named}{error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ProblemError(f"{named}not text") from error


def read_yaml(path: Path | str, what: str = "") -> Any:
    """Return what a YAML file holds; `what` it is of, for the message.

    Raises
    ------
    ProblemError
        If it cannot be read, is not YAML, or says a key twice.
    """
    return parse_yaml(read_text(path, what), path)


def parse_yaml(text: str, name: object, foreign_tags: bool = False) -> Any:
    """Return what a YAML text holds; `name` is what errors call it.

    With `foreign_tags`, values whose tag asks for a class of somebody's are read as what they look like.
    """
    import yaml

    try:
        loader: Any = yaml.SafeLoader(text)
        root = loader.get_single_node()
        for node in _nodes(root) if foreign_tags else ():
            if node.tag not in loader.yaml_constructors:
                node.tag = loader.resolve(type(node), getattr(node, "value", None), (True, False))
        content = None if root is None else loader.construct_document(root)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise ProblemError(f"{name} is not YAML: {' '.join(str(error).split())[:200]}") from error
    _check_keys(root, name)
    return content


def _nodes(root: Any) -> Iterator[Any]:
    """Yield the nodes of a document, each once though aliases come again."""
    import yaml

    nodes, seen = [root], set[int]()
    while nodes:
        node = nodes.pop()
        if node is None or id(node) in seen:
            continue
        seen.add(id(node))
        yield node
        if isinstance(node, yaml.SequenceNode):
            nodes += node.value
        elif isinstance(node, yaml.MappingNode):
            nodes += [part for pair in node.value for part in pair]


def _check_keys(root: Any, name: object) -> None:
    """Refuse a key that stands twice in a mapping: YAML's readers keep the last in silence."""
    import yaml

    for node in _nodes(root):
        pairs = node.value if isinstance(node, yaml.MappingNode) else []
        keys = Counter(key.value for key, _ in pairs if isinstance(key, yaml.ScalarNode))
        for key, count in keys.items():
            if count > 1:
                line = node.start_mark.line + 1
                raise ProblemError(f"{name}: the key {key} stands twice in the mapping at line {line}")


def read_json(path: Path | str, what: str = "") -> Any:
    """Return what a JSON file holds; `what` it is of, for the message.

    Raises
    ------
    ProblemError
        If it cannot be read, is not JSON, or says a key twice.
    """
    text = read_text(path, what)
    try:
        return json.loads(text, object_pairs_hook=_once)
    except ProblemError as error:
        raise ProblemError(f"{path}: {error}") from error
    except (ValueError, RecursionError) as error:  # a whole number may have too many digits
        raise ProblemError(f"{path} is not JSON: {one_line(error)}") from error


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return a mapping, or refuse a key that stands twice in it: JSON's reader keeps the last in silence."""
    table = dict(pairs)
    if len(table) < len(pairs):
        key = next(key for key, count in Counter(key for key, _ in pairs).items() if count > 1)
        raise ProblemError(f"the key {shown(key)} stands twice in a mapping")
    return table


def table_of(
    where: str, value: Any, keys: Sequence[str] | None = None, required: Sequence[str] = ()
) -> dict[str, Any]:
    """Return a table of names if it holds no other keys than `keys` (None: any), and the required ones.

    Raises
    ------
    ProblemError
        Naming what is wrong `where`.
    """
    if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
        named = "names" if keys is None else f"the keys {', '.join(keys)}"
        raise ProblemError(f"{where} must be a mapping of {named}, got {shown(value)}")
    for key in value if keys is not None else ():
        if key not in (keys or ()):
            raise ProblemError(f"{where}: {unknown_name('key', key, keys or ())}")
    for key in required:
        if key not in value:
            raise ProblemError(f"{where}: {key} is missing")
    return value


def plain_value(value: Any) -> Any:
    """Return a value as JSON can hold it: arrays as lists, NaN and infinity as null."""
    if isinstance(value, dict):
        return {str(k): plain_value(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain_value(v) for v in value]
    if hasattr(value, "tolist"):
        return plain_value(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def finite_in_text(name: str, text: str) -> float:
    """Return the finite number that a text holds, or raise a ProblemError that names it."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ProblemError(f"{name}: {text!r} is not a finite number")
    return value
