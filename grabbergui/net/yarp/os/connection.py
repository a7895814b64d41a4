"""One YARP connection as a sans-I/O protocol: bytes in, events out, and the reverse.

The peers take turns, so one phase describes both of them. The opener sends a header with its name, the
acceptor a header reply. Then the sender sends messages; the receiver may reply, and must acknowledge if the
carrier does. The opener is the sender until a message `r` reverses the connection. Over udp, mjpeg and http
the header reply is the last event, over mcast and unix_stream the header: another protocol follows, and
`trailing_data` holds its first bytes.

Only `TRANSITIONS` defines which event may follow which; `codecs` turns events into bytes.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import Final, Literal

from grabbergui.core.errors import LocalProtocolError, ProtocolError, TransportError
from grabbergui.net.yarp.os.binary import MESSAGE_LIMIT
from grabbergui.net.yarp.os.bottle import Buffer
from grabbergui.net.yarp.os.carrier import NAME_SER, Carrier
from grabbergui.net.yarp.os.codecs import Codec, HeaderCodec, ReceiveBuffer, codec_for
from grabbergui.net.yarp.os.events import Acknowledgement, Closed, Event, Header, HeaderReply, Message, Reply
from grabbergui.net.yarp.os.framing import Receiver, new_memory
from grabbergui.net.yarp.os.values import Dialect

Reader = Callable[[ReceiveBuffer], Event | None]


class Phase(str, Enum):
    """Phase of a connection."""

    HEADER = "before the header"
    HEADER_REPLY = "before the header reply"
    READY = "between two messages"
    ANSWER = "before a reply or an acknowledgement"
    ACKNOWLEDGEMENT = "between a reply and its acknowledgement"
    SWITCHED = "with another protocol"
    CLOSED = "closed"
    ERROR = "broken"


class Who(str, Enum):
    """The role in which a peer acts: who connected, and later who sends messages."""

    OPENER = "opener"
    ACCEPTOR = "acceptor"
    SENDER = "sender"
    RECEIVER = "receiver"


class Wait(Enum):
    """Results of `YarpConnection.next_event` that are no events."""

    NEED_DATA = "the event is incomplete"
    PAUSED = "it is our turn, or nothing can follow"


NEED_DATA: Final = Wait.NEED_DATA
PAUSED: Final = Wait.PAUSED


TRANSITIONS: Final[dict[Phase, dict[tuple[Who, type[Event]], Phase]]] = {
    Phase.HEADER: {
        (Who.OPENER, Header): Phase.HEADER_REPLY,
        (Who.OPENER, Closed): Phase.CLOSED,
    },
    Phase.HEADER_REPLY: {
        (Who.ACCEPTOR, HeaderReply): Phase.READY,
        (Who.ACCEPTOR, Closed): Phase.CLOSED,
    },
    Phase.READY: {
        (Who.SENDER, Message): Phase.ANSWER,
        (Who.SENDER, Closed): Phase.CLOSED,
        (Who.RECEIVER, Reply): Phase.READY,  # on carriers without acknowledgements
        (Who.RECEIVER, Closed): Phase.CLOSED,
    },
    Phase.ANSWER: {
        (Who.RECEIVER, Reply): Phase.ACKNOWLEDGEMENT,
        (Who.RECEIVER, Acknowledgement): Phase.READY,
        (Who.RECEIVER, Closed): Phase.CLOSED,
    },
    Phase.ACKNOWLEDGEMENT: {
        (Who.RECEIVER, Acknowledgement): Phase.READY,
        (Who.RECEIVER, Closed): Phase.CLOSED,
    },
    Phase.SWITCHED: {},
    Phase.CLOSED: {},
    Phase.ERROR: {},
}
"""The phase after an event, by the current phase and by who acts."""

READERS: Final[dict[tuple[Phase, Who], Callable[[Codec], Reader]]] = {
    (Phase.HEADER, Who.OPENER): lambda codec: codec.read_header,
    (Phase.HEADER_REPLY, Who.ACCEPTOR): lambda codec: codec.read_header_reply,
    (Phase.READY, Who.SENDER): lambda codec: codec.read_message,
    (Phase.READY, Who.RECEIVER): lambda codec: codec.read_reply,
    (Phase.ANSWER, Who.RECEIVER): lambda codec: codec.read_answer,
    (Phase.ACKNOWLEDGEMENT, Who.RECEIVER): lambda codec: codec.read_acknowledgement,
}
"""Reads the peer's next event, by phase and the peer's role. Without a reader it is not the peer's turn."""

_OPENING: Final = (Phase.HEADER, Phase.HEADER_REPLY)
_ANSWERING: Final = (Phase.ANSWER, Phase.ACKNOWLEDGEMENT)


def _roles(phase: Phase, sends: bool) -> tuple[Who, Who]:
    """Return our role and the peer's. Until messages begin, the one who will send them is the opener."""
    active, passive = (Who.OPENER, Who.ACCEPTOR) if phase in _OPENING else (Who.SENDER, Who.RECEIVER)
    return (active, passive) if sends else (passive, active)


_TURNS: Final = {
    (phase, sends): (own, peer, READERS.get((phase, peer)))
    for phase in Phase
    for sends in (True, False)
    for own, peer in [_roles(phase, sends)]
}
"""Both roles, and the reader of the peer's next event, by phase and by whether we send messages."""


def next_phase(phase: Phase, who: Who, event: type[Event]) -> Phase:
    """Look the phase after an event up. Raises LocalProtocolError for one that is out of turn."""
    try:
        return TRANSITIONS[phase][who, event]
    except KeyError:
        raise LocalProtocolError(
            f"a {who.value} has no {event.__name__} to send on a connection {phase.value}"
        ) from None


