"""Contact for whoever trains a policy: terms of rewards, audits and logs of episodes, rollouts, contacts."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from surefoot.worlds.training import terms

if TYPE_CHECKING:
    from surefoot.worlds.training.audit_wrapper import AuditWrapper as AuditWrapper
    from surefoot.worlds.training.contact_arrays import contact_arrays as contact_arrays
    from surefoot.worlds.training.record_wrapper import RecordWrapper as RecordWrapper
    from surefoot.worlds.training.rollout_logs import log_rollouts as log_rollouts

__all__ = ["AuditWrapper", "RecordWrapper", "contact_arrays", "log_rollouts", "terms"]
_WRAPPERS = {"AuditWrapper": "audit_wrapper", "RecordWrapper": "record_wrapper"}
_FUNCTIONS = {"contact_arrays": "contact_arrays", "log_rollouts": "rollout_logs"}


def __getattr__(name: str) -> object:
    if name in _WRAPPERS:
        from surefoot.base.errors import needs

        with needs("gymnasium", "gym"):
            import gymnasium  # noqa: F401
    module = {**_WRAPPERS, **_FUNCTIONS}.get(name)
    if module is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"surefoot.worlds.training.{module}"), name)
