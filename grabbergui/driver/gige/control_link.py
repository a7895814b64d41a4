"""The control channel's socket, which any number of threads may use, and the device's memory over it.

`ControlLink` drives `ControlChannel` and `Heartbeat`. `DeviceMemory` reads and writes memory and registers of
any length and alignment.
"""

from __future__ import annotations

import logging
import socket
import struct
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial

from grabbergui.core.device_text import text_field
from grabbergui.core.errors import (
    AccessDeniedError,
    AckTimeoutError,
    DeviceLostError,
    DeviceStatusError,
    GrabberError,
    RemoteProtocolError,
    TransportError,
)
from grabbergui.core.socket_timeouts import wait_readable
from grabbergui.driver.gige.bootstrap import (
    GVCP_PORT,
    Capability,
    Field,
    GvcpConfiguration,
    Register,
)
from grabbergui.driver.gige.control_channel import ControlChannel, ControlTiming, Exchange
from grabbergui.driver.gige.discovery import Interface, leave_through
from grabbergui.driver.gige.gvcp import MEMORY_CHUNK, ReadMem, ReadReg, Request, Status, WriteMem, WriteReg
from grabbergui.driver.gige.heartbeat import Heartbeat, Holder, Pulse

log = logging.getLogger(__name__)

LONGEST_RECEIVE = 0.01
"""Seconds that a thread stays in the socket; then it looks whether a retry is due or the link was closed."""
_LARGEST_ACK = 2048
_AT_ONCE = getattr(socket, "MSG_DONTWAIT", 0)
"A full queue must not stop a thread that holds the lock."


