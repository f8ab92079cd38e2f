"""Siconos text files: friction problems u = W r + q and linear complementarity problems.

A friction problem is: dimension, number of contacts, a matrix, q, mu; an LCP is: size, a matrix, q. A
matrix is its storage (0 dense, 1 blocks), rows, columns, and then either rows, columns and the entries row
by row, or the blocks: their number, block rows, block columns, where block rows and columns end, the filled
parts of the two index arrays, the arrays, and each block's number with its entries column by column. Text
may follow.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import scipy.sparse as sp

from surefoot.arrays import FloatArray, IntArray
from surefoot.contact.files import from_foreign, turned
from surefoot.contact.lcp import LCP
from surefoot.contact.problem import ContactProblem
from surefoot.errors import ProblemError


class _Numbers:
    """The numbers of a file, read one after the other."""

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
            raise ProblemError(f"{self.name}: expected numbers after word {self.at}") from error
        if count < 0 or found.size < count:
            raise ProblemError(f"{self.name}: ends before the problem does")
        self.at += count
        return found

    def integers(self, count: int) -> IntArray:
        """Return the next `count` whole numbers."""
        found = self.floats(count)
        if (found != np.floor(found)).any():
            raise ProblemError(f"{self.name}: expected whole numbers before word {self.at}")
        return found.astype(np.int64)

    def integer(self) -> int:
        """Return the next whole number."""
        return int(self.integers(1)[0])


def read(path: Path) -> ContactProblem:
    """Return the contact problem of a Siconos friction file."""
    numbers = _Numbers(path)
    dimension, count = numbers.integers(2)
    matrix = _read_matrix(numbers)
    q = numbers.floats(int(dimension * count))
    mu = numbers.floats(int(count))
    return from_foreign(matrix, q, mu, int(dimension), path.name)


def read_lcp(path: Path) -> LCP:
    """Return the linear complementarity problem of a Siconos LCP file."""
    numbers = _Numbers(path)
    size = numbers.integer()
    matrix = _read_matrix(numbers)
    return LCP(matrix.toarray() if sp.issparse(matrix) else matrix, numbers.floats(size))


def holds_lcp(path: Path) -> bool:
    """Tell by its first numbers whether a Siconos file holds an LCP: size, storage, size, size."""
    try:
        size, storage, rows, columns = _Numbers(path).integers(4)
    except ProblemError:
        return False
    return bool(storage in (0, 1) and rows == columns == size)


def _read_matrix(numbers: _Numbers) -> FloatArray | sp.csr_matrix:
    storage, rows, columns = numbers.integers(3)
    if storage == 0:
        rows, columns = numbers.integers(2)
        return numbers.floats(int(rows * columns)).reshape(rows, columns)
    if storage != 1:
        raise ProblemError(
            f"{numbers.name}: the matrix storage must be 0 (dense) or 1 (blocks), got {storage}"
        )
    blocks, block_rows, block_columns = (int(i) for i in numbers.integers(3))
    row_ends = np.concatenate([[0], numbers.integers(block_rows)])
    column_ends = np.concatenate([[0], numbers.integers(block_columns)])
    filled = [int(i) for i in numbers.integers(2)]
    starts, where = numbers.integers(filled[0]), numbers.integers(filled[1])
    if filled[0] < 1 or int(starts[-1]) > min(filled[1], blocks) or (np.diff(starts) < 0).any():
        raise ProblemError(f"{numbers.name}: the block structure contradicts itself")
    full = sp.lil_matrix((int(rows), int(columns)))
    for block_row in range(filled[0] - 1):
        for at in range(int(starts[block_row]), int(starts[block_row + 1])):
            numbers.integer()  # the block's number
            r = slice(int(row_ends[block_row]), int(row_ends[block_row + 1]))
            c = slice(int(column_ends[where[at]]), int(column_ends[where[at] + 1]))
            height, width = r.stop - r.start, c.stop - c.start
            full[r, c] = numbers.floats(height * width).reshape(width, height).T
    return full.tocsr()


def write(problem: ContactProblem, path: Path) -> None:
    """Write a contact problem as a Siconos friction file, in blocks if G is sparse."""
    n = problem.contacts
    back = np.argsort(turned(n))
    lines = ["3", str(n)]
    blocks = problem.blocks
    if n >= 8 and blocks.density < 0.4:
        lines += _block_lines(problem)
    else:
        W = problem.G[np.ix_(back, back)]
        lines += ["0", str(3 * n), str(3 * n), f"{3 * n}\t{3 * n}"]
        lines += [" ".join(f"{x:.17e}" for x in row) for row in W]
    lines.append(" ".join(f"{x:.17e}" for x in problem.g[back]))
    lines.append(" ".join(f"{x:.17e}" for x in problem.mu))
    with path.open("x", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


def _block_lines(problem: ContactProblem) -> list[str]:
    n, b = problem.contacts, problem.blocks
    count = b.columns.size
    ends = "\t".join(str(3 * (k + 1)) for k in range(n))
    lines = ["1", str(3 * n), str(3 * n), str(count), str(n), str(n), ends, ends, str(n + 1), str(count)]
    lines += ["\t".join(map(str, b.starts)), "\t".join(map(str, b.columns))]
    normal_first = np.array([2, 0, 1])
    for at in range(count):
        block = b.values[at][np.ix_(normal_first, normal_first)]
        lines.append(str(at))
        lines += [f"{x:.17e}" for x in block.T.ravel()]
    return lines
