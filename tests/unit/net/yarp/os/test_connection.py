"""A connection without sockets: both ends in memory, recorded bytes of real YARP, and what is refused."""

from __future__ import annotations

import itertools
import re
import string
from contextlib import nullcontext

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError, TransportError
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os.binary import MAGIC_BASE, encode_number
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.connection import (
    NEED_DATA,
    PAUSED,
    READERS,
    TRANSITIONS,
    Phase,
    Wait,
    Who,
    YarpConnection,
    next_phase,
)
from grabbergui.net.yarp.os.events import Acknowledgement, Closed, Header, HeaderReply, Message, Reply
from grabbergui.net.yarp.os.values import Dialect
from yarp_messages import BINARY, BOTTLE, D, arriving, message, ready
from yarp_transcripts import Conversation, read, streams

TEXT = BOTTLE.to_text()


TURNS = {
    "tcp": [
        ("opener", [Header(wire.TCP, "/a")], b"YA\xe4\x1e\0\0RP\x03\0\0\0/a\0"),
        ("acceptor", [HeaderReply(10002)], b"YA\x12'\0\0RP"),
        ("opener", [Message("d", BINARY)], message(D, BINARY)),
        ("acceptor", [Reply(BINARY), Acknowledgement()], bytes(BINARY) + b"YA\0\0\0\0RP"),
        ("opener", [Message("D 3 4.5", BINARY)], message(b"\x08\0\0\0~\0\0\1D 3 4.5\0", BINARY)),
        ("acceptor", [Acknowledgement()], b"YA\0\0\0\0RP"),
        ("opener", [Message("/\udcffX")], message(b"\4\0\0\0~\0\0\1/\xffX\0")),
    ],
    "fast_tcp": [
        ("opener", [Header(wire.FAST_TCP, "/a (b c)")], b"YA\x64\x1e\0\0RP\x09\0\0\0/a (b c)\0"),
        ("acceptor", [HeaderReply(10002)], b"YA\x12'\0\0RP"),
        ("opener", [Message("D", BINARY)], message(b"\0\0\0\0~D\0\1", BINARY)),
        (
            "opener",
            [Message("/in"), Message("d", BINARY)],
            message(b"\4\0\0\0~\0\0\1/in\0") + message(D, BINARY),
        ),
        ("acceptor", [Reply(BINARY)], bytes(BINARY)),
    ],
    "tcp, reversed": [
        ("opener", [Header(wire.TCP, "/a")], b"YA\xe4\x1e\0\0RP\x03\0\0\0/a\0"),
        ("acceptor", [HeaderReply(1)], b"YA\1\0\0\0RP"),
        ("opener", [Message("r")], message(b"\0\0\0\0~r\0\1")),
        ("acceptor", [Acknowledgement(), Message("d", BINARY)], b"YA\0\0\0\0RP" + message(D, BINARY)),
        ("opener", [Reply(BINARY), Acknowledgement()], bytes(BINARY) + b"YA\0\0\0\0RP"),
        ("acceptor", [Message("q")], message(b"\2\0\0\0~\0\0\1q\0")),
    ],
    "fast_tcp, reversed": [
        ("opener", [Header(wire.FAST_TCP, "/a")], b"YA\x64\x1e\0\0RP\x03\0\0\0/a\0"),
        ("acceptor", [HeaderReply(1)], b"YA\1\0\0\0RP"),
        ("opener", [Message("r"), Reply(BINARY)], message(b"\0\0\0\0~r\0\1") + BINARY),
        ("acceptor", [Message("d", BINARY)], message(D, BINARY)),
        ("opener", [Reply(BINARY)], bytes(BINARY)),
    ],
    "text": [
        ("opener", [Header(wire.TEXT, "/a (b c)")], b"CONNECT /a (b c)\r\n"),
        ("acceptor", [HeaderReply(sender="/a (b c)")], b"Welcome /a (b c)\r\n"),
        ("opener", [Message("d", text=TEXT)], b"d\r\n" + TEXT.encode() + b"\r\n"),
        ("acceptor", [Reply(text=TEXT)], TEXT.encode() + b"\r\n"),
        ("opener", [Message("/in"), Message("D 3 4.5", text="a")], b"/in\r\nD 3 4.5\r\na\r\n"),
        ("acceptor", [Reply(text="Added connection")], b"Added connection\r\n"),
        ("opener", [Message("r")], b"r\r\n"),
        ("acceptor", [Message("D", text="b")], b"D\r\nb\r\n"),
    ],
    "text_ack": [
        ("opener", [Header(wire.TEXT_ACK, "\udcff")], b"CONNACK \xff\r\n"),
        ("acceptor", [HeaderReply(sender="\udcff")], b"Welcome \xff\r\n"),
        ("opener", [Message("a", text="[list] [in]")], b"a\r\n[list] [in]\r\n"),
        ("acceptor", [Reply(text=""), Acknowledgement()], b"\r\n<ACK>\r\n"),
        ("opener", [Message("*")], b"*\r\n"),
        ("acceptor", [Reply(text="one\r\ntwo"), Acknowledgement()], b"one\r\ntwo\r\n<ACK>\r\n"),
        ("opener", [Message("D", text="1")], b"D\r\n1\r\n"),
        ("acceptor", [Acknowledgement()], b"<ACK>\r\n"),
    ],
    "udp": [
        ("opener", [Header(wire.UDP, "/\udcffX")], b"YA\x61\x1e\0\0RP\x04\0\0\0/\xffX\0"),
        ("acceptor", [HeaderReply(40000)], b"YA\x40\x9c\0\0RP"),
    ],
    "mcast": [
        (
            "opener",
            [Header(wire.MCAST, "/a", group=("224.1.1.3", 10007))],
            b"YA\x62\x1e\0\0RP\x03\0\0\0/a\0\xe0\x01\x01\x03\x27\x17",
        ),
    ],
    "unix_stream": [("opener", [Header(wire.UNIX_STREAM, "/a")], b"UNIX_STR\x03\0\0\0/a\0")],
}
"""The acting side, its events, and their bytes, by carrier."""

