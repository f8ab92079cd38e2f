"""Siconos text files: friction problems, local and global, and linear complementarity problems.

A local friction problem u = W r + q is: dimension, number of contacts, W, q, mu. A global one M v = H r + f,
u = Hᵀ v + w is: dimension, number of contacts, M, H, f, w, mu; it is condensed to its contacts. An LCP is:
size, a matrix, q. Text may follow, numbers may not.

A matrix is its storage (0 dense, 1 blocks, 2 sparse), rows, columns, and then

- dense: rows, columns, and the entries *column by column*, whatever the line breaks suggest;
- blocks: their number, block rows, block columns, where block rows and columns end, the filled parts of the
  two index arrays, the arrays, and each block's number with its entries column by column;
- sparse: what it was made as (1 triplets, 2 compressed columns), and CSparse's listing: a line about its
  version, a line with the shape and the number of entries, and the entries, "row column : value" or, for each
  column, "col j : locations a to b" and "row : value". Siconos writes them with six digits.

The format was read off what Siconos 4.4 writes and how it reads that back.
"""

from __future__ import annotations

import re
from itertools import islice
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from surefoot.arrays import FloatArray, IntArray
from surefoot.contact.foreign import check_dense, condensed, from_foreign, turned
from surefoot.contact.lcp import LCP
from surefoot.contact.problem import ContactProblem
from surefoot.errors import ProblemError

DENSE, BLOCKS, SPARSE = 0, 1, 2
TRIPLETS, COLUMNS = 1, 2
LARGEST = 2**31
"""Whole numbers in a file are below this."""
DIGITS = 6
BANNER = 40
"""Words among which the shape of a sparse matrix is looked for."""
SHAPE = re.compile(r"(\d+)-by-(\d+),?")


class _Numbers:
    """The words of a file, most of them numbers, read one after the other."""

    def __init__(self, path: Path) -> None:
        try:
            self.words = path.read_text(encoding="utf-8", errors="replace").split()
        except OSError as error:
            raise ProblemError(f"cannot read {path}: {error.strerror}") from error
        self.name, self.at = path.name, 0
        self.rough = False  # whether a sparse matrix was printed with `DIGITS` digits only

    def take(self, count: int) -> list[str]:
        """Return the next `count` words."""
        if count < 0 or count > len(self.words) - self.at:
            raise ProblemError(f"{self.name}: ends before the problem does")
        self.at += count
        return self.words[self.at - count : self.at]

    def floats(self, count: int) -> FloatArray:
        """Return the next `count` numbers."""
        found = self.numeric(self.words[self.at : self.at + count])
        self.take(count)
        return found

    def numeric(self, words: list[str]) -> FloatArray:
        """Return words as numbers."""
        try:
            return np.array(words, dtype=np.float64)
        except ValueError as error:
            text = next(word for word in words if not _is_number(word))
            raise ProblemError(f"{self.name}: expected numbers, got {text[:20]!r}") from error

    def integers(self, count: int) -> IntArray:
        """Return the next `count` whole numbers."""
        found = self.whole(self.words[self.at : self.at + count])
        self.take(count)
        return found

    def whole(self, words: list[str]) -> IntArray:
        """Return words as whole numbers that can count or index something."""
        found = self.numeric(words)
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
    """Return the contact problem of a Siconos friction file, local or global."""
    numbers = _Numbers(path)
    dimension, count = (int(i) for i in numbers.integers(2))
    if dimension == 5:
        raise ProblemError(f"{path.name}: rolling friction (dimension 5) is not supported")
    if dimension not in (2, 3):
        raise ProblemError(f"{path.name}: the dimension must be 2 or 3, got {dimension}")
    size = dimension * count
    notes: tuple[str, ...] = ()
    matrix = _read_matrix(numbers)
    if _holds_global(numbers, matrix.shape, size, count):
        H = _read_matrix(numbers)
        f, w = numbers.floats(matrix.shape[0]), numbers.floats(size)
        matrix, q = condensed(matrix, H, f, w)
    else:
        q = numbers.floats(size)
        if numbers.rough and sp.issparse(matrix):
            matrix = matrix.astype(np.float32)  # as fine as its digits, and then judged as such
            notes = (f"sparse, written with {DIGITS} digits: known to single precision only",)
    mu = numbers.floats(count)
    numbers.end(count)
    return from_foreign(matrix, q, mu, dimension, path.name, notes=notes)


def _holds_global(numbers: _Numbers, shape: tuple[int, ...], size: int, contacts: int) -> bool:
    """Tell whether a matrix H follows M: by its storage and sizes, and that a local problem would not end."""
    head = numbers.words[numbers.at : numbers.at + 3]
    follows = len(head) == 3 and all(map(_is_number, head))
    follows = follows and float(head[0]) in (DENSE, BLOCKS, SPARSE)
    follows = follows and (float(head[1]), float(head[2])) == (shape[0], size)
    if shape != (size, size):
        if not follows:
            raise ProblemError(
                f"{numbers.name}: a {shape[0]}x{shape[1]} matrix is neither W of {contacts} contacts "
                f"({size}x{size}) nor M with a {shape[0]}x{size} matrix H after it"
            )
        return True
    near = numbers.words[numbers.at : numbers.at + BANNER]
    local = numbers.ahead() <= size + contacts + 1 and not any(map(SHAPE.fullmatch, near))
    return follows and not local


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
    planar = storage == BLOCKS and numbers.ahead() == 2  # one planar contact whose W is sparse
    return bool(storage in (DENSE, BLOCKS, SPARSE) and rows == columns == size and not planar)


