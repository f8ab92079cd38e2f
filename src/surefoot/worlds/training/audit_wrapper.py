"""A wrapper of gymnasium that audits every episode of a MuJoCo environment; see `AuditWrapper`."""

from __future__ import annotations

from typing import Any

import gymnasium
from gymnasium.vector import SyncVectorEnv, VectorEnv

from surefoot.base.errors import ProblemError
from surefoot.records import BatchReport
from surefoot.worlds.mujoco.environment_data import model_and_data
from surefoot.worlds.mujoco.episode.episode_audit import EpisodeAudit
from surefoot.worlds.mujoco.spec import import_mujoco
from surefoot.worlds.training.episode_info import KEY, info_of


class AuditWrapper(gymnasium.Wrapper):  # type: ignore[misc]
    """Audit every episode of a MuJoCo environment, every step of the simulation, into its ``info``.

    At an episode's end ``info["audit"]`` says what `surefoot.audit_log` says of its contacts' laws. An
    episode that is given up is audited by the next `reset`, into the info that this returns. Rewards,
    observations and states are those of the plain environment to the last bit. `report` is the last
    episode's, with its log where that is not proven lawful.

    Parameters
    ----------
    env
        An environment whose steps are made by MuJoCo's functions in Python: gymnasium's, those of
        gymnasium_robotics, dm_control's. Or a `SyncVectorEnv`: its environments are wrapped where they
        stand, and it is returned itself. Workers wrap their own: ``gymnasium.make_vec(name, num_envs=8,
        vectorization_mode="async", wrappers=[sf.rl.AuditWrapper])``.
    robot
        Name of the body at the robot's root, see `surefoot.record`.

    Raises
    ------
    ProblemError
        For what is no environment of MuJoCo, and for workers that have made their environments.
    """

    def __new__(cls, env: Any = None, robot: str | None = None) -> Any:  # copies come without one
        """Return the wrapper of an environment, or the vector environment that was given."""
        if isinstance(env, VectorEnv):
            return _wrap_each(env, robot)
        return super().__new__(cls)

    def __init__(self, env: Any, robot: str | None = None) -> None:
        super().__init__(env)
        self._robot, self._core = robot, env.unwrapped
        self._mujoco = import_mujoco()
        self._audit: EpisodeAudit | None = None
        self.report: BatchReport | None = None
        self._watch()

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Step the environment; the last step of an episode has its audit in ``info["audit"]``."""
        audit = self._watch()
        seen, reward, terminated, truncated, info = self.env.step(action)
        audit.earn(float(reward))
        if terminated or truncated:
            info = {**info, KEY: self._finish(audit)}
        return seen, reward, terminated, truncated, info

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Reset the environment; an episode that was given up is audited into ``info["audit"]``."""
        audit = self._watch()
        told = self._finish(audit) if audit.rows else None
        audit.pause()
        seen, info = self.env.reset(seed=seed, options=options)
        self._watch().begin()
        return seen, info if told is None else {**info, KEY: told}

    def close(self) -> None:
        """Close the environment; its steps are seen no more."""
        if self._audit is not None:
            self._audit.close()
            self._audit = None
        super().close()

    def __getstate__(self) -> dict[str, Any]:
        # places in memory are those of this process and this data
        return {**self.__dict__, "_audit": None, "_mujoco": None, "_core": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._mujoco, self._core = import_mujoco(), self.env.unwrapped

    def _watch(self) -> EpisodeAudit:
        """Return the audit of the environment's present model and data."""
        core, audit = self._core, self._audit
        if audit is not None and audit.of(getattr(core, "model", None), getattr(core, "data", None)):
            return audit
        model, data = model_and_data(self._mujoco, core)
        if self._audit is None or not self._audit.of(model, data):
            if self._audit is not None:
                self._audit.close()
            self._audit = EpisodeAudit(self._mujoco, model, data, self._robot)
        return self._audit

    def _finish(self, audit: EpisodeAudit) -> dict[str, Any]:
        """Return what is told of the episode that ends."""
        self.report, rate = audit.finish()
        return info_of(self.report, rate)


def _wrap_each(envs: Any, robot: str | None) -> Any:
    """Wrap the environments of a vector environment, and return it."""
    core = envs.unwrapped
    if not isinstance(core, SyncVectorEnv):
        raise ProblemError(
            f"AuditWrapper cannot reach the environments of {type(core).__name__}: let them be wrapped where "
            "they are made, gymnasium.make_vec(..., wrappers=[sf.rl.AuditWrapper])"
        )
    core.envs = type(core.envs)(AuditWrapper(env, robot) for env in core.envs)
    return envs