class YarpConnection:
    """One end of a connection. Not thread-safe.

    Pass the bytes that arrive (`receive_data`, or fill `wanted` and call `received`), then call `next_event`
    until it returns NEED_DATA or PAUSED. Write the bytes that `send` returns.
    """

    def __init__(
        self,
        *,
        opener: bool,
        allocate: Callable[[int], memoryview] = new_memory,
        limit: int = MESSAGE_LIMIT,
    ) -> None:
        """`allocate` returns memory for a body; no message longer than `limit` bytes is accepted."""
        self.carrier: Carrier | None = None
        "Known once the header was sent or received."
        self._allocate, self._limit = allocate, limit
        self._codec: Codec = HeaderCodec()
        self._data = ReceiveBuffer()
        self._receiver: Receiver | None = None
        self._ended = self._acknowledged = False
        self._sends = opener
        self._reversing = False
        self._enter(Phase.HEADER)

    def receive_data(self, data: Buffer) -> None:
        """Store bytes that arrived; none of them means that the peer closed the connection."""
        self._ended = not data
        self._data.add(data)

    @property
    def wanted(self) -> memoryview | None:
        """Memory into which to read the next bytes of messages, so that their bodies are not copied.

        None where `receive_data` takes them.
        """
        return self._receiver.wanted if self._receiver and not self._data.data else None

    @property
    def in_body(self) -> bool:
        """Whether `wanted` is the rest of a body, so that it pays to wait until all of it is filled."""
        return self._receiver is not None and self._receiver.in_body

    def received(self, count: int) -> None:
        """Accept `count` bytes in `wanted`; 0 means that the peer closed the connection."""
        self._ended = not count
        assert self._receiver, "`wanted` was None"
        self._receiver.received(count)

    @property
    def missing(self) -> int:
        """Bytes that the next event lacks at least."""
        return self._codec.missing

    @property
    def idle(self) -> bool:
        """Whether the connection is between two messages, and nothing of the next one has arrived."""
        return self.phase is Phase.READY and not self._partial

    @property
    def trailing_data(self) -> bytes:
        """Bytes that were received and belong to no event yet."""
        return bytes(self._data.data)

    def next_event(self) -> Event | Literal[Wait.NEED_DATA, Wait.PAUSED]:
        """Return the peer's next event; NEED_DATA, or PAUSED if it is our turn.

        Raises RemoteProtocolError for bytes that break the protocol, TransportError where the peer closed the
        connection within an event. No event follows an error.
        """
        if self.phase is Phase.CLOSED:
            return Closed()
        reader = self._reader
        try:
            event = reader(self._data) if reader else None
            if event is None:
                if reader and not self._ended:
                    return NEED_DATA
                if (event := self._without_reader()) is None:
                    return PAUSED
            self._advance(event, self._peer)
        except (ProtocolError, TransportError):
            self._enter(Phase.ERROR)
            raise
        return event

    def expect_replies(self, dialect: Dialect) -> None:
        """Read replies as Bottles of this dialect."""
        self._codec.dialect = dialect

    def send(self, event: Event) -> list[Buffer]:
        """Encode an event without copying its body, and advance. Raises LocalProtocolError out of turn."""
        try:
            self._advance(event, self._self)
            return self._codec.write(event)
        except LocalProtocolError:
            self._enter(Phase.ERROR)
            raise

    @property
    def _partial(self) -> bool:
        return bool(self._data.data) or not self._codec.idle

    def _without_reader(self) -> Closed | None:
        """Return the end of the stream, or None if it is our turn. Raises TransportError."""
        if self.phase is Phase.ERROR:
            raise TransportError("the connection is broken")
        if not self._ended or (self._peer, Closed) not in TRANSITIONS[self.phase]:
            return None
        if self._partial:
            raise TransportError("the peer closed the connection within a message")
        return Closed()

    def _advance(self, event: Event, who: Who) -> None:
        """Change the phase by the table, then by the rules for the carrier and for a reversal."""
        kind = type(event)
        phase = next_phase(self.phase, who, kind)
        if isinstance(event, Message):
            self._reversing = event.code == "r"
        elif kind is Reply and phase is Phase.READY and self._acknowledged:
            raise LocalProtocolError("a reply without a message before it")
        elif isinstance(event, Header):
            self.carrier = event.carrier
            self._acknowledged = event.carrier.acknowledged
            self._codec = codec_for(event.carrier, self._allocate, self._limit)
            if event.carrier is NAME_SER:
                phase = Phase.READY  # it has no header reply
            elif not event.carrier.replies:
                phase = Phase.SWITCHED
        elif kind is HeaderReply and self.carrier and self.carrier.switches:
            phase = Phase.SWITCHED
        if not self._acknowledged and phase in _ANSWERING:
            phase = Phase.READY
        if self._reversing and phase is Phase.READY:  # takes effect once acknowledged
            self._sends, self._reversing = not self._sends, False
            if self._receiver:
                self._data.add(self._receiver.release())
        self._enter(phase)

    def _enter(self, phase: Phase) -> None:
        """Change the phase, and with it both roles and the reader."""
        self.phase = phase
        self._self, self._peer, choose = _TURNS[phase, self._sends]
        self._receiver = None
        if phase is Phase.READY:
            if not self._sends:
                self._receiver = self._codec.receiver()
            elif self._acknowledged:
                choose = None  # the receiver has replied to all messages
        self._reader = choose(self._codec) if choose else None
