"""The control channel's socket, which any number of threads may use.

`ControlLink` drives `ControlChannel` and `Heartbeat`; `device_memory` uses it.
"""

from __future__ import annotations

import logging
import socket
import struct
import sys
import threading
import time
from collections.abc import Callable

from grabbergui.core.errors import DeviceLostError, TransportError
from grabbergui.core.socket_timeouts import wait_readable
from grabbergui.driver.gige.bootstrap import GVCP_PORT
from grabbergui.driver.gige.control_channel import ControlChannel, ControlTiming, Exchange
from grabbergui.driver.gige.gvcp import ReadMem, ReadReg, Request
from grabbergui.driver.gige.heartbeat import Heartbeat, Holder, Pulse
from grabbergui.driver.gige.interfaces import Interface, leave_through

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
