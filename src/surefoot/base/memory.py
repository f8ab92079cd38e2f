"""Memory as a value: what an object keeps from one step to the next, copied, compared, and written down.

An object that is used step by step names in `MEMORY` the attributes that last. Its memory is then a
dictionary of plain values, which another object made in the same way can take over: it goes on as the first
would have. By that objects go to other processes, see `Remade`.
"""

from __future__ import annotations

import copy
import dataclasses
import math
from collections import deque
from collections.abc import Iterable, Mapping
from enum import Enum
from typing import Any, ClassVar, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from surefoot.base.errors import ProblemError

State = TypeVar("State")
Memory: TypeAlias = dict[str, Any]
"""Names of attributes and their values; that of a part with a memory of its own is a dictionary again."""
Arrays: TypeAlias = dict[str, NDArray[Any]]
"""Arrays by the path to them."""


class Remembering:
    """Something with a memory.

    Attributes
    ----------
    MEMORY
        Names of the attributes that last from one step to the next; those of base classes are added.
    """

    MEMORY: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def lasting_names(cls) -> tuple[str, ...]:
        """Return the names of all attributes that last."""
        return tuple(name for base in cls.__mro__ for name in base.__dict__.get("MEMORY", ()))

    def remembered(self) -> Memory:
        """Return a copy of what lasts, as far as there is any yet."""
        own = vars(self)
        return {name: _copied(own[name]) for name in self.lasting_names() if name in own}

    def resume(self, memory: Memory) -> None:
        """Go on from a memory, which stays as it is.

        Raises
        ------
        ProblemError
            For a memory of something else: other names, or arrays of another type or number of axes.
        """
        self._check(memory)
        for name, value in memory.items():
            part = getattr(self, name, None)
            if isinstance(part, Remembering):
                part.resume(value)
            elif isinstance(part, np.random.Generator):
                part.bit_generator.state = value
            else:
                setattr(self, name, copy.deepcopy(value))

    def _check(self, memory: Any) -> None:
        """Refuse a memory of something else."""
        own = type(self).__name__
        if not isinstance(memory, dict):
            raise ProblemError(f"the memory of a {own} must name what lasts, got a {type(memory).__name__}")
        known = self.lasting_names()
        for name, value in memory.items():
            if name not in known:
                raise ProblemError(f"a {own} does not remember {name!r}; it remembers {', '.join(known)}")
            now = getattr(self, name, None)
            if not (isinstance(now, np.ndarray) and isinstance(value, np.ndarray)):
                continue
            if (now.dtype, now.ndim) != (value.dtype, value.ndim):
                raise ProblemError(
                    f"{name} of a {own} has {now.ndim} axes of {now.dtype}, "
                    f"the memory has {value.ndim} of {value.dtype}"
                )


def _copied(value: Any) -> Any:
    """Return a copy of a value, the memory of a part that has one, or where a random generator stands."""
    if isinstance(value, Remembering):
        return value.remembered()
    if isinstance(value, np.random.Generator):
        return copy.deepcopy(value.bit_generator.state)
    return copy.deepcopy(value)


def alike(one: Any, other: Any) -> bool:
    """Return whether two values are the same to the last bit; NaN is like NaN.

    Examples
    --------
    >>> alike({"a": np.array([1.0, np.nan])}, {"a": np.array([1.0, np.nan])}), alike((1.0,), [1.0])
    (True, False)
    """
    one, other = (value.item() if isinstance(value, np.generic) else value for value in (one, other))
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        same = one.dtype == other.dtype and one.shape == other.shape
        return bool(same and one.tobytes() == other.tobytes())
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(alike(value, other[key]) for key, value in one.items())
    if isinstance(one, (list, tuple, deque)):
        return len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, float):
        return one == other or (math.isnan(one) and math.isnan(other))
    inside = _fields(one)
    return bool(one == other) if inside is None else alike(inside, _fields(other))


def _fields(value: Any) -> dict[str, Any] | None:
    """Return what an object of Surefoot's consists of; None for a plain value."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    return vars(value) if hasattr(value, "__dict__") else None


def write_down(value: Any, kinds: Mapping[str, type]) -> tuple[Arrays, Any]:
    """Return arrays by path, and the rest as what JSON can hold.

    Parameters
    ----------
    value
        Numbers, texts, None, arrays, and lists, tuples, sets, queues, dictionaries and objects of them.
    kinds
        By name the classes of the objects, those of enumerations included. One that has `_asdict`, as named
        tuples have, is made again of what that returns; any other of its attributes.

    Examples
    --------
    >>> arrays, facts = write_down({"a": np.zeros(2), "b": (1, math.inf)}, {})
    >>> sorted(arrays), facts
    (['a'], {'dict': [['a', {'array': 'a'}], ['b', {'tuple': [1, {'float': 'inf'}]}]]})
    >>> read_back(arrays, facts, {})
    {'a': array([0., 0.]), 'b': (1, inf)}
    """
    arrays: Arrays = {}
    return arrays, _written(value, "", arrays, {kind: name for name, kind in kinds.items()})


def _written(value: Any, path: str, arrays: Arrays, names: Mapping[type, str]) -> Any:
    """Return a value as what JSON can hold, its arrays put down by path."""
    if isinstance(value, np.ndarray):
        arrays[path] = value.copy()
        return {"array": path}
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, Enum) and type(value) in names:
        return {"enum": names[type(value)], "name": value.name}
    if value is None or type(value) in (bool, int, str):
        return value
    if isinstance(value, bytes):
        return {"bytes": value.hex()}
    if isinstance(value, float):
        return value if math.isfinite(value) else {"float": repr(value)}
    within = f"{path}." if path else ""
    if type(value) in names:
        fields = value._asdict() if hasattr(value, "_asdict") else _fields(value) or {}
        rest = {name: _written(part, within + name, arrays, names) for name, part in fields.items()}
        return {"kind": names[type(value)], "fields": rest}
    if isinstance(value, dict):
        items = [[_key(key), _written(one, f"{within}{key}", arrays, names)] for key, one in value.items()]
        return {"dict": items}
    if isinstance(value, deque):
        return {"deque": _each(value, within, arrays, names), "maxlen": value.maxlen}
    for kind in (list, tuple, set):
        if type(value) is kind:
            return {kind.__name__: _each(sorted(value) if kind is set else value, within, arrays, names)}
    raise TypeError(f"{path}: a memory cannot hold a {type(value).__name__}")


def _key(key: Any) -> Any:
    """Return a dictionary's key as what JSON can hold: a text, a number, or for a tuple of them a list."""
    return [_key(part) for part in key] if isinstance(key, tuple) else key


