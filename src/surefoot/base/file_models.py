"""Files against their models: pydantic decides what fits, and what does not is one line in our words.

A model is a `TypedDict` of what may stand in a file, with `FILE` as its configuration: no other keys, and no
value that only looks like what is wanted. What a file leaves out stays out of the result, so each default
stands once, where it is used. A model's module is imported by the function that reads a file, not before:
pydantic takes a quarter of a second to load.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from typing import Annotated, Any, TypeVar, cast

from pydantic import BeforeValidator, ConfigDict, Field, TypeAdapter, ValidationError
from pydantic.json_schema import GenerateJsonSchema

from surefoot.base.errors import ProblemError, shown, unknown_name

T = TypeVar("T")
Schema = dict[str, Any]
Loc = tuple[int | str, ...]

FILE = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, use_attribute_docstrings=True)
"""Configuration of every table in a file."""
_EXPONENT = re.compile(r"[-+]?(\.\d+|\d+(\.\d*)?)[eE][-+]?\d+")
"""Numbers that YAML 1.1 takes for texts, as 2e5 and 1.5e3 (1.5e+3 it knows)."""
_WORST = {"extra_forbidden": 0, "invalid_key": 0, "missing": 1}
"""Which of several errors is said: one about a key explains those about values."""
_NAMES: dict[str, str] = {
    "number": "a number", "integer": "a whole number", "string": "a text", "boolean": "true or false",
    "null": "null",
}  # fmt: skip


def _number(value: object) -> object:
    """Return the number that YAML 1.1 took for a text; anything else as it is."""
    return float(value) if isinstance(value, str) and _EXPONENT.fullmatch(value) else value


def _whole(value: object) -> object:
    """Return 5 for 5.0 and for 5e0, anything else as it is."""
    value = _number(value)
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _text(value: object) -> object:
    """Return a number as the text that it is where a name is wanted; anything else as it is."""
    return str(value) if type(value) in (int, float) else value


def _tuple(value: object) -> object:
    """Return a list as a tuple, anything else as it is."""
    return tuple(value) if isinstance(value, list) else value


YAML = BeforeValidator(_number)
"""Stands last in the annotation of a YAML file's number, after its bounds."""
WHOLE = BeforeValidator(_whole)
"""Stands last in the annotation of a whole number."""
TUPLE = BeforeValidator(_tuple)
"""Stands last in the annotation of a tuple, which is a list in a file."""
Number = Annotated[float, YAML]
"""A finite number of a YAML file."""
AnyNumber = Annotated[float, Field(allow_inf_nan=True), YAML]
"""A number of a YAML file that may be infinite; whether it makes sense its user says."""
Name = Annotated[str, BeforeValidator(_text)]
"""A name, which may look like a number."""


def read_as(form: type[T], content: Any, spoken: bool = False) -> T:
    """Return what a file holds if it fits a model.

    Parameters
    ----------
    form
        The model, a `TypedDict`.
    content
        As YAML or JSON has it.
    spoken
        Whether errors call an entry ``ice[0] mu``, as one would say it, and not ``ice[0]: mu``.

    Raises
    ------
    ProblemError
        For the first thing that does not fit: its place, what is wanted there, and what is.
    """
    try:
        return cast("T", _adapter(form).validate_python(content))
    except ValidationError as error:
        told = error.errors(include_url=False, include_context=True)
        raise ProblemError(_Refusal(schema_of(form), content, spoken).of(told)) from error


def schema_of(form: type) -> Schema:
    """Return a model as JSON Schema (2020-12)."""
    made = _adapter(form).json_schema(schema_generator=_FileSchema)
    for part in made.get("$defs", {}).values():
        part.pop("title", None)  # the names of our classes say nothing to who writes a file
    return {"$schema": _FileSchema.schema_dialect, **made}


def schema_text(form: type) -> str:
    """Return the JSON schema of a model as its file holds it; a description of several lines becomes one."""
    return json.dumps(schema_of(form), indent=2, ensure_ascii=False).replace("\\n", " ") + "\n"


_adapter: Callable[[Any], TypeAdapter[Any]] = cache(TypeAdapter)
"""What checks a model, built once."""


class _FileSchema(GenerateJsonSchema):
    """Schemas without a title for each field: its key is its name."""

    def field_title_should_be_set(self, schema: Any) -> bool:
        return False


