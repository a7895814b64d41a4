"""Closed, lost, streaming: what a camera says of itself, and the errors that a program catches."""

from __future__ import annotations

import threading
import time

import pytest

import grabbergui
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import PATIENCE, until

ADDRESS = "127.20.1.31"


def test_a_loss_is_raised_when_it_is_known() -> None:
    simulated = GigeCamera(ADDRESS)
    try:
        with (
            grabbergui.open(f"gige:{ADDRESS}") as camera,
            camera.frames(timeout=PATIENCE).started() as frames,
        ):
            next(frames)
            threading.Thread(target=simulated.close).start()
            lost = threading.Event()
            camera.on("lost", lambda why: lost.set())
            with pytest.raises(grabbergui.DeviceLostError, match=r"is lost: .*opened again"):
                while True:
                    next(frames)
            raised = time.monotonic()
            assert lost.wait(PATIENCE) and time.monotonic() - raised < PATIENCE / 2
            assert camera.state == "lost" and "lost: " in repr(camera)
            simulated = GigeCamera(ADDRESS)
            until(lambda: camera.state == "streaming", "the return")
            assert next(frames).complete
    finally:
        simulated.close()


def test_a_serial_number_alone_is_searched_among_all_kinds() -> None:
    simulated = GigeCamera("127.20.1.32", power_on={reg.DEVICE_SERIAL_NUMBER: "SIM7F3A"})
    try:
        with grabbergui.open("SIM7F3A") as camera:
            assert camera.info.bus == "GigE Vision" and camera.grab().complete
    finally:
        simulated.close()
    with pytest.raises(grabbergui.SourceNotFoundError, match=r"'SIM7F3A' was found; .*write its kind"):
        grabbergui.open("SIM7F3A")
    with pytest.raises(grabbergui.UsageError, match=r"did you mean file:run\.mcap"):
        grabbergui.open("run.mcap")
