"""What a camera object reports to callbacks: changes, events, loss and return."""

from __future__ import annotations

import threading

import grabbergui
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import PATIENCE

ADDRESS = "127.20.1.1"


def test_a_lost_camera_reports_it_and_comes_back() -> None:
    simulated = GigeCamera(ADDRESS)
    try:
        with grabbergui.open(f"gige:{ADDRESS}") as camera:
            lost, back = threading.Event(), threading.Event()
            camera.on("lost", lambda why: lost.set())
            camera.on("back", lambda why: back.set())
            camera.exposure_time = 3000
            simulated.close()
            assert lost.wait(PATIENCE)
            simulated = GigeCamera(ADDRESS)
            assert back.wait(PATIENCE)
            assert camera.exposure_time == 3000.0
    finally:
        simulated.close()
