"""The events of a connection as bytes, in binary, in text mode, and on a name server's lines. No I/O.

A reader takes one event from the start of the buffer. It returns None while the event is incomplete, and
raises RemoteProtocolError if the bytes cannot become one. It is called only when the phase allows its event.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Final

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os.binary import (
    ACK,
    NAME_LIMIT,
    decode_name,
    decode_name_size,
    decode_number,
    encode_message,
    encode_number,
)
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.carrier import Carrier, encode_header
from grabbergui.net.yarp.os.events import Acknowledgement, Event, Header, HeaderReply, Message, Reply
from grabbergui.net.yarp.os.framing import BottleScanner, LineReader, Receiver, TextBottle
from grabbergui.net.yarp.os.values import Dialect

REPLY_LIMIT: Final = 1 << 28
"""Size of a reply in binary form, in bytes: an image fits."""

TEXT_REPLY_LIMIT: Final = 16 << 20
"""Size of a reply in text mode, in bytes."""

NAMES_LIMIT: Final = 4 << 20
"""Size of a name server's answer, in bytes."""

_SHORT_REPLY: Final = 1024
_ACK: Final = Acknowledgement()
_ACK_LINE: Final = "<ACK>"
_MARK: Final = 8
"""Size of what begins every header and is all of an acknowledgement, in bytes."""


class ReceiveBuffer:
    """Bytes that arrived and were not decoded yet."""

    def __init__(self) -> None:
        self.data = bytearray()

    def add(self, data: Buffer) -> None:
        """Append bytes."""
        self.data += data

    def take(self, size: int) -> memoryview:
        """Remove and return the first bytes. Copies only those that follow."""
        taken, self.data = memoryview(self.data)[:size], self.data[size:]
        return taken


class Codec:
    """Reads and writes the events of one kind of carrier; this one, of none."""

    def __init__(self) -> None:
        self.dialect = Dialect.YARP3
        "Dialect of the Bottles in replies."
        self.missing = 1
        "Bytes that the next event lacks at least."

    @property
    def idle(self) -> bool:
        """Whether nothing of the next message is held here."""
        return True

    def receiver(self) -> Receiver | None:
        """Return what receives messages, where their bytes need not pass through the buffer."""
        return None

    def read_header(self, data: ReceiveBuffer) -> Header | None:
        """Read what an opener sends first."""
        return None

    def read_header_reply(self, data: ReceiveBuffer) -> HeaderReply | None:
        """Read what an acceptor answers."""
        return None

    def read_message(self, data: ReceiveBuffer) -> Message | None:
        """Read a message."""
        return None

    def read_reply(self, data: ReceiveBuffer) -> Reply | None:
        """Read the reply to a message."""
        return None

    def read_answer(self, data: ReceiveBuffer) -> Reply | Acknowledgement | None:
        """Read a reply, or the acknowledgement if there is none."""
        return None

    def read_acknowledgement(self, data: ReceiveBuffer) -> Acknowledgement | None:
        """Read the acknowledgement of a message."""
        return None

    def write(self, event: Event) -> list[Buffer]:
        """Return the event's bytes in pieces."""
        raise LocalProtocolError(f"a {type(event).__name__} has no form on this carrier")


class HeaderCodec(Codec):
    """Reads the header of any carrier, which decides about the codec of what follows."""

    def __init__(self) -> None:
        super().__init__()
        self._lines = LineReader()
        self._request: list[str] = []
        self._request_lines = LineReader(wire.REQUEST_LINE_LIMIT)

    def read_header(self, data: ReceiveBuffer) -> Header | None:
        """Read the carrier and the sender's name."""
        if len(data.data) < _MARK and not self._request:
            return None
        carrier = wire.MJPEG if self._request else wire.identify(data.data)
        if carrier is wire.NAME_SER:
            return Header(carrier, "name client")
        if carrier.pull:
            return self._read_request(data)
        if carrier.text:
            return self._read_text(data, carrier)
        if len(data.data) < _MARK + 4:
            return None
        end = _MARK + 4 + decode_name_size(data.data[_MARK : _MARK + 4])
        size = end + (wire.GROUP_BYTES if carrier.multicast else 0)
        if len(data.data) < size:
            return None
        taken = data.take(size)
        group = wire.decode_group(taken[end:]) if carrier.multicast else None
        return Header(carrier, decode_name(taken[_MARK + 4 : end]), group=group)

    def _read_text(self, data: ReceiveBuffer, carrier: Carrier) -> Header | None:
        line = self._lines.take(data.data)
        if line is None:
            return None
        sender = line[_MARK:]
        if len(sender) > NAME_LIMIT:
            raise RemoteProtocolError(f"sender's name of {len(sender)} characters, at most {NAME_LIMIT}")
        return Header(carrier, sender.strip())

    def _read_request(self, data: ReceiveBuffer) -> Header | None:
        """Read an HTTP request up to the blank line that ends it."""
        while (line := self._request_lines.take(data.data)) is not None:
            if not line:
                first = self._request[0]
                if wire.identify(first.encode("utf-8", "surrogateescape")) is wire.MJPEG:
                    return Header(wire.MJPEG, "mjpeg reader", first)
                return Header(wire.HTTP, "browser", first)
            self._request.append(line)
            if len(self._request) > wire.REQUEST_LINES:
                raise RemoteProtocolError("HTTP request without an end")
        return None

    @property
    def idle(self) -> bool:
        """Whether no line of an HTTP request was read."""
        return not self._request


