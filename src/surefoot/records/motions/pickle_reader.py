"""Pickles read as data: their opcodes are interpreted here, and nothing of a file is run."""

from __future__ import annotations

import pickletools
import warnings
from collections.abc import Callable, Mapping
from typing import IO, Any

from surefoot.base.errors import ProblemError, one_line
from surefoot.records.motions.pickled_parts import (
    CLASSES,
    ArrayPart,
    DtypePart,
    JoblibPart,
    Refused,
    checked_key,
)

MOST_NODES = 5_000_000
"""Opcodes that are read at most: 400,000 frames of twelve numbers as lists."""
DEEPEST = 10
"""Lists and mappings within each other at most."""

Named = tuple[str, Callable[..., Any]]


def class_of(path: str) -> Named:
    """Return what stands for a class that a pickle names, or refuse it."""
    if path not in CLASSES:
        torch = "; save tensors as arrays, tensor.numpy()" if path.startswith("torch.") else ""
        raise Refused(
            f"it asks for {path:.80}, and only arrays of NumPy and joblib, numbers, texts, lists and "
            f"mappings are read; nothing of it was run{torch}"
        )
    return path, CLASSES[path]


_MARK = object()


class PickleReader:
    """A reader of one pickle from a file, opcode by opcode."""

    def __init__(self, file: IO[bytes]) -> None:
        self.file = file
        self.stack: list[Any] = []
        self.memo: dict[int, Any] = {}

    def read(self) -> Any:
        """Return what the pickle holds, arrays as NumPy's, or raise `Refused`."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", DeprecationWarning)  # of escapes in a broken text
                return self._interpret()
        except (
            ValueError,
            IndexError,
            TypeError,
            KeyError,
            AttributeError,
            OverflowError,
            MemoryError,
        ) as error:
            if isinstance(error, ProblemError):
                raise
            raise Refused(f"it is cut or broken: {one_line(error)[:120] or type(error).__name__}") from error
        except RecursionError as error:
            raise Refused("its lists are nested too deeply") from error

    def _interpret(self) -> Any:
        """Carry out the opcodes up to the end, and return what is on top of the stack then."""
        for count, (opcode, argument, _) in enumerate(pickletools.genops(self.file)):
            if opcode.name == "STOP":
                return resolve_parts(self.stack.pop())
            if count > MOST_NODES:
                raise Refused(f"it has more than {MOST_NODES} parts: no motion has")
            self._do(opcode.name, argument)
        raise Refused("it is cut: its end is missing")

    def _do(self, name: str, argument: Any) -> None:
        """Carry out one opcode."""
        if name in VALUES:
            self.stack.append(argument)
        elif name in CONSTANTS:
            self.stack.append(CONSTANTS[name]())
        elif name in STEPS:
            STEPS[name](self, argument)
        else:
            raise Refused(
                f"it uses the opcode {name}, which arrays, numbers, texts, lists and mappings do not need"
            )

    def above_mark(self) -> list[Any]:
        """Return what was put on the stack since the last mark, and take it and the mark off."""
        places = range(len(self.stack) - 1, -1, -1)
        at = next((k for k in places if self.stack[k] is _MARK), None)
        if at is None:
            raise Refused("it is broken: a mark is missing")
        items = self.stack[at + 1 :]
        del self.stack[at:]
        return items

    def tuple_of(self, count: int) -> None:
        """Replace the last values by a tuple of them."""
        if len(self.stack) < count:
            raise Refused("it is broken: a tuple has too few values")
        items = tuple(self.stack[len(self.stack) - count :])
        del self.stack[len(self.stack) - count :]
        self.stack.append(items)

    def extend(self, items: list[Any]) -> None:
        """Append values to the list on top of the stack."""
        if not isinstance(self.stack[-1], list):
            raise Refused("it appends to what is no list")
        self.stack[-1].extend(items)

    def set_items(self, items: list[Any]) -> None:
        """Put keys and values, one after the other, into the mapping on top of the stack."""
        if not isinstance(self.stack[-1], dict):
            raise Refused("it puts keys into what is no mapping")
        for key, value in zip(items[::2], items[1::2], strict=True):
            self.stack[-1][checked_key(key)] = value

    def call(self) -> None:
        """Replace a named class and its arguments by what stands for that class here."""
        arguments, named_class = self.stack.pop(), self.stack.pop()
        if not isinstance(named_class, tuple) or len(named_class) != 2 or CLASSES.get(named_class[0]) is None:
            raise Refused("it calls what is no class")
        self.stack.append(CLASSES[named_class[0]](*arguments))

    def build(self) -> None:
        """Fill an array or a type with its state."""
        state, target = self.stack.pop(), self.stack[-1]
        if not isinstance(target, ArrayPart | DtypePart | JoblibPart):
            raise Refused(f"it sets the state of a {type(target).__name__}")
        target.fill(state)
        if isinstance(target, JoblibPart) and target.objects:
            target.value = PickleReader(self.file).read()
        elif isinstance(target, JoblibPart):
            target.take(self.file)

    def name_class(self) -> None:
        """Replace a module and a name by the class that they name."""
        name, module = self.stack.pop(), self.stack.pop()
        self.stack.append(class_of(f"{module}.{name}"))

    def remember(self, place: int) -> None:
        """Keep the value on top of the stack under a number."""
        self.memo[place] = self.stack[-1]


VALUES = frozenset(
    (
        *("INT", "LONG", "BININT", "BININT1", "BININT2", "LONG1", "LONG4", "FLOAT", "BINFLOAT"),
        *(
            "STRING",
            "BINSTRING",
            "SHORT_BINSTRING",
            "UNICODE",
            "BINUNICODE",
            "SHORT_BINUNICODE",
            "BINUNICODE8",
        ),
        *("BINBYTES", "SHORT_BINBYTES", "BINBYTES8", "BYTEARRAY8"),
    )
)
"""Opcodes whose argument is a value."""
CONSTANTS: Mapping[str, Callable[[], Any]] = {
    "NONE": lambda: None,
    "NEWTRUE": lambda: True,
    "NEWFALSE": lambda: False,
    "EMPTY_LIST": list,
    "EMPTY_TUPLE": tuple,
    "EMPTY_DICT": dict,
    "MARK": lambda: _MARK,
}
"""Opcodes that put a new value on the stack."""


def _set_one(reader: PickleReader, _: Any) -> None:
    value, key = reader.stack.pop(), reader.stack.pop()
    reader.set_items([key, value])


def _put(reader: PickleReader, value: Any) -> None:
    reader.stack.append(value)


STEPS: Mapping[str, Callable[[PickleReader, Any], None]] = {
    "PROTO": lambda _, __: None,
    "FRAME": lambda _, __: None,
    "POP": lambda reader, _: reader.stack.__delitem__(-1),
    "POP_MARK": lambda reader, _: reader.above_mark().clear(),
    "DUP": lambda reader, _: _put(reader, reader.stack[-1]),
    "LIST": lambda reader, _: _put(reader, reader.above_mark()),
    "DICT": lambda reader, _: _put_mapping(reader),
    "TUPLE": lambda reader, _: _put(reader, tuple(reader.above_mark())),
    "TUPLE1": lambda reader, _: reader.tuple_of(1),
    "TUPLE2": lambda reader, _: reader.tuple_of(2),
    "TUPLE3": lambda reader, _: reader.tuple_of(3),
    "APPEND": lambda reader, _: reader.extend([reader.stack.pop()]),
    "APPENDS": lambda reader, _: reader.extend(reader.above_mark()),
    "SETITEM": _set_one,
    "SETITEMS": lambda reader, _: reader.set_items(reader.above_mark()),
    "PUT": lambda reader, place: reader.remember(place),
    "BINPUT": lambda reader, place: reader.remember(place),
    "LONG_BINPUT": lambda reader, place: reader.remember(place),
    "MEMOIZE": lambda reader, _: reader.remember(len(reader.memo)),
    "GET": lambda reader, place: _put(reader, reader.memo[place]),
    "BINGET": lambda reader, place: _put(reader, reader.memo[place]),
    "LONG_BINGET": lambda reader, place: _put(reader, reader.memo[place]),
    "GLOBAL": lambda reader, path: _put(reader, class_of(path.replace(" ", "."))),
    "STACK_GLOBAL": lambda reader, _: reader.name_class(),
    "REDUCE": lambda reader, _: reader.call(),
    "NEWOBJ": lambda reader, _: reader.call(),
    "BUILD": lambda reader, _: reader.build(),
}
"""Opcodes that change the stack, and how."""


def _put_mapping(reader: PickleReader) -> None:
    items = reader.above_mark()
    reader.stack.append({})
    reader.set_items(items)


def resolve_parts(value: Any, depth: int = 0, left: list[int] | None = None) -> Any:
    """Return a value with arrays in place of the parts that stand for them; nested at most `DEEPEST` deep."""
    left = [MOST_NODES] if left is None else left
    left[0] -= 1
    if depth > DEEPEST or left[0] < 0:
        raise Refused("its lists are nested too deeply")
    if isinstance(value, ArrayPart | JoblibPart):
        return resolve_parts(value.value, depth + 1, left)
    if isinstance(value, dict):
        return {key: resolve_parts(one, depth + 1, left) for key, one in value.items()}
    if isinstance(value, list):
        return [resolve_parts(one, depth + 1, left) for one in value]
    if isinstance(value, tuple):
        if len(value) == 2 and value[1] is CLASSES.get(str(value[0]) if isinstance(value[0], str) else ""):
            return value[0]  # a class that stands alone, as the kind of an array does
        return tuple(resolve_parts(one, depth + 1, left) for one in value)
    return value
