"""Which of the two ways kernels are compiled in, chosen once when the first kernel is imported."""

from __future__ import annotations

import logging
import os
import re

import numba

from surefoot.base.compilation.progress import LOG

KNOWN = (0, 61), (0, 69)
"""Versions of Numba from the first up to, not including, the second have the private parts that
`numba_internals` relies on, behaving as it says there. `pyproject.toml` has the same bounds."""
ASKED = "SUREFOOT_PLAIN_NUMBA"
OFF = "NUMBA_DISABLE_JIT is set"


def unknown_version(version: str) -> str:
    """Return why `numba_internals` is not for a version of Numba; "" if it is."""
    numbers = tuple(int(number) for number in re.findall(r"\d+", version)[:2])
    if KNOWN[0] <= numbers < KNOWN[1]:
        return ""
    low, high = (".".join(map(str, bound)) for bound in KNOWN)
    return f"Numba {version} is not one of those whose private parts are known (from {low}, before {high})"


def plain_because() -> str:
    """Return why kernels are compiled the plain way; "" if they are not."""
    if numba.config.DISABLE_JIT:
        return OFF
    if os.environ.get(ASKED, "0") not in ("", "0"):
        return f"{ASKED} is set"
    if why := unknown_version(numba.__version__):
        return why
    try:
        from surefoot.base.compilation import numba_internals

        numba_internals.check()
    except Exception as error:  # whatever a private part that has changed raises
        return f"Numba {numba.__version__} has changed a private part: {error}"
    return ""


PLAIN_BECAUSE = plain_because()
"""Why kernels are compiled by ordinary `numba.njit`; "" if whole trees are, by Numba's private parts."""

if PLAIN_BECAUSE and PLAIN_BECAUSE != OFF:
    # whoever asked for it knows; who has another Numba should hear why the first call is slow
    LOG.log(
        logging.INFO if PLAIN_BECAUSE.startswith(ASKED) else logging.WARNING,
        "kernels are compiled by plain numba.njit, slower the first time, with the same answers: %s",
        PLAIN_BECAUSE,
    )
