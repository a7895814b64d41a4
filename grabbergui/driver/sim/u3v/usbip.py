"""The simulated USB3 Vision camera over USB/IP, for a kernel at the other end of a socket.

The protocol is the Linux kernel's (Documentation/usb/usbip_protocol.rst); headers are big-endian.
"""

from __future__ import annotations

import contextlib
import logging
import socket
import struct
import sys
import threading
import time
from collections import deque
from dataclasses import dataclass, field

from grabbergui.core.errors import GrabberError, ResourceExhaustedError, SourceUnavailableError
from grabbergui.driver.sim.u3v.device import SimulatedU3vDevice
from grabbergui.driver.sim.u3v.pipe import (
    PipeCancelledError,
    PipeError,
    PipeGoneError,
    PipeHaltedError,
    PipeOverflowError,
)
from grabbergui.driver.sim.u3v.registers import PRODUCT_ID, VENDOR_ID
from grabbergui.driver.u3v.bootstrap import MISCELLANEOUS_CLASS, U3V_SUBCLASS

log = logging.getLogger(__name__)

TCP_PORT = 3240
BUS_ID = "1-1"

SUPER_SPEED = 5
"The kernel's number of this speed."

_HEADER = struct.Struct(">IIIIIIIIII8s")
"Command, sequence, device, direction, endpoint, flags or unlinked sequence, length, 3 unused, setup."
_SUBMIT, _UNLINK, _SUBMIT_REPLY, _UNLINK_REPLY = 1, 2, 3, 4
_DIRECTION_IN = 1
LONGEST_REQUEST = 64 << 20
"Bytes; a longer one is a broken peer."
_PAUSE_SECONDS = 0.5
"Before the next host when descriptors were used up."
MOST_REQUESTS = 4096
"Waiting on one endpoint; so is one that sends more."

_OK, _EPIPE, _ECONNRESET, _ESHUTDOWN, _EOVERFLOW = 0, -32, -104, -108, -75
_STATUS = {PipeHaltedError: _EPIPE, PipeOverflowError: _EOVERFLOW, PipeGoneError: _ESHUTDOWN}


@dataclass(eq=False)
class _Request:
    """One request (URB) of the host on an IN endpoint."""

    sequence: int
    length: int
    cancelled: bool = False

    def is_cancelled(self) -> bool:
        """Return whether the host unlinked the request."""
        return self.cancelled


@dataclass(eq=False)
class _Endpoint:
    """Requests on one IN endpoint, and the thread that serves them in order."""

    requests: deque[_Request] = field(default_factory=deque)
    changed: threading.Condition = field(default_factory=threading.Condition)
    thread: threading.Thread | None = None