STEPS = pytest.mark.parametrize("step", [1, 7, 1 << 20], ids=["byte by byte", "7 bytes", "whole"])


MJPEG = wire.STREAM_REQUEST % b"127.0.0.1"


def comparable(event):
    """An event with its body as bytes, wherever it lies."""
    if isinstance(event, Message | Reply):
        return type(event), getattr(event, "command", ""), bytes(event.body), event.text
    return event


@STEPS
@pytest.mark.parametrize("carrier", TURNS)
def test_events_become_their_bytes_and_bytes_their_events(carrier, step):
    ends = {"opener": YarpConnection(opener=True), "acceptor": YarpConnection(opener=False)}
    for who, events, data in TURNS[carrier]:
        other = ends["acceptor" if who == "opener" else "opener"]
        assert b"".join(part for event in events for part in ends[who].send(event)) == data
        found = arriving(other, data, step)
        assert [comparable(event) for event in found] == [comparable(event) for event in events]
        assert not other.trailing_data
    phases = {end.phase for end in ends.values()}
    assert len(phases) == 1, "both ends agree"
    assert phases <= {Phase.READY, Phase.ANSWER, Phase.SWITCHED}


@pytest.mark.parametrize("carrier", TURNS)
def test_an_end_within_an_event_is_an_error_and_between_two_is_none(carrier):
    """Every turn cut off at every byte; whole events before the cut arrive."""
    for number, (who, _, data) in enumerate(TURNS[carrier]):
        for cut in range(1, len(data)):
            peer = YarpConnection(opener=who != "opener")
            for earlier, events, earlier_data in TURNS[carrier][:number]:
                if earlier == who:
                    arriving(peer, earlier_data)
                else:
                    for event in events:
                        peer.send(event)
            peer.receive_data(data[:cut])
            peer.receive_data(b"")
            with pytest.raises(TransportError) if _cuts(carrier, number, cut) else nullcontext():
                while not isinstance(event := peer.next_event(), Closed | Wait):
                    pass
                assert event == Closed() or peer.phase is Phase.SWITCHED


def _cuts(carrier, number, cut):
    """Whether a cut lies within an event: not where one of a turn's events ends."""
    who, events, _ = TURNS[carrier][number]
    actor = YarpConnection(opener=who == "opener")
    for earlier, earlier_events, data in TURNS[carrier][:number]:
        if earlier == who:
            for event in earlier_events:
                actor.send(event)
        else:
            arriving(actor, data)
    lengths = [sum(len(part) for part in actor.send(event)) for event in events]
    if actor.carrier is wire.TEXT_ACK:
        return True  # a reply ends with its acknowledgement
    return cut not in itertools.accumulate(lengths)


