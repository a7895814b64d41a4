"""Keeping control, and knowing when it is gone: a machine without I/O.

Control expires unless its holder talks to the device. Reading CCP is the one command that every device
counts, and its value tells whether control is still ours; where the device can, the address of the holder is
read with it, since after an interruption another application may hold what was ours. A camera that stops
answering, or whose control went elsewhere, is known within two seconds.
"""

from __future__ import annotations

import socket
from dataclasses import dataclass, field

from grabbergui.core.errors import AckTimeoutError, DeviceStatusError, RemoteProtocolError
from grabbergui.driver.gige.bootstrap import Control, Register
from grabbergui.driver.gige.control_channel import ControlChannel, ControlTiming, Exchange
from grabbergui.driver.gige.gvcp import ReadReg, Status


@dataclass(frozen=True)
class Pulse:
    """How often the heartbeat beats, and how long it bears silence."""

    period: float = 0.4
    "Seconds between two reads of CCP."
    timing: ControlTiming = field(default_factory=lambda: ControlTiming(ack_timeout=0.2, tries=6))
    "Of each read. Together: at most 1.6 s until silence is taken for loss."

    @classmethod
    def for_timeout(cls, timeout_ms: int) -> Pulse:
        """Fast enough for a device whose heartbeat timeout is this; 0 where it has none."""
        return cls(min(0.4, timeout_ms / 4000)) if timeout_ms else cls()


Holder = tuple[int, int]
"""Who has control: the registers PRIMARY_APPLICATION_PORT and _IP."""

PRIVILEGE = ReadReg((Register.CCP,))
PRIVILEGE_AND_HOLDER = ReadReg(
    (Register.CCP, Register.PRIMARY_APPLICATION_PORT, Register.PRIMARY_APPLICATION_IP)
)


class Heartbeat:
    """Reads CCP through a channel whose owner drives both."""

    def __init__(
        self,
        channel: ControlChannel,
        pulse: Pulse,
        *,
        controlling: bool,
        now: float,
        holder: Holder | None = None,
    ) -> None:
        """`holder` is who we are to the device, read after control was taken; None where it does not tell."""
        self.lost: str | None = None
        "Why the camera is lost, for people; None while it is not."
        self._channel = channel
        self._pulse = pulse
        self._controlling = controlling
        self._holder = holder
        self._request = PRIVILEGE if holder is None else PRIVILEGE_AND_HOLDER
        self._exchange: Exchange | None = None
        self._begun = now
        self._next = now

    def timer(self) -> float | None:
        """When `handle_timer` wants to be called next; the channel has its own timer beside."""
        return self._next if self._exchange is None and self.lost is None else None

    @property
    def beating(self) -> bool:
        """Whether a read waits for its answer."""
        return self._exchange is not None and not self._exchange.done

    def handle_timer(self, now: float) -> None:
        """Begin a read when it is time, and judge one that has ended."""
        if self._exchange is not None and self._exchange.done:
            exchange, self._exchange = self._exchange, None
            self._next = self._begun + self._pulse.period
            self._judge(exchange, now)
        if self._exchange is None and self.lost is None and now >= self._next:
            self._begun = now
            self._exchange = self._channel.start(self._request, now, self._pulse.timing, urgent=True)

    def _judge(self, exchange: Exchange, now: float) -> None:
        error = exchange.error
        if exchange.payload is not None:
            self._judge_privilege(exchange.payload)
        elif isinstance(error, AckTimeoutError) and not self._excused(exchange):
            self.lost = f"the camera has not answered for {now - exchange.started:.1f} s"
        elif isinstance(error, DeviceStatusError) and error.status == Status.ACCESS_DENIED:
            # Whoever has control exclusively keeps others from reading too.
            self.lost = "another application took control of the camera for itself alone"

    def _judge_privilege(self, payload: bytes) -> None:
        try:
            privilege, *holder = self._request.decode_ack(payload)
        except RemoteProtocolError:
            return
        if not self._controlling:
            return
        if not privilege & (Control.CONTROL | Control.EXCLUSIVE):
            self.lost = (
                "the camera took our control back; its heartbeat may have expired, or it has restarted"
            )
        elif self._holder is not None and tuple(holder) != self._holder:
            address = socket.inet_ntoa(holder[1].to_bytes(4, "big"))
            self.lost = f"another application, at {address}, took control of the camera"

    def _excused(self, exchange: Exchange) -> bool:
        """A device busy with a write may be deaf until it has done it."""
        return self._channel.patient or self._channel.waiting_since(exchange.started)