class BinaryCodec(Codec):
    """tcp, fast_tcp, and the headers of udp and mcast."""

    def __init__(self, allocate: Callable[[int], memoryview], limit: int) -> None:
        super().__init__()
        self._allocate = allocate
        self._limit = limit
        self._receiver: Receiver | None = None
        self._scanner: BottleScanner | None = None

    def receiver(self) -> Receiver:
        """Return the receiver, made when it is needed: a sender of messages has none."""
        if self._receiver is None:
            self._receiver = Receiver(allocate=self._allocate, limit=self._limit)
        return self._receiver

    @property
    def idle(self) -> bool:
        """Whether nothing of the next message is held here."""
        return self._receiver is None or self._receiver.idle

    def read_header_reply(self, data: ReceiveBuffer) -> HeaderReply | None:
        """Read eight bytes with a port number."""
        return HeaderReply(decode_number(data.take(_MARK))) if len(data.data) >= _MARK else None

    def read_message(self, data: ReceiveBuffer) -> Message | None:
        """Read index, command and body."""
        receiver = self.receiver()
        while (message := receiver.take()) is None and data.data:
            del data.data[: receiver.copy(data.data)]
        return message

    def read_reply(self, data: ReceiveBuffer) -> Reply | None:
        """Read a Bottle."""
        available = len(data.data)
        if available <= _SHORT_REPLY and data.data.endswith(ACK):
            # It seems to be complete. Decoding it costs as much as finding its end.
            with suppress(RemoteProtocolError):
                bottle, size = Bottle.decode_from(bytes(data.data), 0, self.dialect)
                self._scanner, self.missing = None, 1
                return Reply(data.take(size), bottle=bottle)
        self._scanner = self._scanner or BottleScanner(self.dialect, REPLY_LIMIT)
        size = self._scanner.scan(data.data)
        if size > available:
            self.missing = size - available
            return None
        self._scanner, self.missing = None, 1
        return Reply(data.take(size))

    def read_answer(self, data: ReceiveBuffer) -> Reply | Acknowledgement | None:
        """Read a Bottle or an acknowledgement, whose first two bytes no Bottle begins with."""
        if len(data.data) < _MARK:
            return None
        return self.read_acknowledgement(data) if data.data.startswith(b"YA") else self.read_reply(data)

    def read_acknowledgement(self, data: ReceiveBuffer) -> Acknowledgement | None:
        """Read eight bytes."""
        if len(data.data) < _MARK:
            return None
        if not data.data.startswith(b"YA"):
            raise RemoteProtocolError(
                f"{bytes(data.data[:_MARK])!r} where a reply or its acknowledgement was expected"
            )
        decode_number(data.take(_MARK))
        return _ACK

    def write(self, event: Event) -> list[Buffer]:
        """Return the event's bytes in pieces."""
        match event:
            case Message():
                return encode_message(event.command, event.parts or ([event.body] if event.body else ()))
            case Reply():
                return list(event.parts) or [event.body]
            case Acknowledgement():
                return [ACK]
            case Header():
                return [encode_header(event.carrier, event.sender, event.group)]
            case HeaderReply():
                return [encode_number(event.number)]
        return super().write(event)


