"""Keeping control, and knowing when it is gone: a machine without I/O.

Control expires unless its holder talks to the device. Reading CCP is the one command that every device
counts, and its value tells whether control is still ours. A camera that stops answering, or whose control
went elsewhere, is known within two seconds.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from grabbergui.core.errors import AckTimeoutError, RemoteProtocolError
from grabbergui.driver.gige.bootstrap import Control, Register
from grabbergui.driver.gige.control_channel import ControlChannel, ControlTiming, Exchange
from grabbergui.driver.gige.gvcp import ReadReg


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


class Heartbeat:
    """Reads CCP through a channel whose owner drives both."""

    REQUEST = ReadReg((Register.CCP,))

    def __init__(self, channel: ControlChannel, pulse: Pulse, *, controlling: bool, now: float) -> None:
        self.lost: str | None = None
        "Why the camera is lost, for people; None while it is not."
        self._channel = channel
        self._pulse = pulse
        self._controlling = controlling
        self._exchange: Exchange | None = None
        self._begun = now
        self._next = now

    def timer(self) -> float | None:
        """When `handle_timer` wants to be called next; the channel has its own timer beside."""
        return self._next if self._exchange is None and self.lost is None else None

    @property
    def beating(self) -> bool:
        """Whether a read is under way."""
        return self._exchange is not None

    def handle_timer(self, now: float) -> None:
        """Begin a read when it is time, and judge one that has ended."""
        if self._exchange is not None and self._exchange.done:
            exchange, self._exchange = self._exchange, None
            self._next = self._begun + self._pulse.period
            self._judge(exchange, now)
        if self._exchange is None and self.lost is None and now >= self._next:
            self._begun = now
            self._exchange = self._channel.start(self.REQUEST, now, self._pulse.timing)

    def _judge(self, exchange: Exchange, now: float) -> None:
        if exchange.payload is not None:
            self._judge_privilege(exchange.payload)
        elif isinstance(exchange.error, AckTimeoutError) and not self._excused(exchange):
            self.lost = f"the camera has not answered for {now - exchange.started:.1f} s"

    def _judge_privilege(self, payload: bytes) -> None:
        try:
            (privilege,) = self.REQUEST.decode_ack(payload)
        except RemoteProtocolError:
            return
        if self._controlling and not privilege & (Control.CONTROL | Control.EXCLUSIVE):
            self.lost = (
                "the camera took our control back; its heartbeat may have expired, or it has restarted"
            )

    def _excused(self, exchange: Exchange) -> bool:
        """A device busy with a write may be deaf until it has done it."""
        return self._channel.patient or self._channel.waiting_since(exchange.started)
