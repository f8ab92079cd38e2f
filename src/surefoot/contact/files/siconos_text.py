"""Siconos text files: local friction problems and linear complementarity problems.

A friction problem u = W r + q is: dimension, number of contacts, W, q, mu. An LCP is: size, a matrix, q. Text
may follow, numbers may not.

A matrix is its storage (0 dense, 1 blocks), rows, columns, and then

- dense: rows, columns, and the entries *column by column*, whatever the line breaks suggest;
- blocks: their number, block rows, block columns, where block rows and columns end, the filled parts of the
  two index arrays, the arrays, and each block's number with its entries column by column.

The format was read off what Siconos 4.4 writes and how it reads that back. Limits: global problems (M, H) and
sparse matrices, which it writes with six digits, are read from FCLIB's files.
"""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ProblemError
from surefoot.contact.files.foreign import check_dense, from_foreign, turned
from surefoot.contact.problem.lcp import LCP
from surefoot.contact.problem.problem import ContactProblem

DENSE, BLOCKS = 0, 1
LARGEST = 2**31
"""Whole numbers in a file are below this."""


class _Numbers:
    """The words of a file, most of them numbers, read one after the other."""

    def __init__(self, path: Path) -> None:
        try:
            self.words = path.read_text(encoding="utf-8", errors="replace").split()
        except OSError as error:
            raise ProblemError(f"cannot read {path}: {error.strerror}") from error
        self.name, self.at = path.name, 0

    def floats(self, count: int) -> FloatArray:
        """Return the next `count` numbers."""
        words = self.words[self.at : self.at + count]
        try:
            found = np.array(words, dtype=np.float64)
        except ValueError as error:
            text = next(word for word in words if not _is_number(word))
            raise ProblemError(f"{self.name}: expected numbers, got {text[:20]!r}") from error
        if count < 0 or len(words) < count:
            raise ProblemError(f"{self.name}: ends before the problem does")
        self.at += count
        return found

    def integers(self, count: int) -> IntArray:
        """Return the next `count` whole numbers, which can count or index something."""
        words, found = self.words[self.at : self.at + count], self.floats(count)
        if not ((found == np.floor(found)) & (found >= 0) & (found < LARGEST)).all():
            raise ProblemError(f"{self.name}: expected whole numbers, got {' '.join(words)[:40]}")
        return found.astype(np.int64)

    def integer(self) -> int:
        """Return the next whole number."""
        return int(self.integers(1)[0])

    def ahead(self) -> int:
        """Return how many numbers follow before the next word that is none."""
        for count, word in enumerate(islice(self.words, self.at, None)):
            if not _is_number(word):
                return count
        return len(self.words) - self.at

    def end(self, contacts: int = 0) -> None:
        """Refuse numbers after the problem, whatever they mean; older files close with a bare 0 or 1."""
        left = self.words[self.at : self.at + self.ahead()]
        if left[-1:] in (["0"], ["1"]) and len(left) + self.at == len(self.words):
            left = left[:-1]
        if left:
            guess = "; rolling friction is not supported" if len(left) == contacts else ""
            raise ProblemError(
                f"{self.name}: numbers are left over after the problem ({len(left)}, the first is {left[0]})"
                + guess
            )


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def read(path: Path) -> ContactProblem:
    """Return the contact problem of a Siconos friction file."""
    numbers = _Numbers(path)
    dimension, count = (int(i) for i in numbers.integers(2))
    if dimension == 5:
        raise ProblemError(f"{path.name}: rolling friction (dimension 5) is not supported")
    if dimension not in (2, 3):
        raise ProblemError(f"{path.name}: the dimension must be 2 or 3, got {dimension}")
    size = dimension * count
    matrix = _read_matrix(numbers)
    if matrix.shape != (size, size):
        raise ProblemError(
            f"{path.name}: a {matrix.shape[0]}x{matrix.shape[1]} matrix is not W of {count} contacts "
            f"({size}x{size}); global problems are read from FCLIB's .hdf5"
        )
    q = numbers.floats(size)
    mu = numbers.floats(count)
    numbers.end(count)
    return from_foreign(matrix, q, mu, dimension, path.name)


