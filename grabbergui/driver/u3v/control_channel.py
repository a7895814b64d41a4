"""GenCP's control channel, for one command at a time: ids, retries and pending acknowledges.

It does no I/O and reads no clock.
"""

from __future__ import annotations

from dataclasses import dataclass

from grabbergui.core.errors import AckTimeoutError, DeviceStatusError, LocalProtocolError, RemoteProtocolError
from grabbergui.driver.u3v.gencp import (
    FLAG_ACKNOWLEDGE,
    CommandId,
    Packet,
    Status,
    parse_reserved_and_value,
    status_text,
)

TRIES = 3
"Number of times a command is sent before it fails."
SHORTEST_RESPONSE_TIME = 0.2
"Seconds; some devices announce less time than they need."
LONGEST_RESPONSE_TIME = 5.0
BUSY_PAUSE = 0.05
"Seconds before a command is sent again to a busy device."
LONGEST_PENDING = 60.0
"Longest total time in seconds for which pending acknowledges may delay a command."


@dataclass
class _Outstanding:
    command: CommandId
    data: bytes
    request_id: int
    deadline: float
    last_deadline: float
    tries: int = 1


class ControlChannel:
    """Turns commands into transfers and transfers into acknowledges.

    `begin` returns the transfer to send. Pass received transfers to `receive` until it returns the
    acknowledge; after `deadline`, `expire` returns the transfer to resend. Times are seconds of one clock.
    """

    def __init__(self, first_request_id: int = 1) -> None:
        self.response_time = 0.5
        "Seconds until a command is sent again."
        self.ignored = 0
        "Number of transfers that were malformed or did not answer the outstanding command."
        self._longest_pending = LONGEST_PENDING
        "Seconds; hardly any after a command that the device postponed to the end, until it answers another."
        self._next_id = first_request_id
        self._outstanding: _Outstanding | None = None

    @property
    def deadline(self) -> float:
        """Time at which `expire` is due. Raises LocalProtocolError if no command is outstanding."""
        return self._current().deadline

    def set_maximum_response_time(self, milliseconds: int) -> None:
        """Use the device's own value (ABRM), within limits."""
        self.response_time = min(max(milliseconds / 1000, SHORTEST_RESPONSE_TIME), LONGEST_RESPONSE_TIME)

    def begin(self, command: CommandId, data: bytes, now: float) -> bytes:
        """Return a command's transfer. Raises LocalProtocolError while another command is outstanding."""
        if self._outstanding is not None:
            raise LocalProtocolError("GenCP takes one command at a time")
        self._outstanding = _Outstanding(
            command, data, self._take_id(), now + self.response_time, now + self._longest_pending
        )
        return self._encode(self._outstanding)

    def receive(self, transfer: bytes, now: float) -> Packet | None:
        """Return the acknowledge; None if this transfer is not the final one, so keep receiving.

        Raises DeviceStatusError for an error status, which also ends the command.
        """
        waiting = self._current()
        try:
            packet = Packet.decode(transfer)
            if packet.request_id != waiting.request_id:
                raise RemoteProtocolError(f"answer to request {packet.request_id}, not {waiting.request_id}")
            if packet.command == CommandId.PENDING_ACK:
                put_off = parse_reserved_and_value(packet.data) / 1000
                waiting.deadline = min(now + put_off + self.response_time, waiting.last_deadline)
                return None
            if packet.command != waiting.command + 1:
                raise RemoteProtocolError(f"answer 0x{packet.command:04X} to 0x{waiting.command:04X}")
        except RemoteProtocolError:
            # An answer to a previous host may still be in the pipe.
            self.ignored += 1
            return None
        if packet.status == Status.BUSY and waiting.tries < TRIES:
            waiting.deadline = now + BUSY_PAUSE
            return None
        self._outstanding = None
        self._longest_pending = LONGEST_PENDING
        if packet.status & 0x8000:
            address = int.from_bytes(waiting.data[:8], "little")
            raise DeviceStatusError(
                f"the device refused {waiting.command.name} at 0x{address:X}: {status_text(packet.status)}",
                packet.status,
            )
        return packet

    def expire(self, now: float) -> bytes:
        """Return the same command with a new id, to send when `deadline` has passed.

        Raises AckTimeoutError after the last try, or after the longest time that the device may ask for. A
        late answer to the previous id is ignored.
        """
        waiting = self._current()
        if now >= waiting.last_deadline:  # it may still be at work on the command
            self._outstanding = None
            waited, self._longest_pending = self._longest_pending, (TRIES + 1) * self.response_time
            raise AckTimeoutError(
                f"{waiting.command.name} was not acknowledged within {waited:g} s;"
                " the camera had asked for more time"
            )
        if waiting.tries >= TRIES:
            self._outstanding = None
            raise AckTimeoutError(
                f"the device did not answer {waiting.command.name} after {waiting.tries} tries "
                f"of {self.response_time * 1000:.0f} ms; unplug it and plug it in again"
            )
        waiting.tries += 1
        waiting.request_id = self._take_id()
        waiting.deadline = now + self.response_time  # not from the old deadline: this program may be late
        return self._encode(waiting)

    def abandon(self) -> None:
        """Forget the outstanding command, if any, because its transfer failed."""
        self._outstanding = None

    def _current(self) -> _Outstanding:
        if self._outstanding is None:
            raise LocalProtocolError("no GenCP command is outstanding")
        return self._outstanding

    def _take_id(self) -> int:
        taken = self._next_id
        self._next_id = taken % 0xFFFF + 1  # 0 is skipped, as other hosts do
        return taken

    def _encode(self, waiting: _Outstanding) -> bytes:
        return Packet(FLAG_ACKNOWLEDGE, waiting.command, waiting.request_id, waiting.data).encode()
