"""The heartbeat of a controlled device: how often, and when silence counts as loss. No I/O."""

from __future__ import annotations

from dataclasses import dataclass, field

from grabbergui.core.errors import AckTimeoutError, DeviceStatusError, RemoteProtocolError
from grabbergui.driver.gige.bootstrap import BootstrapRegister, ControlPrivilege, ip_text
from grabbergui.driver.gige.control_channel import ControlChannel, ControlTiming, Exchange
from grabbergui.driver.gige.gvcp import ReadReg, Status

Holder = tuple[int, int]
"""Who has control: the registers PRIMARY_APPLICATION_PORT and _IP."""


@dataclass(frozen=True)
class Pulse:
    """Period of the heartbeat, and how long the device may be silent."""

    period: float = 0.4
    "Seconds between two reads of CCP."
    timing: ControlTiming = field(default_factory=lambda: ControlTiming(ack_timeout=0.2, tries=6))
    "Timing of each read. With the period, silence counts as loss after at most 1.6 s."

    @classmethod
    def for_timeout(cls, timeout_ms: int) -> Pulse:
        """Return a pulse fast enough for a heartbeat timeout; 0: the device has none."""
        return cls(min(0.4, timeout_ms / 4000)) if timeout_ms else cls()


PRIVILEGE = ReadReg((BootstrapRegister.CCP,))
PRIVILEGE_AND_HOLDER = ReadReg(
    (
        BootstrapRegister.CCP,
        BootstrapRegister.PRIMARY_APPLICATION_PORT,
        BootstrapRegister.PRIMARY_APPLICATION_IP,
    )
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
        """`holder` is our address as the device sees it, read after control was taken; None if unknown."""
        self.lost: str | None = None
        "Why the camera is lost, as display text; None while it is not."
        self.held: bool | None = None
        "Whether an application has control, as of the last beat; None before the first."
        self._channel = channel
        self._pulse = pulse
        self._controlling = controlling
        self._holder = holder
        self.request = PRIVILEGE if holder is None else PRIVILEGE_AND_HOLDER
        "The request of each beat."
        self._exchange: Exchange | None = None
        self._next = now

    def timer(self) -> float | None:
        """Return when `handle_timer` wants to be called next; the channel has a timer of its own."""
        return self._next if self._exchange is None and self.lost is None else None

    @property
    def beating(self) -> bool:
        """Whether a read waits for its answer."""
        return self._exchange is not None and not self._exchange.done

    def handle_timer(self, now: float) -> None:
        """Begin a read when it is time, and judge one that has ended."""
        if self._exchange is not None and self._exchange.done:
            exchange, self._exchange = self._exchange, None
            self.judge(exchange, now)
        if self._exchange is None and self.lost is None and now >= self._next:
            self._next = now + self._pulse.period
            self._exchange = self._channel.start(self.request, now, self._pulse.timing, urgent=True)

    def judge(self, exchange: Exchange, now: float) -> None:
        """Note in `lost` what an exchange of `request` that has ended says."""
        error = exchange.error
        if exchange.payload is not None:
            self._judge_privilege(exchange.payload)
        elif isinstance(error, AckTimeoutError) and not self._channel.patient:
            more = ", but asked for more time" if error.postponed else ""
            self.lost = f"the camera did not answer for {now - exchange.started:.1f} s{more}"
        elif isinstance(error, DeviceStatusError) and error.status == Status.ACCESS_DENIED:
            # Whoever has control exclusively keeps others from reading too.
            self.lost = "another application took exclusive control of the camera"

    def _judge_privilege(self, payload: bytes) -> None:
        try:
            privilege, *holder = self.request.decode_ack(payload)
        except RemoteProtocolError:
            return
        self.held = bool(privilege & (ControlPrivilege.CONTROL | ControlPrivilege.EXCLUSIVE))
        if not self._controlling:
            return
        if not self.held:
            self.lost = (
                "the camera took our control back; its heartbeat may have expired, or it has restarted"
            )
        elif self._holder is not None and tuple(holder) != self._holder:
            self.lost = f"another application, at {ip_text(holder[1])}, took control of the camera"
