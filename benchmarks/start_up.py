"""What a command costs to start, and the first call of a kernel, both ways to compile it.

Run: python -m benchmarks.start_up. Each figure is of a process of its own: the least CPU time of a command
that has run before, with an empty cache too, and of the libraries below it; the CPU time of a kernel's first
call in a program, once with an empty cache and once with what that call left there.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import surefoot as sf

WAYS = {"0": "whole trees", "1": "plain numba.njit"}
"""Values of SUREFOOT_PLAIN_NUMBA."""
ONE_THREAD = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
QUESTIONS = ("can_stand", "solve")


LIBRARIES = "import numba, scipy.linalg, scipy.sparse, typer"
STANCE = Path(__file__).parents[1] / "examples/stances/go2_three_legs.yaml"
COMMANDS = (
    "--version",
    "--help",
    "check STANCE --no-picture",
    "check STANCE",
    "solve PROBLEM",
    "region STANCE",
    "cone --mu 0.6 --facets 4",
)


def least(words: list[str], repeats: int = 7, cache: str | None = None) -> float:
    """Return the least CPU time of a program [s], with another folder of compiled code where one is given."""
    times, given = [], ONE_THREAD if cache is None else {**ONE_THREAD, "NUMBA_CACHE_DIR": cache}
    for _ in range(repeats):
        before = os.times()
        subprocess.run([sys.executable, *words], env=given, capture_output=True, check=True)
        after = os.times()
        times.append(sum(after[2:4]) - sum(before[2:4]))
    return min(times)


def print_commands() -> None:
    """Print what commands cost, beside the libraries alone."""
    import surefoot as sf

    base = least(["-c", LIBRARIES])
    print(f"{LIBRARIES}: {base:.2f} s; commands, then above the libraries, then with nothing compiled")
    with tempfile.TemporaryDirectory() as folder:
        problem = sf.write_problem(four_contacts(), f"{folder}/problem.npz")
        for command in COMMANDS:
            words = command.replace("STANCE", str(STANCE)).replace("PROBLEM", str(problem)).split()
            if words[0] in ("check", "region", "cone"):
                words += ["--out", folder]
            time = least(["-m", "surefoot", *words])
            cold = least(["-m", "surefoot", *words], cache=f"{folder}/cold")
            print(f"surefoot {command:30}{time:6.2f} s{time - base:7.2f} s{cold:7.2f} s")


def four_contacts() -> sf.ContactProblem:
    """Return a problem of four contacts."""
    import numpy as np

    import surefoot as sf

    random = np.random.default_rng(0)
    jacobian, g = random.normal(size=(12, 18)), random.normal(size=12)
    return sf.ContactProblem(jacobian @ jacobian.T, g, 0.6)


def ask(question: str) -> float:
    """Return the CPU time of the first answer [s]."""
    import surefoot as sf

    if question == "can_stand":
        feet = [sf.PointContact((x, y, 0.0), mu=0.6) for x in (-0.2, 0.2) for y in (-0.1, 0.1)]
        stance = sf.Stance(feet)
        begin = time.process_time()
        sf.can_stand(stance, [0.01, 0.0, 0.3], 16.0)
    else:
        problem = four_contacts()
        begin = time.process_time()
        sf.solve(problem)
    return time.process_time() - begin


def main() -> None:
    """Print the tables; with a word, one measurement."""
    if len(sys.argv) == 2:
        print(ask(sys.argv[1]))
        return
    print_commands()
    print(f"{'first call of':14}{'compiled':22}{'cold [s]':>10}{'warm [s]':>10}{'files':>8}{'MB':>6}")
    for question in QUESTIONS:
        for way, title in WAYS.items():
            with tempfile.TemporaryDirectory() as folder:
                words = [sys.executable, "-W", "ignore", "-m", "benchmarks.start_up", question]
                environment = {**os.environ, "NUMBA_CACHE_DIR": folder, "SUREFOOT_PLAIN_NUMBA": way}
                cold, warm = (
                    float(subprocess.run(words, env=environment, capture_output=True, check=True).stdout)
                    for _ in range(2)
                )
                sizes = [f.stat().st_size for f in Path(folder).rglob("*.nb[ci]")]
            print(f"{question:14}{title:22}{cold:10.1f}{warm:10.2f}{len(sizes):8}{1e-6 * sum(sizes):6.1f}")


if __name__ == "__main__":
    main()