class _Refusal:
    """One line for what pydantic says of a file: it tells the place, the schema tells what is wanted there.

    Parameters
    ----------
    schema
        Of the model.
    content, spoken
        See `read_as`.
    """

    def __init__(self, schema: Schema, content: Any, spoken: bool) -> None:
        self.schema, self.content, self.spoken = schema, content, spoken

    def of(self, told: Sequence[Any]) -> str:
        """Return the line for the worst of some errors."""
        rank: Callable[[Any], int] = lambda error: _WORST.get(error["type"], 2)  # noqa: E731
        worst = min(map(rank, told))
        errors = [error for error in told if rank(error) == worst]
        path, _ = self._walk(errors[0]["loc"])
        # of the branches of a union the one that got furthest is the one that was meant
        inside = [e for e in errors if e["loc"][: len(path)] == path]
        return self._line(max(inside, key=lambda e: len(self._walk(e["loc"])[0])))

    def _line(self, error: Any) -> str:
        kind, loc = error["type"], error["loc"]
        if kind in ("extra_forbidden", "missing"):
            *above, key = loc
            path, table = self._walk(tuple(above))
            where = _path_text(path) if path else "the file"
            if kind == "missing":
                return f"{where} needs the key {key!r}" if self.spoken else f"{where}: {key} is missing"
            return self._unknown(path, key, table.get("properties", ()))
        path, node = self._walk(loc[:-1] if kind == "invalid_key" or loc[-1:] == ("[key]",) else loc)
        return self._value(kind, path, node, error)

    def _unknown(self, path: Loc, key: object, valid: Iterable[str]) -> str:
        """Return the line for a key that no table of its place has."""
        where = _path_text(path)
        if self.spoken:
            return unknown_name(f"key of {where}" if where else "key", key, valid)
        return f"{where or 'the file'}: {unknown_name('key', key, valid)}"

    def _value(self, kind: str, path: Loc, node: Schema, error: Any) -> str:
        """Return the line for a value."""
        place, value = self._place(path), self._entry_at(path, error["input"])
        if kind == "value_error":
            return f"{place} {error['ctx']['error']}, got {shown(value)}"
        if kind == "finite_number" and not _bounds(node):
            return f"{place} is {'NaN' if value != value else 'infinite'}"
        if _names(node):
            above, _, key = place.rpartition(": ")
            return f"{above and f'{above}: '}{unknown_name(key, value, _names(node))}"
        names = [name for each in node.get("anyOf", ()) for name in _names(each)]
        also = f"; valid names: {', '.join(names)}" if names else ""
        return f"{place} must be {self._expectation(node)}, got {shown(value)}{also}"

    def _expectation(self, node: Schema) -> str:
        """Return what a schema's node asks for, in words."""
        node = self._resolve(node)
        if "anyOf" in node:
            branches = [each for each in map(self._resolve, node["anyOf"]) if not _names(each)]
            *most, last = [self._expectation(each) for each in branches]
            return f"{', '.join(most)} or {last}" if most else last
        kind = node.get("type", "")
        if kind == "array":
            return f"a list{_size(node)}"
        if kind != "object":
            return f"{_NAMES.get(kind, 'something else')}{_bounds(node)}"
        if "properties" not in node:
            return "a mapping of names"
        keys = ", ".join(node["properties"])
        return "a mapping of keys" if self.spoken else f"a mapping of the keys {keys}"

    def _place(self, path: Loc) -> str:
        """Return what the entry at a path is called: the table that holds it, then its key."""
        last = max((k for k, part in enumerate(path) if isinstance(part, str)), default=0)
        above, entry = _path_text(path[:last]), _path_text(path[last:])
        if not entry:
            return "the file"
        return f"{above}{' ' if self.spoken else ': '}{entry}" if above else entry

    def _entry_at(self, path: Loc, read: Any) -> Any:
        """Return what the file has at a path; what was `read` where a model takes several forms for one."""
        found = self.content
        for part in path:
            try:
                found = found[part]
            except (LookupError, TypeError):
                return read
        return found

    def _walk(self, loc: Loc, node: Schema | None = None) -> tuple[Loc, Schema]:
        """Return how far a location leads in the schema, without the tags of unions, and the node there."""
        node = self._resolve(self.schema if node is None else node)
        if not loc:
            return (), node
        below = self._below(node, loc[0])
        if below is not None:
            path, found = self._walk(loc[1:], below)
            return (loc[0], *path), found
        ways = [self._walk(loc[1:], each) for each in node.get("anyOf", ())]
        return max((way for way in ways if way[0]), key=lambda way: len(way[0]), default=((), node))

    def _below(self, node: Schema, part: int | str) -> Schema | None:
        """Return the node of an entry of a table or list; None for what is no entry."""
        if isinstance(part, int):
            found = node.get("items")
        else:
            found = node.get("properties", {}).get(part, node.get("additionalProperties"))
        return {} if found is True else found or None

    def _resolve(self, node: Schema) -> Schema:
        """Return a node in place of a reference to it, and what is no null in place of what may be null."""
        if "$ref" in node:
            node = self.schema["$defs"][node["$ref"].rsplit("/", 1)[-1]]
        some = [each for each in node.get("anyOf", ()) if each != {"type": "null"}]
        return self._resolve(some[0]) if len(some) == 1 else node


def _path_text(path: Sequence[int | str]) -> str:
    """Return a path as text; a key is a file's, and a file's may be long or of several lines.

    >>> _path_text(("phases", 0, "contacts", 2))
    'phases[0].contacts[2]'
    """
    parts = (f"[{part}]" if isinstance(part, int) else f".{shown(part)[1:-1]}" for part in path)
    return "".join(parts).removeprefix(".")


def _names(node: Schema) -> list[str]:
    """Return the texts that a node takes, if it takes only some."""
    return node["enum"] if "enum" in node else [node["const"]] if "const" in node else []


def _bounds(node: Schema) -> str:
    """Return a node's bounds in words, empty for none."""
    low, high = node.get("minimum"), node.get("maximum")
    if high is not None:
        return f" from {low:g} to {high:g}"
    above = node.get("exclusiveMinimum")
    return f" >= {low:g}" if low is not None else f" > {above:g}" if above is not None else ""


def _size(node: Schema) -> str:
    """Return how many entries a list has, in words, empty for any number."""
    least, most = node.get("minItems", 0), node.get("maxItems")
    if most is None:
        return f" of {least} entries or more" if least else ""
    return f" of {least} entries" if least == most else f" of {least} to {most}"
