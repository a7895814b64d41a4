"""The control channel's socket: drives `ControlChannel` and `Heartbeat` for any number of threads.

One of the threads that wait for an acknowledge receives for all of them, without holding the lock; the
others sleep until it has received something. So a command needs no second thread, a slow one does not stop
the heartbeat, and a beat without an answer does not delay commands.
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
from grabbergui.driver.gige.bootstrap import GVCP_PORT
from grabbergui.driver.gige.control.channel import ControlChannel, ControlTiming, Heartbeat, Holder, Pulse
from grabbergui.driver.gige.gvcp import ReadMem, ReadReg, Request

log = logging.getLogger(__name__)

LONGEST_RECEIVE = 0.01
"""Seconds that a thread stays in the socket; then it looks whether a retry is due or the link was closed."""
_LARGEST_ACK = 2048
_AT_ONCE = getattr(socket, "MSG_DONTWAIT", 0)
"A full queue must not stop a thread that holds the lock."


class ControlLink:
    """Sends commands to one device. Any thread may call; commands are sent in the order of the calls."""

    def __init__(self, ip: str, port: int = GVCP_PORT, timing: ControlTiming | None = None) -> None:
        self.on_lost: Callable[[str], None] | None = None
        "Called once, on the heartbeat's thread, when the camera is lost."
        self._channel = ControlChannel(timing)
        self._heartbeat: Heartbeat | None = None
        self._received = threading.Condition(threading.Lock())
        "Guards the channel, the heartbeat and the socket; notified when any of them has changed."
        self._receiving = False
        "Whether one of the waiting threads receives for all."
        self._closed = False
        self._resting = threading.Event()
        "Set once the heartbeat is to stop."
        self._thread: threading.Thread | None = None
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            _limit_receive(self._socket, LONGEST_RECEIVE)
            self._socket.connect((ip, port))
        except OSError as error:
            self._socket.close()
            raise TransportError(f"no way to {ip}: {error.strerror or error}") from error
        self.local_address: str = self._socket.getsockname()[0]
        "The host's IP address on the way to the device."
        self.local_port: int = self._socket.getsockname()[1]
        "The UDP port by which the device identifies its controller."

    @property
    def lost(self) -> str | None:
        """Why the camera is lost, or None."""
        return self._heartbeat.lost if self._heartbeat else None

    def execute(self, request: Request, timing: ControlTiming | None = None) -> bytes:
        """Send a command, wait, and return the acknowledge's payload.

        Raises AckTimeoutError, DeviceStatusError, DeviceLostError.
        """
        with self._received:
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
        if exchange.error is not None:
            raise exchange.error
        assert exchange.payload is not None
        return exchange.payload

    def send_last(self, request: Request) -> None:
        """Send a command to a camera that counts as lost, without waiting: it may only have been slow."""
        with self._received:
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
        self._resting.set()
        thread = self._thread
        if thread is not None and thread is not threading.current_thread():
            thread.join()
        self._thread = None

    def close(self) -> None:
        """Stop the heartbeat and close the socket. Commands of other threads fail. May be called twice."""
        self.stop_heartbeat()
        with self._received:
            self._closed = True
            self._received.notify_all()
            self._received.wait_for(lambda: not self._receiving)
            self._socket.close()

    def _run(self) -> None:
        heartbeat = self._heartbeat
        assert heartbeat is not None
        while heartbeat.lost is None and not self._resting.wait(self._pause(heartbeat)):
            self._beat(heartbeat)
        if heartbeat.lost and not self._resting.is_set():
            log.warning("camera lost: %s", heartbeat.lost)
            if self.on_lost is not None:
                self.on_lost(heartbeat.lost)

    @staticmethod
    def _pause(heartbeat: Heartbeat) -> float:
        due = heartbeat.timer()
        return 0.0 if due is None else max(0.0, due - time.monotonic())

    def _beat(self, heartbeat: Heartbeat) -> None:
        with self._received:
            heartbeat.handle_timer(time.monotonic())
            self._send_due()
            while heartbeat.beating and not self._resting.is_set():
                self._wait()
                self._send_due()
            heartbeat.handle_timer(time.monotonic())
            if heartbeat.lost:
                self._received.notify_all()

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
            self._received.wait(LONGEST_RECEIVE if due is None else max(0.0, due - time.monotonic()))
            return
        self._receiving = True
        self._received.release()
        datagram = b""
        try:
            datagram = self._receive()
        finally:
            self._received.acquire()
            self._receiving = False
            self._received.notify_all()  # an answer may be theirs; one of them receives from now on
        if datagram:
            self._channel.receive(datagram, time.monotonic())

    def _receive(self) -> bytes:
        """Return one datagram, or nothing after LONGEST_RECEIVE.

        One system call, since each may cost a wait for the GIL.
        """
        try:
            return self._socket.recv(_LARGEST_ACK)
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
        if self.lost:
            raise DeviceLostError(f"the camera is lost: {self.lost}")
        if self._closed:
            raise DeviceLostError("the camera is closed")


def _limit_receive(opened: socket.socket, seconds: float) -> None:
    """Let `recv` give up after a while, where possible by itself; Python's own timeout calls `poll` first."""
    if sys.platform == "win32":
        opened.settimeout(seconds)  # Windows adds half a second to its own
    else:
        limit = struct.pack("@ll", int(seconds), round(seconds % 1 * 1e6))
        opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, limit)
