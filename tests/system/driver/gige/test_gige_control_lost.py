"""Control that goes to another program while ours could not talk to the camera."""

from __future__ import annotations

import os
import queue
import time
from contextlib import closing

import pytest

from grabbergui.core.errors import AccessDeniedError, AckTimeoutError, DeviceLostError
from grabbergui.core.grabber import Access, ConnectionState
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.gige import control_link, privilege
from grabbergui.driver.gige.bootstrap import BootstrapRegister, ControlPrivilege, GvcpCapability
from grabbergui.driver.gige.control_channel import ControlChannel, ControlTiming
from grabbergui.driver.gige.control_link import ControlLink
from grabbergui.driver.gige.device import GigeDevice, GigeOptions
from grabbergui.driver.gige.gvcp import Request, WriteReg
from grabbergui.driver.gige.heartbeat import Pulse
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import PATIENCE, until


def test_another_program_in_control_is_noticed_and_named() -> None:
    with closing(GigeCamera(f"127.81.{os.getpid() % 250 + 1}.1")) as simulated:
        camera = DeviceGrabber(GigeDevice(simulated.address))
        states: queue.Queue[tuple[ConnectionState, str]] = queue.Queue()
        camera.open()
        camera.connection_changed.connect(lambda state, why: states.put((state, why)))
        with closing(camera), closing(ControlLink(simulated.address)) as other:
            simulated.control.release()  # as when our heartbeat did not get through for three seconds
            other.execute(WriteReg(((BootstrapRegister.CCP, ControlPrivilege.CONTROL),)))
            state, why = states.get(timeout=PATIENCE)
            assert state is ConnectionState.LOST
            assert why.startswith(("another application, at 127.0.0.1", "the camera took our control back"))
            other.execute(WriteReg(((BootstrapRegister.CCP, 0),)))
            state, _ = states.get(timeout=PATIENCE)
            assert state is ConnectionState.OPEN, "it is ours again when the other leaves"


@pytest.mark.parametrize("taken", [False, True])
def test_a_refused_write_notices_that_control_is_gone(monkeypatch: pytest.MonkeyPatch, taken: bool) -> None:
    """A camera that restarted between two beats is lost, not controlled by another application."""
    monkeypatch.setattr(Pulse, "for_timeout", lambda timeout_ms: Pulse(period=1.5))
    with closing(GigeCamera(f"127.81.{os.getpid() % 250 + 1}.7")) as simulated:
        camera = DeviceGrabber(GigeDevice(simulated.address))
        states: queue.Queue[ConnectionState] = queue.Queue()
        camera.open()
        camera.write_feature("ExposureTime", 1500.0)
        camera.connection_changed.connect(lambda state, why: states.put(state))
        with closing(camera), closing(ControlLink(simulated.address)) as other:
            simulated.control.release()
            if taken:
                other.execute(WriteReg(((BootstrapRegister.CCP, ControlPrivilege.CONTROL),)))
            with pytest.raises(DeviceLostError, match="took control" if taken else "has restarted"):
                camera.write_feature("ExposureTime", 1600.0)
            assert states.get(timeout=PATIENCE) is ConnectionState.LOST
            if taken:
                other.execute(WriteReg(((BootstrapRegister.CCP, 0),)))
            assert states.get(timeout=PATIENCE) is ConnectionState.OPEN
            assert camera.feature("ExposureTime").value == 1500.0


def test_opening_that_fails_half_way_gives_control_back(monkeypatch: pytest.MonkeyPatch) -> None:
    with closing(GigeCamera(f"127.81.{os.getpid() % 250 + 1}.2")) as simulated:
        device = GigeDevice(simulated.address)

        def refuse(link: ControlLink, capability: GvcpCapability) -> None:
            assert simulated.control.controlled
            raise AckTimeoutError("no answer")

        monkeypatch.setattr(privilege, "holder_of", refuse)
        with pytest.raises(AckTimeoutError):
            device.open(Access.CONTROL)
        assert not simulated.control.controlled


def test_control_whose_grant_was_lost_on_the_way_is_given_back(monkeypatch: pytest.MonkeyPatch) -> None:
    """The link that has it is closed: until the camera forgets it, nobody could take control."""
    execute = ControlLink.execute

    def lose_grant(link: ControlLink, request: Request, timing: ControlTiming | None = None) -> bytes:
        answer = execute(link, request, timing)
        if isinstance(request, WriteReg) and request.writes == (
            (BootstrapRegister.CCP, ControlPrivilege.CONTROL),
        ):
            assert simulated.control.controlled
            raise AckTimeoutError("no answer")
        return answer

    with closing(GigeCamera(f"127.81.{os.getpid() % 250 + 1}.5")) as simulated:
        with monkeypatch.context() as patch, pytest.raises(AccessDeniedError):
            patch.setattr(ControlLink, "execute", lose_grant)
            GigeDevice(simulated.address).open(Access.CONTROL)
        assert not simulated.control.controlled


