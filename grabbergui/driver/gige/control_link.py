"""The control channel's socket: drives `ControlChannel` and `Heartbeat` for any number of threads.

Whoever waits for an acknowledge moves the datagrams, the heartbeat's included, so a slow command does not
stop the heart; between commands the heartbeat's own thread does.
"""

from __future__ import annotations

import logging
import selectors
import socket
import threading
import time
from collections.abc import Callable

from grabbergui.core.errors import DeviceLostError, TransportError
from grabbergui.driver.gige.bootstrap import GVCP_PORT
from grabbergui.driver.gige.control_channel import ControlChannel, ControlTiming, Exchange
from grabbergui.driver.gige.gvcp import ReadMem, ReadReg, Request
from grabbergui.driver.gige.heartbeat import Heartbeat, Holder, Pulse

log = logging.getLogger(__name__)


class ControlLink:
    """Commands to one device. Any thread may call; commands take turns."""

    def __init__(self, ip: str, port: int = GVCP_PORT, timing: ControlTiming | None = None) -> None:
        self.on_lost: Callable[[str], None] | None = None
        "Called once, on the heartbeat's thread, when the camera is lost."
        self._channel = ControlChannel(timing)
        self._heartbeat: Heartbeat | None = None
        self._turn = threading.Lock()
        self._wake = threading.Event()
        self._closing = False
        self._thread: threading.Thread | None = None
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.setblocking(False)
            self._socket.connect((ip, port))
        except OSError as error:
            self._socket.close()
            raise TransportError(f"no way to {ip}: {error.strerror or error}") from error
        self._poller = selectors.DefaultSelector()
        self._poller.register(self._socket, selectors.EVENT_READ)
        self.local_address: str = self._socket.getsockname()[0]
        "The host's IP address towards this device."
        self.local_port: int = self._socket.getsockname()[1]
        "The UDP port by which the device knows who controls it."

    @property
    def lost(self) -> str | None:
        """Why the camera is lost, or None."""
        return self._heartbeat.lost if self._heartbeat else None

    def execute(self, request: Request, timing: ControlTiming | None = None) -> bytes:
        """Send a command and wait; the acknowledge's payload.

        Raises AckTimeoutError, DeviceStatusError, DeviceLostError.
        """
        with self._turn:
            self._require_open()
            exchange = self._channel.start(request, time.monotonic(), timing)
            try:
                while not exchange.done:
                    self._step()
                    if self.lost and not exchange.done:
                        self._require_open()
            finally:
                self._channel.cancel(exchange)
        return self._result(exchange)

    def send_last(self, request: Request) -> None:
        """Send a command to a camera that counts as lost, without waiting: it may only have been slow."""
        with self._turn:
            if self._socket.fileno() >= 0:
                self._channel.start(request, time.monotonic())
                for datagram in self._channel.datagrams():
                    self._send(datagram)

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
        self._heartbeat = Heartbeat(
            self._channel, pulse, controlling=controlling, now=begin, holder=holder
        )
        self._thread = threading.Thread(target=self._run, name="gige-heartbeat", daemon=True)
        self._thread.start()

    def stop_heartbeat(self) -> None:
        """Let the heart rest; commands go on. May be called twice."""
        self._closing = True
        self._wake.set()
        thread = self._thread
        if thread is not None and thread is not threading.current_thread():
            thread.join()
        self._thread = None

    def close(self) -> None:
        """Stop the heartbeat and let the socket go. May be called twice."""
        self.stop_heartbeat()
        with self._turn:
            self._poller.close()
            self._socket.close()

    def _run(self) -> None:
        heartbeat = self._heartbeat
        assert heartbeat is not None
        while not self._closing and heartbeat.lost is None:
            due = heartbeat.timer()
            self._wake.wait(0.05 if due is None else max(0.0, due - time.monotonic()))
            # A thread that has the turn drives the heartbeat too.
            if self._closing or not self._turn.acquire(timeout=0.05):
                continue
            try:
                self._beat(heartbeat)
            finally:
                self._turn.release()
        if heartbeat.lost and not self._closing:
            log.warning("camera lost: %s", heartbeat.lost)
            if self.on_lost is not None:
                self.on_lost(heartbeat.lost)

    def _beat(self, heartbeat: Heartbeat) -> None:
        heartbeat.handle_timer(time.monotonic())
        while heartbeat.beating and not self._closing:
            self._step()

    def _step(self) -> None:
        """Send what is to be sent, wait for the next datagram or deadline, and take it."""
        now = time.monotonic()
        self._channel.handle_timer(now)
        if self._heartbeat is not None:
            self._heartbeat.handle_timer(now)
        for datagram in self._channel.datagrams():
            self._send(datagram)
        if self._receive():
            return
        timers = [self._channel.timer(), self._heartbeat.timer() if self._heartbeat else None]
        due = min((timer for timer in timers if timer is not None), default=now)
        if due > now:
            self._poller.select(due - now)
            self._receive()

    def _receive(self) -> bool:
        received = False
        while True:
            try:
                datagram = self._socket.recv(2048)
            except BlockingIOError:
                return received
            except OSError as error:
                # The host over there has no such port: as good as no answer, and it may come back.
                log.debug("control channel: %s", error)
                return received
            self._channel.receive(datagram, time.monotonic())
            received = True

    def _send(self, datagram: bytes) -> None:
        try:
            self._socket.send(datagram)
        except OSError as error:
            # A cable out, a full queue: the retry or the deadline deals with it.
            log.debug("control channel: %s", error)

    def _require_open(self) -> None:
        if self.lost:
            raise DeviceLostError(f"the camera is lost: {self.lost}")
        if self._socket.fileno() < 0:
            raise DeviceLostError("the camera is closed")

    def _result(self, exchange: Exchange) -> bytes:
        if exchange.error is not None:
            raise exchange.error
        assert exchange.payload is not None
        return exchange.payload