def _read_matrix(numbers: _Numbers) -> FloatArray | sp.csr_matrix:
    storage, rows, columns = (int(i) for i in numbers.integers(3))
    # vectors of both lengths follow, so what is left is longer: looked at before memory is asked for
    if storage in (DENSE, BLOCKS, SPARSE) and max(rows, columns) > len(numbers.words) - numbers.at:
        raise ProblemError(f"{numbers.name}: a matrix is {rows}x{columns}, more than the file can hold")
    if storage == DENSE:
        again = tuple(int(i) for i in numbers.integers(2))
        if again != (rows, columns):
            raise ProblemError(f"{numbers.name}: a matrix is {rows}x{columns} and then {again[0]}x{again[1]}")
        return numbers.floats(rows * columns).reshape(columns, rows).T
    if storage == BLOCKS:
        return _read_blocks(numbers, rows, columns)
    if storage == SPARSE:
        return _read_sparse(numbers, rows, columns)
    raise ProblemError(
        f"{numbers.name}: the matrix storage must be 0 (dense), 1 (blocks) or 2 (sparse), got {storage}"
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


def _read_sparse(numbers: _Numbers, rows: int, columns: int) -> sp.csr_matrix:
    origin = numbers.integer()
    if origin not in (TRIPLETS, COLUMNS):
        raise ProblemError(
            f"{numbers.name}: a sparse matrix must be 1 (triplets) or 2 (compressed columns), got {origin}"
        )
    banner = numbers.words[numbers.at : numbers.at + BANNER]
    at = next((k for k, word in enumerate(banner) if SHAPE.fullmatch(word)), None)
    found = None if at is None else SHAPE.fullmatch(banner[at])
    if at is None or found is None or tuple(map(int, found.groups())) != (rows, columns):
        raise ProblemError(f"{numbers.name}: a sparse matrix must say that it is {rows}-by-{columns}")
    numbers.take(at + 1)
    labels = numbers.take(4 if origin == TRIPLETS else 6)  # nzmax: n nnz: n, 1-norm: x
    if labels[0] != "nzmax:" or labels[2] != "nnz:":
        raise ProblemError(f"{numbers.name}: expected the number of entries of a sparse matrix")
    count = int(numbers.whole([labels[3].rstrip(",")])[0])
    i, j, words = _triplets(numbers, count) if origin == TRIPLETS else _columns(numbers, columns, count)
    x = numbers.numeric(words)
    numbers.rough = numbers.rough or (bool(words) and max(map(_digits, words)) <= DIGITS)
    if (i >= rows).any() or (j >= columns).any():
        raise ProblemError(f"{numbers.name}: a sparse matrix has an entry outside of {rows}-by-{columns}")
    return sp.csr_matrix((x, (i, j)), shape=(rows, columns))


def _digits(word: str) -> int:
    """Return how many digits a number was written with, leading zeros aside."""
    return len(word.lower().split("e")[0].lstrip("+-").replace(".", "").lstrip("0"))


def _triplets(numbers: _Numbers, count: int) -> tuple[IntArray, IntArray, list[str]]:
    """Return the rows, columns and values of lines "row column : value"."""
    words = numbers.take(4 * count)
    if set(words[2::4]) - {":"}:
        raise ProblemError(f"{numbers.name}: expected lines 'row column : value'")
    return numbers.whole(words[0::4]), numbers.whole(words[1::4]), words[3::4]


def _columns(numbers: _Numbers, columns: int, count: int) -> tuple[IntArray, IntArray, list[str]]:
    """Return the rows, columns and values of blocks "col j : locations a to b" with lines "row : value"."""
    rows, values, sizes = [], [], []
    for column in range(columns):
        words = numbers.take(7)
        if [*words[:4], words[5]] != ["col", str(column), ":", "locations", "to"]:
            raise ProblemError(f"{numbers.name}: expected column {column} of a sparse matrix")
        first, last = numbers.numeric([words[4], words[6]])  # last = first - 1 for an empty one
        if not -1.0 <= last - first < count:
            raise ProblemError(f"{numbers.name}: column {column} of a sparse matrix contradicts itself")
        sizes.append(int(last - first) + 1)
        lines = numbers.take(3 * sizes[-1])
        rows += lines[0::3]
        values += lines[2::3]
    if sum(sizes) != count:
        raise ProblemError(f"{numbers.name}: a sparse matrix has {sum(sizes)} entries and says {count}")
    return numbers.whole(rows), np.repeat(np.arange(columns), sizes), values


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