def _read_key(key: Any) -> Any:
    """Return the key that `_key` has made a list of."""
    return tuple(_read_key(part) for part in key) if isinstance(key, list) else key


def _each(parts: Iterable[Any], within: str, arrays: Arrays, names: Mapping[type, str]) -> list[Any]:
    """Return each of some values as what JSON can hold."""
    return [_written(part, f"{within}{k}", arrays, names) for k, part in enumerate(parts)]


def read_back(arrays: Arrays, facts: Any, kinds: Mapping[str, type]) -> Any:
    """Return the value that `write_down` has put into arrays and facts."""
    if not isinstance(facts, dict):
        return facts

    def inside(parts: Any) -> list[Any]:
        return [read_back(arrays, part, kinds) for part in parts]

    (what, held), *more = facts.items()
    if what == "array":
        return arrays[held].copy()
    if what == "float":
        return float(held)
    if what == "bytes":
        return bytes.fromhex(held)
    if what == "dict":
        return {_read_key(key): read_back(arrays, part, kinds) for key, part in held}
    if what == "enum":
        return kinds[held][more[0][1]]  # type: ignore[index]
    if what == "kind":
        fields = {name: read_back(arrays, part, kinds) for name, part in more[0][1].items()}
        return _made(kinds[held], fields)
    if what == "deque":
        return deque(inside(held), maxlen=more[0][1])
    return {"list": list, "tuple": tuple, "set": set}[what](inside(held))


def _made(kind: type, fields: dict[str, Any]) -> Any:
    """Return an object of a class with given fields, as it was when it was written down."""
    if hasattr(kind, "_asdict"):
        return kind(**fields)
    if dataclasses.is_dataclass(kind):
        known = {field.name for field in dataclasses.fields(kind)}
        if fields.keys() != known:
            wrong = ", ".join(sorted(fields.keys() ^ known))
            raise ValueError(f"a {kind.__name__} is not made of these fields: {wrong}")
    out: Any = object.__new__(kind)
    for name, value in fields.items():
        object.__setattr__(out, name, value)
    return out


def read_state(kind: type[State], owner: str, arrays: Arrays, facts: Any, kinds: Mapping[str, type]) -> State:
    """Return the state of a class that `write_down` has put into arrays and facts.

    Parameters
    ----------
    kind, owner
        Class of the state, and what it is one of, for the message: "a walk".
    arrays, facts, kinds
        As for `read_back`.

    Raises
    ------
    ProblemError
        For arrays and facts that are no such state.
    """
    try:
        state = read_back(arrays, facts, kinds)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise ProblemError(f"this is no state of {owner}: {type(error).__name__} at {error}") from error
    if not isinstance(state, kind):
        raise ProblemError(f"this is no state of {owner}")
    return state


class Remade:
    """Something that pickle, cloudpickle and deepcopy make anew and put into its state, to the last bit.

    What an engine or a compiled function holds cannot be pickled; what it was made of can. The arguments that
    it was made with are kept, arrays as copies. A subclass has `state` and `resume`, or says by `_lasting`
    and `_go_on` what else lasts.
    """

    _made_with: tuple[tuple[Any, ...], dict[str, Any]]

    def __new__(cls, *arguments: Any, **options: Any) -> Any:
        """Keep what it is made with."""
        self = super().__new__(cls)
        self._made_with = (
            tuple(map(_copy_array, arguments)),
            {name: _copy_array(one) for name, one in options.items()},
        )
        return self

    def _lasting(self) -> Any:
        """Return all that lasts, as a value that can be pickled."""
        return self.state  # type: ignore[attr-defined]

    def _go_on(self, lasting: Any) -> None:
        """Go on from what `_lasting` gave."""
        self.resume(lasting)  # type: ignore[attr-defined]

    def __reduce__(self) -> tuple[Any, ...]:
        return remake, (type(self), *self._made_with), (self._lasting(),)

    def __setstate__(self, state: tuple[Any]) -> None:
        self._go_on(*state)


def remake(kind: type, arguments: tuple[Any, ...], options: dict[str, Any]) -> Any:
    """Return an object of a class, made with these arguments."""
    return kind(*arguments, **options)


def _copy_array(value: Any) -> Any:
    """Return an argument as it is now, whatever its owner writes into it later."""
    return value.copy() if isinstance(value, np.ndarray) else value
