"""Archives that unpack to far more than they are: refused by every reader before anything is unpacked."""

from __future__ import annotations

import io
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.base.npz_files import check_archive

NUMBERS = 400_000_000
MEMORY = 2_500_000_000
"""Address space of the process that reads it [bytes]: less than the archive unpacks to."""


@pytest.fixture(scope="module")
def bomb(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return an archive of 3 MB with 3.2 GB of zeros."""
    path = tmp_path_factory.mktemp("bomb") / "zeros.npz"
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (NUMBERS,)})
    block = bytes(1 << 22)
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("states.npy", "w", force_zip64=True) as entry,
    ):
        entry.write(head.getvalue())
        for start in range(0, 8 * NUMBERS, len(block)):
            entry.write(block[: 8 * NUMBERS - start])
    return path


@pytest.mark.long
@pytest.mark.parametrize("command", ["solve", "identify", "audit"])
def test_no_command_unpacks_it(command: str, bomb: Path) -> None:
    code = (
        f"import resource, sys; resource.setrlimit(resource.RLIMIT_AS, ({MEMORY}, {MEMORY})); "
        "from surefoot.app.cli.main import main; sys.exit(main(sys.argv[1:]))"
    )
    done = subprocess.run([sys.executable, "-c", code, command, str(bomb)], capture_output=True, text=True)
    assert done.returncode == 2
    assert "would unpack to 3200 MB from 3.1 MB" in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_numbers_as_they_are_pass(tmp_path: Path) -> None:
    path = tmp_path / "small.npz"
    np.savez_compressed(path, a=np.zeros(1_000_000), b=np.random.default_rng(0).normal(size=1000))
    check_archive(path, path)
    (tmp_path / "none.npz").write_bytes(b"no archive")
    check_archive(tmp_path / "none.npz", "none")
    check_archive(tmp_path / "missing.npz", "missing")


def test_an_archive_that_claims_too_much_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("surefoot.base.npz_files.SMALL", 1 << 20)
    path = tmp_path / "zeros.npz"
    np.savez_compressed(path, a=np.zeros(1_000_000))
    with pytest.raises(ProblemError, match=r"would unpack to 8 MB from 0\.0 MB"):
        check_archive(path, path)
