"""TEO, simulated."""

from __future__ import annotations

from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot


class SimTeo(SimRobot):
    """TEO's head and right arm."""

    def __init__(self) -> None:
        super().__init__(teo.BODY)