class TextCodec(Codec):
    """text and text_ack: lines."""

    _limit = TEXT_REPLY_LIMIT

    def __init__(self) -> None:
        super().__init__()
        self._lines = LineReader()
        self._reply_lines = LineReader(self._limit)
        self._command = ""
        self._bottle: TextBottle | None = None
        self._reply: list[str] = []
        self._reply_size = 0

    @property
    def idle(self) -> bool:
        """Whether nothing of the next message is held here."""
        return self._bottle is None and not self._reply

    def read_header_reply(self, data: ReceiveBuffer) -> HeaderReply | None:
        """Read `Welcome SENDER`."""
        line = self._lines.take(data.data)
        return None if line is None else HeaderReply(sender=line.partition(" ")[2])

    def read_message(self, data: ReceiveBuffer) -> Message | None:
        """Read a command's line, and the lines of a Bottle where one follows."""
        while (line := self._lines.take(data.data)) is not None:
            if self._bottle is not None:
                text = self._bottle.add(line)
                if text is not None:
                    self._bottle = None
                    return Message(self._command, text=text)
            elif line and line[0] in "adD":
                self._command, self._bottle = line, TextBottle()
            elif line:
                return Message(line)
        return None

    def read_reply(self, data: ReceiveBuffer) -> Reply | None:
        """Read one line."""
        line = self._reply_lines.take(data.data)
        return None if line is None else Reply(text=line)

    def read_answer(self, data: ReceiveBuffer) -> Reply | Acknowledgement | None:
        """Read the lines before `<ACK>`, or that line if there is no reply."""
        while (line := self._reply_lines.take(data.data)) is not None:
            if line == _ACK_LINE:
                return self._whole_reply() if self._reply else _ACK
            self._add_to_reply(line)
        return None

    def read_acknowledgement(self, data: ReceiveBuffer) -> Acknowledgement | None:
        """Return the acknowledgement that ended the reply."""
        return _ACK

    def write(self, event: Event) -> list[Buffer]:
        """Return the event's lines."""
        match event:
            case Header():
                return [encode_header(event.carrier, event.sender)]
            case HeaderReply():
                return _encode_lines(f"Welcome {event.sender}")
            case Message() if event.code in ("a", "d", "D"):
                return _encode_lines(event.command, event.text)
            case Message():
                return _encode_lines(event.command)
            case Reply():
                return _encode_lines(event.text)
            case Acknowledgement():
                return _encode_lines(_ACK_LINE)
        return super().write(event)

    def _add_to_reply(self, line: str) -> None:
        self._reply.append(line)
        self._reply_size += len(line) + 2  # and its end, or empty lines would cost nothing
        if self._reply_size > self._limit:
            raise RemoteProtocolError(f"reply of more than {self._limit} bytes")

    def _whole_reply(self) -> Reply:
        lines, self._reply, self._reply_size = self._reply, [], 0
        return Reply(text="\r\n".join(lines))


class NameCodec(TextCodec):
    """A name server's line protocol."""

    _limit = NAMES_LIMIT

    def read_message(self, data: ReceiveBuffer) -> Message | None:
        """Read a request, which is one line."""
        line = self._lines.take(data.data)
        return None if line is None else Message("d", text=line)

    def read_reply(self, data: ReceiveBuffer) -> Reply | None:
        """Read lines up to the one that ends an answer."""
        while (line := self._reply_lines.take(data.data)) is not None:
            self._add_to_reply(line)
            if line.startswith(("*", "[")) or self._reply[0].startswith(("port (", "ports")):
                return self._whole_reply()
        return None

    def write(self, event: Event) -> list[Buffer]:
        """Return the event's lines; a header has none."""
        match event:
            case Header():
                return []
            case Message():
                return _encode_lines(event.text)
            case Reply():
                return [event.text.encode("utf-8", "surrogateescape")]
        return super().write(event)


class HttpCodec(Codec):
    """mjpeg and a browser's request: the header reply is the head of the HTTP response."""

    def __init__(self, carrier: Carrier) -> None:
        super().__init__()
        self._carrier = carrier

    def read_header_reply(self, data: ReceiveBuffer) -> HeaderReply | None:
        """Return as soon as a response begins. It stays in the buffer, since any HTTP camera may send it."""
        return HeaderReply() if data.data else None

    def write(self, event: Event) -> list[Buffer]:
        """Return the request, or the response's head for mjpeg."""
        match event:
            case Header() if event.carrier is wire.MJPEG:
                return [wire.STREAM_REQUEST % event.sender.encode()]
            case HeaderReply():  # that of a page has its length in it, so the page's writer makes it
                return [wire.STREAM_RESPONSE] if self._carrier is wire.MJPEG else []
        return super().write(event)


def codec_for(carrier: Carrier, allocate: Callable[[int], memoryview], limit: int) -> Codec:
    """Return the codec of what follows a header."""
    if carrier.pull:
        return HttpCodec(carrier)
    if carrier is wire.NAME_SER:
        return NameCodec()
    return TextCodec() if carrier.text else BinaryCodec(allocate, limit)


def _encode_lines(*lines: str) -> list[Buffer]:
    return ["".join(f"{line}\r\n" for line in lines).encode("utf-8", "surrogateescape")]
