"""The simulated USB3 Vision camera as a Linux gadget: FunctionFS on a USB device controller.

A Raspberry Pi's port becomes a camera. FunctionFS does not carry the class-specific device-info descriptor,
so hosts that insist on it refuse this camera; the USB/IP one has it. Root is needed.
"""

from __future__ import annotations

import contextlib
import ctypes
import ctypes.util
import errno
import logging
import os
import signal
import struct
import sys
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import TracebackType

from grabbergui.core.errors import SourceUnavailableError
from grabbergui.driver.sim.u3v.device import SimulatedU3vDevice
from grabbergui.driver.sim.u3v.pipe import PipeError, PipeTimeoutError
from grabbergui.driver.sim.u3v.registers import (
    CONTROL_IN,
    EVENT_IN,
    LONGEST_TRANSFER,
    PRODUCT_ID,
    STREAM_IN,
    VENDOR_ID,
)
from grabbergui.driver.u3v.bootstrap import MISCELLANEOUS_CLASS, U3V_SUBCLASS

log = logging.getLogger(__name__)

_CONFIGFS = Path("/sys/kernel/config/usb_gadget")
_CONTROLLERS = Path("/sys/class/udc")
_NAME = "grabbergui-u3v"

_DESCRIPTORS_MAGIC, _STRINGS_MAGIC = 3, 2
_HAS_SPEEDS = 1 | 2 | 4
"Full, high and super speed."
_EVENT = struct.Struct("<8sB3x")
_DISABLE, _SETUP = 3, 4
_GUID_STRING = 5
"FunctionFS's first string follows the gadget's own: vendor, model, serial number, configuration."


def function_descriptors() -> bytes:
    """Return the descriptors for ep0: interfaces event, stream, control, for each of three speeds.

    Aravis before 0.9.2 takes the control endpoints to have the same number in both directions. In this order
    (with a spare event endpoint) a controller that numbers by order of appearance, as dummy_hcd, gives them
    such numbers.
    """
    lists = [_descriptors_at(size, companion=size == 1024) for size in (64, 512, 1024)]
    counts = b"".join(struct.pack("<I", count) for count, _ in lists)
    body = counts + b"".join(data for _, data in lists)
    return struct.pack("<III", _DESCRIPTORS_MAGIC, 12 + len(body), _HAS_SPEEDS) + body


def function_strings(guid: str) -> bytes:
    """Return the strings for ep0, which follow the descriptors: the GUID, in English."""
    body = struct.pack("<IIH", 1, 1, 0x0409) + guid.encode() + b"\0"
    return struct.pack("<II", _STRINGS_MAGIC, 8 + len(body)) + body


def _descriptors_at(packet_size: int, *, companion: bool) -> tuple[int, bytes]:
    def endpoint(address: int) -> list[bytes]:
        plain = struct.pack("<BBBBHB", 7, 5, address, 2, packet_size, 0)
        return [plain, struct.pack("<BBBBH", 6, 0x30, 15, 0, 0)] if companion else [plain]

    def interface(number: int, endpoints: int, protocol: int, text: int = 0) -> list[bytes]:
        kind = (MISCELLANEOUS_CLASS, U3V_SUBCLASS, protocol, text)
        return [struct.pack("<9B", 9, 4, number, 0, endpoints, *kind)]

    # Only types that FunctionFS knows pass. Where a host reads the GUID's string index without looking at
    # the type, it finds it in the last of four OTG descriptors.
    stand_in = [b"\3\x09\0"] * 3 + [bytes((3, 9, _GUID_STRING))]
    descriptors = [
        struct.pack("<8B", 8, 0x0B, 0, 3, MISCELLANEOUS_CLASS, U3V_SUBCLASS, 0, 1),
        *interface(0, 2, 1, 1),
        *endpoint(0x81),
        *endpoint(0x82),
        *interface(1, 1, 2),
        *endpoint(0x83),
        *interface(2, 2, 0),
        *stand_in,
        *endpoint(0x84),
        *endpoint(0x01),
    ]
    return len(descriptors), b"".join(descriptors)


