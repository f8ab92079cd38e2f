"""Contact files that were damaged: one clear line, no traceback, no signal, no memory beyond the file's.

Every file is read in a process of its own kind (one for many files), so that a crash of the interpreter is a
failure of one test and not of pytest.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf

READER = """
import json, resource, sys, time
from pathlib import Path
import numpy as np
import surefoot as sf
from surefoot.contact.files import fclib, formats
resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
for line in sys.stdin:
    start, said = time.process_time(), "read"
    try:
        problem = sf.read_problem(line.strip())
        assert np.isfinite(problem.g).all() and np.isfinite(problem.mu).all()
    except sf.ProblemError as error:
        said = "refused" if "\\n" not in str(error) else f"two lines: {error}"
    except BaseException as error:
        said = f"{type(error).__name__}: {error}"
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print(json.dumps([Path(line.strip()).name, said, time.process_time() - start, peak]), flush=True)
"""


def read_apart(files: list[Path]) -> list[tuple[str, str, float, float]]:
    """Return (name, what became of it, seconds, peak memory [MB]) of files, read in another process."""
    lines = "\n".join(map(str, files)) + "\n"
    done = subprocess.run(
        [sys.executable, "-c", READER], input=lines, capture_output=True, text=True, timeout=600
    )
    found = [tuple(json.loads(line)) for line in done.stdout.splitlines()]
    if len(found) < len(files):
        found.append((files[len(found)].name, f"ended by {done.returncode}: {done.stderr[-300:]}", 0.0, 0.0))
    return found  # type: ignore[return-value]


def originals(folder: Path) -> list[Path]:
    """Write one problem in every format: rows and columns, text, and an archive with everything."""
    rng = np.random.default_rng(0)
    J = rng.normal(size=(12, 18))
    problem = sf.ContactProblem(J @ J.T, rng.normal(size=12), rng.uniform(0.2, 0.9, 4))
    kinds = [".dat", ".npz"]
    try:
        import h5py  # noqa: F401
    except ImportError:
        pass
    else:
        kinds += [".hdf5", ".hdf5"]
    return [sf.write_problem(problem, folder / f"whole{k}{kind}") for k, kind in enumerate(kinds)]


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """Return a file with some bytes changed, cut out, doubled or set to extremes."""
    out = bytearray(data)
    for _ in range(int(rng.integers(1, 6))):
        at = int(rng.integers(len(out)))
        kind = int(rng.integers(5))
        if kind == 0:
            out[at] = int(rng.integers(256))
        elif kind == 1:
            out[at] ^= 1 << int(rng.integers(8))
        elif kind == 2:
            out[at : at + int(rng.integers(1, 9))] = b"\xff" * int(rng.integers(1, 9))
        elif kind == 3:
            del out[at : at + int(rng.integers(1, 65))]
        else:
            out[at:at] = out[at : at + int(rng.integers(1, 65))]
        if not out:
            return b""
    return bytes(out)


@pytest.mark.parametrize(
    "count", [pytest.param(200, id="quick"), pytest.param(3000, id="long", marks=pytest.mark.long)]
)
def test_damaged_files_are_refused_in_one_line(count: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    whole = originals(tmp_path)
    files = []
    for k in range(count):
        source = whole[k % len(whole)]
        path = tmp_path / f"damaged{k}{source.suffix}"
        path.write_bytes(damaged(source.read_bytes(), rng))
        files.append(path)
    found = read_apart([*whole, *files])
    assert [said for _, said, _, _ in found[: len(whole)]] == ["read"] * len(whole)
    wrong = [row for row in found if row[1] not in ("read", "refused") or row[2] > 5.0]
    assert not wrong, wrong[:5]
    assert len(found) == len(whole) + count
    assert sum(said == "refused" for _, said, _, _ in found) > count // 4
    assert found[-1][3] - found[0][3] < 500.0


COLUMNS = np.tile(np.arange(6), 6)
h5py = pytest.importorskip("h5py", reason="h5py is not here (extra files)")


def fclib(path: Path, **changes: object) -> Path:
    """Write a local problem of two contacts by rows, with some of its entries replaced."""
    rng = np.random.default_rng(1)
    J = rng.normal(size=(6, 8))
    W = J @ J.T
    entries = {
        "spacedim": [3], "vectors/q": rng.normal(size=6), "vectors/mu": [0.5, 0.5], "W/m": [6], "W/n": [6],
        "W/nz": [-2], "W/nzmax": [36], "W/p": 6 * np.arange(7), "W/i": COLUMNS, "W/x": W.ravel(),
    }  # fmt: skip
    with h5py.File(path, "w") as file:
        for name, value in (entries | changes).items():
            file[f"fclib_local/{name}"] = value
    return path


def test_fclib_as_it_should_be(tmp_path: Path) -> None:
    assert sf.read_problem(fclib(tmp_path / "a.hdf5")).contacts == 2


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"W/i": np.where(np.arange(36) == 7, 10**6, COLUMNS)}, "entry at 1000000, outside of 0 to 5"),
        ({"W/i": np.where(np.arange(36) == 7, -1, COLUMNS)}, "entry at -1"),
        ({"W/i": np.where(np.arange(36) == 7, 6, COLUMNS)}, "entry at 6"),
        ({"W/nz": [-1], "W/i": np.where(np.arange(36) == 7, 10**9, COLUMNS)}, "entry at 1000000000"),
        ({"W/nz": [36], "W/p": np.repeat(np.arange(6), 6) + 10**7}, "entry at 10000000"),
        ({"W/nz": [37]}, "says 37 entries"),
        ({"W/p": [0, 6, 12, 18, 24, 30, 10**9]}, "p must rise from 0"),
        ({"W/p": [0, 6, 12, 18, 6, 30, 36]}, "p must rise from 0"),
        ({"W/p": [0, 6, 12, 18, 24, 30, 35]}, "holds 36 entries, of which p counts 35"),
        ({"W/p": [0, 6]}, "p must rise from 0"),
        ({"W/m": [10**9], "W/n": [10**9]}, "must be 6x6"),
        ({"W/x": np.full(36, 1.0 + 2.0j)}, "x must be an array of numbers"),
        ({"vectors/q": np.array([b"one"] * 6)}, "q must be an array of numbers"),
        ({"spacedim": [7]}, "dimension must be 2 or 3, got 7"),
        ({"spacedim": [3, 3]}, "spacedim must be one whole number"),
    ],
)
@pytest.mark.sampled(3)
def test_bad_indices_and_sizes_are_named(changes: dict[str, object], words: str, tmp_path: Path) -> None:
    ((_, said, _, _),) = read_apart([fclib(tmp_path / "bad.hdf5", **changes)])
    assert said == "refused"
    with pytest.raises(sf.ProblemError, match=words):
        sf.read_problem(tmp_path / "bad.hdf5")


def test_a_small_file_that_asks_for_much_memory(tmp_path: Path) -> None:
    path = fclib(tmp_path / "huge.hdf5")
    with h5py.File(path, "r+") as file:
        del file["fclib_local/W/x"]
        file.create_dataset("fclib_local/W/x", shape=(10**13,), dtype="f8", chunks=(1024,))
    with pytest.raises(sf.ProblemError, match="claims 10000000000000 entries, more than the file can hold"):
        sf.read_problem(path)


def test_links_in_circles_and_out_of_the_file(tmp_path: Path) -> None:
    path = fclib(tmp_path / "links.hdf5")
    with h5py.File(path, "r+") as file:
        del file["fclib_local/vectors/mu"]
        file["fclib_local/vectors/mu"] = h5py.SoftLink("/fclib_local/vectors/mu")
    with pytest.raises(sf.ProblemError, match="no FCLIB file"):
        sf.read_problem(path)
    other = fclib(tmp_path / "other.hdf5")
    with h5py.File(path, "r+") as file:
        del file["fclib_local/vectors/mu"]
        file["fclib_local/vectors/mu"] = h5py.ExternalLink(str(other), "/fclib_local/vectors/mu")
    with pytest.raises(sf.ProblemError, match="'mu' is a link to another file"):
        sf.read_problem(path)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"g": np.zeros(3, dtype=complex)}, "g is complex128"),
        ({"mu": np.array(["half"])}, "mu is <U4"),
        ({"facets": np.array([4, 4])}, r"facets is int64 of shape \(2,\)"),
        ({"law": np.array([["coulomb"]])}, "law is <U7 of shape"),
    ],
)
def test_archives_of_other_things(changes: dict[str, object], words: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.npz"
    np.savez(path, **({"G": np.eye(3), "g": np.zeros(3), "mu": np.array([0.5])} | changes))  # type: ignore[arg-type]
    with pytest.raises(sf.ProblemError, match=words):
        sf.read_problem(path)
