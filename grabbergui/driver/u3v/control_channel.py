"""One command at a time to a USB3 Vision device: ids, retries, pending acknowledges. No I/O, no clock."""

from __future__ import annotations

from dataclasses import dataclass

from grabbergui.core.errors import (
    AckTimeoutError,
    DeviceStatusError,
    LocalProtocolError,
    RemoteProtocolError,
)
from grabbergui.driver.u3v.gencp import (
    FLAG_ACKNOWLEDGE,
    CommandId,
    Packet,
    Status,
    parse_reserved_and_value,
    status_text,
)

TRIES = 3
"Number of times a command is sent before it is given up."
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

    `begin` gives the transfer to send; then `receive` takes what comes until it returns an acknowledge, and
    `expire` gives the transfer to send again when `deadline` has passed. Times are seconds of any one clock.
    """

    def __init__(self, first_request_id: int = 1) -> None:
        self.response_time = 0.5
        "Seconds until a command is sent again."
        self.ignored = 0
        "Transfers that were malformed or no answer to the outstanding command."
        self._next_id = first_request_id
        self._outstanding: _Outstanding | None = None

    @property
    def deadline(self) -> float:
        """Time at which `expire` is due. Raises LocalProtocolError if no command is outstanding."""
        return self._current().deadline

    def set_maximum_response_time(self, milliseconds: int) -> None:
        """Take the device's own figure (ABRM), within reason."""
        self.response_time = min(max(milliseconds / 1000, SHORTEST_RESPONSE_TIME), LONGEST_RESPONSE_TIME)

    def begin(self, command: CommandId, data: bytes, now: float) -> bytes:
        """Return a command's transfer. Raises LocalProtocolError while another command is outstanding."""
        if self._outstanding is not None:
            raise LocalProtocolError("GenCP takes one command at a time")
        self._outstanding = _Outstanding(
            command, data, self._take_id(), now + self.response_time, now + LONGEST_PENDING
        )
        return self._encode(self._outstanding)

    def receive(self, transfer: bytes, now: float) -> Packet | None:
        """Return the acknowledge, or None where this transfer was not it: go on receiving.

        Raises DeviceStatusError for an error status; the command is over then, too.
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
            # An answer to a former host may still be in the pipe.
            self.ignored += 1
            return None
        if packet.status == Status.BUSY and waiting.tries < TRIES:
            waiting.deadline = now + BUSY_PAUSE
            return None
        self._outstanding = None
        if packet.status & 0x8000:
            address = int.from_bytes(waiting.data[:8], "little")
            raise DeviceStatusError(
                f"the device refused {waiting.command.name} at 0x{address:X}: {status_text(packet.status)}",
                packet.status,
            )
        return packet

    def expire(self) -> bytes:
        """Return the same command with a new id, to be sent when `deadline` has passed.

        Raises AckTimeoutError when it was sent often enough. A late answer to the former id is ignored.
        """
        waiting = self._current()
        if waiting.tries >= TRIES:
            self._outstanding = None
            raise AckTimeoutError(
                f"the device did not answer {waiting.command.name} after {waiting.tries} tries "
                f"of {self.response_time * 1000:.0f} ms; unplug it and plug it in again"
            )
        waiting.tries += 1
        waiting.request_id = self._take_id()
        waiting.deadline += self.response_time
        return self._encode(waiting)

    def abandon(self) -> None:
        """Forget the outstanding command, if any: the transfer itself failed."""
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
