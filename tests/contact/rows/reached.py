"""Columns that blocks of rows reach, for solvers that are called on their own."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.contact import fill_columns


def columns_of(J: FloatArray, table: IntArray) -> IntArray:
    """Return the (blocks, n + 1) numbers of columns that each block reaches, and which they are."""
    found = np.full((len(table), J.shape[1] + 1), -1, dtype=np.int64)
    fill_columns(J, table, found)
    return found
