"""A wrapper of gymnasium that hands over the log of every episode; see `RecordWrapper`."""

from __future__ import annotations

from typing import Any

import gymnasium

from surefoot.worlds.mujoco.environment_data import model_and_data
from surefoot.worlds.mujoco.recording import Recording, record
from surefoot.worlds.mujoco.spec import import_mujoco

KEY = "log"


class RecordWrapper(gymnasium.Wrapper):  # type: ignore[misc]
    """Record every episode of a MuJoCo environment: the last ``info["log"]`` is its log, see `record`.

    The log of an episode that is given up is in the info of the next `reset`. For the workers of an
    `AsyncVectorEnv`, whose data no other process sees: ``gymnasium.make_vec(name, num_envs=8,
    vectorization_mode="async", wrappers=[sf.rl.RecordWrapper])``.

    Parameters
    ----------
    env
        An environment whose steps are made by MuJoCo's functions in Python.
    robot
        Name of the body at the robot's root, see `surefoot.record`.

    Raises
    ------
    ProblemError
        For what is no environment of MuJoCo.
    """

    def __init__(self, env: Any, robot: str | None = None) -> None:
        super().__init__(env)
        self._robot = robot
        self._recording: Recording | None = None
        model_and_data(import_mujoco(), env.unwrapped, "RecordWrapper")

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Step the environment; the last step of an episode has its log in ``info["log"]``."""
        if self._recording is None:
            self._begin()
        seen, reward, terminated, truncated, info = self.env.step(action)
        if terminated or truncated:
            info = {**info, KEY: self._end()}
        return seen, reward, terminated, truncated, info

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Reset the environment; the log of an episode that was given up is ``info["log"]``."""
        log = None if self._recording is None else self._end()
        seen, info = self.env.reset(seed=seed, options=options)
        return seen, info if log is None else {**info, KEY: log}

    def close(self) -> None:
        """Close the environment; an episode that is not over is given up."""
        if self._recording is not None:
            self._end()
        super().close()

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_recording": None}  # a recording is of this process and this data

    def _begin(self) -> None:
        """Begin a recording in the present state: before an episode's first step."""
        model, data = model_and_data(import_mujoco(), self.env.unwrapped, "RecordWrapper")
        self._recording = record(model, data, self._robot)
        self._recording.__enter__()

    def _end(self) -> Any:
        """Return the log of the episode."""
        recording, self._recording = self._recording, None
        assert recording is not None
        recording.__exit__(None, None, None)
        return recording
