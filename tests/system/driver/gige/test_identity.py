"""The camera that was named is the one that is opened, and the same one comes back."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from dataclasses import replace

import pytest

from grabbergui import sources
from grabbergui.core.errors import AccessDeniedError, OtherCameraError
from grabbergui.core.grabber import Access, ConnectionState
from grabbergui.core.uri import SourceUri
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.gige import bootstrap, device
from grabbergui.driver.gige.address_commands import force_ip
from grabbergui.driver.gige.device import GigeDevice
from grabbergui.driver.gige.identity import ForceIp
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import until

SERIAL = "TWIN"
ATTEMPTS = 100
_numbers = itertools.count(1)


def address() -> str:
    return f"127.12.7.{next(_numbers)}"


@pytest.fixture
def simulate() -> Iterator[Callable[..., GigeCamera]]:
    """Starts a simulated camera of the serial number that others have too."""
    with ExitStack() as stack:

        def start(ip: str, *, serial: str = SERIAL, model: str = "Twin", user_name: str = "") -> GigeCamera:
            power_on = {
                reg.DEVICE_SERIAL_NUMBER: serial,
                reg.DEVICE_MODEL_NAME: model,
                reg.DEVICE_USER_ID: user_name or ip,
            }
            return stack.enter_context(closing(GigeCamera(ip, power_on=power_on)))

        yield start


def test_of_two_cameras_of_one_serial_both_in_use_the_named_one_answers(simulate) -> None:
    twins = [simulate(address()), simulate(address())]
    with ExitStack() as stack:
        for twin in twins:
            user = stack.enter_context(closing(GigeDevice(twin.address)))
            user.open(Access.CONTROL)
        for twin in itertools.islice(itertools.cycle(twins), ATTEMPTS):
            with closing(GigeDevice(twin.address)) as device:
                with pytest.raises(AccessDeniedError):  # as `get` does: control first, then reading only
                    device.open(Access.CONTROL)
                device.open(Access.MONITOR)
                named = device.read(bootstrap.USER_NAME.address, bootstrap.USER_NAME.length)
                assert named.rstrip(b"\0").decode() == twin.address == device.info.address
                assert device.info.uri == f"gige:{twin.address}"


def test_a_name_that_two_cameras_have_opens_neither_and_names_both(simulate) -> None:
    twins = [simulate(address(), serial="SAME"), simulate(address(), serial="SAME")]
    with closing(GigeDevice("SAME")) as device, pytest.raises(OtherCameraError) as refusal:
        device.open(Access.MONITOR)
    assert all(f"gige:{twin.address}" in str(refusal.value) for twin in twins)
    with closing(GigeDevice(device_mac(twins[1]))) as device:
        device.open(Access.MONITOR)
        assert device.info.address == twins[1].address


@pytest.mark.parametrize("other", [{"serial": "one"}, {"serial": "TWO", "user_name": "ONE"}])
def test_cameras_that_share_a_name_are_listed_by_names_that_lead_to_them(
    simulate, other: dict[str, str]
) -> None:
    cameras = [simulate(address(), serial="ONE"), simulate(address(), **other)]
    listed = {info.address: info.uri for info in device.discover(1.0)}
    for camera in cameras:
        with closing(GigeDevice(SourceUri.parse(listed[camera.address]).name)) as opened:
            opened.open(Access.MONITOR)
            assert opened.info.address == camera.address


def device_mac(camera: GigeCamera) -> str:
    with closing(GigeDevice(camera.address)) as device:
        device.open(Access.MONITOR)
        return device.info.hardware_id


def test_another_camera_at_the_named_address_is_refused_and_named_until_the_same_is_back(
    simulate, caplog
) -> None:
    ip = address()
    first = simulate(ip)
    grabber = sources.create(f"gige:{ip}")
    assert isinstance(grabber, DeviceGrabber)
    reported: list[tuple[ConnectionState, str]] = []
    grabber.connection_changed.connect(lambda state, reason: reported.append((state, reason)))
    with closing(grabber):
        grabber.open()
        first.close()
        until(lambda: reported[-1][0] is ConnectionState.LOST)
        other = simulate(ip, model="Another")
        until(lambda: "Another" in reported[-1][1])
        assert reported[-1][0] is ConnectionState.LOST and ip in reported[-1][1] and "Twin" in reported[-1][1]
        assert reported[-1][1] in caplog.text, "a command has nothing but the log to show it in"
        other.close()
        simulate(ip)
        until(lambda: reported[-1][0] is ConnectionState.OPEN)
        assert sum("Another" in reason for _, reason in reported) == 1, "said once, not at every attempt"
        assert grabber.info.model == "Twin"


def test_a_camera_named_by_serial_comes_back_at_another_address_and_no_other_in_its_place(simulate) -> None:
    home, elsewhere = address(), address()
    camera = simulate(home, serial="WANDERER")
    with closing(GigeDevice("WANDERER")) as device:
        device.open(Access.CONTROL)
        assert device.info.uri == "gige:WANDERER" and device.info.address == home
        device.close()
        camera.close()
        simulate(elsewhere, serial="WANDERER")  # of another MAC address, as that follows from the address
        with pytest.raises(OtherCameraError, match=elsewhere):
            device.open(Access.CONTROL)
        simulate(home, serial="WANDERER")
        device.open(Access.CONTROL)
        assert device.info.address == home


def test_a_camera_named_by_serial_is_found_again_where_it_was_moved_to(simulate) -> None:
    camera, elsewhere = simulate(address(), serial="NOMAD"), address()
    home = camera.address
    with closing(GigeDevice("NOMAD")) as device:
        device.open(Access.CONTROL)
        device.close()
        force_ip(ForceIp(device.info.hardware_id, elsewhere, "255.0.0.0"))
        device.open(Access.CONTROL)
        assert device.info.address == elsewhere != home


def test_an_answer_that_comes_from_another_camera_than_the_search_found_is_refused(
    simulate, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two cameras with one IP address: who is reached is not who was named."""
    camera = simulate(address(), serial="REACHED")
    found = GigeDevice.search

    def confused(device: GigeDevice):
        answer = found(device)
        return replace(answer, identity=replace(answer.identity, mac="00:11:22:33:44:55"))

    monkeypatch.setattr(GigeDevice, "search", confused)
    named_and_answering = rf"{camera.address}.*00:11:22:33:44:55.*force-ip"
    with closing(GigeDevice("REACHED")) as device, pytest.raises(OtherCameraError, match=named_and_answering):
        device.open(Access.CONTROL)
