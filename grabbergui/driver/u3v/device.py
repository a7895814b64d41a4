"""A USB3 Vision camera as a `Device`; `u3v:` sources.

The URI is `u3v:` (the first), `u3v:<serial>`, `u3v:<GUID>` or `u3v:<bus-port>`; options are in `U3vOptions`.
"""

from __future__ import annotations

import atexit
import contextlib
import logging
import weakref
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

from typing_extensions import override

from grabbergui.core.errors import (
    AccessDeniedError,
    DeviceLostError,
    DeviceStatusError,
    GrabberError,
    SourceUnavailableError,
    TransportError,
)
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import DeviceInfo, require_same
from grabbergui.core.uri import SourceUri, U3vOptions, read_options
from grabbergui.driver.device import DataLayout, Device, StreamRequest, with_texts
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.u3v import bootstrap
from grabbergui.driver.u3v.bootstrap import Abrm, Eirm, Sbrm, Sirm, StreamRequirements, read_description
from grabbergui.driver.u3v.device_clock import DeviceClock
from grabbergui.driver.u3v.enumeration import UsbCamera, find_camera, find_cameras
from grabbergui.driver.u3v.libusb_queue import open_queue
from grabbergui.driver.u3v.register_access import FIRST_TRANSFER, RegisterAccess
from grabbergui.driver.u3v.stream_protocol import TransferPlan
from grabbergui.driver.u3v.stream_receiver import StreamReceiver
from grabbergui.driver.u3v.transfer_queue import TransferQueue
from grabbergui.driver.u3v.usb import UsbHandle
from grabbergui.driver.u3v.watcher import Watcher

log = logging.getLogger(__name__)

USUAL_RESPONSE_TIME_MS = 500
"Longest time until a command is acknowledged, for a camera that does not report it."

LARGEST_TRANSFER = 1 << 20
"Bytes of a payload transfer. Some controllers lose data beyond 64 KiB; transfer_size in the URI lowers it."
TRANSFERS_IN_FLIGHT = 64


