"""How kernels are compiled, in one of two ways with the same answers.

`numba_internals` compiles every tree of calls once, and keeps it on disk under the code it was made from. It
relies on private parts of Numba, and is the only file that does. `plain` needs none of them: every kernel is
an ordinary `numba.njit(cache=True)`, slower to compile. `choice` takes the first way where the version of
Numba is one that it is known to work with, else the second; SUREFOOT_PLAIN_NUMBA=1 asks for the second.

Numba compiles every function on its own: optimises it, makes machine code of it, wraps it for Python, and
does so again for each caller that it is linked into. In the first way a kernel that is called by a kernel is
only translated; optimisation and machine code come once, for the kernel that Python calls, with the whole
`tree` in one module. `turns` lets one process compile and others wait, `progress` says what is going on,
`clock` stands still meanwhile. `cold_start` lets Python run a kernel where one short question is all that is
asked.
"""

from __future__ import annotations

from surefoot.base.compilation.choice import PLAIN_BECAUSE
from surefoot.base.compilation.clock import working_time
from surefoot.base.compilation.progress import LOG

if PLAIN_BECAUSE:
    from surefoot.base.compilation.plain import (
        borrowed,
        cache_folders,
        compiled,
        compiled_so_far,
        entry_point,
        keep,
        kept_files,
        window,
    )
else:
    from surefoot.base.compilation.numba_internals import (
        cache_folders,
        compiled,
        entry_point,
        kept_files,
    )
    from surefoot.base.compilation.progress import compiled_so_far
    from surefoot.base.compilation.uncounted import borrowed, keep, window

__all__ = [
    "LOG",
    "PLAIN_BECAUSE",
    "borrowed",
    "cache_folders",
    "compiled",
    "compiled_so_far",
    "entry_point",
    "keep",
    "kept_files",
    "window",
    "working_time",
]
