"""What the adapters share: a line of JSON that says the job, one that answers, then numbers to and fro.

Adapters run with an interpreter of their own and need nothing of Surefoot: Python finds this file beside
them.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

REQUEST = 1 + 3 + 19 + 18 + 4
"""Doubles of a request: time, velocity that is asked for, q, v, contact of the feet."""


class Adapter(Protocol):
    """A peer's stack: its step [s], its gait's period [s], the joints that it starts from."""

    dt: float
    period: float
    joints: np.ndarray

    def step(self, now: float, wanted: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return torques, planned forces and planned stance: (28,)."""
        ...


def serve(make: Callable[[dict[str, Any]], Adapter]) -> None:
    """Answer the requests on standard input until there are none."""
    commands, answers = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what the peer prints is no answer
    stack = make(json.loads(commands.readline()))
    described = {"dt": stack.dt, "period": stack.period, "joints": stack.joints.tolist()}
    answers.write((json.dumps(described) + "\n").encode())
    answers.flush()
    while len(raw := commands.read(8 * REQUEST)) == 8 * REQUEST:
        request = np.frombuffer(raw)
        begin = time.process_time()
        answer = stack.step(float(request[0]), request[1:4], request[4:23].copy(), request[23:41].copy())
        spent = time.process_time() - begin
        answers.write(np.append(answer, spent).astype(np.float64).tobytes())
        answers.flush()