class ControlLink:
    """Sends commands to one device. Any thread may call; commands are sent in the order of the calls."""

    def __init__(
        self,
        ip: str,
        port: int = GVCP_PORT,
        timing: ControlTiming | None = None,
        interface: Interface | None = None,
    ) -> None:
        """Prepare to send to an address through an interface; None: the one that the routing table chooses.

        Raises TransportError if there is no way to the address.
        """
        self.on_lost: Callable[[str], None] | None = None
        "Called once, on the heartbeat's thread, when the camera is lost."
        self.on_held: Callable[[bool], None] | None = None
        "Called on the same thread with whether an application has control: at first, and when that changes."
        self._channel = ControlChannel(timing)
        self._heartbeat: Heartbeat | None = None
        self._lock = threading.Lock()
        "Guards the channel, the heartbeat and the socket."
        self._changed = threading.Condition(self._lock)
        "Notified when any of them has changed."
        self._waiting = 0
        "Threads that wait for that."
        self._receiving = False
        "Whether one of the waiting threads receives for all."
        self._closed = False
        self.abandoned = False
        "Whether `abandon` was called."
        self._resting = False
        "Whether the heartbeat is to stop."
        self._awake = threading.Event()
        "Set once the heartbeat's thread has more to do than to beat: to stop, or to report a loss."
        self._thread: threading.Thread | None = None
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            _limit_receive(self._socket, LONGEST_RECEIVE)
            if interface is not None:
                self._socket.bind((interface.ip, 0))
                leave_through(self._socket, interface)
            self._socket.connect((ip, port))
        except OSError as error:
            self._socket.close()
            raise TransportError(f"no way to {ip}: {error.strerror or error}") from error
        self.local_address: str = self._socket.getsockname()[0]
        "The host's IP address on the way to the device."

    @property
    def lost(self) -> str | None:
        """Why the camera is lost, or None."""
        return self._heartbeat.lost if self._heartbeat else None

    def execute(self, request: Request, timing: ControlTiming | None = None) -> bytes:
        """Send a command, wait, and return the acknowledge's payload.

        Raises AckTimeoutError, DeviceStatusError, DeviceLostError.
        """
        with self._lock:
            exchange = self._carry_out(request, timing)
        if exchange.error is not None:
            raise exchange.error
        assert exchange.payload is not None
        return exchange.payload

    def require_control(self) -> None:
        """Ask the device who has control, as the heartbeat does, if it beats; without control it is lost.

        Raises DeviceLostError, AckTimeoutError, DeviceStatusError.
        """
        heartbeat = self._heartbeat
        if heartbeat is None:
            return
        with self._lock:
            exchange = self._carry_out(heartbeat.request)
            heartbeat.judge(exchange, time.monotonic())
            if heartbeat.lost:
                self._awake.set()
                self._changed.notify_all()
            self._require_open()
        if exchange.error is not None:
            raise exchange.error

    def _carry_out(self, request: Request, timing: ControlTiming | None = None) -> Exchange:
        """Send a command and wait, with the lock; return it answered or given up. Raises DeviceLostError."""
        self._require_open()
        exchange = self._channel.start(request, time.monotonic(), timing)
        try:
            self._send_waiting()
            self._wait()
            while not exchange.done:
                self._require_open()
                self._send_due()
                self._wait()
        finally:
            self._channel.cancel(exchange)
        return exchange

    def send_last(self, request: Request) -> None:
        """Send a command on a lost or abandoned link, without waiting: the camera may only have been slow."""
        with self._lock:
            if not self._closed:
                self._channel.start(request, time.monotonic(), urgent=True)
                self._send_due()

    def read_register(self, address: int) -> int:
        """One register by READREG. Raises as `execute`, and RemoteProtocolError."""
        request = ReadReg((address,))
        return request.decode_ack(self.execute(request))[0]

    def read_memory(self, address: int, count: int) -> bytes:
        """Up to 536 bytes by READMEM, both numbers multiples of 4. Raises as `read_register`."""
        request = ReadMem(address, count)
        return request.decode_ack(self.execute(request))

    def start_heartbeat(self, pulse: Pulse, *, controlling: bool, holder: Holder | None = None) -> None:
        """Keep the device awake and watch it, until `close`; see Heartbeat."""
        begin = time.monotonic() + pulse.period
        self._heartbeat = Heartbeat(self._channel, pulse, controlling=controlling, now=begin, holder=holder)
        self._thread = threading.Thread(target=self._run, name="gige-heartbeat", daemon=True)
        self._thread.start()

    def stop_heartbeat(self) -> None:
        """End the heartbeat; commands are still possible. May be called twice."""
        self._resting = True
        self._awake.set()
        thread = self._thread
        if thread is not None and thread is not threading.current_thread():
            thread.join()
        self._thread = None

    def close(self) -> None:
        """Stop the heartbeat and close the socket. Commands of other threads fail. May be called twice."""
        self.stop_heartbeat()
        with self._lock:
            self._closed = True
            self._changed.notify_all()
            while self._receiving:
                self._wait_for_change(LONGEST_RECEIVE)
            self._socket.close()

    def abandon(self) -> None:
        """Let the commands of all threads fail at once, except `send_last`. Any thread; then call `close`."""
        with self._lock:
            self.abandoned = True
            self._changed.notify_all()

    def _run(self) -> None:
        heartbeat = self._heartbeat
        assert heartbeat is not None
        while heartbeat.lost is None and not self._awake.wait(self._pause(heartbeat)):
            held = heartbeat.held
            self._beat(heartbeat)
            if heartbeat.held is not None and heartbeat.held is not held and self.on_held is not None:
                self.on_held(heartbeat.held)
        if heartbeat.lost and not self._resting:
            log.info("camera lost: %s", heartbeat.lost)
            if self.on_lost is not None:
                self.on_lost(heartbeat.lost)

    @staticmethod
    def _pause(heartbeat: Heartbeat) -> float:
        due = heartbeat.timer()
        return 0.0 if due is None else max(0.0, due - time.monotonic())

    def _beat(self, heartbeat: Heartbeat) -> None:
        with self._lock:
            heartbeat.handle_timer(time.monotonic())
            self._send_due()
            while heartbeat.beating and not self._awake.is_set():
                self._wait()
                self._send_due()
            heartbeat.handle_timer(time.monotonic())
            if heartbeat.lost:
                self._changed.notify_all()

    def _send_due(self) -> None:
        """Send commands whose turn or retry has come."""
        self._channel.handle_timer(time.monotonic())
        self._send_waiting()

    def _send_waiting(self) -> None:
        for datagram in self._channel.datagrams():
            self._send(datagram)

    def _wait(self) -> None:
        """Wait, without the lock, until something was received, a deadline has come, or LONGEST_RECEIVE."""
        if self._receiving:
            due = self._channel.timer()
            self._wait_for_change(LONGEST_RECEIVE if due is None else max(0.0, due - time.monotonic()))
            return
        self._receiving = True
        self._lock.release()
        datagram = b""
        try:
            datagram = self._receive()
        finally:
            try:
                self._lock.acquire()
            finally:  # Ctrl-C may come as the lock is taken; `close` would wait for ever
                self._receiving = False
            if self._waiting:
                self._changed.notify_all()  # an answer may be theirs; one of them receives from now on
        if datagram:
            self._channel.receive(datagram, time.monotonic())

    def _wait_for_change(self, seconds: float) -> None:
        self._waiting += 1
        try:
            self._changed.wait(seconds)
        finally:
            self._waiting -= 1

    def _receive(self) -> bytes:
        """Return one datagram, or nothing after LONGEST_RECEIVE.

        One system call, since each may cost a wait for the GIL.
        """
        try:
            return self._socket.recv(_LARGEST_ACK, wait_readable(self._socket))
        except (BlockingIOError, TimeoutError):
            return b""
        except OSError as error:
            # The device's port is closed (ICMP): the same as no answer, and it may open again.
            log.debug("control channel: %s", error)
            return b""

    def _send(self, datagram: bytes) -> None:
        try:
            self._socket.send(datagram, _AT_ONCE)
        except OSError as error:
            # A cable out, a full queue: the retry or the deadline deals with it.
            log.debug("control channel: %s", error)

    def _require_open(self) -> None:
        if self._heartbeat is not None and self._heartbeat.lost:
            raise DeviceLostError(f"the camera is lost: {self._heartbeat.lost}")
        if self._closed or self.abandoned:
            raise DeviceLostError("the camera is closed")


