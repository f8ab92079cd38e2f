"""`surefoot lab`: it serves, ends cleanly, and says in one line what it cannot do."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import urllib.request
from typing import Any

import pytest

pytest.importorskip("viser", reason="viser is not installed: pip install -e '.[lab]'")

QUICK = ["--port", "0", "--seconds", "0.2"]


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 0), (signal.SIGTERM, 143)])
def test_a_signal_ends_it_cleanly(number: signal.Signals, code: int) -> None:
    program = [sys.executable, "-m", "surefoot", "lab", "cone", "--port", "0"]
    with subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        url = re.search(r"http://\S+", line)
        assert url is not None
        with urllib.request.urlopen(url[0], timeout=20) as answer:
            assert answer.status == 200
        os.kill(process.pid, number)
        out, err = process.communicate(timeout=30)
    assert process.returncode == code
    assert (out, err) == ("", "")


def test_a_port_in_use_is_one_line(printed: Any) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        said = printed("lab", "stand", "--port", port, code=2)
    assert said == f"surefoot: port {port} of 127.0.0.1 is in use; choose another with --port, or 0 for any\n"


def test_another_host_is_warned_of(printed: Any, answer: Any) -> None:
    said = printed("lab", "cone", "--host", "0.0.0.0", *QUICK)
    assert "everyone who reaches this address can use the page" in said
    assert answer("lab", "cone", *QUICK)["url"].startswith("http://127.0.0.1:")


def test_without_viser_one_line_says_what_to_install(printed: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    for page in ("stand", "cone", "push"):
        line = "surefoot: viser is not installed; run: pip install -e '.[lab]'\n"
        assert printed("lab", page, code=2) == line


def test_the_library_is_imported_without_viser() -> None:
    code = (
        "import sys, surefoot.app.cli.lab\n"
        "import surefoot.app.lab.server, surefoot.app.lab.stand, surefoot.app.lab.push\n"
        "assert not {'viser', 'websockets', 'pinocchio', 'mujoco'} & sys.modules.keys(), sys.modules.keys()"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