class UsbIpConnection:
    """One attached host: answers its requests until either side hangs up."""

    def __init__(self, connection: socket.socket, camera: SimulatedU3vDevice) -> None:
        self._socket = connection
        self._camera = camera
        self._sending = threading.Lock()
        self._closed = False
        self._endpoints = {address: _Endpoint() for address in camera.pipes}
        for address, endpoint in self._endpoints.items():
            endpoint.thread = threading.Thread(
                target=self._serve_endpoint,
                args=(address, endpoint),
                name=f"usbip-{address:02x}",
                daemon=True,
            )

    def run(self) -> None:
        """Serve until the connection ends. Never raises."""
        for endpoint in self._endpoints.values():
            assert endpoint.thread is not None
            endpoint.thread.start()
        try:
            while header := _receive(self._socket, _HEADER.size):
                self._handle(header)
        except (OSError, GrabberError) as error:
            log.info("USB/IP: %s", error)
        finally:
            self.close()
            for endpoint in self._endpoints.values():
                assert endpoint.thread is not None
                endpoint.thread.join()

    def close(self) -> None:
        """Close the connection: the host sees the camera unplugged. May be called twice, from any thread."""
        self._closed = True
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()
        for address, endpoint in self._endpoints.items():
            with endpoint.changed:
                for request in endpoint.requests:
                    request.cancelled = True
                endpoint.changed.notify_all()
            self._camera.pipes[address].wake()

    def _handle(self, header: bytes) -> None:
        command, sequence, _, direction, endpoint, argument, length, *_, setup = _HEADER.unpack(header)
        if command == _UNLINK:
            # The unlinked sequence number takes the place of a submit's flags.
            self._unlink(sequence, argument)
            return
        if command != _SUBMIT:
            raise GrabberError(f"USB/IP command {command} is unknown")
        if length > LONGEST_REQUEST:
            raise GrabberError(f"USB/IP request of {length} bytes")
        if direction == _DIRECTION_IN and endpoint:
            self._queue(endpoint | 0x80, _Request(sequence, length))
            return
        data = b"" if direction == _DIRECTION_IN else _receive(self._socket, length)
        if endpoint:
            self._camera.command(data)
            self._reply(sequence, _OK, length)
        else:
            self._answer_setup(sequence, setup)

    def _answer_setup(self, sequence: int, setup: bytes) -> None:
        request_type, request, value, index, length = struct.unpack("<BBHHH", setup)
        answer = self._camera.control_request(request_type, request, value, index)
        if answer is None:
            self._reply(sequence, _EPIPE, 0)
        elif request_type & 0x80:
            self._reply(sequence, _OK, len(answer[:length]), memoryview(answer[:length]))
        else:
            self._reply(sequence, _OK, length)

    def _queue(self, address: int, request: _Request) -> None:
        endpoint = self._endpoints.get(address)
        if endpoint is None:
            self._reply(request.sequence, _EPIPE, 0)
            return
        with endpoint.changed:
            if len(endpoint.requests) == MOST_REQUESTS:
                raise GrabberError(f"USB/IP: more than {MOST_REQUESTS} requests on endpoint 0x{address:02x}")
            endpoint.requests.append(request)
            endpoint.changed.notify_all()

    def _unlink(self, sequence: int, unlinked: int) -> None:
        status = _OK  # answered already
        for address, endpoint in self._endpoints.items():
            with endpoint.changed:
                request = next((r for r in endpoint.requests if r.sequence == unlinked), None)
                if request is None:
                    continue
                endpoint.requests.remove(request)
                request.cancelled = True
                status = _ECONNRESET
            self._camera.pipes[address].wake()
        with self._sending:
            self._send(_reply_header(_UNLINK_REPLY, sequence, status))

    def _serve_endpoint(self, address: int, endpoint: _Endpoint) -> None:
        pipe = self._camera.pipes[address]
        while True:
            with endpoint.changed:
                endpoint.changed.wait_for(lambda: endpoint.requests or self._closed)
                if self._closed:
                    return
                request = endpoint.requests[0]
            status, parts = _OK, list[memoryview]()
            try:
                parts = pipe.take(request.length, cancelled=request.is_cancelled)
            except PipeCancelledError:
                continue
            except PipeError as error:
                status = _STATUS[type(error)]
            with endpoint.changed:
                if request.cancelled:
                    continue  # the host has its answer; the data are lost, as on a cable
                endpoint.requests.popleft()
                # Send nothing else before the answer: after the reply to an unlink, Linux considers the
                # request finished and closes the connection if an answer to it follows.
                self._sending.acquire()
            try:
                length = sum(map(len, parts))
                self._send(_reply_header(_SUBMIT_REPLY, request.sequence, status, length), *parts)
            finally:
                self._sending.release()

    def _reply(self, sequence: int, status: int, length: int, *data: memoryview) -> None:
        with self._sending:
            self._send(_reply_header(_SUBMIT_REPLY, sequence, status, length), *data)

    def _send(self, header: bytes, *data: memoryview) -> None:
        """Send with `_sending` held; the reader notices a lost host."""
        with contextlib.suppress(OSError):
            if sys.platform == "win32" or not data:
                self._socket.sendall(b"".join((header, *data)))
                return
            # One call for all parts; a stream socket may accept fewer bytes.
            sent = self._socket.sendmsg([header, *data])
            for part in (memoryview(header), *data):
                if sent < len(part):
                    self._socket.sendall(part[sent:])
                sent = max(sent - len(part), 0)


def _reply_header(reply: int, sequence: int, status: int, length: int = 0) -> bytes:
    return _HEADER.pack(reply, sequence, 0, 0, 0, status & 0xFFFFFFFF, length, 0, 0, 0, bytes(8))