def _limit_receive(opened: socket.socket, seconds: float) -> None:
    """Let `recv` give up after a while, where possible by itself; Python's own timeout calls `poll` first."""
    if sys.platform == "win32":
        opened.settimeout(seconds)  # Windows adds half a second to its own
    else:
        limit = struct.pack("@ll", int(seconds), round(seconds % 1 * 1e6))
        opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, limit)


# -- memory of any length and alignment ----------------------------------------------------------
_WORD = 4
SHORTEST_CHUNK = 64
"Bytes that a device is expected to read or write at once."
_ABOUT_THE_PLACE = (Status.INVALID_ADDRESS, Status.WRITE_PROTECT, Status.ACCESS_DENIED, Status.BUSY)
"Statuses that have nothing to do with the length of an access."
_SPACE = 1 << 32
"Bytes that 32-bit addresses reach."


class DeviceMemory:
    """Reads and writes of any length and alignment, by the protocol's aligned ones. Any thread may call."""

    def __init__(self, link: ControlLink) -> None:
        self._link = link
        self.capability = Capability(0)
        "The device's capabilities; set while it is opened."
        self.writable = False
        "Whether we have control."
        self.little_endian = False
        "Whether words are little-endian in the device's memory, which READMEM and WRITEMEM carry as it is."
        self._ready_to_write = False
        "Whether PENDING_ACK is enabled where the device has it."
        self._writes_memory = False
        "Whether the device knows WRITEMEM."
        self._absent: set[int] = set()
        "Registers that the device refused to read; it is not asked again."
        self._protected: set[int] = set()
        "Registers that it refused to write."
        self._longest = dict.fromkeys((ReadMem, WriteMem), MEMORY_CHUNK)
        "Bytes that one READMEM or WRITEMEM may have; some devices take fewer than the standard allows."

    def read(self, address: int, length: int) -> bytes:
        """Read exactly `length` bytes. Raises DeviceStatusError, TransportError, RemoteProtocolError."""
        first, end = self._aligned(address, length)
        data = bytearray()
        while first + len(data) < end:
            read = partial(self._link.read_memory, first + len(data))
            data += self._shortened(ReadMem, end - first - len(data), read)
        return bytes(data[address - first :][:length])

    def write(self, address: int, data: bytes) -> None:
        """Write all of `data`; a word covered in part is read first. Raises as `read`, AccessDeniedError."""
        self._begin_write()
        first, end = self._aligned(address, len(data))
        if (first, end) != (address, address + len(data)):
            around = self.read(first, end - first)
            data = around[: address - first] + data + around[address - first + len(data) :]
        written = 0
        while written < len(data):
            written += self._write_aligned(first + written, data[written:])

    def read_register(self, register: int) -> int:
        """Read a 32-bit register as a number, whatever the order of its bytes. Raises as `read`."""
        return self._link.read_register(register)

    def write_register(self, register: int, value: int) -> None:
        """Write a number into a 32-bit register of the standard, as `read_register` reads it.

        Raises as `read`, AccessDeniedError.
        """
        self._execute_write(WriteReg(((register, value),)))

    def read_numbers(self, address: int, length: int) -> bytes:
        """Read as `read`, but a single aligned word as a number, its most significant byte first."""
        if length != _WORD or address % _WORD:
            return self.read(address, length)
        self._aligned(address, length)
        return self._link.read_register(address).to_bytes(_WORD, "big")

    def write_numbers(self, address: int, data: bytes) -> None:
        """Write as `write`, but a single aligned word as a number, its most significant byte first."""
        if len(data) != _WORD or address % _WORD:
            self.write(address, data)
            return
        self._begin_write()
        self._aligned(address, len(data))
        self.write_register(address, int.from_bytes(data, "big"))

    def read_optional(self, register: int, otherwise: int = 0) -> int:
        """Read a register that a device need not have; one that refuses is asked once.

        Returns `otherwise` without it. Raises TransportError, DeviceLostError, RemoteProtocolError.
        """
        if register in self._absent:
            return otherwise
        try:
            return self.read_register(register)
        except DeviceStatusError as error:
            refusal: GrabberError = error
        except AckTimeoutError as error:
            self._link.read_register(Register.CCP)  # some devices do not answer what they refuse
            refusal = error
        self._absent.add(register)
        log.info("the camera has no register 0x%04X: %s", register, refusal)
        return otherwise

    def write_optional(self, register: int, value: int) -> bool:
        """Write a register that a device need not have, or may protect; return whether it took the value.

        One that refuses is asked once. Raises TransportError, DeviceLostError.
        """
        if register in self._protected:
            return False
        try:
            self.write_register(register, value)
        except (DeviceStatusError, AccessDeniedError) as error:
            if isinstance(error, DeviceStatusError) and error.status == Status.BUSY:
                raise
            self._protected.add(register)
            log.info("the camera does not take %d in its register 0x%04X: %s", value, register, error)
            return False
        return True

    def read_text(self, field: Field) -> str:
        """Read a string register. Raises as `read`."""
        return text_field(self.read(field.address, field.length))

    def _aligned(self, address: int, length: int) -> tuple[int, int]:
        first, end = address - address % _WORD, address + length + -(address + length) % _WORD
        if address < 0 or length < 0 or end > _SPACE:
            raise TransportError(
                f"{length} bytes at 0x{address:X} are outside the camera's 32-bit address space"
            )
        return first, end

    def _write_aligned(self, address: int, data: bytes) -> int:
        """Write as much as one command takes; return the number of bytes."""
        if self._writes_memory:

            def write(count: int) -> bytes:
                self._execute_write(WriteMem(address, data[:count]))
                return data[:count]

            return len(self._shortened(WriteMem, len(data), write))
        word = struct.Struct("<I" if self.little_endian else ">I")
        for offset in range(0, len(data), _WORD):
            (value,) = word.unpack_from(data, offset)
            self._execute_write(WriteReg(((address + offset, value),)))
        return len(data)

    def _shortened(
        self, command: type[ReadMem | WriteMem], wanted: int, execute: Callable[[int], bytes]
    ) -> bytes:
        """Execute a command for at most `wanted` bytes; learn how many a device takes that refuses many."""
        while True:
            count = min(wanted, self._longest[command])
            try:
                return execute(count)
            except (DeviceStatusError, RemoteProtocolError) as error:
                if count <= SHORTEST_CHUNK or getattr(error, "status", None) in _ABOUT_THE_PLACE:
                    raise
                refusal: GrabberError = error
            # Shorter ones may be refused for the same reason, which is not their length then.
            for shorter in (256, 128, SHORTEST_CHUNK):
                if shorter < count:
                    with suppress(DeviceStatusError, RemoteProtocolError):
                        data = execute(shorter)
                        self._longest[command] = shorter
                        log.info("the camera takes %d bytes at a time: %s", shorter, refusal)
                        return data
            raise refusal

    def _execute_write(self, request: WriteReg | WriteMem) -> None:
        try:
            self._link.execute(request)
        except AckTimeoutError as error:
            # Some devices do not answer a refused write; unlike dead ones they answer a read.
            self._link.require_control()
            if error.postponed:
                raise DeviceStatusError(str(error), Status.BUSY) from error
            raise AccessDeniedError(
                "the camera answers reads but not this write; another application may control it"
            ) from error
        except DeviceStatusError as error:
            # Devices answer ACCESS_DENIED for locked features too.
            if error.status == Status.ACCESS_DENIED:
                self._link.require_control()
            raise

    def _begin_write(self) -> None:
        if not self.writable:
            raise AccessDeniedError("the camera is open for reading only; another application may control it")
        if not self._ready_to_write:
            self._prepare_writing()

    def _prepare_writing(self) -> None:
        """Enable PENDING_ACK before the first write, and not before, so that opening writes nothing."""
        self._writes_memory = Capability.WRITEMEM in self.capability
        if self.capability & Capability.PENDING_ACK:
            register, bit = Register.GVCP_CONFIGURATION, GvcpConfiguration.PENDING_ACK
            try:
                configuration = self._link.read_register(register)
                if not configuration & bit:
                    self.write_register(register, configuration | bit)
            except DeviceStatusError as error:
                log.info("late acknowledges cannot be announced: %s", error)
        self._ready_to_write = True