@STEPS
def test_a_name_servers_lines(step):
    client, server = YarpConnection(opener=True), YarpConnection(opener=False)
    assert client.send(Header(wire.NAME_SER, "")) == []
    exchanges = [
        ("query /a", "registration name /a ip 127.0.0.1 port 10002 type tcp\r\n*** end of message\r\n"),
        ("announce /a", "[ok]\r\n"),
        ("bot list", "ports\r\n"),
        ("bot query /a", 'port (name "/a") (ip "127.0.0.1") (port_number 10002) (carrier tcp)\r\n'),
        ("query /\udcff", "registration name /\udcff\r\n*** end of message\r\n"),
    ]
    for command, answer in exchanges:
        data = b"".join(client.send(Message("d", text=f"NAME_SERVER {command}")))
        assert data == f"NAME_SERVER {command}\r\n".encode("utf-8", "surrogateescape")
        *header, asked = arriving(server, data, step)
        assert header in ([], [Header(wire.NAME_SER, "name client")])
        assert asked == Message("d", text=f"NAME_SERVER {command}")
        (replied,) = arriving(client, b"".join(server.send(Reply(text=answer))), step)
        assert replied == Reply(text=answer.removesuffix("\r\n"))


@STEPS
@pytest.mark.parametrize(
    ("request_", "header", "reply"),
    [
        (
            wire.STREAM_REQUEST % b"127.0.0.1",
            Header(wire.MJPEG, "mjpeg reader", "GET /?action=stream"),
            wire.STREAM_RESPONSE,
        ),
        (
            b"GET / HTTP/1.1\r\nHost: x\r\n\r\n",
            Header(wire.HTTP, "browser", "GET / HTTP/1.1"),
            b"",
        ),
    ],
    ids=["mjpeg", "page"],
)
def test_http_follows_the_header_reply(request_, header, reply, step):
    source = YarpConnection(opener=False)
    assert arriving(source, request_, step) == [header]
    assert b"".join(source.send(HeaderReply())) == reply
    assert source.phase is Phase.SWITCHED and source.next_event() is PAUSED


def test_a_reader_of_mjpeg_leaves_the_response_to_its_own_reader():
    reader = YarpConnection(opener=True)
    assert reader.send(Header(wire.MJPEG, "127.0.0.1")) == [wire.STREAM_REQUEST % b"127.0.0.1"]
    assert reader.next_event() is NEED_DATA
    assert arriving(reader, b"HTTP/1.0 200 OK\r\n") == [HeaderReply()]
    assert reader.trailing_data == b"HTTP/1.0 200 OK\r\n" and reader.phase is Phase.SWITCHED


def replayed(conversation: Conversation, dialect: Dialect, step: int):
    """Both sides' events, read from a recorded conversation; each end gets what the other one read.

    YARP does not always wait for its turn to write, but both read in turns.
    """
    opener, acceptor = YarpConnection(opener=True), YarpConnection(opener=False)
    found = []

    def pump():
        before = -1
        while len(found) > before:
            before = len(found)
            for side, reader, writer in (("C", acceptor, opener), ("S", opener, acceptor)):
                while not isinstance(event := reader.next_event(), Wait | Closed):
                    found.append((side, event))
                    writer.send(event)
                    opener.expect_replies(dialect)

    for side, data in conversation.turns:
        for start in range(0, len(data), step):
            (acceptor if side == "C" else opener).receive_data(data[start : start + step])
            pump()
    assert not opener.trailing_data and not acceptor.trailing_data
    return found


@pytest.mark.parametrize("step", [1, 1 << 20], ids=["byte by byte", "whole"])
@pytest.mark.parametrize(
    ("name", "dialect"),
    [("rpc_all_commands_fake_312", Dialect.YARP3), ("rpc_typed_yarp_rpc_40", Dialect.YARP4)],
)
def test_real_requests_and_replies(name, dialect, step):
    calls = 0
    for conversation in streams(name, encode_number(MAGIC_BASE + wire.TCP.code)):
        if dialect is Dialect.YARP4:  # up to a request whose reply is no Bottle
            asked = [b"getRemoteProtocolVersion" in data for _, data in conversation.turns]
            del conversation.turns[asked.index(True) if True in asked else len(asked) :]
        events = replayed(conversation, dialect, step)
        for (side, event), (_, following) in itertools.pairwise(events):
            if side == "S" and isinstance(event, Reply):
                assert following == Acknowledgement()
                assert Bottle.decode(event.body, dialect)
                calls += 1
    assert calls >= 5


@pytest.mark.parametrize("step", [1, 1 << 20], ids=["byte by byte", "whole"])
def test_real_administration_over_text(step):
    replies = 0
    for conversation in read("admin_commands_312"):
        if not conversation.client.startswith((b"CONNACK", b"CONNECT")):
            continue
        events = replayed(conversation, Dialect.YARP3, step)
        assert isinstance(events[0][1], Header)
        replies += sum(isinstance(event, Reply) for _, event in events)
    assert replies >= 5


def test_every_reader_has_its_place_in_the_table_and_every_phase_a_row():
    assert set(TRANSITIONS) == set(Phase)
    for phase, who in READERS:
        assert any(actor is who for actor, _ in TRANSITIONS[phase])
    for phase, row in TRANSITIONS.items():
        for who, event in row:
            assert (phase, who) in READERS or event is Closed, "what may be sent can be read"


