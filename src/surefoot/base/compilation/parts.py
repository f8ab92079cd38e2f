"""Kernels that are called by kernels: translated, and left to the caller to optimise and to compile."""

from __future__ import annotations

from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

_HOOKS = ("_optimize_final_module", "_finalize_final_module", "get_pointer_to_function", "codegen")
WHOLE_TREES = all(hasattr(JITCodeLibrary, name) for name in _HOOKS)
"""Whether this Numba has what `Part` overrides; else kernels compile one by one, as Numba does."""


class Part(JITCodeLibrary):  # type: ignore[misc]
    """The translated code of a kernel that is called by kernels, to be linked into theirs as it is."""

    def _optimize_final_module(self) -> None:
        """Leave that to the caller, who has more to go by."""

    def _finalize_final_module(self) -> None:
        """Make no machine code."""
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0, for nothing here can be called."""
        self._ensure_finalized()
        return 0

    @property
    def codegen(self) -> Part:
        """Itself, whose `set_env` has nowhere to write to."""
        return self

    def set_env(self, env_name: str, env: Any) -> None:
        """Do nothing; see `Cache.save_overload`."""


class PartCompiler(Compiler):  # type: ignore[misc]
    """Numba's pipeline, into a `Part`."""

    def define_pipelines(self) -> Any:
        """Return the usual passes, and give them a `Part` to write to."""
        name = self.state.func_id.func_qualname
        self.state.library = Part(self.state.targetctx.codegen(), name)
        return super().define_pipelines()
