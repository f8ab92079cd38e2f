"""Where samples are run: processes of this machine, a Ray or a Dask cluster; one per file."""

from surefoot.sweep.pools.pool import Pool, open_pool
from surefoot.sweep.pools.table import BACKENDS

__all__ = ["BACKENDS", "Pool", "open_pool"]
