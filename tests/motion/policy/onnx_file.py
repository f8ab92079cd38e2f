"""ONNX files written by hand: one matrix product and one sum, so that tests need no exporter."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike


def _varint(value: int) -> bytes:
    out = b""
    while value > 127:
        out, value = out + bytes([value & 127 | 128]), value >> 7
    return out + bytes([value])


def _field(number: int, content: int | str | bytes) -> bytes:
    """Return a field of a protobuf message: a number, or a text or message with its length."""
    if isinstance(content, int):
        return _varint(number << 3) + _varint(content)
    data = content.encode() if isinstance(content, str) else content
    return _varint(number << 3 | 2) + _varint(len(data)) + data


def _value(name: str, size: int) -> bytes:
    shape = b"".join(_field(1, _field(1, n)) for n in (1, size))
    return _field(1, name) + _field(2, _field(1, _field(1, 1) + _field(2, shape)))


def _node(kind: str, inputs: tuple[str, str], output: str) -> bytes:
    return b"".join(_field(1, name) for name in inputs) + _field(2, output) + _field(4, kind)


def _tensor(name: str, values: np.ndarray) -> bytes:
    dims = b"".join(_field(1, n) for n in values.shape)
    return dims + _field(2, 1) + _field(8, name) + _field(9, values.astype("<f4").tobytes())


def write_onnx(
    path: Path,
    weights: ArrayLike,
    bias: ArrayLike,
    metadata: Mapping[str, str] | None = None,
    name: str = "obs",
) -> Path:
    """Write y = x W + b with W (inputs, outputs), and metadata as texts."""
    W, b = np.asarray(weights), np.asarray(bias)
    graph = (
        _field(1, _node("MatMul", (name, "W"), "h")) + _field(1, _node("Add", ("h", "b"), "actions"))
        + _field(2, "g") + _field(5, _tensor("W", W)) + _field(5, _tensor("b", b))
        + _field(11, _value(name, W.shape[0])) + _field(12, _value("actions", W.shape[1]))
    )  # fmt: skip
    notes = [_field(14, _field(1, key) + _field(2, value)) for key, value in (metadata or {}).items()]
    path.write_bytes(_field(1, 8) + _field(7, graph) + _field(8, _field(2, 13)) + b"".join(notes))
    return path
