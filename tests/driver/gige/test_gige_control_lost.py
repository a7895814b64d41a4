"""Control that goes to another program while ours could not talk to the camera."""

from __future__ import annotations

import os
import queue
from contextlib import closing

import pytest

from grabbergui.core.errors import AckTimeoutError
from grabbergui.core.grabber import Access, ConnectionState
from grabbergui.driver.camera import Camera
from grabbergui.driver.gige.bootstrap import Capability, Control, Register
from grabbergui.driver.gige.control_link import ControlLink
from grabbergui.driver.gige.device import GigeDevice
from grabbergui.driver.gige.gvcp import WriteReg
from grabbergui.driver.sim.gige.server import GigeCamera


def test_another_program_in_control_is_noticed_and_named() -> None:
    with closing(GigeCamera(f"127.81.{os.getpid() % 250 + 1}.1")) as simulated:
        camera = Camera(GigeDevice(simulated.address))
        states: queue.Queue[tuple[ConnectionState, str]] = queue.Queue()
        camera.open()
        camera.connection_changed.connect(lambda state, why: states.put((state, why)))
        with closing(camera), closing(ControlLink(simulated.address)) as other:
            simulated.control.release()  # as when our heartbeat did not get through for three seconds
            other.execute(WriteReg(((Register.CCP, Control.CONTROL),)))
            state, why = states.get(timeout=2)
            assert state is ConnectionState.LOST
            assert why.startswith(("another application, at 127.0.0.1", "the camera took our control back"))
            other.execute(WriteReg(((Register.CCP, 0),)))
            assert states.get(timeout=5)[0] is ConnectionState.OPEN, "it is ours again when the other leaves"


def test_opening_that_fails_half_way_gives_control_back(monkeypatch: pytest.MonkeyPatch) -> None:
    with closing(GigeCamera(f"127.81.{os.getpid() % 250 + 1}.2")) as simulated:
        device = GigeDevice(simulated.address)

        def refuse(link: ControlLink, capability: Capability) -> None:
            assert simulated.control.controlled
            raise AckTimeoutError("no answer")

        monkeypatch.setattr(device, "_holder", refuse)
        with pytest.raises(AckTimeoutError):
            device.open(Access.CONTROL)
        assert not simulated.control.controlled
