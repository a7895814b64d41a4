"""The control channel as a sans-I/O protocol: request ids, turns, retries, pending acknowledges, heartbeat.

A device handles one command at a time, so commands are sent in the order in which they were started, each
when the one before it is done. Urgent ones (the heartbeat's) are sent at once, but not between a write and
its repetition. The driver (`control_link`) sends the `datagrams()`, feeds received ones to `receive()`, and
calls `handle_timer()` at `timer()`. Nothing here reads a clock or opens a socket; times are seconds of any
monotonic clock. One thread at a time.

Control expires unless its holder talks to the device. Reading CCP is the one command that every device
counts, and its value shows whether control is still ours; if the device can, the address of the holder is
read with it, since after an interruption another application may hold control. A camera that stops answering,
or whose control went elsewhere, is noticed within two seconds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from grabbergui.core.errors import AckTimeoutError, DeviceStatusError, GrabberError, RemoteProtocolError
from grabbergui.driver.gige import gvcp
from grabbergui.driver.gige.gvcp import Ack, Request, Status


@dataclass(frozen=True)
class ControlTiming:
    """Timeouts and retries of a command."""

    ack_timeout: float = 0.4
    "Seconds after which an unanswered command is sent again."
    tries: int = 4
    "How often it is sent in all: a dead camera is noticed within two seconds."
    busy_pause: float = 0.02
    "Seconds before a command that met a busy device is sent again."
    pending_limit: float = 30.0
    "Seconds for which a device may postpone its acknowledge in all."


class Exchange:
    """One command: waiting for its turn, sent, perhaps again, and at last answered or given up."""

    def __init__(
        self, request: Request, req_id: int, timing: ControlTiming, now: float, *, urgent: bool
    ) -> None:
        self.request = request
        self.req_id = req_id
        self.urgent = urgent
        "Whether it is sent without waiting for its turn."
        self.payload: bytes | None = None
        "The acknowledge's payload, once received."
        self.error: GrabberError | None = None
        "Why no acknowledge is to be expected."
        self.pending = False
        "Whether the device announced a late acknowledge (PENDING_ACK)."
        self._timing = timing
        self._datagram = gvcp.encode_command(request.CODE, request.payload(), req_id)
        self.started = now
        "When it was sent first."
        self._tries = 0
        self.deadline = now
        "When it must be sent, sent again or given up."

    @property
    def is_write(self) -> bool:
        """Whether it changes the device; only such commands may be slow."""
        return isinstance(self.request, (gvcp.WriteReg, gvcp.WriteMem))

    @property
    def may_be_repeated(self) -> bool:
        """Whether it is a write that was sent and will be sent again without an answer."""
        return self.is_write and self._tries > 0 and not self.pending

    @property
    def done(self) -> bool:
        """Whether it was answered or given up."""
        return self.payload is not None or self.error is not None

    def next_try(self, now: float) -> bytes | None:
        """At the deadline: the datagram to send, or None when it is given up."""
        timing = self._timing
        if self.pending or self._tries >= timing.tries:
            waited = now - self.started
            self.error = AckTimeoutError(
                f"{self._describe()} was not acknowledged within {waited:.1f} s"
                + ("; the camera had asked for more time" if self.pending else f" ({self._tries} tries)")
            )
            self.error.postponed = self.pending
            return None
        if not self._tries:
            self.started = now
        self._tries += 1
        self.deadline = now + timing.ack_timeout
        return self._datagram

    def receive(self, ack: Ack, now: float) -> None:
        """Take an acknowledge of this request id; one of another command is ignored."""
        if ack.acknowledge == gvcp.PENDING_ACK:
            try:
                seconds = gvcp.decode_pending_ack(ack.payload)
            except RemoteProtocolError:
                return
            self.pending = True
            latest = self.started + self._timing.pending_limit
            self.deadline = min(now + seconds + self._timing.ack_timeout, latest)
        elif ack.acknowledge != self.request.CODE + 1:
            return
        elif ack.status == Status.BUSY and self._tries < self._timing.tries:
            self.pending = False
            self.deadline = now + self._timing.busy_pause * self._tries
        elif ack.failed:
            text = gvcp.status_text(ack.status)
            self.error = DeviceStatusError(f"{self._describe()}: the camera answered {text}", ack.status)
        else:
            self.payload = ack.payload

    def _describe(self) -> str:
        request = self.request
        if isinstance(request, gvcp.ReadReg):
            address = request.addresses[0]
        elif isinstance(request, gvcp.WriteReg):
            address = request.writes[0][0]
        else:
            address = request.address
        return f"{request.CODE.name} at 0x{address:X}"


class ControlChannel:
    """All exchanges with one device, matched to acknowledges by their request ids."""

    def __init__(self, timing: ControlTiming | None = None, first_request_id: int = 1) -> None:
        self.timing = timing or ControlTiming()
        self.ignored = 0
        "Datagrams that acknowledged no exchange in progress."
        self._exchanges: dict[int, Exchange] = {}
        self._outgoing: list[bytes] = []
        self._next_id = first_request_id
        self._impatient: set[bool] = set()
        """Whether writes (True) or reads (False) may be postponed briefly only.

        So it is after a command that the device postponed to the end, until it answers another of the kind:
        all together wait hardly longer than `pending_limit`.
        """

    def start(
        self, request: Request, now: float, timing: ControlTiming | None = None, *, urgent: bool = False
    ) -> Exchange:
        """Begin an exchange; `datagrams()` has its first datagram when its turn comes, at once if urgent.

        Raises LocalProtocolError.
        """
        while self._next_id in self._exchanges:
            self._advance_id()
        timing = timing or self.timing
        if isinstance(request, (gvcp.WriteReg, gvcp.WriteMem)) in self._impatient:
            timing = replace(timing, pending_limit=timing.ack_timeout * timing.tries)
        exchange = Exchange(request, self._next_id, timing, now, urgent=urgent)
        self._advance_id()
        self._exchanges[exchange.req_id] = exchange
        self.handle_timer(now)
        return exchange

    def receive(self, datagram: bytes, now: float) -> None:
        """Take a datagram from the device; anything unexpected is counted and dropped."""
        try:
            ack = Ack.decode(datagram)
        except RemoteProtocolError:
            self.ignored += 1
            return
        exchange = self._exchanges.get(ack.ack_id)
        if exchange is None:
            self.ignored += 1
            return
        exchange.receive(ack, now)
        if exchange.done:
            self._impatient.discard(exchange.is_write)
            self.cancel(exchange)

    def cancel(self, exchange: Exchange) -> None:
        """Give up waiting; a late answer is ignored."""
        self._exchanges.pop(exchange.req_id, None)

    def datagrams(self) -> list[bytes]:
        """Return the datagrams to send, each once."""
        outgoing, self._outgoing = self._outgoing, []
        return outgoing

    def timer(self) -> float | None:
        """Return when `handle_timer` wants to be called next, perhaps in the past; or None."""
        return min((exchange.deadline for exchange in self._in_flight()), default=None)

    def handle_timer(self, now: float) -> None:
        """Send commands whose turn has come; repeat or give up those not acknowledged in time."""
        for exchange in self._in_flight():
            if exchange.deadline <= now:
                datagram = exchange.next_try(now)
                if datagram is not None:
                    self._outgoing.append(datagram)
                else:
                    if exchange.pending:
                        self._impatient |= {True, False}
                    self.cancel(exchange)

    @property
    def patient(self) -> bool:
        """Whether the device announced a late acknowledge, so that its silence means nothing."""
        return any(exchange.pending for exchange in self._exchanges.values())

    def _in_flight(self) -> list[Exchange]:
        """Return the urgent exchanges and the oldest of the others: those that are sent or to be sent.

        An urgent read waits for a write that may have to be sent again. A device that has executed it, but
        whose answer was lost, would execute it twice if it had another command in between.
        """
        oldest = next((exchange for exchange in self._exchanges.values() if not exchange.urgent), None)
        alone = oldest is not None and oldest.may_be_repeated
        return [
            exchange
            for exchange in self._exchanges.values()
            if exchange is oldest or (exchange.urgent and (exchange.is_write or not alone))
        ]

    def _advance_id(self) -> None:
        self._next_id = self._next_id % 0xFFFF + 1
