"""Kernels as Python sees them, and as other kernels do."""

from __future__ import annotations

from typing import Any

from numba.core import types
from numba.core.datamodel import models, register_default
from numba.core.imputils import lower_constant
from numba.core.registry import CPUDispatcher

from surefoot.base.compilation.cache import Cache
from surefoot.base.compilation.parts import WHOLE_TREES, PartCompiler
from surefoot.base.compilation.progress import LOG, progress
from surefoot.base.compilation.tree import KernelTree


class KernelType(types.Dispatcher):
    """A kernel given to a kernel as an argument: its type says which, and its value is nothing."""


register_default(KernelType)(models.OpaqueModel)


@lower_constant(KernelType)  # type: ignore[untyped-decorator]
def _no_address(context: Any, builder: Any, kind: KernelType, kernel: Any) -> Any:
    """Return null, where Numba would write the object's address into code that could then not be kept."""
    return context.get_dummy_value()


class _PartDispatcher(CPUDispatcher):  # type: ignore[misc]
    """A kernel as other kernels see it."""

    def compile(self, sig: Any) -> Any:
        found = super().compile(sig)
        progress.passed(self.py_func)
        return found


class Kernel(CPUDispatcher):  # type: ignore[misc]
    """A compiled function; called from Python it is the top of its own tree.

    It may not call itself.
    """

    _cache: Any

    def __init__(self, py_func: Any, locals: Any = None, targetoptions: Any = None, **options: Any) -> None:
        super().__init__(py_func, locals, targetoptions, **options)
        self._tree: KernelTree | None = None
        self._part: CPUDispatcher | None = None

    @property
    def _numba_type_(self) -> KernelType:
        return KernelType(self)

    @property
    def tree(self) -> KernelTree:
        """What this kernel is compiled from."""
        if self._tree is None:
            self._tree = KernelTree.below(self)
        return self._tree

    def compile(self, sig: Any) -> Any:
        """Compile for argument types, or load what has been compiled before; return the compiled function."""
        if self._tree is None:
            try:
                self._cache = Cache(self.py_func, self.tree)
            except RuntimeError as error:  # nowhere to write to
                LOG.warning("%s", error)
        try:
            return super().compile(sig)
        finally:
            if isinstance(self._cache, Cache):
                self._cache.end_turn()

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return what a kernel that calls this one is given of it."""
        return self._for_kernels().get_call_template(args, kws)

    def get_overload(self, sig: Any) -> Any:
        """Return what a kernel that calls this one links."""
        return self._for_kernels().get_overload(sig)

    def _for_kernels(self) -> CPUDispatcher:
        if self._part is None:
            # what only kernels call needs no way in from Python or C
            options = {**self.targetoptions, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
            more = {"pipeline_class": PartCompiler} if WHOLE_TREES else {}
            self._part = _PartDispatcher(self.py_func, {}, options, **more)
        return self._part