class UsbIpServer:
    """Offers the camera on TCP to one host at a time: `usbip attach -r HOST -b 1-1`."""

    _OPERATION = struct.Struct(">HHI")
    _VERSION = 0x0111
    _IMPORT, _IMPORT_REPLY, _LIST, _LIST_REPLY = 0x8003, 0x0003, 0x8005, 0x0005

    def __init__(self, camera: SimulatedU3vDevice, host: str = "127.0.0.1", port: int = TCP_PORT) -> None:
        """Begin to listen; port 0 takes a free one. Raises SourceUnavailableError."""
        self._camera = camera
        self._host: socket.socket | None = None
        "The connection of the host that is being served."
        self._closed = False
        self._lock = threading.Lock()
        try:
            self._listener = socket.create_server((host, port))
        except OSError as error:
            reason = (error.strerror or str(error)).partition(" (while")[0]  # Python repeats the address
            raise SourceUnavailableError(f"cannot serve USB/IP on {host}:{port}: {reason}") from error
        self.address: tuple[str, int] = self._listener.getsockname()[:2]
        "Host and port on which it listens."

    def run(self) -> None:
        """Serve hosts, one after the other, until `close`."""
        while not self._closed:
            try:
                connection, peer = self._listener.accept()
            except OSError as error:
                failure = ResourceExhaustedError.of(error)
                if failure is None or self._closed:
                    return
                log.warning("USB/IP: no host can connect: %s", failure)
                time.sleep(_PAUSE_SECONDS)
                continue
            log.info("USB/IP: %s is here", peer)
            with self._lock:
                if self._closed:
                    connection.close()
                    return
                self._host = connection
            try:
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._greet(connection)
            except (OSError, GrabberError) as error:
                log.info("USB/IP: %s: %s", peer, error)
            finally:
                with self._lock:
                    self._host = None
                    connection.close()

    def close(self) -> None:
        """Stop listening and close all connections. Any thread; may be called twice."""
        with self._lock:
            self._closed = True
            if self._host is not None:
                # The thread that serves it finds the connection closed.
                with contextlib.suppress(OSError):
                    self._host.shutdown(socket.SHUT_RDWR)
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()

    def _greet(self, connection: socket.socket) -> None:
        connection.settimeout(5.0)
        header = _receive(connection, self._OPERATION.size)
        if not header:
            return
        _, operation, _ = self._OPERATION.unpack(header)
        if operation == self._LIST:
            reply = self._OPERATION.pack(self._VERSION, self._LIST_REPLY, 0) + struct.pack(">I", 1)
            interfaces = b"".join(
                bytes((MISCELLANEOUS_CLASS, U3V_SUBCLASS, protocol, 0)) for protocol in (0, 1, 2)
            )
            connection.sendall(reply + self._description() + interfaces)
        elif operation == self._IMPORT:
            wanted = _receive(connection, 32).rstrip(b"\0").decode("ascii", "replace")
            if wanted != BUS_ID or not self._camera.plugged:
                connection.sendall(self._OPERATION.pack(self._VERSION, self._IMPORT_REPLY, 1))
                return
            connection.sendall(
                self._OPERATION.pack(self._VERSION, self._IMPORT_REPLY, 0) + self._description()
            )
            connection.settimeout(None)
            UsbIpConnection(connection, self._camera).run()
            self._camera.reset()
        else:
            raise GrabberError(f"USB/IP operation 0x{operation:04X} is unknown")

    def _description(self) -> bytes:
        path = b"/sys/devices/simulated/usb1/1-1".ljust(256, b"\0")
        return (
            path
            + BUS_ID.encode().ljust(32, b"\0")
            + struct.pack(">III", 1, 2, SUPER_SPEED)
            + struct.pack(">HHH", VENDOR_ID, PRODUCT_ID, 0x0100)
            + bytes((MISCELLANEOUS_CLASS, 2, 1, 1, 1, 3))
        )


def _receive(connection: socket.socket, length: int) -> bytes:
    """Read exactly that many bytes; return none if the peer closed the connection."""
    data = bytearray()
    while len(data) < length:
        part = connection.recv(length - len(data))
        if not part:
            return b""
        data += part
    return bytes(data)
