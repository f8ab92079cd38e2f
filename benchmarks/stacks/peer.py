"""Stacks of others: a controller that asks a process which runs their code, from the user's own checkout.

The process speaks over its standard input and output: a line of JSON that says what the job is, a line that
answers, then numbers as doubles, a request and an answer each time the peer is due. In between its torques
are held, as its own scripts do. World, estimator and log are the bench's (`benchmarks.stacks.setting`).
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, Any

import numpy as np

from benchmarks.stacks.pins import PINS, commit_of
from benchmarks.stacks.stack import START, Job, TimedController, ramped
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import SurefootError
from surefoot.motion.control.controller import Command, Controller, RobotState
from surefoot.records.log.channels import CHANNELS, Channel

PROGRAMS = Path(__file__).parent / "peers"
JOINTS, FEET = 12, 4
ANSWER = JOINTS + 3 * FEET + FEET + 1
"""Doubles of an answer: torques, forces on the feet in world axes, planned stance, CPU time."""


@dataclass(frozen=True)
class Peer:
    """A stack in a process of its own.

    Attributes
    ----------
    name
        See `Stack`.
    program
        What runs there, a file of `peers/`: our adapter, on top of their code.
    robots
        Names of the catalogue that it is made for.
    checkout, interpreter
        Where their code is, and a Python that has what it needs; None for what the environment says.
    """

    name: str
    program: str
    robots: tuple[str, ...]
    checkout: Path | None = None
    interpreter: str = ""

    def at(self, checkout: Path | None) -> Peer:
        """Return the stack with its checkout, from the environment where none is given."""
        variable = PINS[self.name].variable
        named = os.environ.get(variable)
        folder = checkout if checkout is not None else None if named is None else Path(named)
        return replace(
            self, checkout=folder, interpreter=os.environ.get(f"{variable}_PYTHON", sys.executable)
        )

    def missing(self) -> str:
        """See `Stack.missing`."""
        pin = PINS[self.name]
        if self.checkout is None:
            return f"set --{self.name} or {pin.variable} to a checkout of {pin.url}"
        if not self.checkout.is_dir():
            return f"{self.checkout} is no folder; wanted: a checkout of {pin.url}"
        return ""

    def walks(self, robot: str) -> bool:
        """See `Stack.walks`."""
        return robot in self.robots

    def version(self) -> str:
        """See `Stack.version`."""
        assert self.checkout is not None
        pin, found = PINS[self.name], commit_of(self.checkout)
        if found == pin.commit:
            return f"{pin.url} {found}"
        return f"{pin.url} {found or 'of no known commit'}, written for {pin.commit}"

    def controller(self, job: Job) -> TimedController:
        """See `Stack.controller`."""
        return PeerController(self, job)


class PeerController(Controller):
    """A peer as a controller of the bench.

    Parameters
    ----------
    peer
        Which.
    job
        What it is asked to do.

    Raises
    ------
    SurefootError
        If its process does not start; the message ends with what it said last.
    """

    channels: tuple[Channel, ...] = (CHANNELS["command"],)
    apart = True
    starts = START
    posture: FloatArray | None = None

    def __init__(self, peer: Peer, job: Job) -> None:
        assert peer.checkout is not None
        self._peer, self._job = peer, job
        self._height = float(job.robot.nominal[2])
        self.cpu: list[float] = []
        self._process: subprocess.Popen[bytes] | None = None
        self.facts = {
            "kind": "walk", "normal_min": 0.0, "normal_max": float("inf"), "mu_controller": job.mu,
            "gait": f"trot of {peer.name}", "notes": [],
        }  # fmt: skip
        self._start()

    def _start(self) -> None:
        """Start the process and tell it the job."""
        peer, job = self._peer, self._job
        self._errors: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115, closed with the process
        self._process = subprocess.Popen(
            [peer.interpreter, "-u", str(PROGRAMS / peer.program), str(peer.checkout)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors,
        )  # fmt: skip
        setup = {
            "urdf": _urdf(job.robot.name), "mass": job.robot.mass, "mu": job.mu, "dt": job.dt,
            "q": job.robot.nominal.tolist(), "effort_limits": job.robot.effort_limits.tolist(),
        }  # fmt: skip
        self._send((json.dumps(setup) + "\n").encode())
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise self._ended("did not start")
        answer = json.loads(line)
        self.posture = np.array([*job.robot.nominal[:7], *answer["joints"]])
        self._every = max(1, round(float(answer["dt"]) / job.dt))
        self.gait_start, self.gait_period = 0.0, float(answer["period"])
        self._number, self._torques = 0, np.zeros(JOINTS)
        self._forces, self._stance = np.zeros((FEET, 3)), np.ones(FEET, dtype=bool)

    def reset(self) -> None:
        """Forget the past: a new process."""
        self.close()
        self.cpu.clear()
        self._start()

    def warm_up(self, state: RobotState) -> None:
        """Let the peer compile what it needs, then start it anew unless it forgets by itself."""
        self.step(state)
        self.reset()

    def step(self, state: RobotState) -> Command:
        """Return the peer's torques, new ones where it is due."""
        wanted, spent = ramped(self._job.asked, state.time, self._height), 0.0
        if self._number % self._every == 0:
            contact = np.ones(FEET) if state.contact is None else np.asarray(state.contact, dtype=np.float64)
            answer = self._ask(np.concatenate([[state.time], wanted, state.q, state.v, contact]))
            self._torques = answer[:JOINTS]
            forces, stance = answer[JOINTS : JOINTS + 3 * FEET], answer[JOINTS + 3 * FEET : -1]
            self._stance, spent = stance > 0.5, float(answer[-1])
            self._forces = self._in_contact_frames(forces.reshape(FEET, 3), state) * self._stance[:, None]
        self._number += 1
        self.cpu.append(spent)
        return _PeerCommand(
            self._torques, self._forces, self._stance, wanted=wanted
        )  # fmt: skip

    def _in_contact_frames(self, forces: FloatArray, state: RobotState) -> FloatArray:
        """Return (4, 3) forces of world axes in the frames of the ground below the base [N]."""
        frame = self._job.terrain.frame(state.q[:2])
        return np.asarray(forces @ frame)

    def _ask(self, request: FloatArray) -> FloatArray:
        """Send a request and return the answer."""
        self._send(np.ascontiguousarray(request, dtype=np.float64).tobytes())
        assert self._process is not None
        assert self._process.stdout is not None
        raw = self._process.stdout.read(8 * ANSWER)
        if len(raw) < 8 * ANSWER:
            raise self._ended("ended")
        answer = np.frombuffer(raw)
        if not np.isfinite(answer).all():
            raise SurefootError(f"{self._peer.name} gave torques or forces that are not finite")
        return answer

    def _send(self, data: bytes) -> None:
        assert self._process is not None
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(data)
            self._process.stdin.flush()
        except BrokenPipeError:
            raise self._ended("ended") from None

    def _ended(self, how: str) -> SurefootError:
        """Let go of a process that ended, and return the error that says what it said last."""
        if self._process is not None:
            self._process.wait(timeout=10.0)
        self._errors.seek(0)
        said = self._errors.read().decode(errors="replace").strip().splitlines()
        self.close()
        return SurefootError(f"the process of {self._peer.name} {how}: {said[-1] if said else 'no word'}")

    def close(self) -> None:
        """End the process."""
        if self._process is None:
            return
        self._process.kill()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with suppress(OSError):  # what was not sent yet goes nowhere
                    pipe.close()
        self._process.wait()
        self._errors.close()
        self._process = None


@dataclass(frozen=True, kw_only=True)
class _PeerCommand(Command):
    """A command with the velocity that was asked for."""

    wanted: FloatArray

    def rows(self) -> dict[str, Any]:
        return {"command": self.wanted}


def _urdf(robot: str) -> dict[str, str]:
    """Return where the robot's own file lies, and the folder that its meshes are named from."""
    from surefoot.mechanics.robot.catalog import find, robots_folder

    folder = robots_folder()
    return {"file": str(folder / find(robot).urdf), "packages": str(folder.parents[1])}
