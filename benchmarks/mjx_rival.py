"""MJX beside exact contact: a box on four contacts, stepped in a batch, and the gradients of its step.

MJX solves MuJoCo's soft problem, not ours: its row says what a user pays for a step with four contacts, how
fast corners still go into the ground after it, and whether its derivative is that of the step. Forward mode:
its solver loops until it has converged, which JAX cannot differentiate backwards.
"""

from __future__ import annotations

import importlib.util
from typing import Any, NamedTuple

import numpy as np

from benchmarks.timing import least_time
from surefoot.arrays import FloatArray

BOX = """<mujoco><option timestep="0.002" cone="pyramidal"/><worldbody>
<geom type="plane" size="5 5 1" friction="0.6"/>
<body pos="0 0 0.0999"><freejoint/><geom type="box" size="0.2 0.15 0.1" mass="5" friction="0.6"/></body>
</worldbody></mujoco>"""
CORNERS = np.array([[x, y, -0.1] for x in (-0.2, 0.2) for y in (-0.15, 0.15)])
STEP = 1e-6
"""Of the differences that its derivatives are held against."""
NOTHING = 1e-12
"""A derivative below this is zero."""


def mjx_present() -> bool:
    """Return whether MJX is installed."""
    return importlib.util.find_spec("jax") is not None and importlib.util.find_spec("mujoco.mjx") is not None


class MjxRow(NamedTuple):
    """Seconds a step and a step with its Jacobian; speed into the ground [m/s]; the Jacobian's faults.

    `error` is the median over the batch of the largest relative difference, `nan` and `zero` are the numbers
    of boxes whose Jacobian has a NaN, or vanishes.
    """

    step: float
    both: float
    inward: float
    error: float
    nan: int
    zero: int


def mjx_row(count: int, repeats: int) -> MjxRow:
    """Measure it on a batch of boxes that stand, slide and lift off."""
    import jax
    import jax.numpy as jnp
    import mujoco
    from mujoco import mjx

    jax.config.update("jax_enable_x64", True)
    model = mujoco.MjModel.from_xml_string(BOX)
    device, start = mjx.put_model(model), mjx.make_data(model)
    random = np.random.default_rng(0)
    speeds = random.normal(size=(count, 6)) * [0.5, 0.5, 0.2, 0.5, 0.5, 0.5]

    def after(v: Any) -> Any:
        return mjx.step(device, start.replace(qpos=jnp.asarray(model.qpos0), qvel=v)).qvel

    step = jax.jit(jax.vmap(after))
    both = jax.jit(jax.vmap(lambda v: (after(v), jax.jacfwd(after)(v))))
    out, slopes = (np.asarray(x) for x in both(speeds))
    wanted = np.stack(
        [
            (np.asarray(step(speeds + e)) - np.asarray(step(speeds - e))) / (2.0 * STEP)
            for e in STEP * np.eye(6)
        ],
        axis=2,
    )
    off = np.abs(slopes - wanted).max(axis=(1, 2)) / np.abs(wanted).max(axis=(1, 2))
    return MjxRow(
        least_time(lambda: jax.block_until_ready(step(speeds)), repeats) / count,
        least_time(lambda: jax.block_until_ready(both(speeds)), repeats) / count,
        float(max(0.0, -_heights_rate(out).min())),
        float(np.nanmedian(off)),
        int(np.isnan(slopes).any(axis=(1, 2)).sum()),
        int((np.abs(slopes) < NOTHING).all(axis=(1, 2)).sum()),
    )


def _heights_rate(v: FloatArray) -> FloatArray:
    """Return (B, 4) how fast the corners of upright boxes rise [m/s]; turns are about the body's own axes."""
    return np.asarray(v[:, None, 2] + np.cross(v[:, None, 3:], CORNERS)[..., 2])