def read_lcp(path: Path) -> LCP:
    """Return the linear complementarity problem of a Siconos LCP file."""
    numbers = _Numbers(path)
    size = numbers.integer()
    matrix = _read_matrix(numbers)
    q = numbers.floats(size)
    numbers.end()
    check_dense(f"{path.name}: a matrix", *matrix.shape)
    return LCP(matrix.toarray() if sp.issparse(matrix) else matrix, q)


def holds_lcp(path: Path) -> bool:
    """Tell by its first numbers whether a Siconos file holds an LCP: size, storage, size, size."""
    try:
        numbers = _Numbers(path)
        size, storage, rows, columns = numbers.integers(4)
    except ProblemError:
        return False
    return bool(storage in (DENSE, BLOCKS) and rows == columns == size)


def _read_matrix(numbers: _Numbers) -> FloatArray | sp.csr_matrix:
    storage, rows, columns = (int(i) for i in numbers.integers(3))
    # vectors of both lengths follow, so what is left is longer: looked at before memory is asked for
    if storage in (DENSE, BLOCKS) and max(rows, columns) > len(numbers.words) - numbers.at:
        raise ProblemError(f"{numbers.name}: a matrix is {rows}x{columns}, more than the file can hold")
    if storage == DENSE:
        again = tuple(int(i) for i in numbers.integers(2))
        if again != (rows, columns):
            raise ProblemError(f"{numbers.name}: a matrix is {rows}x{columns} and then {again[0]}x{again[1]}")
        return numbers.floats(rows * columns).reshape(columns, rows).T
    if storage == BLOCKS:
        return _read_blocks(numbers, rows, columns)
    raise ProblemError(
        f"{numbers.name}: the matrix storage must be 0 (dense) or 1 (blocks), got {storage}; sparse ones are "
        "read from FCLIB's .hdf5"
    )


def _read_blocks(numbers: _Numbers, rows: int, columns: int) -> sp.csr_matrix:
    blocks, block_rows, block_columns = (int(i) for i in numbers.integers(3))
    row_ends = np.concatenate([[0], numbers.integers(block_rows)])
    column_ends = np.concatenate([[0], numbers.integers(block_columns)])
    filled = [int(i) for i in numbers.integers(2)]
    starts, where = numbers.integers(filled[0]), numbers.integers(filled[1])
    if (
        not 1 <= filled[0] <= block_rows + 1
        or int(starts[-1]) > min(filled[1], blocks)
        or (np.diff(starts) < 0).any()
        or (where >= block_columns).any()
        or any((np.diff(e) <= 0).any() or e[-1] != n for e, n in ((row_ends, rows), (column_ends, columns)))
    ):
        raise ProblemError(f"{numbers.name}: the block structure contradicts itself")
    full = sp.lil_matrix((rows, columns))
    for block_row in range(filled[0] - 1):
        for at in range(int(starts[block_row]), int(starts[block_row + 1])):
            numbers.integer()  # the block's number
            r = slice(int(row_ends[block_row]), int(row_ends[block_row + 1]))
            c = slice(int(column_ends[where[at]]), int(column_ends[where[at] + 1]))
            height, width = r.stop - r.start, c.stop - c.start
            full[r, c] = numbers.floats(height * width).reshape(width, height).T
    return full.tocsr()


def write(problem: ContactProblem, path: Path) -> None:
    """Write a contact problem as a Siconos friction file."""
    n = problem.contacts
    back = np.argsort(turned(n))
    W = problem.G[np.ix_(back, back)]
    lines = ["3", str(n), "0", str(3 * n), str(3 * n), f"{3 * n}\t{3 * n}"]
    # entries go column by column; W is symmetric, so that its rows are its columns
    lines += [" ".join(f"{x:.17e}" for x in row) for row in W]
    lines.append(" ".join(f"{x:.17e}" for x in problem.g[back]))
    lines.append(" ".join(f"{x:.17e}" for x in problem.mu))
    with path.open("x", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
