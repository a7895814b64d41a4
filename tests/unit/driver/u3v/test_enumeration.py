"""Which USB3 Vision camera a name leads to, and the errors if none can be opened."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from types import SimpleNamespace

import pytest

from grabbergui.core.errors import (
    AccessDeniedError,
    OtherCameraError,
    SourceNotFoundError,
    TransportError,
    UsageError,
)
from grabbergui.core.grabber import Access
from grabbergui.core.uri import SourceUri
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.u3v.backend import SimulatedBus
from grabbergui.driver.sim.u3v.device import SimulatedU3vDevice
from grabbergui.driver.sim.u3v.registers import Descriptors, UsbIdentity
from grabbergui.driver.u3v import device
from grabbergui.driver.u3v.device import U3vDevice
from grabbergui.driver.u3v.enumeration import find_camera, find_cameras


def test_a_camera_is_found_by_serial_guid_or_place() -> None:
    bus = SimulatedBus(SimulatedU3vDevice())
    for name in ("", "SIM001", "sim001", "GRUI00SIM001", "1-1"):
        assert find_camera(name, bus).info.serial == "SIM001"
    with pytest.raises(SourceNotFoundError, match="there is u3v:SIM001"):
        find_camera("OTHER", bus)
    assert bus.opened == 0


def test_the_uri_of_any_serial_number_leads_to_its_camera() -> None:
    bus = SimulatedBus(SimulatedU3vDevice(CameraModel(power_on={reg.DEVICE_SERIAL_NUMBER: "50%?A"})))
    (found,) = find_cameras(bus)
    assert find_camera(SourceUri.parse(found.info.uri).name, bus).info.serial == "50%?A"


def test_the_first_camera_is_missed_by_its_own_name() -> None:
    first, other = camera_of("First"), camera_of("Other")
    bus = SimulatedBus(first)
    wanted = replace(find_camera("", bus).info, serial="SIM007")
    bus.camera = other
    with pytest.raises(SourceNotFoundError, match=r"serial SIM007.* is not plugged in; there is u3v:SIM001"):
        find_camera("", bus, wanted)


class TwoPorts(SimulatedBus):
    """Two cameras, at 1-1 and 1-2."""

    def __init__(self, *cameras: SimulatedU3vDevice) -> None:
        super().__init__(cameras[0])
        self.cameras = cameras

    def enumerate_devices(self) -> list[SimulatedU3vDevice]:
        return list(self.cameras)

    def open_device(self, dev: SimulatedU3vDevice) -> object:
        self.camera = dev  # one is open at a time
        return super().open_device(dev)

    def get_device_descriptor(self, dev: SimulatedU3vDevice) -> SimpleNamespace:
        port = self.cameras.index(dev) + 1
        descriptor = super().get_device_descriptor(dev)
        descriptor.address, descriptor.port_numbers = port, (port,)
        return descriptor


def camera_of(model: str) -> SimulatedU3vDevice:
    return SimulatedU3vDevice(CameraModel(power_on={reg.DEVICE_MODEL_NAME: model}))


@dataclass(frozen=True)
class ChosenIdentity(UsbIdentity):
    chosen_guid: str

    @property
    def guid(self) -> str:
        return self.chosen_guid


def camera_with_guid(guid: str) -> SimulatedU3vDevice:
    """A camera of the default serial number."""
    camera = SimulatedU3vDevice()
    camera.identity = ChosenIdentity(**asdict(camera.identity), chosen_guid=guid)
    camera.descriptors = Descriptors(camera.identity)
    return camera


def test_a_serial_number_that_two_cameras_have_opens_neither_and_names_both() -> None:
    bus = TwoPorts(SimulatedU3vDevice(), SimulatedU3vDevice())
    with pytest.raises(OtherCameraError, match=r"u3v:1-1, .* and u3v:1-2, "):
        find_camera("SIM001", bus)
    assert find_camera("1-2", bus).info.address == "1-2"


@pytest.mark.parametrize(
    ("guids", "uris"),
    [
        (("ACME0000000A", "ACME0000000B"), ["u3v:ACME0000000A", "u3v:ACME0000000B"]),
        (("ACME0000000A", "acme0000000a"), ["u3v:1-1", "u3v:1-2"]),
        (("ACME0000000A", "SIM001"), ["u3v:ACME0000000A", "u3v:1-2"]),
    ],
)
def test_two_cameras_of_one_serial_number_are_listed_and_opened_by_uris_of_their_own(
    guids: tuple[str, str], uris: list[str]
) -> None:
    cameras = [camera_with_guid(guid) for guid in guids]
    bus = TwoPorts(*cameras)
    found = find_cameras(bus)
    assert [camera.info.uri for camera in found] == uris
    for place, uri in enumerate(uris):
        cameras[place].start()
        opened = U3vDevice(SourceUri.parse(uri).name, backend=bus)
        opened.open(Access.CONTROL)
        assert (opened.info.address, opened.info.uri) == (f"1-{place + 1}", uri)
        opened.close()
        cameras[place].stop()


def test_a_serial_number_that_is_the_name_of_another_camera_is_no_uri() -> None:
    named = SimulatedU3vDevice(CameraModel(power_on={reg.DEVICE_USER_ID: "sim001"}))
    plain = camera_with_guid("ACME0000000A")
    found = find_cameras(TwoPorts(plain, named))
    assert [camera.info.uri for camera in found] == ["u3v:ACME0000000A", "u3v:GRUI00SIM001"]


@pytest.mark.parametrize("name", ["", "SIM001", "1-1"])
def test_another_camera_of_the_same_serial_number_is_refused_in_its_place(name: str) -> None:
    first, other = camera_of("First"), camera_of("Other")
    bus = SimulatedBus(first)
    device = U3vDevice(name, backend=bus)
    device.open(Access.CONTROL)
    assert device.info.uri == f"u3v:{name or 'SIM001'}"
    device.close()
    bus.camera = other
    with pytest.raises((OtherCameraError, SourceNotFoundError), match=r"Other|SIM001"):
        device.open(Access.CONTROL)
    bus.camera = first
    device.open(Access.CONTROL)
    assert device.info.model == "First"
    device.close()
    assert bus.opened == 0


def test_without_permission_the_camera_is_listed_with_the_cure() -> None:
    bus = SimulatedBus(SimulatedU3vDevice(), forbidden=True)
    (found,) = find_cameras(bus)
    assert "setup udev" in found.info.note
    with pytest.raises(AccessDeniedError, match=r"sudo /.* setup udev"):
        U3vDevice(backend=bus).open(Access.CONTROL)


class WithoutDriver(SimulatedBus):
    """libusb has no driver through which it can open the camera, as on Windows until WinUSB is chosen."""

    def open_device(self, dev: SimulatedU3vDevice) -> object:
        raise NotImplementedError("Operation not supported or unimplemented on this platform")


def test_a_camera_without_a_usable_driver_is_listed_and_refused_in_plain_words() -> None:
    bus = WithoutDriver(SimulatedU3vDevice())
    (found,) = find_cameras(bus)
    assert "driver" in found.info.note
    with pytest.raises(TransportError, match="lacks this call; on Windows libusb needs WinUSB"):
        U3vDevice(backend=bus).open(Access.CONTROL)


def test_a_second_host_learns_that_the_camera_is_in_use(plug_in) -> None:
    _, device = plug_in()
    device.open(Access.CONTROL)
    second = U3vDevice(backend=device.backend)
    with pytest.raises(AccessDeniedError, match="another application"):
        second.open(Access.CONTROL)
    device.close()
    second.open(Access.CONTROL)
    second.close()


@pytest.mark.parametrize("text", ["u3v:?transfer_size=12", "u3v:?transfers=many", "u3v:?transfers=0"])
def test_options_out_of_range_are_refused(text: str) -> None:
    with pytest.raises(UsageError, match="a number from"):
        device.create(SourceUri.parse(text))
