"""Backends by name, one line each: what `--backend` chooses from."""

BACKENDS: dict[str, str] = {
    "loky": "surefoot.sweep.pools.loky:LokyPool",
    "ray": "surefoot.sweep.pools.ray:RayPool",
    "dask": "surefoot.sweep.pools.dask:DaskPool",
    "serial": "surefoot.sweep.pools.serial:SerialPool",
}
"""Name to "module:class", imported when asked for."""