class _Files:
    """`read` and `write` of libc: unlike Python's, they return when a signal comes (EINTR)."""

    def __init__(self) -> None:
        self._libc = ctypes.CDLL(ctypes.util.find_library("c"), use_errno=True)
        self._libc.read.restype = self._libc.write.restype = ctypes.c_ssize_t
        self._libc.read.argtypes = (ctypes.c_int, ctypes.c_void_p, ctypes.c_size_t)
        self._libc.write.argtypes = (ctypes.c_int, ctypes.c_void_p, ctypes.c_size_t)

    def read(self, descriptor: int, size: int) -> bytes:
        """Read one transfer of at most `size` bytes. Raises OSError."""
        buffer = ctypes.create_string_buffer(size)
        length = self._checked(self._libc.read(descriptor, buffer, size))
        return buffer.raw[:length]

    def write(self, descriptor: int, data: bytes | memoryview) -> None:
        """Write one transfer. Raises OSError."""
        view = memoryview(data)
        if view.readonly:
            self._checked(self._libc.write(descriptor, bytes(view), len(view)))
        else:
            start = (ctypes.c_char * len(view)).from_buffer(view)
            self._checked(self._libc.write(descriptor, start, len(view)))

    def mount(self, function: str, folder: Path) -> None:
        """Mount a FunctionFS. Raises OSError."""
        self._checked(self._libc.mount(function.encode(), str(folder).encode(), b"functionfs", 0, None))

    def unmount(self, folder: Path) -> None:
        """Undo it. Raises OSError."""
        self._checked(self._libc.umount(str(folder).encode()))

    @staticmethod
    def _checked(result: int) -> int:
        if result < 0:
            number = ctypes.get_errno()
            raise OSError(number, os.strerror(number))
        return result


