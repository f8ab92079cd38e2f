"""Networks from files: ONNX by onnxruntime on one thread; TorchScript, which is code, for who trusts it."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError, needs, one_line

SUFFIXES = (".onnx", ".pt", ".jit")


class Network(Protocol):
    """A function of an observation, which may have a memory.

    Attributes
    ----------
    inputs, outputs
        How many numbers it takes and gives; 0 where the file does not say.
    input_name
        What the file calls the observation.
    metadata
        What its exporter wrote beside it: numbers, names, lists of them.
    """

    inputs: int
    outputs: int
    input_name: str
    metadata: dict[str, Any]

    def __call__(self, observation: FloatArray) -> FloatArray:
        """Return the (outputs,) answer to an (inputs,) observation."""

    def reset(self) -> None:
        """Forget what it remembers."""


def open_network(path: str | Path, trust: bool = False) -> Network:
    """Return the network of a file.

    Raises
    ------
    ProblemError
        For a file that is none, or TorchScript without `trust`: it is code that would run.
    MissingExtra
        Without onnxruntime or torch.
    """
    file = Path(path)
    if file.suffix not in SUFFIXES:
        raise ProblemError(f"a policy's network is a file {', '.join(SUFFIXES)}, got {path}")
    if not file.is_file():
        raise ProblemError(f"cannot read the network {path}: no such file")
    if file.suffix == ".onnx":
        return OnnxNetwork(file)
    if not trust:
        raise ProblemError(
            f"{path} is TorchScript, code that would run: trust=True (--trust) if you trust its author"
        )
    return TorchNetwork(file)


class OnnxNetwork:
    """A network of onnxruntime, see `Network`; inputs after the first are a memory, as LSTM exporters write.

    Parameters
    ----------
    path
        The file.
    """

    def __init__(self, path: Path) -> None:
        with needs("onnxruntime", "policy"):
            import onnxruntime
        self._path = path.resolve()
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = 3
        try:
            self._session = onnxruntime.InferenceSession(str(path), options, ["CPUExecutionProvider"])
        except Exception as error:  # onnxruntime has its own classes for every fault of a file
            raise ProblemError(f"{path} is no ONNX network: {one_line(error)[:160]}") from error
        first, *memory = self._session.get_inputs()
        given = self._session.get_outputs()
        self.input_name, self.inputs, self.outputs = first.name, _width(first.shape), _width(given[0].shape)
        self._shape = (1,) * max(len(first.shape) - 1, 0) + (-1,)
        self._memory = [(one.name, [n if isinstance(n, int) else 1 for n in one.shape]) for one in memory]
        if memory and (len(given) != len(memory) + 1 or "float" not in memory[0].type):
            names = ", ".join(one.name for one in memory)
            raise ProblemError(f"{path} wants {names} beside the observation: no memory that it gives back")
        self.metadata = {
            k: parse_metadata(v) for k, v in self._session.get_modelmeta().custom_metadata_map.items()
        }
        self.reset()

    def __reduce__(self) -> tuple[Any, ...]:
        """Reduce to the file, which a copy reads again, and the memory."""
        return OnnxNetwork, (self._path,), self._feed

    def __setstate__(self, feed: dict[str, Any]) -> None:
        self._feed = {name: value.copy() for name, value in feed.items()}

    def reset(self) -> None:
        """See `Network`."""
        self._feed = {name: np.zeros(shape, dtype=np.float32) for name, shape in self._memory}

    def __call__(self, observation: FloatArray) -> FloatArray:
        """See `Network`."""
        self._feed[self.input_name] = observation.astype(np.float32).reshape(self._shape)
        answer, *memory = self._session.run(None, self._feed)
        for (name, _), value in zip(self._memory, memory, strict=False):
            self._feed[name] = value
        return np.asarray(answer, dtype=np.float64).ravel()


class TorchNetwork:
    """A network of TorchScript on one thread, see `Network`; `reset_memory` is called where it has one.

    Parameters
    ----------
    path
        The file: it is code.
    """

    inputs = outputs = 0
    input_name = ""

    def __init__(self, path: Path) -> None:
        with needs("torch", "torch"):
            import torch
        self._torch, self.metadata = torch, dict[str, Any]()
        torch.set_num_threads(1)
        self._path = path.resolve()
        try:
            self._module = torch.jit.load(str(path), map_location="cpu").eval()
        except (RuntimeError, ValueError) as error:
            raise ProblemError(f"{path} is no TorchScript network: {one_line(error)[:160]}") from error

    def __reduce__(self) -> tuple[Any, ...]:
        """Reduce to the file, which a copy reads again.

        Raises
        ------
        ProblemError
            For a network with a memory: TorchScript does not show it.
        """
        if hasattr(self._module, "reset_memory"):
            raise ProblemError(f"{self._path} has a memory that TorchScript does not show: open it anew")
        return TorchNetwork, (self._path,)

    def reset(self) -> None:
        """See `Network`."""
        if hasattr(self._module, "reset_memory"):
            self._module.reset_memory()

    def __call__(self, observation: FloatArray) -> FloatArray:
        """See `Network`."""
        with self._torch.inference_mode():
            answer = self._module(self._torch.from_numpy(observation.astype(np.float32)[None]))
        return np.asarray(answer.numpy(), dtype=np.float64).ravel()


def parse_metadata(text: str) -> Any:
    """Return what a value of ONNX metadata means: JSON, or numbers or names with commas between.

    >>> [parse_metadata(text) for text in ("[20.0, 0.5]", "0.250,-0.1", "FL_hip, FL_calf", '"go2"')]
    [[20.0, 0.5], [0.25, -0.1], ['FL_hip', 'FL_calf'], 'go2']
    """
    try:
        return json.loads(text)
    except ValueError:
        words = [word.strip(" '\"[]()") for word in text.split(",")]
    try:
        values: list[Any] = [float(word) for word in words]
    except ValueError:
        values = words
    return values if len(values) > 1 or "[" in text else values[0]


def _width(shape: list[Any]) -> int:
    """Return how many numbers a tensor of a shape holds, 0 where it does not say; a batch is one."""
    own = [n if isinstance(n, int) else 0 for n in shape[1:]]
    return math.prod(own) if own else 0
