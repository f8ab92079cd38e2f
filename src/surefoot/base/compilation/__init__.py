"""How kernels are compiled: every tree of calls once, and kept on disk under the code that it was made from.

Numba compiles every function on its own: optimises it, makes machine code of it, wraps it for Python, and
does so again for each caller that it is linked into. Here a kernel that is called by a kernel is only
translated (`Part`); optimisation and machine code come once, for the kernel that Python calls, with
the whole tree in one module. That halves the time of a first call and changes no result.

Numba keeps compiled code as long as the kernel's own file is the same. Here the key is the code itself:
that of the kernel, of all kernels that it calls and of the constants that they read, wherever they are
written.
"""

from __future__ import annotations

from surefoot.base.compilation.cache import cache_folders
from surefoot.base.compilation.dispatcher import Kernel
from surefoot.base.compilation.progress import LOG, compiled_so_far

__all__ = ["LOG", "Kernel", "cache_folders", "compiled_so_far"]
