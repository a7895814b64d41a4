"""A camera of a GenTL producer as a `Device`; `gentl:` sources.

The URI is `gentl:/path/producer.cti` (its first camera) or `gentl:/path/producer.cti#CAMERA`. The folder may
be omitted if it is in GENICAM_GENTL64_PATH; `gentl:` alone means the first producer there. CAMERA is a GenTL
id, a serial number or a user-defined name.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from genicam import gentl
from typing_extensions import override

from grabbergui.core.errors import (
    AccessDeniedError,
    AckTimeoutError,
    DeviceLostError,
    DeviceStatusError,
    GrabberError,
    LocalProtocolError,
    MissingFileError,
    OtherCameraError,
    RemoteProtocolError,
    SourceNotFoundError,
    TransportError,
)
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import DeviceInfo, choose, describe, differs, require_same
from grabbergui.core.uri import DescriptionOption, SourceUri, read_options
from grabbergui.driver.description import fetch_description
from grabbergui.driver.device import Device, StreamRequest, with_texts
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.genapi.cleaning import port_name
from grabbergui.driver.gentl.errors import answering, opening
from grabbergui.driver.gentl.module_registers import choose_order_mechanism
from grabbergui.driver.gentl.producer import FoundCamera, Producer, text_of
from grabbergui.driver.gentl.stream import GentlStream
from grabbergui.driver.gige.bootstrap import BIG_ENDIAN_MODE, BootstrapRegister
from grabbergui.driver.gige.identity import identity_texts as gige_texts
from grabbergui.driver.gige.quirks import DescriptionTraits
from grabbergui.driver.u3v.bootstrap import identity_texts as u3v_texts

log = logging.getLogger(__name__)

SEARCH_PATH = "GENICAM_GENTL64_PATH"
"""Environment variable with the folders (or files) of producers, as the GenTL standard names it."""

_ACCESS = {
    Access.CONTROL: gentl.DEVICE_ACCESS_FLAGS_LIST.DEVICE_ACCESS_CONTROL,
    Access.MONITOR: gentl.DEVICE_ACCESS_FLAGS_LIST.DEVICE_ACCESS_READONLY,
}

_TEXTS = {"GEV": gige_texts, "U3V": u3v_texts}
"Functions that read a camera's identity, by GenTL's type of the transport layer."


class GentlDevice(Device):
    """One camera of one producer, by its GenTL id, serial number or name; empty: the first.

    The name selects a camera only the first time; reopening finds the same unit or fails.
    """

    def __init__(self, producer: Path, name: str, info: DeviceInfo) -> None:
        super().__init__(info)
        self._path = producer
        self._name = name
        self._producer: Producer | None = None
        self._device: Any = None
        self._writable = False
        self._transport_layer = ""
        "GenTL's name of the camera's kind of transport; GEV: GigE Vision."
        self._identified = False
        "Whether `info` comes from the camera itself."

    @override
    def open(self, access: Access) -> Access:
        self.close()
        producer = Producer.acquire(self._path)
        try:
            found = self._find(producer)
            with opening(f"opening {found.device.title}"):
                device = found.info.create_device()
                device.open(_ACCESS[access])
        except BaseException:
            producer.release()
            raise
        self._producer, self._device = producer, device
        self._writable = access is Access.CONTROL
        self.lost = ""
        try:
            info = self._identify(device, found)
        except BaseException:
            self.close()
            raise
        self.info, self._identified = info, True
        return access

    def _identify(self, device: Any, found: FoundCamera) -> DeviceInfo:
        """Return the open camera's own identity. Raises OtherCameraError if it is not the listed camera.

        Some producers identify a camera by only a part of its identity, and open another one.
        """
        listed = replace(found.device, uri=self.info.uri if self._name else found.device.uri)
        opened = replace(
            listed,
            address=text_of(device, "id_") or listed.address,
            serial=text_of(device, "serial_number") or listed.serial,
        )
        self._transport_layer = text_of(found.info, "tl_type")
        texts = _TEXTS.get(self._transport_layer)
        if texts is not None:
            # A producer may not expose these registers.
            with suppress(DeviceStatusError, RemoteProtocolError):
                opened = with_texts(opened, texts(self.read))
        if opened.address != listed.address or differs(opened, listed):
            raise OtherCameraError(
                f"{self._path.name} opened {describe(opened)} at {opened.address} instead of"
                f" {describe(listed)} at {listed.address}; name the camera by its GenTL id, or open it"
                " without this producer (gige:, u3v:)"
            )
        if self._identified:
            require_same(self.info, opened)
        return opened

    @override
    def close(self) -> None:
        self.close_stream()
        device, self._device = self._device, None
        producer, self._producer = self._producer, None
        if device is not None:
            with suppress(gentl.GenericException):  # it may be unplugged
                device.close()
        if producer is not None:
            producer.release()

    def _find(self, producer: Producer) -> FoundCamera:
        cameras = producer.cameras()
        answering = [camera for camera in cameras if camera.answers_to(self._name)]
        opened = self.info if self._identified else None
        if (chosen := choose(self._name, answering, opened, lambda camera: camera.device)) is not None:
            return chosen
        known = ", ".join(camera.device.uri for camera in cameras) or "none"
        wanted = (
            f"camera '{self._name}'" if self._name else describe(self.info) if self._identified else "camera"
        )
        raise SourceNotFoundError(
            f"{self._path.name} does not list {wanted}; found: {known}. Check cable and power"
        )

    @override
    def read(self, address: int, length: int) -> bytes:
        with self._detecting_loss(), answering(f"reading {length} bytes at 0x{address:X}"):
            count, data = self._opened().remote_port.read(address, length)
        if count != length:
            raise TransportError(f"the producer read {count} of {length} bytes at 0x{address:X}")
        return bytes(data)

    @override
    def write(self, address: int, data: bytes) -> None:
        device = self._opened()
        if not self._writable:
            raise AccessDeniedError("the camera is open for reading only; another application may control it")
        with self._detecting_loss(), answering(f"writing {len(data)} bytes at 0x{address:X}"):
            device.remote_port.write(address, data)

    @override
    def description(self) -> bytes:
        with answering("reading where the description is"):
            urls = [info.url for info in self._opened().remote_port.url_info_list]
        return fetch_description(urls, self.read)

    @override
    def use_description(self, xml: str) -> None:
        if self._transport_layer != "GEV":
            return
        traits = DescriptionTraits.of(xml, port_name(xml))
        little_endian = False
        with suppress(GrabberError):  # a producer may not expose the register
            little_endian = (
                not int.from_bytes(self.read(BootstrapRegister.DEVICE_MODE, 4), "big") & BIG_ENDIAN_MODE
            )
        try:
            choose_order_mechanism(self._opened(), numbers=traits.numbers(little_endian=little_endian))
        except GrabberError as error:
            log.info("%s: the order of registers is the producer's choice: %s", self.info.title, error)

    @override
    def open_stream(self, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        if self._receiving is not None:
            raise LocalProtocolError("the stream is open already")
        ticks = self._tick_frequency()
        self._receiving = GentlStream(self._opened(), request, deliver, self.report_lost, ticks)

    def _tick_frequency(self) -> int:
        """Return the ticks per second of the camera's clock, by the producer or the camera; 0 if unknown."""
        with suppress(gentl.GenericException):
            if frequency := int(self._opened().timestamp_frequency):
                return frequency
        if self._transport_layer == "U3V":
            return 1_000_000_000  # USB3 Vision 1.1, 5.4.2: nanoseconds
        if self._transport_layer != "GEV":
            return 0
        with suppress(GrabberError):  # the producer may not expose the registers
            return int.from_bytes(self.read(BootstrapRegister.TICK_FREQUENCY_HIGH, 8), "big")
        return 0

    def _opened(self) -> Any:
        device = self._device
        if device is None:
            raise DeviceLostError(f"{self.info.title} is not open")
        return device

    @contextmanager
    def _detecting_loss(self) -> Iterator[None]:
        """Detect and report the loss of the camera, once.

        Many producers report a timeout for a camera that is gone, as for a slow one. A camera that does not
        answer a read of its first register either counts as lost.
        """
        self._opened()
        try:
            yield
        except DeviceLostError as error:
            self.report_lost(str(error))
            raise
        except AckTimeoutError as error:
            try:
                with answering("reading the first register"):
                    self._opened().remote_port.read(0, 4)
            except (AckTimeoutError, DeviceLostError):
                self.report_lost(str(error))
                raise DeviceLostError(str(error)) from error
            except DeviceStatusError:
                pass
            raise


