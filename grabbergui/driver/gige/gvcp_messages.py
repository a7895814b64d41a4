"""GVCP messages of device events and actions."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import ClassVar

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.gige.gvcp import (
    FLAG_ACK_REQUIRED,
    FLAG_EXTENDED_IDS,
    FLAG_SCHEDULED,
    CommandCode,
    encode_command,
)

NO_CHANNEL = 0xFFFF
"Channel number of an event that belongs to no stream channel."


@dataclass(frozen=True)
class Event:
    """One event of EVENT_CMD or EVENTDATA_CMD, which the device sends."""

    STANDARD: ClassVar[struct.Struct] = struct.Struct(">HHHHQ")
    EXTENDED: ClassVar[struct.Struct] = struct.Struct(">HHHHQQ")

    event_id: int
    block_id: int = 0
    timestamp: int = 0
    "Device ticks."
    channel: int = NO_CHANNEL
    data: bytes = b""
    "Data of EVENTDATA."
    extended: bool = False

    def entry(self) -> bytes:
        """Return the event's bytes in the payload, which GenApi's event ports address."""
        if self.extended:
            size = self.EXTENDED.size + len(self.data)
            head = self.EXTENDED.pack(size, self.event_id, self.channel, 0, self.block_id, self.timestamp)
        else:
            head = self.STANDARD.pack(0, self.event_id, self.channel, self.block_id & 0xFFFF, self.timestamp)
        return head + self.data

    def encode(self, req_id: int, *, ack_required: bool = True) -> bytes:
        """Return the datagram: EVENTDATA if there is data, else EVENT."""
        flags = FLAG_ACK_REQUIRED if ack_required else 0
        flags |= FLAG_EXTENDED_IDS if self.extended else 0
        code = CommandCode.EVENTDATA if self.data else CommandCode.EVENT
        return encode_command(code, self.entry(), req_id, flags)

    @classmethod
    def decode_all(cls, command: int, payload: bytes, flags: int) -> tuple[Event, ...]:
        """Return the events of one command. Raises RemoteProtocolError."""
        extended = bool(flags & FLAG_EXTENDED_IDS)
        layout = cls.EXTENDED if extended else cls.STANDARD
        events = []
        position = 0
        while position < len(payload):
            if len(payload) - position < layout.size:
                raise RemoteProtocolError(
                    f"GVCP event of {len(payload) - position} bytes, need {layout.size}"
                )
            size, event_id, channel, *numbers = layout.unpack_from(payload, position)
            block_id, timestamp = numbers[-2:]
            if command == CommandCode.EVENT:
                end = position + layout.size
            else:
                # Only extended entries contain their length, so a standard one is the last.
                end = position + size if extended and size else len(payload)
            if not position + layout.size <= end <= len(payload):
                raise RemoteProtocolError(f"GVCP event of {size} bytes, {len(payload) - position} arrived")
            data = payload[position + layout.size : end]
            events.append(cls(event_id, block_id, timestamp, channel, data, extended))
            position = end
        return tuple(events)


@dataclass(frozen=True)
class Action:
    """ACTION_CMD: executed by every device whose keys match."""

    PLAIN: ClassVar[struct.Struct] = struct.Struct(">III")
    SCHEDULED: ClassVar[struct.Struct] = struct.Struct(">IIIQ")

    device_key: int
    group_key: int
    group_mask: int
    time: int | None = None
    "In device ticks; None: immediately."

    def encode(self, req_id: int, *, ack_required: bool = True) -> bytes:
        """Return the datagram, for broadcast or one device."""
        flags = FLAG_ACK_REQUIRED if ack_required else 0
        keys = (self.device_key, self.group_key, self.group_mask)
        if self.time is None:
            return encode_command(CommandCode.ACTION, self.PLAIN.pack(*keys), req_id, flags)
        payload = self.SCHEDULED.pack(*keys, self.time)
        return encode_command(CommandCode.ACTION, payload, req_id, flags | FLAG_SCHEDULED)

    @classmethod
    def decode(cls, payload: bytes, flags: int) -> Action:
        """Read the command. Raises RemoteProtocolError."""
        layout = cls.SCHEDULED if flags & FLAG_SCHEDULED else cls.PLAIN
        if len(payload) != layout.size:
            raise RemoteProtocolError(f"ACTION of {len(payload)} bytes, need {layout.size}")
        return cls(*layout.unpack(payload))