def test_events_out_of_turn_are_refused_by_name():
    opener = YarpConnection(opener=True)
    with pytest.raises(
        LocalProtocolError, match="opener has no Message to send on a connection before the header"
    ):
        opener.send(Message("d"))
    with pytest.raises(LocalProtocolError):
        opener.send(Header(wire.TCP, "/a"))  # nothing follows an error
    with pytest.raises(LocalProtocolError, match="receiver has no Message"):
        next_phase(Phase.READY, Who.RECEIVER, Message)


@pytest.mark.parametrize(
    "header",
    [*(turns[0][2] for turns in TURNS.values() if len(turns) > 1), MJPEG, b"NAME_SERVER list\r\n"],
)
def test_what_has_no_form_on_a_carrier_is_refused_by_name(header):
    acceptor = YarpConnection(opener=False)
    acceptor.receive_data(header)
    assert isinstance(acceptor.next_event(), Header)
    with pytest.raises(LocalProtocolError, match="a Closed has no form"):
        acceptor.send(Closed())
    assert acceptor.phase is Phase.ERROR


def tcp_header(name):
    return b"YA\xe4\x1e\0\0RP" + len(name).to_bytes(4, "little") + name


@pytest.mark.parametrize(
    ("data", "header"),
    [
        (tcp_header(b"\0"), Header(wire.TCP, "")),
        (tcp_header(b"n" * 999 + b"\0"), Header(wire.TCP, "n" * 999)),
        (tcp_header(b""), "name of 0 bytes"),
        (tcp_header(b"n" * 1000 + b"\0"), "name of 1001 bytes"),
        (b"CONNECT " + b"n" * 1000 + b"\r\n", Header(wire.TEXT, "n" * 1000)),
        (b"CONNECT " + b"n" * 1001 + b"\r\n", "name of 1001 characters"),
        (b"GET / HTTP/1.1\n" + b"a: b\n" * 99 + b"\n", Header(wire.HTTP, "browser", "GET / HTTP/1.1")),
        (b"GET / HTTP/1.1\n" + b"a: b\n" * 100, "HTTP request without an end"),
        (b"GET /" + b"a" * 8187 + b"\n\n", Header(wire.HTTP, "browser", "GET /" + "a" * 8187)),
        (b"GET /" + b"a" * 8188 + b"\n\n", "line of more than 8192 bytes"),
        (b"GET /\xff HTTP/1.1\n\n", Header(wire.HTTP, "browser", "GET /\udcff HTTP/1.1")),
    ],
    ids=[
        "tcp without a name", "tcp, longest", "tcp, no size", "tcp, too long", "text, longest",
        "text, too long", "http, most lines", "http, too many lines", "http, longest line",
        "http, too long a line", "http, not UTF-8",
    ],
)  # fmt: skip
def test_headers_at_their_limits(data, header):
    acceptor = YarpConnection(opener=False)
    acceptor.receive_data(data)
    if isinstance(header, Header):
        assert acceptor.next_event() == header
        if not header.request:
            assert YarpConnection(opener=True).send(header) == [data]
    else:
        with pytest.raises(RemoteProtocolError, match=header):
            acceptor.next_event()


def test_a_name_that_no_peer_would_take_is_not_sent():
    with pytest.raises(LocalProtocolError, match="name of 1001 bytes"):
        YarpConnection(opener=True).send(Header(wire.TCP, "n" * 1000))


def test_on_text_only_what_carries_a_bottle_is_followed_by_one():
    for letter in set(string.printable) - set("adD" + string.whitespace):
        _, acceptor = ready(wire.TEXT)
        assert arriving(acceptor, letter.encode() + b"\r\n") == [Message(letter)]


@given(
    st.binary(max_size=300),
    st.sampled_from([b"", *(turns[0][2] for turns in TURNS.values()), b"GET /", b"NAME_SER"]),
)
def test_random_bytes_become_events_or_an_error(data, header):
    acceptor = YarpConnection(opener=False, limit=1 << 16)
    acceptor.receive_data(header + data)
    acceptor.receive_data(b"")
    try:
        while not isinstance(event := acceptor.next_event(), Closed | Wait):
            if isinstance(event, Header):
                if event.carrier is not wire.NAME_SER and event.carrier.replies:
                    acceptor.send(HeaderReply(1))
            elif acceptor.carrier.acknowledged:
                acceptor.send(Acknowledgement())
    except (RemoteProtocolError, TransportError) as error:
        assert re.search(r"\w+ \w+", str(error))
    assert acceptor.phase in (Phase.CLOSED, Phase.ERROR, Phase.SWITCHED, Phase.READY)