def create(uri: SourceUri) -> FrameGrabber:
    """Return the camera of a URI, without opening it. Raises UsageError, SourceNotFoundError."""
    options = read_options(DescriptionOption, uri)
    file, _, name = uri.name.partition("#")
    path = _producer_file(file)
    device = GentlDevice(path, name, DeviceInfo(str(uri), bus="GenTL", address=name))
    device.description_file = options.description
    return DeviceGrabber(device)


def discover(timeout: float) -> list[DeviceInfo]:
    """Return every camera of the producers in the environment variable; load nothing without it."""
    found: list[DeviceInfo] = []
    for path in installed_producers():
        try:
            producer = Producer.acquire(path)
            try:
                found += [camera.device for camera in producer.cameras(int(timeout * 1000))]
            finally:
                producer.release()
        except GrabberError as error:
            log.warning("%s", error)
    return found


def installed_producers() -> list[Path]:
    """Return the `.cti` files in the environment variable; skip folders that do not exist."""
    found: list[Path] = []
    for entry in os.environ.get(SEARCH_PATH, "").split(os.pathsep):
        path = Path(entry)
        if not entry:
            continue
        # A folder may not be readable, or the entry may be no path at all.
        with suppress(OSError, ValueError):
            candidates = sorted(path.glob("*.cti")) if path.is_dir() else [path]
            found += [file for file in candidates if file.suffix == ".cti" and file.is_file()]
    return list(dict.fromkeys(found))


def _producer_file(file: str) -> Path:
    with suppress(OSError):  # a name that is too long for the file system
        if file and Path(file).is_file():
            return Path(file)
    installed = installed_producers()
    for path in installed:
        if not file or path.name == file:
            return path
    missing = MissingFileError if file else SourceNotFoundError
    known = ", ".join(str(path) for path in installed) or "no .cti file"
    raise missing(
        f"there is no GenTL producer{f' {file}' if file else ''}; {SEARCH_PATH} leads to {known}. "
        "Give the file's whole path, as in gentl:/opt/vendor/producer.cti"
    )