def test_a_camera_that_was_only_slow_gives_its_control_back(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is taken for lost while its heart goes on: it must not keep us out until that expires."""
    with closing(GigeCamera(f"127.81.{os.getpid() % 250 + 1}.6")) as simulated:
        device = GigeDevice(simulated.address)
        device.open(Access.CONTROL)
        assert simulated.control.controlled
        monkeypatch.setattr(ControlLink, "lost", "it has not answered")
        device.close()
        until(lambda: not simulated.control.controlled, "the release")


@pytest.mark.parametrize("named", [True, False], ids=["by serial number", "by address"])
def test_a_camera_that_is_gone_is_closed_at_once(monkeypatch: pytest.MonkeyPatch, named: bool) -> None:
    """An attempt to find it again is ended, however long a search or a command would wait."""
    with closing(GigeCamera(f"127.81.{os.getpid() % 250 + 1}.8")) as simulated:
        name = simulated.serial if named else simulated.address
        device = GigeDevice(name, GigeOptions(search_timeout=4 * PATIENCE if named else 1.0))
        camera = DeviceGrabber(device)
        camera.open()
        patient = ControlTiming(ack_timeout=4 * PATIENCE, tries=1)
        monkeypatch.setattr(control_link, "ControlChannel", lambda timing: ControlChannel(timing or patient))
        attempts = queue.SimpleQueue[None]()
        stage = "_link_to" if not named else "search"
        original = getattr(device, stage)
        monkeypatch.setattr(device, stage, lambda *found: (attempts.put(None), original(*found))[1])
    attempts.get(timeout=PATIENCE)
    begun = time.monotonic()
    camera.close()
    assert time.monotonic() - begun < PATIENCE


def test_a_camera_that_was_closed_during_an_attempt_can_be_opened_again() -> None:
    with closing(GigeCamera(f"127.81.{os.getpid() % 250 + 1}.9")) as simulated:
        device = GigeDevice(simulated.address)
        device.interrupt()
        with pytest.raises(DeviceLostError, match="was closed while it was opened"):
            device.open(Access.CONTROL)
        with closing(DeviceGrabber(device)) as camera:
            camera.open()
            assert simulated.control.controlled
        assert not simulated.control.controlled


def test_control_is_taken_from_one_who_offers_it_and_stays_taken() -> None:
    with closing(GigeCamera(f"127.81.{os.getpid() % 250 + 1}.3")) as simulated:
        first, second = (DeviceGrabber(GigeDevice(simulated.address)) for _ in range(2))
        states: queue.Queue[tuple[ConnectionState, str]] = queue.Queue()
        with closing(first), closing(second):
            first.open()
            first.start()
            first.connection_changed.connect(lambda state, why: states.put((state, why)))
            with pytest.raises(AccessDeniedError):
                second.open()
            second.open(Access.TAKE_OVER)
            assert second.access is Access.CONTROL
            state, why = states.get(timeout=PATIENCE)
            assert state is ConnectionState.LOST and "another application" in why
            frames = second.open_queue()
            second.start()
            assert frames.get(PATIENCE).complete
            assert second.write_feature("ExposureTime", 1500.0).value == 1500.0
            # The first looks for the camera all the while, but does not take it back.
            with pytest.raises(queue.Empty):
                states.get(timeout=1.5)
            assert second.write_feature("ExposureTime", 1600.0).value == 1600.0
            second.close()
            assert states.get(timeout=PATIENCE)[0] is ConnectionState.OPEN


def test_what_another_program_changed_is_named_when_control_is_back_and_left_so() -> None:
    """What was set here is set again; of the rest, what was known here is compared."""
    with closing(GigeCamera(f"127.81.{os.getpid() % 250 + 1}.9")) as simulated:
        first, second = (DeviceGrabber(GigeDevice(simulated.address)) for _ in range(2))
        back: queue.Queue[str] = queue.Queue()
        with closing(first), closing(second):
            first.open()
            first.features()  # as the panel reads them
            first.write_feature("Gain", 3.0)
            first.start()
            first.connection_changed.connect(
                lambda state, why: back.put(why) if state is ConnectionState.OPEN else None
            )
            second.open(Access.TAKE_OVER)
            for name, value in (("Gain", 6.0), ("Gamma", 2.0), ("ExposureAuto", "Continuous")):
                second.write_feature(name, value)
            second.close()
            changes = ("ExposureAuto is Continuous instead of Off", "Gamma is 2 instead of 1")
            assert back.get(timeout=PATIENCE) == (
                f"set as before; changed meanwhile, not by us: {'; '.join(changes)}"
            )
            assert (first.unlike_before, first.changed_meanwhile) == ((), changes)
            found = [first.feature(name).value for name in ("Gain", "Gamma", "ExposureAuto")]
            assert found == [3.0, 2.0, "Continuous"] and first.streaming


def test_control_is_not_taken_from_one_who_does_not_offer_it() -> None:
    address = f"127.81.{os.getpid() % 250 + 1}.4"
    with (
        closing(GigeCamera(address)),
        closing(ControlLink(address)) as holder,
        closing(DeviceGrabber(GigeDevice(address))) as camera,
    ):
        holder.execute(WriteReg(((BootstrapRegister.CCP, ControlPrivilege.CONTROL),)))
        with pytest.raises(AccessDeniedError, match="this program controls"):
            camera.open(Access.TAKE_OVER)
        holder.execute(WriteReg(((BootstrapRegister.CONTROL_SWITCHOVER_KEY, 0x1234),)))
        holder.execute(
            WriteReg(((BootstrapRegister.CCP, ControlPrivilege.CONTROL | ControlPrivilege.SWITCHOVER),))
        )
        with pytest.raises(AccessDeniedError, match="this program controls"):
            camera.open(Access.TAKE_OVER)
        holder.execute(WriteReg(((BootstrapRegister.CCP, 0),)))
        camera.open(Access.TAKE_OVER)
