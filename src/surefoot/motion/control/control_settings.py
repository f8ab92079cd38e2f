"""Settings of the controllers of the whole body."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.settings import Settings, setting


@dataclass(frozen=True)
class BodyControlSettings(Settings):
    """Rates of the controllers of the whole body."""

    calm_time: float = setting(
        0.1, "s", "time within which an error of velocity is expected to die out", low=1e-06
    )
    speeding_rate: float = setting(
        200.0, "1/s", "rate at which joints that no contact loads approach their speed limits", low=0.0
    )
    stopping_rate: float = setting(30.0, "1/s", "rate at which such joints approach their stops", low=0.0)
    damping_rate: float = setting(
        10.0, "1/s", "rate at which joints are slowed when nothing else can be done", low=0.0
    )


BODY_CONTROL = BodyControlSettings()
"""The values in use; compiled code folds them when it is compiled."""
