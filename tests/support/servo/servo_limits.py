"""The limits of a robot that runs in real time on a machine that others use too."""

from __future__ import annotations

from dataclasses import replace

from grabbergui.servo.config import Config
from patience import allowance

LIMITS = ("image_timeout", "robot_timeout", "command_timeout", "freeze", "stuck", "guardian_timeout")


MOST = 30.0
"""Largest factor on them."""


def patient_config(factor: float | None = None) -> Config:
    """Return a configuration in which images and readings may be older if this machine is slow now.

    With the limits of a real robot it would rightly not move at all there. Tests in simulated time hold them.
    Other programs may start during a test, so one that checks no limit takes MOST as the `factor`.
    """
    config, slow = Config(), factor or min(3 * allowance(), MOST)
    relaxed = replace(config.safety, **{name: slow * getattr(config.safety, name) for name in LIMITS})
    object.__setattr__(config, "safety", relaxed)  # past the check, which holds every user to 0.2 s
    return config
