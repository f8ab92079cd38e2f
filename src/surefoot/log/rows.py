"""Rows of a log in memory, each a block of bytes, so that a whole row is written at once."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from operator import attrgetter, itemgetter
from typing import Any

import numpy as np

from surefoot.log.channels import Channel

_dtype = attrgetter("dtype")


class RowMemory:
    """A bounded number of rows of channels.

    A row's single numbers come first, then its arrays of numbers, then its arrays of flags.

    Parameters
    ----------
    channels
        Of a row; their sizes are numbers.
    count
        Number of rows.

    Attributes
    ----------
    arrays
        Name to (count, ...) array, to be read and written; all share the memory of the rows.
    """

    def __init__(self, channels: Iterable[Channel], count: int) -> None:
        self._channels = tuple(channels)
        order = sorted(
            range(len(self._channels)),
            key=lambda k: (bool(self._channels[k].row_shape), self._channels[k].flag),
        )
        placed = [self._channels[k] for k in order]
        singles = [c for c in placed if not c.row_shape]
        vectors = [c for c in placed if c.row_shape]
        pattern = "=" + "".join("?" if c.flag else "d" for c in singles)
        pattern += f"{-struct.calcsize(pattern) % 8}x"  # so that arrays are aligned
        self._pack, self._singles = struct.Struct(pattern).pack, len(singles)
        self._dtypes = [c.dtype for c in vectors]
        self._shapes, self._fit = [c.row_shape for c in vectors], False
        self._lengths = [shape[0] for shape in self._shapes]
        self._sorted = itemgetter(*order) if len(order) > 1 else tuple
        flags = sum(c.flag for c in singles)
        begins = [8 * k for k in range(len(singles) - flags)]
        begins += [8 * (len(singles) - flags) + k for k in range(flags)]
        end = struct.calcsize(pattern)
        for channel in vectors:
            begins.append(end)
            end += channel.dtype.itemsize * int(np.prod(channel.row_shape))
        self._used, self._size = end, max(end + -end % 8, 8)
        table = np.zeros(
            count,
            np.dtype(
                {
                    "names": [c.name for c in placed],
                    "formats": [(c.dtype, c.row_shape) for c in placed],
                    "offsets": begins,
                    "itemsize": self._size,
                }
            ),
        )
        self._memory = table.view(np.uint8).data
        self.arrays: dict[str, Any] = {c.name: table[c.name] for c in self._channels}

    def write(self, at: int, values: Sequence[Any]) -> None:
        """Write row `at`: one value for every channel, in their order, that can be assigned to its row.

        Raises
        ------
        ValueError, TypeError
            For a value that does not fit its channel.
        """
        values = self._sorted(values)
        vectors = values[self._singles :]
        try:
            plain = [*map(_dtype, vectors)] == self._dtypes and [*map(len, vectors)] == self._lengths
            if plain and (self._fit or self._fits(vectors)):
                start = at * self._size
                row = b"".join((self._pack(*values[: self._singles]), *vectors))
                self._memory[start : start + self._used] = row
                return
        except (AttributeError, TypeError, ValueError, BufferError, struct.error):
            pass  # of another kind, size or order in memory: NumPy knows what can be assigned
        for channel, value in zip(self._sorted(self._channels), values, strict=True):
            self.arrays[channel.name][at] = value

    def _fits(self, vectors: Sequence[Any]) -> bool:
        """Tell whether arrays have their channels' shapes; once they had, lengths and a row's size tell."""
        self._fit = [value.shape for value in vectors] == self._shapes
        return self._fit