class U3vDevice(Device):
    """One camera. Its interfaces are claimed exclusively: USB3 Vision has no monitor access."""

    chunk_layout = DataLayout.USB3_VISION
    event_layout = DataLayout.USB3_VISION

    def __init__(
        self,
        name: str = "",
        *,
        backend: Any | None = None,
        largest_transfer: int = LARGEST_TRANSFER,
        transfers_in_flight: int = TRANSFERS_IN_FLIGHT,
    ) -> None:
        """`name` is a serial number, GUID or bus address; empty means the first camera found.

        The name selects a camera only the first time; reopening finds the same unit or fails.
        """
        super().__init__(DeviceInfo(uri=f"u3v:{name}", bus="USB3 Vision"))
        self._identified = False
        "True once `info` comes from the camera itself."
        self._name = name
        self.backend = backend
        self._largest_transfer = largest_transfer
        self._transfers_in_flight = transfers_in_flight
        self._access = Access.CONTROL
        self._clock = DeviceClock()
        self._camera: UsbCamera | None = None
        self._handle: UsbHandle | None = None
        self._registers: RegisterAccess | None = None
        self._watcher: Watcher | None = None
        self._queue: TransferQueue | None = None
        self._manifest_address = 0
        self._sbrm_address = 0
        self._sirm_address = 0
        self._eirm_address = 0
        self._has_clock = False
        self._at_exit: Callable[[], None] | None = None

    @override
    def open(self, access: Access) -> Access:
        """Open the camera. The USB claim is exclusive, so MONITOR also excludes others."""
        if self._handle is not None:
            return self._access
        camera = find_camera(self._name, self.backend, self.info if self._identified else None)
        self.lost = ""
        handle = UsbHandle(camera.backend, camera.device_id, camera.info.title)
        try:
            try:
                handle.claim(camera.control.number)
            except AccessDeniedError as error:
                if user := camera.user():
                    raise AccessDeniedError(
                        f"{camera.info.title} is in use by {user}; close it there"
                    ) from error
                raise
            registers = RegisterAccess(handle, camera.control)
            # A host that crashed may have left either endpoint halted.
            registers.clear_halts()
            self._camera, self._handle, self._registers = camera, handle, registers
            self._read_bootstrap(registers)
            uri = self.info.uri if self._name else camera.info.uri
            info = replace(camera.info, uri=uri)
            info = with_texts(info, bootstrap.identity_texts(registers.read))
            if self._identified:
                require_same(self.info, info)
            self.info, self._identified = info, True
            # Last, so that no later failure has to stop the thread.
            self._start_watching(camera, handle, registers)
        except BaseException:
            self._camera = self._handle = self._registers = None
            handle.close()
            raise
        # libusb must not shut down at the interpreter's exit while our threads use it.
        self._at_exit = partial(_close_at_exit, weakref.ref(self))
        atexit.register(self._at_exit)
        self._access = access
        return access

    @override
    def close(self) -> None:
        if self._at_exit is not None:
            atexit.unregister(self._at_exit)
        self.close_stream()
        watcher, self._watcher = self._watcher, None
        if watcher is not None:
            watcher.stop()
            self._disable_events()
        handle, self._handle = self._handle, None
        self._camera = self._registers = None
        self._clock.forget()
        if handle is not None:
            handle.close()

    def _read_bootstrap(self, registers: RegisterAccess) -> None:
        """Read the registers that lead to the others. A camera that refuses one does without it."""
        optional = registers.read_optional
        registers.channel.set_maximum_response_time(
            optional(Abrm.MAXIMUM_RESPONSE_TIME, 4, USUAL_RESPONSE_TIME_MS)
        )
        self._has_clock = bool(optional(Abrm.DEVICE_CAPABILITY, 8) & Abrm.CAPABILITY_TIMESTAMP)
        self._manifest_address = optional(Abrm.MANIFEST_TABLE_ADDRESS, 8)
        self._sirm_address = self._eirm_address = 0
        sbrm = optional(Abrm.SBRM_ADDRESS, 8)
        if not sbrm:
            return
        technology = optional(sbrm + Sbrm.CAPABILITY, 8, Sbrm.CAPABILITY_SIRM)
        registers.set_longest_transfers(
            optional(sbrm + Sbrm.MAXIMUM_COMMAND_TRANSFER, 4, FIRST_TRANSFER),
            optional(sbrm + Sbrm.MAXIMUM_ACKNOWLEDGE_TRANSFER, 4, FIRST_TRANSFER),
        )
        if technology & Sbrm.CAPABILITY_SIRM:
            self._sirm_address = optional(sbrm + Sbrm.SIRM_ADDRESS, 8)
        if technology & Sbrm.CAPABILITY_EIRM:
            self._eirm_address = optional(sbrm + Sbrm.EIRM_ADDRESS, 8)

    def _start_watching(self, camera: UsbCamera, handle: UsbHandle, registers: RegisterAccess) -> None:
        event = camera.event if self._eirm_address else None
        longest = 0
        if event is not None:
            handle.claim(event.number)
            handle.clear_halt(event.endpoint_in)
            longest = registers.read_optional(
                self._eirm_address + Eirm.MAXIMUM_EVENT_TRANSFER, 4, FIRST_TRANSFER
            )
            try:
                registers.write_u32(self._eirm_address + Eirm.CONTROL, Eirm.EVENT_ENABLE)
            except DeviceStatusError as error:
                log.warning("%s: the camera does not enable events: %s", self.info.title, error)
        self._watcher = Watcher(
            handle, event, longest, self.report_event, self.report_lost, self._synchronise_clock
        )

    def _disable_events(self) -> None:
        if self._eirm_address and not self.lost and self._registers is not None:
            with contextlib.suppress(GrabberError):
                self._registers.write_u32(self._eirm_address + Eirm.CONTROL, 0)

    def _synchronise_clock(self) -> None:
        if not self._has_clock:
            return
        registers = self._opened()
        try:
            self._clock.synchronise(
                lambda: registers.write_u32(Abrm.TIMESTAMP_LATCH, 1),
                lambda: registers.read_u64(Abrm.TIMESTAMP),
            )
        except DeviceLostError:
            raise
        except GrabberError as error:  # the camera is usable without its clock
            self._has_clock = False
            log.info("%s: its clock cannot be read: %s", self.info.title, error)

    @override
    def read(self, address: int, length: int) -> bytes:
        with self._detecting_loss() as registers:
            return registers.read(address, length)

    @override
    def write(self, address: int, data: bytes) -> None:
        if self._access is not Access.CONTROL:
            raise AccessDeniedError(f"{self.info.title} was opened for reading only")
        with self._detecting_loss() as registers:
            registers.write(address, data)

    @override
    def description(self) -> bytes:
        with self._detecting_loss() as registers:
            return read_description(registers.read, self._manifest_address)

    @override
    def bootstrap_registers(self) -> list[tuple[str, int, int]]:
        return bootstrap.known_registers(self._sbrm_address, self._sirm_address, self._eirm_address)

    @contextlib.contextmanager
    def _detecting_loss(self) -> Iterator[RegisterAccess]:
        registers, handle = self._opened(), self._handle
        try:
            yield registers
        except DeviceLostError as error:
            self.report_lost(str(error))
            raise
        except TransportError as error:
            # Unplugging during a transfer causes the same error as a disturbance on the bus.
            if handle is None or handle.is_present():
                raise
            reason = f"{self.info.title} was unplugged"
            self.report_lost(reason)
            raise DeviceLostError(reason) from error

    def _opened(self) -> RegisterAccess:
        if self.lost:
            raise DeviceLostError(self.lost)
        if self._registers is None:
            raise DeviceLostError(f"{self.info.title} is not open")
        return self._registers

    @override
    def open_stream(self, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        self.close_stream()
        with self._detecting_loss() as registers:
            try:
                self._open_stream(registers, request, deliver)
            except BaseException:
                self.close_stream()
                raise

    def _open_stream(
        self, registers: RegisterAccess, request: StreamRequest, deliver: Callable[[Frame], None]
    ) -> None:
        camera, handle = self._camera, self._handle
        if camera is None or handle is None or camera.stream is None or not self._sirm_address:
            raise TransportError(f"{self.info.title} has no stream interface")
        sirm = self._sirm_address
        needs = self._requirements(registers)
        if needs.enabled:  # a host that crashed left it on; sizes are writable only while it is off
            registers.write_u32(sirm + Sirm.CONTROL, 0)
            needs = self._requirements(registers)
        if not needs.payload_size:
            needs = replace(needs, payload_size=request.payload_size)
        packet_size = camera.stream.packet_size
        plan = TransferPlan.for_device(needs, self._largest_transfer, packet_size)
        self._write_plan(registers, plan)
        self._synchronise_clock()
        self._queue = open_queue(camera, handle, self._transfers_in_flight)
        self._queue.reset_endpoint()
        self._receiving = StreamReceiver(
            self._queue,
            plan,
            packet_size,
            self._clock,
            deliver,
            self.report_lost,
            deliver_incomplete=request.deliver_incomplete,
        )
        registers.write_u32(sirm + Sirm.CONTROL, Sirm.STREAM_ENABLE)

    def _requirements(self, registers: RegisterAccess) -> StreamRequirements:
        # Register by register: some devices refuse reads across register boundaries.
        sirm = self._sirm_address
        sizes = (
            (Sirm.INFO, 4),
            (Sirm.CONTROL, 4),
            (Sirm.REQUIRED_PAYLOAD_SIZE, 8),
            (Sirm.REQUIRED_LEADER_SIZE, 4),
            (Sirm.REQUIRED_TRAILER_SIZE, 4),
        )
        values = (registers.read_optional(sirm + at, size).to_bytes(size, "little") for at, size in sizes)
        return StreamRequirements.decode(b"".join(values))

    def _write_plan(self, registers: RegisterAccess, plan: TransferPlan) -> None:
        data = plan.encode()
        for at in range(0, len(data), 4):
            registers.write(self._sirm_address + TransferPlan.ADDRESS + at, data[at : at + 4])

    @override
    def close_stream(self) -> None:
        """Never raises."""
        super().close_stream()
        queue, self._queue = self._queue, None
        if queue is not None:
            queue.close()
            if not self.lost and self._registers is not None:
                with contextlib.suppress(GrabberError):
                    self._registers.write_u32(self._sirm_address + Sirm.CONTROL, 0)


def _close_at_exit(reference: weakref.ref[U3vDevice]) -> None:
    device = reference()
    if device is not None:
        device.close()


def create(uri: SourceUri) -> FrameGrabber:
    """Return the camera of a URI, without opening it. Raises UsageError."""
    options = read_options(U3vOptions, uri)
    device = U3vDevice(
        uri.name, largest_transfer=options.transfer_size, transfers_in_flight=options.transfers
    )
    device.info = replace(device.info, uri=str(uri))
    device.description_file = options.description
    return DeviceGrabber(device)


def discover(timeout: float) -> list[DeviceInfo]:
    """Return every camera on the USB buses, with the names read from it; none without libusb.

    The note of one that another program uses names that program.
    """
    try:
        cameras = find_cameras()
    except SourceUnavailableError:
        return []
    users = [camera.user() for camera in cameras]
    return [
        replace(camera.info, note=f"in use by {user}") if user else camera.info
        for camera, user in zip(cameras, users, strict=True)
    ]