class Gadget:
    """The camera on a device controller, from entering to leaving the context."""

    def __init__(self, camera: SimulatedU3vDevice, udc: str = "") -> None:
        """Open a USB device controller. Raises SourceUnavailableError if the system has none."""
        controllers = sorted(path.name for path in _CONTROLLERS.glob("*")) if _CONTROLLERS.exists() else []
        if not controllers or (udc and udc not in controllers):
            known = f"; there is {', '.join(controllers)}" if controllers else ""
            raise SourceUnavailableError(f"no USB device controller {udc}".rstrip() + known)
        self.udc = udc or controllers[0]
        "The device controller's name."
        self._camera = camera
        self._files = _Files()
        self._folder = _CONFIGFS / _NAME
        self._mount = Path("/run") / _NAME
        self._endpoints: list[int] = []
        self._threads: list[threading.Thread] = []
        self._writing: dict[int, object] = {}
        "A token for each IN endpoint with a transfer on its way."
        self._stopping = False

    def __enter__(self) -> Gadget:
        """Make the gadget and plug it in. Raises SourceUnavailableError."""
        if sys.platform == "win32":
            raise SourceUnavailableError("a USB gadget needs Linux: use --via tcp")
        # Interrupts a blocked read or write; the handler itself has nothing to do.
        signal.signal(signal.SIGUSR1, lambda *_: None)
        self._clear_away()
        try:
            self._make()
            self._open_endpoints()
            self._bind(self.udc)
        except OSError as error:
            self._remove()
            raise SourceUnavailableError(
                f"cannot make a USB gadget on {self.udc}: {error}; it takes root, `modprobe libcomposite "
                "usb_f_fs` and a free controller"
            ) from error
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Unplug and remove it."""
        self._remove()

    def _clear_away(self) -> None:
        """Remove what a killed program left. Raises SourceUnavailableError if another has the gadget."""
        if not self._folder.exists():
            return
        try:
            controller = (self._folder / "UDC").read_text().strip()
        except OSError:
            controller = ""
        # Linux unbinds the gadget of a program that ends.
        if controller:
            raise SourceUnavailableError(f"another simulated camera is on the device controller {controller}")
        self._dismantle()

    def _make(self) -> None:
        identity = self._camera.identity
        self._folder.mkdir()
        for name, value in (
            ("idVendor", f"0x{VENDOR_ID:04x}"),
            ("idProduct", f"0x{PRODUCT_ID:04x}"),
            ("bcdDevice", "0x0100"),
            ("bDeviceClass", f"0x{MISCELLANEOUS_CLASS:02x}"),
            ("bDeviceSubClass", "0x02"),
            ("bDeviceProtocol", "0x01"),
        ):
            (self._folder / name).write_text(value)
        strings = self._folder / "strings/0x409"
        strings.mkdir()
        (strings / "manufacturer").write_text(identity.vendor)
        (strings / "product").write_text(identity.model)
        (strings / "serialnumber").write_text(identity.serial)
        configuration = self._folder / "configs/c.1"
        configuration.mkdir()
        (configuration / "strings/0x409").mkdir()
        (configuration / "strings/0x409/configuration").write_text("USB3 Vision")
        function = self._folder / f"functions/ffs.{_NAME}"
        function.mkdir()
        (configuration / f"ffs.{_NAME}").symlink_to(function)
        self._mount.mkdir(exist_ok=True)
        self._files.mount(_NAME, self._mount)

    def _open_endpoints(self) -> None:
        control = os.open(self._mount / "ep0", os.O_RDWR)
        self._endpoints.append(control)
        os.write(control, function_descriptors())
        os.write(control, function_strings(self._camera.identity.guid))
        # Files are numbered in the order of the endpoint descriptors: event, spare, stream, control.
        event, _spare, stream, control_in, control_out = (
            os.open(self._mount / f"ep{number}", os.O_RDWR) for number in (1, 2, 3, 4, 5)
        )
        self._endpoints += [event, _spare, stream, control_in, control_out]
        self._start("gadget-ep0", self._serve_setup, control)
        self._start("gadget-command", self._serve_commands, control_out)
        for name, descriptor, address in (
            ("acknowledge", control_in, CONTROL_IN),
            ("event", event, EVENT_IN),
            ("stream", stream, STREAM_IN),
        ):
            thread = self._start(f"gadget-{name}", self._serve_in, descriptor, address)
            self._camera.pipes[address].on_flush = partial(self._abort_write, address, thread)

    def _start(self, name: str, target: Callable[..., None], *arguments: int) -> threading.Thread:
        thread = threading.Thread(target=target, args=arguments, name=name, daemon=True)
        self._threads.append(thread)
        thread.start()
        return thread

    def _bind(self, udc: str) -> None:
        (self._folder / "UDC").write_text(udc or "\n")

    def _remove(self) -> None:
        self._stopping = True
        for pipe in self._camera.pipes.values():
            pipe.on_flush = None
        with contextlib.suppress(OSError):
            self._bind("")
        for thread in self._threads:
            while thread.is_alive():
                _interrupt(thread)
                thread.join(0.05)
        for descriptor in self._endpoints:
            os.close(descriptor)
        self._endpoints.clear()
        self._dismantle()

    def _dismantle(self) -> None:
        with contextlib.suppress(OSError):
            self._files.unmount(self._mount)
            self._mount.rmdir()
        configuration = self._folder / "configs/c.1"
        with contextlib.suppress(OSError):
            (configuration / f"ffs.{_NAME}").unlink()
        for folder in (
            configuration / "strings/0x409",
            configuration,
            self._folder / f"functions/ffs.{_NAME}",
            self._folder / "strings/0x409",
            self._folder,
        ):
            with contextlib.suppress(OSError):
                folder.rmdir()

    def _serve_setup(self, descriptor: int) -> None:
        """Serve endpoint 0: connection events of the host; requests that the kernel does not serve stall."""
        while not self._stopping:
            try:
                events = self._files.read(descriptor, _EVENT.size * 4)
            except OSError as error:
                if error.errno in (errno.EINTR, errno.EAGAIN):
                    continue
                return
            for setup, kind in _EVENT.iter_unpack(events[: len(events) // _EVENT.size * _EVENT.size]):
                if kind == _DISABLE:
                    self._camera.reset()
                elif kind == _SETUP:
                    self._stall(descriptor, towards_host=bool(setup[0] & 0x80))

    def _stall(self, descriptor: int, *, towards_host: bool) -> None:
        # Reading or writing in the wrong direction makes FunctionFS stall the endpoint.
        with contextlib.suppress(OSError):
            if towards_host:
                self._files.read(descriptor, 0)
            else:
                self._files.write(descriptor, b"")

    def _serve_commands(self, descriptor: int) -> None:
        while not self._stopping:
            try:
                # Exactly the longest command: a longer read would wait for more after a full one.
                self._camera.command(self._files.read(descriptor, LONGEST_TRANSFER))
            except OSError as error:
                if not _transient(error):
                    log.error("gadget: commands: %s", error)
                    return

    def _serve_in(self, descriptor: int, address: int) -> None:
        pipe = self._camera.pipes[address]
        while not self._stopping:
            try:
                transfer = pipe.take_transfer(0.1)
            except PipeTimeoutError:
                continue
            except PipeError:
                return  # unplugged
            self._writing[address] = token = object()
            try:
                self._files.write(descriptor, transfer)
            except OSError as error:
                # Interrupted: the host is not to have it. Else it is not there yet, or went, or halted us.
                if not _transient(error):
                    log.error("gadget: endpoint 0x%02x: %s", address, error)
                    return
            finally:
                if self._writing.get(address) is token:
                    del self._writing[address]

    def _abort_write(self, address: int, thread: threading.Thread) -> None:
        """Cancel the transfer that waits for the host on an IN endpoint, even if it ends meanwhile."""
        token = self._writing.get(address)
        while token is not None and self._writing.get(address) is token:
            _interrupt(thread)
            time.sleep(0.001)


def _transient(error: OSError) -> bool:
    """Return whether a retry makes sense: interrupted, not yet enabled, disabled by the host, halted."""
    return error.errno in (errno.EINTR, errno.EAGAIN, errno.ESHUTDOWN, errno.EBADMSG, errno.ENODEV)


def _interrupt(thread: threading.Thread) -> None:
    if sys.platform != "win32" and thread.ident is not None and thread.is_alive():
        with contextlib.suppress(ProcessLookupError):
            signal.pthread_kill(thread.ident, signal.SIGUSR1)
